//! Figures of what adding effects does.

use super::identification::{names, numbers};
use super::{Figure, Mark, Panel, Series, unit};
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

/// Points of a cloud: more than this is ink on ink.
const CLOUD: usize = 1500;

/// What the declared model leaves on a finding's joint and what the model with the effects found leaves, against the variable that the finding is a
/// function of (its `against`). `None` where the document has no series to draw.
pub fn finding_figure(document: &Value, finding: &Value) -> Option<Figure> {
    let (joint, variable) = (&finding["against"]["joint"], finding["against"]["variable"].as_str()?);
    let series = document["predictions"].as_array()?;
    let own = series.iter().find(|s| s["joint"] == *joint && s["declared"].is_array())?;
    let across = numbers(&own[if variable == "tau" { "measured" } else { variable }]);
    let measured = numbers(&own["measured"]);
    let step = measured.len().div_ceil(CLOUD).max(1);
    let left = |model: &str| -> Vec<(f64, f64)> {
        let predicted = numbers(&own[model]);
        let rest = measured.iter().zip(&predicted).map(|(m, p)| m - p);
        across.iter().copied().zip(rest).step_by(step).collect()
    };
    let at = document["joints"].as_array()?.iter().position(|j| j == joint)?;
    let sliding = document["provenance"]["robot"]["joints"][at]["kind"] == "prismatic";
    let (position, effort) = if sliding { ("m", "N") } else { ("rad", "N m") };
    let name = joint.as_str().unwrap_or_default();
    let x = match variable {
        "q" => format!("q {name} ({position})"),
        "qd" => format!("qd {name} ({position}/s)"),
        "qdd" => format!("qdd {name} ({position}/s²)"),
        "tau" => format!("tau {name} ({})", unit(effort)),
        _ => "time (s)".into(),
    };
    let panel = |label: &str, model: &str, colour: usize| Panel {
        y: format!("left of {name} ({})", unit(effort)),
        series: vec![Series {
            name: label.into(),
            mark: Mark::Point,
            colour,
            points: left(model),
        }],
    };
    Some(Figure {
        title: String::new(),
        x,
        places: Vec::new(),
        panels: vec![
            panel("declared model", "declared", 1),
            panel("with the effects found", "base", 0),
        ],
        size: (900, 400),
    })
}
