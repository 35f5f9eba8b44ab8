//! From rows with time stamps to a uniform record.

use super::plausible::drop_implausible;
use super::report::{FindingKind, Tally};
use super::table::Table;
use super::time_unit::{PLAUSIBLE_HZ, is_rate_of, to_seconds};
use super::{Columns, Finding, LogError, LogReport};
use crate::cancel::CancelFlag;
use crate::dynamics::Channel;
use crate::model::INPUT_LIMITS;
use crate::preparation::Log;

/// Fewer samples than this hold no motion.
const LEAST_ROWS: usize = 16;
/// One row in twenty out of order is a sorted or spliced file, not a glitch.
const DISORDER_LIMIT: usize = 20;
/// Up to this many identical rows in succession are a value that was polled twice; more are a stuck signal, which is left in
/// place for the fault detectors to see.
const POLLED_AGAIN: usize = 3;
/// A hole of up to three samples is bridged by interpolation: a motion sampled fast enough is smooth over four steps.
const BRIDGED_STEPS: f64 = 3.5;
/// More than a fifth of the time missing is no recording.
const MISSING_LIMIT: f64 = 0.2;
/// Time stamps nearer than this fraction of a step to the grid are on the grid.
const ON_GRID: f64 = 0.01;

/// Lays a table onto a uniform grid, converts to SI, and reports.
pub(super) fn uniform(mut table: Table, columns: &Columns, cancel: &CancelFlag) -> Result<(Log, LogReport), LogError> {
    let mut findings = garbage_findings(&table);
    findings.append(&mut table.findings);
    whole_stamps(&mut table);
    if table.has_time {
        to_seconds(&mut table, columns, &mut findings);
    } else {
        // Rows that were left out still took their time.
        let Some(rate) = columns.sample_rate_hz else {
            return Err(LogError::NoTimeBase { file: table.file });
        };
        let first = table.numbers.first().copied().unwrap_or(0);
        table.time = table.numbers.iter().map(|&n| f64::from(n - first) / rate).collect();
    }
    cancel.leave_if_set();
    to_si(&mut table, columns);
    drop_implausible(&mut table, &mut findings)?;
    cancel.leave_if_set();
    drop_rows(&mut table, &mut findings)?;
    cancel.leave_if_set();
    check_stamps(&table)?;
    let rows_used = table.time.len();
    if rows_used < LEAST_ROWS {
        return Err(LogError::TooShort {
            file: table.file,
            rows: rows_used,
            least: LEAST_ROWS,
        });
    }
    let grid = Grid::fit(&table, columns.sample_rate_hz, &mut findings)?;
    let start_s = table.time[0];
    for column in table.q.iter_mut().chain(&mut table.qd).chain(&mut table.tau) {
        cancel.leave_if_set();
        grid.resample(&table.time, column);
    }
    let channels = channels(&mut table, columns, &grid, &mut findings)?;
    let qd = (!table.qd.is_empty()).then(|| std::mem::take(&mut table.qd));
    let report = LogReport {
        file: table.file.clone(),
        rows: table.rows,
        rows_used,
        samples: grid.samples,
        rate_hz: grid.rate_hz,
        duration_s: (grid.samples - 1) as f64 / grid.rate_hz,
        resampled: grid.resampled,
        findings,
    };
    let log = Log {
        name: table.file,
        rate_hz: grid.rate_hz,
        start_s,
        q: table.q,
        qd,
        tau: table.tau,
        usable: grid.usable,
        channels,
    };
    Ok((log, report))
}

/// The further quantities on the grid. They are slow, and need not be in every row: straight lines join their values.
fn channels(table: &mut Table, columns: &Columns, grid: &Grid, findings: &mut Vec<Finding>) -> Result<Vec<Channel>, LogError> {
    let mut found = Vec::new();
    for (values, column) in std::mem::take(&mut table.channels).into_iter().zip(&columns.channels) {
        let known: Vec<(f64, f64)> = table
            .time
            .iter()
            .copied()
            .zip(values)
            .filter(|(_, v)| v.abs() <= INPUT_LIMITS.measured_channel)
            .collect();
        if known.is_empty() {
            return Err(LogError::EmptyChannel {
                file: table.file.clone(),
                column: column.header.clone(),
            });
        }
        let without = table.time.len() - known.len();
        if without > 0 {
            findings.push(Finding {
                kind: FindingKind::SlowChannel,
                count: without,
                lines: Vec::new(),
                detail: format!("rows without a number in `{}`; straight lines join its values", column.header),
            });
        }
        found.push(Channel::new(&column.name, &column.unit, grid.joined(table.time[0], &known)));
    }
    Ok(found)
}

/// Factors, coupling and offsets that the request states.
fn to_si(table: &mut Table, columns: &Columns) {
    columns.position.transformation.apply(&mut table.q, true);
    columns.torque.transformation.apply(&mut table.tau, true);
    if !table.qd.is_empty() {
        columns.velocity.transformation.apply(&mut table.qd, true);
    }
}

/// The first row whose time stamp is no time.
fn check_stamps(table: &Table) -> Result<(), LogError> {
    let is_time = |t: &f64| t.abs() <= INPUT_LIMITS.time_stamp;
    match table.time.iter().position(|t| !is_time(t)) {
        None => Ok(()),
        Some(row) => Err(LogError::ImplausibleTime {
            file: table.file.clone(),
            counted: table.counted,
            line: u64::from(table.lines[row]),
            value: table.time[row],
        }),
    }
}

/// Seconds and nanoseconds become one time, from the first stamp on: doubles do not resolve nanoseconds since 1970.
fn whole_stamps(table: &mut Table) {
    let Some(nanos) = table.nanos.pop() else { return };
    let first = table.time.first().copied().unwrap_or(0.0);
    for (time, nano) in table.time.iter_mut().zip(nanos) {
        *time = (*time - first) + 1e-9 * nano;
    }
}

fn garbage_findings(table: &Table) -> Vec<Finding> {
    let garbage = table.garbage.finding(FindingKind::GarbageRow, |first| {
        format!("rows that are not a row of numbers (first: {first}); dropped")
    });
    let missing = table.missing_time.finding(FindingKind::MissingTime, |first| {
        format!("rows without a time stamp (first: {first}); dropped")
    });
    garbage.into_iter().chain(missing).collect()
}

/// Drops repeated rows and rows that run backwards in time.
fn drop_rows(table: &mut Table, findings: &mut Vec<Finding>) -> Result<(), LogError> {
    let (mut repeated_row, mut repeated_time, mut disorder) = (Tally::default(), Tally::default(), Tally::default());
    let mut keep = vec![true; table.time.len()];
    let mut last: Option<usize> = None;
    let mut back = None;
    for row in 0..keep.len() {
        let Some(before) = last else {
            last = Some(row);
            continue;
        };
        let (t, t0) = (table.time[row], table.time[before]);
        let line = u64::from(table.lines[row]);
        // A single stamp that is too late shows in the next one, which fits between its neighbours.
        let too_late = table.time.get(row + 1).is_some_and(|&next| next < t && next > t0);
        if t < t0 || too_late {
            disorder.add(line, || format!("{t:?} s after {t0:?} s"));
            back.get_or_insert((line, t0, t));
            keep[row] = false;
        } else if t == t0 {
            let tally = if table.same(row, before) {
                &mut repeated_row
            } else {
                &mut repeated_time
            };
            tally.add(line, || format!("{t:?} s"));
            keep[row] = false;
        } else {
            last = Some(row);
        }
    }
    if let Some((line, from, to)) = back
        && disorder.count * DISORDER_LIMIT > keep.len()
    {
        return Err(LogError::TimeGoesBack {
            file: table.file.clone(),
            counted: table.counted,
            line,
            from,
            to,
            count: disorder.count,
            rows: keep.len(),
        });
    }
    drop_polled_again(table, &mut keep, &mut repeated_row);
    findings.extend(repeated_row.finding(FindingKind::RepeatedRow, |_| {
        "rows that repeat the one before (polled twice); dropped, the value at that time is interpolated".to_string()
    }));
    findings.extend(repeated_time.finding(FindingKind::RepeatedTime, |first| {
        format!("rows with the time stamp of the one before (first: {first}) but other values; the first of each is kept")
    }));
    findings.extend(disorder.finding(FindingKind::TimeOutOfOrder, |first| {
        format!("time stamps out of order (first: {first}); dropped")
    }));
    table.retain(&keep);
    Ok(())
}

/// Marks short runs of identical rows, all but the first of each.
fn drop_polled_again(table: &Table, keep: &mut [bool], tally: &mut Tally) {
    let kept: Vec<usize> = (0..keep.len()).filter(|&r| keep[r]).collect();
    let mut start = 0;
    while start < kept.len() {
        let mut end = start + 1;
        while end < kept.len() && table.same(kept[end], kept[start]) {
            end += 1;
        }
        if end - start <= POLLED_AGAIN + 1 {
            for &row in &kept[start + 1..end] {
                tally.add(u64::from(table.lines[row]), String::new);
                keep[row] = false;
            }
        }
        start = end;
    }
}

impl Table {
    pub(super) fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let motion = self.q.iter_mut().chain(&mut self.qd);
        let measured = motion.chain(&mut self.tau).chain(&mut self.nanos);
        measured.chain(&mut self.channels)
    }

    fn same(&self, a: usize, b: usize) -> bool {
        self.q.iter().chain(&self.qd).chain(&self.tau).all(|c| c[a] == c[b])
    }

    pub(super) fn retain(&mut self, keep: &[bool]) {
        if keep.iter().all(|&k| k) {
            return;
        }
        let pack = |column: &mut Vec<f64>| {
            let mut flags = keep.iter();
            column.retain(|_| *flags.next().expect("one flag per row"));
        };
        self.columns_mut().for_each(pack);
        // Without a column of time there is none before rows are numbered.
        if !self.time.is_empty() {
            pack(&mut self.time);
        }
        for counts in [&mut self.lines, &mut self.numbers] {
            let mut flags = keep.iter();
            counts.retain(|_| *flags.next().expect("one flag per row"));
        }
    }
}

/// The uniform grid, and which of its samples are data.
struct Grid {
    rate_hz: f64,
    samples: usize,
    /// False when every row already stands on its sample.
    resampled: bool,
    usable: Vec<bool>,
}

impl Grid {
    fn fit(table: &Table, stated_rate: Option<f64>, findings: &mut Vec<Finding>) -> Result<Self, LogError> {
        let time = &table.time;
        if let Some(stated_hz) = stated_rate
            && let Err(rate_hz) = is_rate_of(stated_hz, time)
        {
            return Err(LogError::RateDiffers {
                file: table.file.clone(),
                rate_hz,
                stated_hz,
            });
        }
        let rate_hz = stated_rate.unwrap_or_else(|| rate_of(time));
        if !(PLAUSIBLE_HZ[0]..=PLAUSIBLE_HZ[1]).contains(&rate_hz) {
            return Err(LogError::ImplausibleRate {
                file: table.file.clone(),
                rate_hz,
            });
        }
        // The number of samples is that of the rows as long as little is missing: nothing is allocated before that is known.
        let gaps = Gaps::from_table(table, rate_hz)?;
        let duration = time[time.len() - 1] - time[0];
        let samples = (duration * rate_hz).round() as usize + 1;
        let deviation = largest_deviation(time, rate_hz);
        let on_grid = deviation <= (ON_GRID / rate_hz).max(0.51 * stamp_resolution(time));
        let mut grid = Self {
            rate_hz,
            samples,
            resampled: !on_grid || samples != time.len(),
            usable: vec![true; samples],
        };
        if !on_grid {
            findings.push(Finding {
                kind: FindingKind::Jitter,
                count: time.len(),
                lines: Vec::new(),
                detail: format!(
                    "time stamps up to {:.3} ms off a uniform {rate_hz:.6} Hz grid; all values interpolated onto it (cubic in time)",
                    deviation * 1e3
                ),
            });
        }
        gaps.mark(&mut grid, time);
        gaps.report(findings, table.counted);
        Ok(grid)
    }

    /// Values on the grid from `(time, value)` pairs, joined by straight lines and constant beyond the first and the last.
    fn joined(&self, start: f64, known: &[(f64, f64)]) -> Vec<f64> {
        let mut i = 0;
        let mut at = |s: usize| {
            let t = start + s as f64 / self.rate_hz;
            while i + 1 < known.len() && known[i + 1].0 <= t {
                i += 1;
            }
            let (t0, y0) = known[i];
            let (t1, y1) = known[(i + 1).min(known.len() - 1)];
            if t <= t0 || t1 <= t0 {
                return y0;
            }
            y0 + (y1 - y0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
        };
        (0..self.samples).map(&mut at).collect()
    }

    /// Replaces the values at `time` by those on the grid: cubic Hermite with slopes of the parabola through three neighbours.
    fn resample(&self, time: &[f64], column: &mut Vec<f64>) {
        if !self.resampled {
            return;
        }
        let last = time.len() - 1;
        // Slope at sample i of the parabola through a, b, c (in that order in time).
        let parabola = |a: usize, b: usize, c: usize, i: usize| {
            let (h0, h1) = (time[b] - time[a], time[c] - time[b]);
            let (d0, d1) = ((column[b] - column[a]) / h0, (column[c] - column[b]) / h1);
            let bend = (d1 - d0) / (h0 + h1);
            d0 + bend * (2.0 * time[i] - time[a] - time[b])
        };
        let slope = |i: usize| {
            let middle = i.clamp(1, last - 1);
            parabola(middle - 1, middle, middle + 1, i)
        };
        let mut i = 0;
        let on_grid: Vec<f64> = (0..self.samples)
            .map(|s| {
                let t = time[0] + s as f64 / self.rate_hz;
                while i + 1 < last && time[i + 1] <= t {
                    i += 1;
                }
                let h = time[i + 1] - time[i];
                let x = ((t - time[i]) / h).clamp(0.0, 1.0);
                let (y0, y1) = (column[i], column[i + 1]);
                let (m0, m1) = (slope(i) * h, slope(i + 1) * h);
                let (x2, x3) = (x * x, x * x * x);
                y0 * (2.0 * x3 - 3.0 * x2 + 1.0) + m0 * (x3 - 2.0 * x2 + x) + y1 * (3.0 * x2 - 2.0 * x3) + m1 * (x3 - x2)
            })
            .collect();
        *column = on_grid;
    }
}

/// Where samples are missing.
struct Gaps {
    gaps: Tally,
    bridged: Tally,
    /// Rows before each gap that is too long to be bridged.
    before: Vec<usize>,
    missing_s: f64,
    longest_s: f64,
}

impl Gaps {
    /// # Errors
    /// More than a fifth of the time is missing.
    fn from_table(table: &Table, rate_hz: f64) -> Result<Self, LogError> {
        let time = &table.time;
        let mut found = Self {
            gaps: Tally::default(),
            bridged: Tally::default(),
            before: Vec::new(),
            missing_s: 0.0,
            longest_s: 0.0,
        };
        let mut longest = 0;
        for row in 1..time.len() {
            let gap = time[row] - time[row - 1];
            let steps = gap * rate_hz;
            let line = u64::from(table.lines[row - 1]);
            if steps > BRIDGED_STEPS {
                found.gaps.add(line, || format!("{gap:.4} s"));
                found.before.push(row - 1);
                found.missing_s += gap - 1.0 / rate_hz;
                if gap > found.longest_s {
                    (found.longest_s, longest) = (gap, row);
                }
            } else if steps > 1.5 {
                found.bridged.add(line, || format!("{:.0}", steps - 1.0));
            }
        }
        let total = time[time.len() - 1] - time[0];
        if found.missing_s > MISSING_LIMIT * total {
            return Err(LogError::TooManyGaps {
                file: table.file.clone(),
                missing_s: found.missing_s,
                total_s: total,
                counted: table.counted,
                line: u64::from(table.lines[longest - 1]),
                from: time[longest - 1],
                to: time[longest],
            });
        }
        Ok(found)
    }

    fn mark(&self, grid: &mut Grid, time: &[f64]) {
        let inside = |t: f64| ((t - time[0]) * grid.rate_hz).round() as usize;
        for &row in &self.before {
            let (from, to) = (inside(time[row]) + 1, inside(time[row + 1]));
            grid.usable[from.min(grid.samples)..to.min(grid.samples)].fill(false);
        }
    }

    fn report(&self, findings: &mut Vec<Finding>, counted: &str) {
        findings.extend(self.bridged.finding(FindingKind::MissingSample, |_| {
            format!("after these {counted}s one to three samples are missing; interpolated")
        }));
        findings.extend(self.gaps.finding(FindingKind::Gap, |_| {
            format!(
                "after these {counted}s samples are missing, {:.3} s in all, longest {:.3} s; those times are left out of the fit",
                self.missing_s, self.longest_s
            )
        }));
    }
}

/// Sample rate of a record with jitter and holes: every interval counts as a whole number of median steps.
pub(super) fn rate_of(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let middle = steps.len() / 2;
    let (_, &mut median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let count: f64 = time.windows(2).map(|w| ((w[1] - w[0]) / median).round()).sum();
    let duration = time[time.len() - 1] - time[0];
    let rate = count / duration;
    // A rate that is a whole number within what the stamps resolve was meant to be that.
    let whole = rate.round();
    let uncertainty = 2.0 * largest_deviation(time, whole).min(1.0 / rate) / duration + 1e-9;
    if (rate - whole).abs() <= uncertainty * rate {
        whole
    } else {
        rate
    }
}

/// Farthest that a time stamp is from the nearest sample of the grid that starts at the first stamp (s).
fn largest_deviation(time: &[f64], rate_hz: f64) -> f64 {
    let off = |t: &f64| {
        let steps = (t - time[0]) * rate_hz;
        (steps - steps.round()).abs() / rate_hz
    };
    time.iter().map(off).fold(0.0, f64::max)
}

/// Distance between neighbouring numbers that the stamps were written with: 1e-4 for `12.3456`.
fn stamp_resolution(time: &[f64]) -> f64 {
    let written_with = |digits: i32| {
        let scale = 10f64.powi(digits);
        // Products of times up to 1e5 s and scales up to 1e7 carry rounding of 1e-4.
        time.iter().all(|t| (t * scale - (t * scale).round()).abs() < 1e-3)
    };
    (1..=7).find(|&d| written_with(d)).map_or(0.0, |d| 10f64.powi(-d))
}
