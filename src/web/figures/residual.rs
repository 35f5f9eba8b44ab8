//! Figures of what adding effects does.

use super::identification::by_joint;
use super::{Figure, Mark, Panel, Series, unit};
use crate::documents::{EffectFinding, IdentifyDocument, ResidualDocument};

/// Error per joint of the declared model and of the one with the effects found, beside the noise floor: on identification data,
/// and below it on held-out data where there is some. `None` without a diagnosis.
pub fn before_after_figure(document: &IdentifyDocument) -> Option<Figure> {
    let residual = document.residual.as_ref()?;
    let (before, after) = (&residual.rms_before, &residual.rms_after);
    let kinds = [
        ("identification", &before.identification, &after.identification),
        ("held out", &before.held_out, &after.held_out),
    ];
    let panels: Vec<Panel> = kinds
        .into_iter()
        .filter(|(_, before, _)| !before.is_empty())
        .map(|(name, before, after)| panel(residual, name, [before, after]))
        .collect();
    Some(Figure {
        title: String::new(),
        x: "joint".into(),
        places: document.joints.clone(),
        size: (900, 60 + 210 * panels.len() as u32),
        panels,
    })
    .filter(|f| !f.panels.is_empty())
}

fn panel(residual: &ResidualDocument, name: &str, [before, after]: [&Vec<Option<f64>>; 2]) -> Panel {
    let series = |label: &str, mark: Mark, colour: usize, values: &[Option<f64>]| Series {
        name: label.into(),
        mark,
        colour,
        points: by_joint(values),
    };
    Panel {
        y: format!("{name}: RMS (N·m or N)"),
        series: vec![
            series("declared model", Mark::Bar { at: 0, of: 2 }, 1, before),
            series("with effects", Mark::Bar { at: 1, of: 2 }, 0, after),
            series("noise floor", Mark::Level, 6, &residual.noise_floor),
        ],
    }
}

/// Points of a cloud: more than this is ink on ink.
const CLOUD: usize = 1500;

/// The residual of the declared model on a finding's joint, with what the effects add to its prediction, and that of the model
/// with the effects found, against the variable that the finding is a function of (its `against`). `None` where the document has
/// no series to draw.
pub fn finding_figure(document: &IdentifyDocument, finding: &EffectFinding) -> Option<Figure> {
    let name = finding.against.joint.as_ref()?;
    let at = document.joints.iter().position(|j| j == name)?;
    let variable = variable_of(finding, at);
    let own = document
        .predictions
        .iter()
        .find(|s| s.joint == *name && s.declared.is_some())?;
    let across = match variable {
        "q" => &own.q,
        "qd" => &own.qd,
        "qdd" => &own.qdd,
        "tau" => &own.measured,
        _ => &own.time,
    };
    let step = own.measured.len().div_ceil(CLOUD).max(1);
    let left = |predicted: &[f64]| -> Vec<(f64, f64)> {
        let rest = own.measured.iter().zip(predicted).map(|(m, p)| m - p);
        across.iter().copied().zip(rest).step_by(step).collect()
    };
    let sliding = document.is_sliding(at);
    let (position, effort) = if sliding { ("m", "N") } else { ("rad", "N m") };
    let x = match variable {
        "q" => format!("q {name} ({position})"),
        "qd" => format!("qd {name} ({position}/s)"),
        "qdd" => format!("qdd {name} ({position}/s²)"),
        "tau" => format!("tau {name} ({})", unit(effort)),
        _ => "time (s)".into(),
    };
    let declared = own.declared.as_deref().unwrap_or_default();
    let points = |name: &str, colour: usize, points| Series {
        name: name.into(),
        mark: Mark::Point,
        colour,
        points,
    };
    let panel = |series: Vec<Series>| Panel {
        y: format!("residual of {name} ({})", unit(effort)),
        series,
    };
    let added = own.base.iter().zip(declared).map(|(with, without)| with - without);
    let added = across.iter().copied().zip(added).step_by(step).collect();
    Some(Figure {
        title: String::new(),
        x,
        places: Vec::new(),
        panels: vec![
            panel(vec![
                points("declared model", 1, left(declared)),
                points("what the effects add", 6, added),
            ]),
            panel(vec![points("with the effects found", 0, left(&own.base))]),
        ],
        size: (900, 400),
    })
}

/// What of joint `at` a finding is drawn over: `q`, `qd`, `qdd`, `tau` or `time`; a law's own variable of this joint.
fn variable_of(finding: &EffectFinding, at: usize) -> &str {
    let variables = finding.law.iter().flat_map(|law| &law.variables);
    let own = |name: &String| {
        let number = name.trim_start_matches(|c: char| c.is_ascii_alphabetic()).parse::<usize>();
        let kind = ["qdd", "qd", "q"].into_iter().find(|kind| name.starts_with(kind));
        kind.filter(|_| number == Ok(at + 1))
    };
    variables.filter_map(own).next().unwrap_or(&finding.against.variable)
}
