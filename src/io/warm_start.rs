//! An earlier trajectory to go on from, in the words in which a design hands it out.

use super::cursor::{Cursor, Fields};
use crate::trajectory::FourierSeries;
use nalgebra::DMatrix;

pub const WARM_START_FIELDS: &[&str] = &["coefficients", "offset", "fundamental_hz"];
const COEFFICIENT_FIELDS: &[&str] = &["a", "b"];
/// More harmonics than any problem takes.
const MOST_HARMONICS: usize = 50;

/// Reads `{"coefficients": {"a": [[…]…], "b": …}, "offset": […], "fundamental_hz": …}`, one row per joint.
pub(super) fn read_warm_start(cursor: &Cursor, joints: Option<usize>) -> Option<FourierSeries> {
    let fields = cursor.fields(WARM_START_FIELDS)?;
    read_trajectory(cursor, &fields, joints)
}

/// The same of an object that may have other fields beside.
pub(super) fn read_trajectory(cursor: &Cursor, fields: &Fields, joints: Option<usize>) -> Option<FourierSeries> {
    let rows = fields.required("coefficients").and_then(|c| c.fields(COEFFICIENT_FIELDS));
    let offset = fields.required("offset").and_then(|c| c.numbers(joints));
    let fundamental_hz = fields.required("fundamental_hz").and_then(|c| positive(&c));
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

fn positive(cursor: &Cursor) -> Option<f64> {
    let value = cursor.number()?;
    if value <= 0.0 {
        cursor.complain(format!("is {value}; it must be a positive number of Hz"));
        return None;
    }
    Some(value)
}

fn matrix(fields: &Fields, name: &str, joints: Option<usize>) -> Option<DMatrix<f64>> {
    let cursor = fields.required(name)?;
    let items = cursor.items()?;
    let rows: Vec<Vec<f64>> = items.iter().map(|row| row.numbers(None)).collect::<Option<_>>()?;
    let order = rows.first().map_or(0, Vec::len);
    if joints.is_some_and(|n| n != rows.len()) || order == 0 || order > MOST_HARMONICS || rows.iter().any(|r| r.len() != order) {
        let expected = joints.map_or("one row per joint".to_string(), |n| format!("{n} rows, one per joint,"));
        cursor.complain(format!(
            "must have {expected} with one number per harmonic in each, 1 to {MOST_HARMONICS}"
        ));
        return None;
    }
    Some(DMatrix::from_fn(rows.len(), order, |j, l| rows[j][l]))
}
