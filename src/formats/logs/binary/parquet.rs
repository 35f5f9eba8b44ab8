//! Parquet: tables of pandas, pyarrow and Polars. Lists of one length are read as that many columns.

use super::super::LogError;
use super::super::names::Named;
use super::super::sheet::{Loaded, Sheet};
use super::npz::since_first;
use super::{MOST_NUMBERS, arrays, too_large};
use crate::model::INPUT_LIMITS;
use parquet::basic::{LogicalType, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

/// Values that are decoded at a time.
const BATCH: usize = 1 << 14;

pub(super) struct Parquet {
    file: String,
    reader: SerializedFileReader<bytes::Bytes>,
    rows: usize,
    names: Vec<Named>,
    places: Vec<Place>,
}

/// One element of a leaf of the schema.
#[derive(Debug, Clone, Copy)]
struct Place {
    leaf: usize,
    index: usize,
    /// Elements of every row.
    count: usize,
    /// Of stamps: seconds per count.
    stamp: Option<f64>,
}

impl Parquet {
    pub fn open(file: &str, all: Vec<u8>) -> Result<Self, LogError> {
        let reader = SerializedFileReader::new(bytes::Bytes::from(all)).map_err(|e| damaged(file, &e))?;
        let about = reader.metadata().file_metadata();
        let rows = usize::try_from(about.num_rows()).unwrap_or(usize::MAX);
        if rows > INPUT_LIMITS.log_rows {
            return Err(LogError::TooLong {
                file: file.to_string(),
                limit: INPUT_LIMITS.log_rows,
            });
        }
        let leaves = about.schema_descr().columns().to_vec();
        if leaves.len() > INPUT_LIMITS.log_columns {
            return Err(LogError::TooManyColumns {
                file: file.to_string(),
                columns: leaves.len(),
                limit: INPUT_LIMITS.log_columns,
            });
        }
        let mut found = Self {
            file: file.to_string(),
            reader,
            rows,
            names: Vec::new(),
            places: Vec::new(),
        };
        for (leaf, about) in leaves.iter().enumerate().filter(|(_, d)| is_number(d)) {
            let count = if about.max_rep_level() == 0 {
                1
            } else {
                found.elements(leaf)?
            };
            let stamp = seconds(about);
            if found.names.len() + count > INPUT_LIMITS.log_columns {
                return Err(too_large(file, "a row", INPUT_LIMITS.log_columns as u64));
            }
            for index in 0..count {
                found.names.push(arrays::named(&path(about), index, count));
                found.places.push(Place {
                    leaf,
                    index,
                    count,
                    stamp,
                });
            }
        }
        if found.names.is_empty() {
            let (file, detail) = (
                file.to_string(),
                "all columns of the table are text or lists of lists".to_string(),
            );
            return Err(LogError::NoSeries { file, detail });
        }
        Ok(found)
    }

    /// Elements of the first row of a list.
    fn elements(&self, leaf: usize) -> Result<usize, LogError> {
        let mut count = 0;
        self.each(leaf, Some(1), &mut |_, _| count += 1)?;
        Ok(count)
    }

    /// Hands every value of a leaf to `take`: whether a row begins with it, and the number.
    fn each(&self, leaf: usize, rows: Option<usize>, take: &mut dyn FnMut(bool, Value)) -> Result<(), LogError> {
        let damaged = |e: ParquetError| damaged(&self.file, &e);
        for group in 0..self.reader.num_row_groups() {
            let group = self.reader.get_row_group(group).map_err(damaged)?;
            match group.get_column_reader(leaf).map_err(damaged)? {
                ColumnReader::BoolColumnReader(c) => values(c, rows, &mut |v| Value::Real(f64::from(u8::from(*v))), take),
                ColumnReader::Int32ColumnReader(c) => values(c, rows, &mut |v| Value::Whole(i64::from(*v)), take),
                ColumnReader::Int64ColumnReader(c) => values(c, rows, &mut |v| Value::Whole(*v), take),
                ColumnReader::FloatColumnReader(c) => values(c, rows, &mut |v| Value::Real(f64::from(*v)), take),
                ColumnReader::DoubleColumnReader(c) => values(c, rows, &mut |v| Value::Real(*v), take),
                _ => Ok(()),
            }
            .map_err(damaged)?;
            if rows.is_some() {
                break;
            }
        }
        Ok(())
    }

    /// All elements of a leaf, row by row; rows of another length are NaN.
    fn leaf(&self, place: Place) -> Result<Vec<f64>, LogError> {
        let (count, limit) = (place.count, self.rows.saturating_mul(place.count));
        if limit > MOST_NUMBERS {
            return Err(too_large(&self.file, "a column", MOST_NUMBERS as u64));
        }
        let mut all: Vec<i64> = Vec::new();
        let mut values: Vec<f64> = Vec::new();
        let mut within = count;
        let take = &mut |begins: bool, value: Value| {
            if begins {
                // What the row before was short of.
                fill(&mut values, &mut all, count - within);
                within = 0;
            }
            if within < count && values.len() < limit {
                within += 1;
                match value {
                    Value::Whole(v) if place.stamp.is_some() => all.push(v),
                    Value::Missing if place.stamp.is_some() => all.push(i64::MIN),
                    _ => all.push(0),
                }
                values.push(value.number());
            }
        };
        self.each(place.leaf, None, take)?;
        fill(&mut values, &mut all, count - within);
        Ok(match place.stamp {
            Some(seconds) => since_first(all.into_iter(), seconds),
            None => values,
        })
    }
}

fn fill(values: &mut Vec<f64>, whole: &mut Vec<i64>, by: usize) {
    values.extend(std::iter::repeat_n(f64::NAN, by));
    whole.extend(std::iter::repeat_n(i64::MIN, by));
}

#[derive(Debug, Clone, Copy)]
enum Value {
    Real(f64),
    Whole(i64),
    Missing,
}

impl Value {
    fn number(self) -> f64 {
        match self {
            Self::Real(v) => v,
            Self::Whole(v) => v as f64,
            Self::Missing => f64::NAN,
        }
    }
}

impl Sheet for Parquet {
    fn names(&self) -> &[Named] {
        &self.names
    }

    fn rows(&self) -> usize {
        self.rows
    }

    fn load(&mut self, wanted: &[usize], _: usize) -> Result<Loaded, LogError> {
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut last: Option<(usize, Vec<f64>)> = None;
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by_key(|&k| self.places[wanted[k]].leaf);
        for k in order {
            let place = self.places[wanted[k]];
            if last.as_ref().is_none_or(|(leaf, _)| *leaf != place.leaf) {
                last = Some((place.leaf, self.leaf(place)?));
            }
            if let Some((_, all)) = &last {
                columns[k] = all.iter().skip(place.index).step_by(place.count).copied().collect();
            }
        }
        Ok(columns.into())
    }
}

/// Hands the values of one chunk over; what is null is missing.
fn values<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: Option<usize>,
    number: &mut dyn FnMut(&T::T) -> Value,
    take: &mut dyn FnMut(bool, Value),
) -> Result<(), ParquetError> {
    let (mut defined, mut repeated, mut found) = (Vec::new(), Vec::new(), Vec::new());
    let mut deepest = 0;
    loop {
        defined.clear();
        repeated.clear();
        found.clear();
        let most = rows.unwrap_or(BATCH);
        let (records, count, levels) = column.read_records(most, Some(&mut defined), Some(&mut repeated), &mut found)?;
        let levels = if defined.is_empty() { count } else { levels };
        deepest = defined.iter().copied().fold(deepest, i16::max);
        let mut numbers = found.iter();
        for level in 0..levels {
            let is_there = defined.get(level).is_none_or(|d| *d == deepest);
            let value = if is_there {
                numbers.next().map_or(Value::Missing, &mut *number)
            } else {
                Value::Missing
            };
            take(repeated.get(level).is_none_or(|r| *r == 0), value);
        }
        if records == 0 || rows.is_some() {
            return Ok(());
        }
    }
}

fn is_number(about: &ColumnDescriptor) -> bool {
    let known = matches!(
        about.physical_type(),
        Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
    );
    let counts = !matches!(about.logical_type_ref(), Some(LogicalType::Decimal(_)));
    known && counts && about.max_rep_level() <= 1
}

/// Of stamps: seconds per count.
fn seconds(about: &ColumnDescriptor) -> Option<f64> {
    let Some(LogicalType::Timestamp(stamp)) = about.logical_type_ref() else {
        return None;
    };
    Some(match stamp.unit {
        parquet::basic::TimeUnit::MILLIS => 1e-3,
        parquet::basic::TimeUnit::MICROS => 1e-6,
        parquet::basic::TimeUnit::NANOS => 1e-9,
    })
}

/// The name of a column, without what a list is made of.
fn path(about: &ColumnDescriptor) -> String {
    let parts = about.path().parts();
    let is_inner = |p: &&String| matches!(p.as_str(), "list" | "element" | "item" | "array" | "bag");
    let end = if about.max_rep_level() == 0 {
        0
    } else {
        parts.iter().rev().take_while(is_inner).count()
    };
    parts[..parts.len().saturating_sub(end).max(1)].join(".")
}

fn damaged(file: &str, e: &ParquetError) -> LogError {
    LogError::Damaged {
        file: file.to_string(),
        format: "Parquet file",
        detail: e.to_string(),
        remedy: "save it again: frame.to_parquet('log.parquet')",
    }
}
