//! Figures of an identification, from its document.

use super::{Figure, Mark, Panel, Series, unit};
use crate::documents::{BaseValue, IdentifyDocument, LogRms, PredictionDocument};

/// Points of every curve: as many as a printed page shows.
const POINTS: usize = 700;

/// Mean steps of a series after which it has a gap: thinned ones have steps of up to four.
const GAP: f64 = 8.0;

/// The `kept` ones of points, with one that is no number in every gap: a line across rows that the fit leaves out would be no
/// measurement.
fn parted(time: &[f64], kept: &[usize], values: &[f64]) -> Vec<(f64, f64)> {
    let mean = time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first) / (time.len().max(2) - 1) as f64;
    let gap_within = |from: usize, to: usize| time[from..=to].windows(2).any(|t| t[1] - t[0] > GAP * mean);
    let mut points = Vec::new();
    for (k, &i) in kept.iter().enumerate() {
        if k > 0 && gap_within(kept[k - 1], i) {
            points.push((f64::NAN, f64::NAN));
        }
        points.push((time[i], values[i]));
    }
    points
}

/// Measured and predicted torque and their difference, from one of the document's `predictions`.
pub fn torque_figure(prediction: &PredictionDocument, effort_unit: &str) -> Figure {
    let PredictionDocument {
        time,
        measured,
        base: predicted,
        ..
    } = prediction;
    let rest: Vec<f64> = measured.iter().zip(predicted).map(|(m, p)| m - p).collect();
    let kept = crate::preparation::keep_peaks(&[measured, &rest], POINTS);
    let curve = |name: &str, colour: usize, values: &[f64]| Series {
        name: name.into(),
        mark: Mark::Line,
        colour,
        points: parted(time, &kept, values),
    };
    let unit = unit(effort_unit);
    Figure {
        title: format!("{}, {}", prediction.joint, prediction.log),
        x: "time (s)".into(),
        places: Vec::new(),
        panels: vec![
            Panel {
                y: format!("torque ({unit})"),
                series: vec![curve("measured", 7, measured), curve("predicted", 1, predicted)],
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
pub fn parameter_figures(document: &IdentifyDocument) -> Vec<Figure> {
    let all = &document.base_parameters;
    let mut units: Vec<&str> = Vec::new();
    for p in all {
        if !units.contains(&p.unit.as_str()) {
            units.push(&p.unit);
        }
    }
    let of = |unit: &str| all.iter().filter(|p| p.unit == unit && p.value.is_some()).collect::<Vec<_>>();
    let figures = units.iter().map(|unit| parameters(&of(unit), unit));
    figures.filter(|f| !f.places.is_empty()).collect()
}

fn parameters(list: &[&BaseValue], parameter_unit: &str) -> Figure {
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    Figure {
        title: String::new(),
        x: "base parameter".into(),
        places: list.iter().map(|p| p.name.clone()).collect(),
        panels: vec![Panel {
            y: format!("value ± 2σ ({})", unit(parameter_unit)),
            series: vec![Series {
                name: String::new(),
                mark: Mark::Dot(list.iter().map(|p| 2.0 * number(p.std_dev)).collect()),
                colour: 0,
                points: list.iter().enumerate().map(|(i, p)| (i as f64, number(p.value))).collect(),
            }],
        }],
        size: (900, 300),
    }
}

/// RMS error per joint of every log.
pub fn error_figure(document: &IdentifyDocument) -> Figure {
    let all: Vec<&LogRms> = document.rms.identification.iter().chain(&document.rms.validation).collect();
    let bars = |(at, log): (usize, &&LogRms)| Series {
        name: log.name.clone(),
        mark: Mark::Bar { at, of: all.len() },
        colour: at,
        points: by_joint(&log.base.rms),
    };
    Figure {
        title: String::new(),
        x: "joint".into(),
        places: document.joints.clone(),
        panels: vec![Panel {
            y: "RMS error (N·m or N)".into(),
            series: all.iter().enumerate().map(bars).collect(),
        }],
        size: (900, 300),
    }
}

/// A point for every joint; not a number where there is none.
pub(super) fn by_joint(values: &[Option<f64>]) -> Vec<(f64, f64)> {
    let point = |(j, v): (usize, &Option<f64>)| (j as f64, v.unwrap_or(f64::NAN));
    values.iter().enumerate().map(point).collect()
}
