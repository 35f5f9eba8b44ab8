//! The unit of time stamps.
//!
//! Controllers and ROS stamp in milliseconds, microseconds or nanoseconds, often since 1970. Rates of motions lie within two and
//! a half decades, and units are three decades apart: the stamps themselves say which it is.

use super::columns::{Columns, TimeUnit};
use super::report::{Finding, FindingKind};
use super::table::Table;
use super::time_base::rate_of;

/// Rates that are taken as they are stated (Hz).
pub const PLAUSIBLE_HZ: [f64; 2] = [5.0, 100_000.0];
/// Rates at which a unit other than the second is recognised (Hz): less than three decades, so that no two units fit.
const USUAL_HZ: [f64; 2] = [20.0, 10_000.0];
/// A rate that is stated beside the stamps is theirs within this factor; it replaces what they say.
const SAME_RATE: f64 = 2.0;
/// A unit is that of the stamps where it makes the stated rate within this factor.
const SAME_UNIT: f64 = 1.1;
/// Counts of a unit since 1970 are above this; numbers of rows are not.
const SINCE_1970: f64 = 1e11;

/// Brings the stamps to seconds, in the unit that is stated or that they are in.
pub(super) fn to_seconds(table: &mut Table, columns: &Columns, findings: &mut Vec<Finding>) {
    let stated = columns.time_unit.or(table.time_unit);
    let unit = stated.unwrap_or_else(|| recognised(table, columns.sample_rate_hz));
    if unit == TimeUnit::Seconds {
        return;
    }
    let seconds = unit.seconds();
    table.time.iter_mut().for_each(|t| *t *= seconds);
    if stated.is_none() {
        let (words, name) = unit.names();
        findings.push(Finding {
            kind: FindingKind::TimeUnit,
            count: table.time.len(),
            lines: Vec::new(),
            detail: format!(
                "time stamps are read as {words}, which their steps are; state `time_unit`: \"{name}\" in `columns` to be sure"
            ),
        });
    }
}

/// Seconds unless only another unit makes a rate that motions are sampled with, or that is stated.
fn recognised(table: &Table, stated_hz: Option<f64>) -> TimeUnit {
    let Some(rate) = rough_rate(&table.time) else {
        return TimeUnit::Seconds;
    };
    // Steps of one may be milliseconds, and may be the numbers of the rows: a guess would be a factor in every velocity.
    if rate == 1.0 && stated_hz.is_none() && table.time[0].abs() < SINCE_1970 {
        return TimeUnit::Seconds;
    }
    let fits = |unit: &TimeUnit| {
        let rate = rate / unit.seconds();
        let [low, high] = match (stated_hz, unit) {
            (Some(stated), _) => [stated / SAME_UNIT, stated * SAME_UNIT],
            (None, TimeUnit::Seconds) => PLAUSIBLE_HZ,
            (None, _) => USUAL_HZ,
        };
        (low..=high).contains(&rate)
    };
    TimeUnit::ALL.into_iter().find(fits).unwrap_or_default()
}

/// Rows per unit of time, from steps forward; `None` where there are none.
fn rough_rate(time: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = time
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|s| *s > 0.0 && s.is_finite())
        .collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let (_, &mut median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    Some(1.0 / median)
}

/// Whether a stated rate is that of stamps in seconds.
pub(super) fn is_rate_of(stated_hz: f64, time: &[f64]) -> Result<(), f64> {
    let rate = rate_of(time);
    let same = (stated_hz / SAME_RATE..=stated_hz * SAME_RATE).contains(&rate);
    if same { Ok(()) } else { Err(rate) }
}
