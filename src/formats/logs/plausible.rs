//! Numbers that no arm measures.
//!
//! A column can hold any double. What is beyond every arm is either one row among many (a stray packet, a placeholder such as
//! 1e300), which is dropped and reported, or the whole column is another quantity or in another unit, which is refused. Nothing
//! that comes after has to live with squares and differences that overflow.

use super::LogError;
use super::columns::Quantity;
use super::error::beyond as beyond_every_arm;
use super::report::{Finding, FindingKind, Tally};
use super::table::{GARBAGE_LIMIT, Table};
use crate::model::INPUT_LIMITS;

impl Quantity {
    /// Largest absolute value of an arm [rad or m, rad/s or m/s, N m or N].
    fn largest(self) -> f64 {
        match self {
            Self::Position => INPUT_LIMITS.measured_position,
            Self::Velocity => INPUT_LIMITS.measured_velocity,
            Self::Torque => INPUT_LIMITS.measured_torque,
        }
    }
}

/// Drops the rows with values beyond those of arms, in SI, and reports them.
///
/// A torque column that is none throughout stays: the joint is left out by name, and the others are not affected. Its values are
/// brought to where sums of their squares are still numbers.
///
/// # Errors
/// [`LogError::Implausible`]: a column of positions or velocities of which more than one row in twenty is beyond.
pub(super) fn drop_implausible(table: &mut Table, findings: &mut Vec<Finding>) -> Result<(), LogError> {
    let mut keep = vec![true; table.lines.len()];
    let mut tally = Tally::default();
    for (quantity, columns, names) in table.quantities() {
        for (column, name) in columns.iter().zip(names) {
            let beyond = |v: &f64| v.is_nan() || v.abs() > quantity.largest();
            let count = column.iter().filter(|v| beyond(v)).count();
            let Some(first) = column.iter().position(beyond) else {
                continue;
            };
            let line = u64::from(table.lines[first]);
            if count * GARBAGE_LIMIT <= column.len() {
                tally.note(line, || format!("{} in `{name}`", beyond_every_arm(column[first])));
                keep.iter_mut().zip(column).for_each(|(k, v)| *k &= !beyond(v));
            } else if quantity != Quantity::Torque {
                return Err(LogError::Implausible {
                    file: table.file.clone(),
                    counted: table.counted,
                    line,
                    column: name.clone(),
                    value: column[first],
                    quantity: quantity.word(),
                    limit: quantity.largest(),
                });
            }
        }
    }
    for value in table.tau.iter_mut().flatten() {
        *value = if value.is_nan() {
            OVERFLOWED
        } else {
            value.clamp(-OVERFLOWED, OVERFLOWED)
        };
    }
    let lines = table
        .lines
        .iter()
        .zip(&keep)
        .filter(|(_, k)| !**k)
        .map(|(l, _)| u64::from(*l));
    tally.count_lines(lines);
    findings.extend(tally.finding(FindingKind::ImplausibleValue, |first| {
        format!("rows with values beyond those of any arm (first: {first}); dropped")
    }));
    table.retain(&keep);
    Ok(())
}

/// The sum of the squares of as many such values as a log may have is a number.
const OVERFLOWED: f64 = 1e150;

#[cfg(test)]
mod tests {
    use crate::formats::logs::{Columns, LogError, Source, read_log};

    /// A log of one joint, 0.01 s a row, `changed` at some rows.
    fn read(rows: usize, changed: impl Fn(usize) -> Option<(&'static str, f64)>) -> Result<(usize, String), LogError> {
        let mut text = "time,q1,qd1,tau1\n".to_string();
        for row in 0..rows {
            let t = 0.01 * row as f64;
            let mut values = [("time", t), ("q1", t.sin()), ("qd1", t.cos()), ("tau1", 2.0 * t.sin())];
            if let Some((name, value)) = changed(row) {
                values.iter_mut().filter(|v| v.0 == name).for_each(|v| v.1 = value);
            }
            text += &values.map(|v| format!("{:e}", v.1)).join(",");
            text.push('\n');
        }
        let source = Source {
            name: "log.csv".into(),
            bytes: text.as_bytes(),
        };
        let (log, report) = read_log(source, &Columns::default(), &["J".into()])?;
        assert!(
            log.q
                .iter()
                .chain(&log.tau)
                .chain(log.qd.iter().flatten())
                .flatten()
                .all(|v| v.is_finite() && v.abs() <= 1e150)
        );
        let said: Vec<String> = report
            .findings
            .iter()
            .map(|f| format!("{} {:?}: {}", f.kind.code(), f.lines, f.detail))
            .collect();
        Ok((report.rows_used, said.join("; ")))
    }

    #[test]
    fn prop_single_values_beyond_every_arm_are_dropped_and_named() {
        for value in [1e7f64, -1e12, 1e150, -1e200, 1.7e308] {
            for column in ["q1", "qd1", "tau1"] {
                let value = if column == "tau1" {
                    value * 1e3f64.min(1.7e308 / value.abs())
                } else {
                    value
                };
                let (used, said) = read(300, |row| [17, 120].contains(&row).then_some((column, value))).unwrap();
                assert_eq!(used, 298, "{column} {value}");
                assert!(
                    said.contains("implausible_value [19, 122]") && said.contains(&format!("`{column}`")),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn prop_columns_beyond_every_arm_are_refused_with_column_and_line() {
        for value in [2e6, -1e40, 1e308] {
            for column in ["q1", "qd1"] {
                let refused = read(300, |row| (row >= 40).then_some((column, value)))
                    .unwrap_err()
                    .to_string();
                for word in ["log.csv, line 42", column, "`columns`"] {
                    assert!(refused.contains(word), "{word}: {refused}");
                }
            }
            // A torque that is none is left out later, by name.
            assert_eq!(read(300, |row| (row >= 40).then_some(("tau1", value * 0.9))).unwrap().0, 300);
        }
    }

    #[test]
    fn prop_stamps_beyond_time_are_refused_with_their_line() {
        for (row, value) in [(299, 1e300), (299, 1.7e308), (0, -1.7e308), (0, -1e300), (299, 1e25)] {
            let refused = read(300, |r| (r == row).then_some(("time", value))).unwrap_err().to_string();
            assert!(
                refused.contains(&format!("line {}", row + 2)) && refused.contains("time"),
                "{refused}"
            );
            assert!(!refused.contains("inf") && !refused.contains("NaN"), "{refused}");
        }
    }
}
