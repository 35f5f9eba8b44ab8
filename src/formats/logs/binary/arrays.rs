//! Named arrays as columns: which axis is that of the samples, and what the columns are called.

use super::super::names::Named;
use crate::model::INPUT_LIMITS;
use std::collections::BTreeMap;

/// The name and size of an array; a vector has one column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    pub name: String,
    pub rows: usize,
    pub columns: usize,
}

/// One column of an array: element `index` of every sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub array: usize,
    pub index: usize,
    /// Whether the samples run along the second axis.
    pub transposed: bool,
}

/// The columns of arrays that were recorded together: those that have the most usual number of samples.
pub(super) fn columns(shapes: &[Shape]) -> (Vec<Named>, Vec<Place>) {
    let samples = samples(shapes);
    let (mut names, mut places) = (Vec::new(), Vec::new());
    for (array, shape) in shapes.iter().enumerate() {
        let (transposed, count) = match (shape.rows == samples, shape.columns == samples) {
            (true, _) => (false, shape.columns),
            (false, true) => (true, shape.rows),
            _ => continue,
        };
        if samples == 0 || names.len() + count > INPUT_LIMITS.log_columns {
            continue;
        }
        for index in 0..count {
            names.push(named(&shape.name, index, count));
            places.push(Place {
                array,
                index,
                transposed,
            });
        }
    }
    (names, places)
}

/// A name of one array: `q` of seven columns is `q1` to `q7`.
pub(super) fn named(name: &str, index: usize, count: usize) -> Named {
    if count == 1 {
        return Named::new(name, 0);
    }
    let between = if name.ends_with(|c: char| c.is_ascii_digit()) {
        "_"
    } else {
        ""
    };
    Named::plain(format!("{name}{between}{}", index + 1), 0)
}

/// The length that most arrays have; of several the longest.
fn samples(shapes: &[Shape]) -> usize {
    let mut counted: BTreeMap<usize, usize> = BTreeMap::new();
    for shape in shapes {
        *counted.entry(shape.rows.max(shape.columns)).or_default() += 1;
    }
    counted
        .into_iter()
        .max_by_key(|&(length, count)| (count, length))
        .map_or(0, |(length, _)| length)
}

/// Values of one column of a matrix that is stored by rows or by columns.
pub(super) fn values(data: &[f64], shape: &Shape, place: Place, by_columns: bool) -> Vec<f64> {
    let (rows, columns) = (shape.rows, shape.columns);
    let at = |row: usize, column: usize| {
        if by_columns {
            column * rows + row
        } else {
            row * columns + column
        }
    };
    if place.transposed {
        (0..columns).map(|s| data[at(place.index, s)]).collect()
    } else {
        (0..rows).map(|s| data[at(s, place.index)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(name: &str, rows: usize, columns: usize) -> Shape {
        Shape {
            name: name.to_string(),
            rows,
            columns,
        }
    }

    #[test]
    fn samples_run_along_the_axis_that_the_arrays_have_in_common() {
        let shapes = [
            shape("t", 1, 500),
            shape("q", 500, 2),
            shape("tau", 2, 500),
            shape("gains", 7, 7),
        ];
        let (names, places) = columns(&shapes);
        let names: Vec<&str> = names.iter().map(|n| n.name.as_str()).collect();
        assert_eq!(names, ["t", "q1", "q2", "tau1", "tau2"]);
        assert!(places[0].transposed && !places[1].transposed && places[4].transposed);
        let data = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let by_rows = shape("x", 3, 2);
        let place = |index, transposed| Place {
            array: 0,
            index,
            transposed,
        };
        assert_eq!(values(&data, &by_rows, place(1, false), false), [2.0, 4.0, 6.0]);
        assert_eq!(values(&data, &by_rows, place(1, false), true), [4.0, 5.0, 6.0]);
        assert_eq!(values(&data, &by_rows, place(1, true), false), [3.0, 4.0]);
    }
}
