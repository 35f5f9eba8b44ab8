//! The figure of what adding effects does.

use super::identification::{names, numbers};
use super::{Figure, Mark, Panel, Series};
use serde_json::Value;

/// Error per joint of the declared model and of the one with the effects found, beside the noise floor: on identification data, and
/// below it on held-out data where there is some. `None` without tracing.
pub fn before_after_figure(document: &Value) -> Option<Figure> {
    let residual = document.get("residual").filter(|r| r.is_object())?;
    let kinds = [("identification", "identification"), ("held_out", "held out")];
    let panels: Vec<Panel> = kinds
        .iter()
        .filter(|(key, _)| !numbers(&residual["rms_before"][key]).is_empty())
        .map(|(key, name)| panel(residual, key, name))
        .collect();
    Some(Figure {
        title: String::new(),
        x: "joint".into(),
        places: names(&document["joints"]),
        size: (900, 60 + 210 * panels.len() as u32),
        panels,
    })
    .filter(|f| !f.panels.is_empty())
}

fn panel(residual: &Value, key: &str, name: &str) -> Panel {
    let series = |label: &str, mark: Mark, colour: usize, values: &Value| Series {
        name: label.into(),
        mark,
        colour,
        points: numbers(values).into_iter().enumerate().map(|(j, v)| (j as f64, v)).collect(),
    };
    Panel {
        y: format!("{name}: RMS (N m or N)"),
        series: vec![
            series("declared model", Mark::Bar { at: 0, of: 2 }, 1, &residual["rms_before"][key]),
            series("with effects", Mark::Bar { at: 1, of: 2 }, 0, &residual["rms_after"][key]),
            series("noise floor", Mark::Level, 6, &residual["noise_floor"]),
        ],
    }
}
