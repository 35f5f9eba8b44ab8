//! The samples of a trajectory, and the plainest files of them.

use crate::trajectory::{FourierSeries, Trajectory, sample_count};
use serde_json::json;
use std::fmt::Write;

/// Rows beyond this would be gigabytes; an hour at 1 kHz is 3.6 million.
pub const MOST_ROWS: usize = 4_000_000;

/// A motion to be sampled: a run-in, so many periods, a run-out.
#[derive(Debug, Clone)]
pub(super) struct Course {
    pub series: FourierSeries,
    pub rate_hz: f64,
    pub periods: usize,
    /// Half a period of each is taken, a whole number of samples.
    pub run_in: Option<FourierSeries>,
    pub run_out: Option<FourierSeries>,
}

impl Course {
    pub fn periodic(series: FourierSeries, rate_hz: f64, periods: usize) -> Self {
        Self {
            series,
            rate_hz,
            periods,
            run_in: None,
            run_out: None,
        }
    }

    /// Samples before the first period.
    fn before(&self) -> usize {
        self.run_in
            .as_ref()
            .map_or(0, |way| sample_count(0.5 * way.duration(), self.rate_hz))
    }

    /// Samples of the periods; the next is the first of what comes after.
    fn within(&self) -> usize {
        // A product beyond usize saturates, which is above every bound.
        sample_count(self.series.duration() * self.periods as f64, self.rate_hz)
    }

    /// Rows with the last one: the motion ends where it began, or where the run-out ends.
    pub fn rows(&self) -> usize {
        let after = self.run_out.as_ref().map_or(0, |way| {
            // Where the periods are no whole number of samples, the run-out begins between two.
            let rest = self.series.duration() * self.periods as f64 - self.within() as f64 / self.rate_hz;
            sample_count(0.5 * way.duration() + rest, self.rate_hz)
        });
        self.before()
            .saturating_add(self.within())
            .saturating_add(after)
            .saturating_add(1)
    }

    /// One row; numbers of a whole period are computed at the same phases in every period, so that periods are equal to the last
    /// bit when the period is a whole number of samples.
    pub fn row(&self, index: usize) -> Vec<f64> {
        let (before, within) = (self.before(), self.within());
        let states = match (&self.run_in, &self.run_out) {
            (Some(way), _) if index < before => along(way, index as f64 / self.rate_hz),
            (_, Some(way)) if index >= before + within => {
                let begun = self.series.duration() * self.periods as f64;
                along(way, (index - before) as f64 / self.rate_hz - begun)
            }
            _ => self.periodic_states(index - before),
        };
        let of = |k: usize| states.iter().map(move |s| s[k]);
        std::iter::once(index as f64 / self.rate_hz)
            .chain(of(0))
            .chain(of(1))
            .chain(of(2))
            .collect()
    }

    fn periodic_states(&self, index: usize) -> Vec<[f64; 3]> {
        let per_period = self.series.duration() * self.rate_hz;
        let whole = per_period.round();
        // As in `sample_count`: whole up to rounding.
        let phase = if (per_period - whole).abs() <= 1e-9 * whole {
            index % whole as usize
        } else {
            index
        };
        (0..self.series.joints())
            .map(|j| self.series.state(j, phase as f64 / self.rate_hz))
            .collect()
    }
}

/// States of all joints along a run, at rest at its outer end.
fn along(way: &FourierSeries, t: f64) -> Vec<[f64; 3]> {
    let t = t.clamp(0.0, 0.5 * way.duration());
    (0..way.joints()).map(|j| way.state(j, t)).collect()
}

/// Columns `time, q1 … qn, qd1 … qdn, qdd1 … qddn` [s, rad or m, and per second].
fn header(joints: usize) -> Vec<String> {
    let of = |symbol: &'static str| (1..=joints).map(move |j| format!("{symbol}{j}"));
    std::iter::once("time".to_string())
        .chain(of("q"))
        .chain(of("qd"))
        .chain(of("qdd"))
        .collect()
}

/// A row by its quantities.
pub(super) struct State {
    /// (s)
    pub time: f64,
    /// q, qd and qdd of every joint.
    pub of: [Vec<f64>; 3],
}

pub(super) fn states(row: Vec<f64>) -> State {
    let joints = (row.len() - 1) / 3;
    let of = |k: usize| row[1 + k * joints..1 + (k + 1) * joints].to_vec();
    State {
        time: row[0],
        of: [of(0), of(1), of(2)],
    }
}

/// Decimals of a number in a file: a tenth of a nanoradian, a thousandth of what the finest encoders resolve.
const DECIMALS: usize = 10;

/// A number without digits that say nothing.
pub(super) fn decimal(value: f64) -> String {
    let text = format!("{value:.DECIMALS$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

/// Rows in one part of a table: written in about a millisecond.
const ROWS_OF_A_PART: usize = 256;

/// Texts of the rows, so many at a time.
pub(super) fn parts(
    course: Course,
    write: impl Fn(&mut String, usize, Vec<f64>) + Send + 'static,
) -> impl Iterator<Item = String> + Send + 'static {
    let count = course.rows();
    (0..count).step_by(ROWS_OF_A_PART).map(move |first| {
        let mut text = String::new();
        for index in first..count.min(first + ROWS_OF_A_PART) {
            write(&mut text, index, course.row(index));
        }
        text
    })
}

/// As comma-separated values with a header, part by part: the whole may be gigabytes. Numbers have ten decimals at most.
pub fn trajectory_csv_parts(
    series: FourierSeries,
    rate_hz: f64,
    periods: usize,
) -> impl Iterator<Item = String> + Send + 'static {
    csv_parts(Course::periodic(series, rate_hz, periods))
}

pub(super) fn csv_parts(course: Course) -> impl Iterator<Item = String> + Send + 'static {
    let head = header(course.series.joints()).join(",") + "\n";
    let write = |text: &mut String, _, row: Vec<f64>| {
        for (column, value) in row.iter().enumerate() {
            let separator = if column == 0 { "" } else { "," };
            write!(text, "{separator}{}", decimal(*value)).expect("writing to a string cannot fail");
        }
        text.push('\n');
    };
    std::iter::once(head).chain(parts(course, write))
}

/// As comma-separated values with a header; numbers have ten decimals at most.
pub fn trajectory_csv(series: &FourierSeries, rate_hz: f64, periods: usize) -> String {
    trajectory_csv_parts(series.clone(), rate_hz, periods).collect()
}

/// As an object of `columns` and `rows`, part by part.
pub fn trajectory_json_parts(
    series: FourierSeries,
    rate_hz: f64,
    periods: usize,
) -> impl Iterator<Item = String> + Send + 'static {
    json_parts(Course::periodic(series, rate_hz, periods))
}

pub(super) fn json_parts(course: Course) -> impl Iterator<Item = String> + Send + 'static {
    let columns = json!(header(course.series.joints()));
    let head = format!(
        "{{\"columns\":{columns},\"rate_hz\":{},\"periods\":{},\"rows\":[",
        json!(course.rate_hz),
        course.periods
    );
    let write = |text: &mut String, index, row: Vec<f64>| {
        let separator = if index == 0 { "" } else { "," };
        write!(text, "{separator}{}", json!(row)).expect("writing to a string cannot fail");
    };
    let rows = parts(course, write);
    std::iter::once(head).chain(rows).chain(std::iter::once("]}".to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn series() -> FourierSeries {
        let a = DMatrix::from_row_slice(2, 2, &[0.1, -0.1, 0.7, -0.7]);
        let b = DMatrix::from_row_slice(2, 2, &[0.2, -0.1, 0.3, -0.15]);
        FourierSeries {
            fundamental_hz: 0.1,
            a,
            b,
            offset: vec![0.25, -1.0 / 3.0],
        }
    }

    #[test]
    fn rows_hold_the_state_and_close_the_period() {
        let text: String = trajectory_csv_parts(series(), 100.0, 2).collect();
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), "time,q1,q2,qd1,qd2,qdd1,qdd2");
        let table: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        assert_eq!(table.len(), 2001);
        let state = series().state(1, 3.21);
        for (written, value) in [table[321][2], table[321][4], table[321][6]].iter().zip(state) {
            assert!((written - value).abs() <= 0.5e-10, "{written} {value}");
        }
        assert!(
            text.lines()
                .skip(1)
                .flat_map(|l| l.split(','))
                .all(|v| v.split('.').nth(1).is_none_or(|d| d.len() <= 10))
        );
        assert_eq!(table[0][1..], table[1000][1..]);
        assert_eq!(table[2000][0], 20.0);
        assert_eq!(table[2000][1..], table[0][1..]);
        let json: String = trajectory_json_parts(series(), 100.0, 2).collect();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["columns"][6], "qdd2");
        assert_eq!((&json["rate_hz"], &json["periods"]), (&json!(100.0), &json!(2)));
        assert_eq!(json["rows"][321][2], json!(series().state(1, 3.21)[0]));
        assert_eq!(json["rows"].as_array().unwrap().len(), table.len());
    }
}
