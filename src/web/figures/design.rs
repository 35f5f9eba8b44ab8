//! Figures of a design.

use super::{Figure, Mark, Panel, Series};
use crate::model::Robot;
use crate::trajectory::{FourierSeries, Trajectory};

/// Points of every curve: as many as a printed page shows.
const POINTS: usize = 600;

/// q, qd and qdd of every joint over one period.
pub fn design_figure(robot: &Robot, series: &FourierSeries) -> Figure {
    let units = |suffix: &str| {
        let mut all: Vec<String> = robot
            .joints()
            .iter()
            .map(|j| format!("{}{suffix}", j.position_unit()))
            .collect();
        all.dedup();
        all.join(" or ")
    };
    let panel = |k: usize, name: &str, suffix: &str| Panel {
        y: format!("{name} ({})", units(suffix)),
        series: (0..series.joints()).map(|j| curve(robot, series, j, k)).collect(),
    };
    Figure {
        title: robot.name().to_string(),
        x: "time (s)".into(),
        places: Vec::new(),
        panels: vec![panel(0, "q", ""), panel(1, "qd", "/s"), panel(2, "qdd", "/s²")],
        size: (900, 780),
    }
}

fn curve(robot: &Robot, series: &FourierSeries, j: usize, k: usize) -> Series {
    let at = |s: usize| {
        let t = series.duration() * s as f64 / POINTS as f64;
        (t, series.state(j, t)[k])
    };
    Series {
        name: if k == 0 {
            robot.joints()[j].name.clone()
        } else {
            String::new()
        },
        mark: Mark::Line,
        colour: j,
        points: (0..=POINTS).map(at).collect(),
    }
}
