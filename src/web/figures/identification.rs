//! Figures of an identification, from its document.

use super::{Figure, Mark, Panel, Series, unit};
use serde_json::Value;

/// Points of every curve: as many as a printed page shows.
const POINTS: usize = 700;

pub(super) fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().into_iter().flatten();
    list.map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

pub(super) fn names(value: &Value) -> Vec<String> {
    let list = value.as_array().into_iter().flatten();
    list.map(|v| v.as_str().unwrap_or_default().to_string()).collect()
}

/// Measured and predicted torque and their difference, from one of the document's `predictions`.
pub fn torque_figure(prediction: &Value, effort_unit: &str) -> Figure {
    let (time, measured) = (numbers(&prediction["time"]), numbers(&prediction["measured"]));
    let predicted = numbers(&prediction["base"]);
    let rest: Vec<f64> = measured.iter().zip(&predicted).map(|(m, p)| m - p).collect();
    let kept = crate::preparation::keep_peaks(&[&measured, &rest], POINTS);
    let curve = |name: &str, colour: usize, values: &[f64]| Series {
        name: name.into(),
        mark: Mark::Line,
        colour,
        points: kept.iter().map(|&i| (time[i], values[i])).collect(),
    };
    let unit = unit(effort_unit);
    Figure {
        title: format!(
            "{}, {}",
            prediction["joint"].as_str().unwrap_or_default(),
            prediction["log"].as_str().unwrap_or_default()
        ),
        x: "time (s)".into(),
        places: Vec::new(),
        panels: vec![
            Panel {
                y: format!("torque ({unit})"),
                series: vec![curve("measured", 7, &measured), curve("predicted", 1, &predicted)],
            },
            Panel {
                y: format!("difference ({unit})"),
                series: vec![curve("", 0, &rest)],
            },
        ],
        size: (900, 380),
    }
}

/// Base parameters with two standard deviations to both sides, one figure per unit.
pub fn parameter_figures(document: &Value) -> Vec<Figure> {
    let all: Vec<&Value> = document["base_parameters"].as_array().into_iter().flatten().collect();
    let mut units: Vec<&str> = Vec::new();
    for p in &all {
        let unit = p["unit"].as_str().unwrap_or_default();
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    let of = |name: &&str| {
        all.iter()
            .filter(|p| p["unit"] == **name && p["value"].is_number())
            .copied()
            .collect::<Vec<_>>()
    };
    units
        .iter()
        .map(|name| parameters(&of(name), name))
        .filter(|f| !f.places.is_empty())
        .collect()
}

fn parameters(list: &[&Value], parameter_unit: &str) -> Figure {
    let number = |p: &Value, key: &str| p[key].as_f64().unwrap_or(f64::NAN);
    Figure {
        title: String::new(),
        x: "base parameter".into(),
        places: list
            .iter()
            .map(|p| p["name"].as_str().unwrap_or_default().to_string())
            .collect(),
        panels: vec![Panel {
            y: format!("value ± 2σ ({})", unit(parameter_unit)),
            series: vec![Series {
                name: String::new(),
                mark: Mark::Dot(list.iter().map(|p| 2.0 * number(p, "std_dev")).collect()),
                colour: 0,
                points: list.iter().enumerate().map(|(i, p)| (i as f64, number(p, "value"))).collect(),
            }],
        }],
        size: (900, 300),
    }
}

/// RMS error per joint of every log.
pub fn error_figure(document: &Value) -> Figure {
    let logs = |role: &str| document["rms"][role].as_array().cloned().unwrap_or_default();
    let all: Vec<Value> = logs("identification").into_iter().chain(logs("validation")).collect();
    let bars = |(at, log): (usize, &Value)| Series {
        name: log["name"].as_str().unwrap_or_default().to_string(),
        mark: Mark::Bar { at, of: all.len() },
        colour: at,
        points: numbers(&log["base"]["rms"])
            .into_iter()
            .enumerate()
            .map(|(j, v)| (j as f64, v))
            .collect(),
    };
    Figure {
        title: String::new(),
        x: "joint".into(),
        places: names(&document["joints"]),
        panels: vec![Panel {
            y: "RMS error (N m or N)".into(),
            series: all.iter().enumerate().map(bars).collect(),
        }],
        size: (900, 300),
    }
}
