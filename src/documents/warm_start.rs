//! An earlier trajectory to go on from, in the words in which a design hands it out.

use super::cursor::{Cursor, Fields};
use super::requests;
use crate::model::INPUT_LIMITS;
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;

/// Reads `{"coefficients": {"a": [[…]…], "b": …}, "offset": […], "fundamental_hz": …}`, one row per joint.
pub(super) fn read_warm_start(cursor: &Cursor, joints: Option<usize>) -> Option<FourierSeries> {
    let fields = cursor.fields_of::<requests::WarmStart>()?;
    read_trajectory(cursor, &fields, joints)
}

/// The same of an object that may have other fields beside.
pub(super) fn read_trajectory(cursor: &Cursor, fields: &Fields, joints: Option<usize>) -> Option<FourierSeries> {
    let rows = fields
        .required("coefficients")
        .and_then(|c| c.fields_of::<super::Coefficients>());
    let fundamental_hz = fields.required("fundamental_hz").and_then(|c| fundamental(&c));
    let offset = fields.required("offset").and_then(|c| row(&c, joints, INPUT_LIMITS.joints));
    let rows = rows?;
    let (a, b) = (matrix(&rows, "a", joints), matrix(&rows, "b", joints));
    let (a, b, offset) = (a?, b?, offset?);
    if a.shape() != b.shape() || a.nrows() != offset.len() {
        cursor.complain(
            "has `a`, `b` and `offset` of different sizes: one row per joint, one column per harmonic, one offset per joint",
        );
        return None;
    }
    Some(FourierSeries {
        fundamental_hz: fundamental_hz?,
        a,
        b,
        offset,
    })
}

/// A fundamental frequency (Hz).
fn fundamental(cursor: &Cursor) -> Option<f64> {
    let ([low, high], value) = (INPUT_LIMITS.fundamental_hz, cursor.number()?);
    if !(low..=high).contains(&value) {
        cursor.complain(format!("is {value}; a fundamental is from {low:e} to {high:e} Hz"));
        return None;
    }
    Some(value)
}

/// As many numbers as `length` says, or up to `most`, none of them beyond any motion.
fn row(cursor: &Cursor, length: Option<usize>, most: usize) -> Option<Vec<f64>> {
    if length.is_none() {
        cursor.items_up_to(most, "values")?;
    }
    let (values, largest) = (cursor.numbers(length)?, INPUT_LIMITS.coefficient);
    if let Some(v) = values.iter().find(|v| v.abs() > largest) {
        cursor.complain(format!("has the value {v:e}; the largest accepted is {largest:e}"));
        return None;
    }
    Some(values)
}

fn matrix(fields: &Fields, name: &str, joints: Option<usize>) -> Option<DMatrix<f64>> {
    let (cursor, most) = (fields.required(name)?, INPUT_LIMITS.harmonics);
    let items = cursor.items_up_to(INPUT_LIMITS.joints, "rows")?;
    let rows: Vec<Vec<f64>> = items.iter().map(|c| row(c, None, most)).collect::<Option<_>>()?;
    let order = rows.first().map_or(0, Vec::len);
    if joints.is_some_and(|n| n != rows.len()) || order == 0 || rows.iter().any(|r| r.len() != order) {
        let expected = joints.map_or("one row per joint".to_string(), |n| format!("{n} rows, one per joint,"));
        cursor.complain(format!(
            "must have {expected} with one number per harmonic in each, 1 to {most}, in all rows alike"
        ));
        return None;
    }
    Some(DMatrix::from_fn(rows.len(), order, |j, l| rows[j][l]))
}
