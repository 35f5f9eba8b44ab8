//! Archives of NumPy arrays: `numpy.savez` and `numpy.savez_compressed`.

use super::super::LogError;
use super::super::names::Named;
use super::super::sheet::{Loaded, Sheet};
use super::arrays::{self, Place, Shape};
use super::{MOST_NUMBERS, too_large};
use crate::model::INPUT_LIMITS;
use npyz::{DType, NpyHeader, Order, TypeChar, TypeStr};
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Longest header of an array that is read, and the deepest brackets in it: a shape within a dictionary.
const LONGEST_HEADER: usize = 10_000;
const DEEPEST: usize = 4;
/// Arrays in one archive.
const MOST_ARRAYS: usize = INPUT_LIMITS.log_columns;

pub(super) struct Npz {
    file: String,
    archive: ZipArchive<Cursor<Vec<u8>>>,
    arrays: Vec<Array>,
    names: Vec<Named>,
    places: Vec<Place>,
}

struct Array {
    entry: usize,
    shape: Shape,
    number: Number,
    by_columns: bool,
    /// Bytes before the numbers.
    header: usize,
}

/// How a number is written.
#[derive(Debug, Clone, Copy)]
struct Number {
    kind: TypeChar,
    size: usize,
    big: bool,
    /// Of stamps: seconds per count.
    seconds: f64,
}

impl Npz {
    pub fn open(file: &str, bytes: Vec<u8>) -> Result<Self, LogError> {
        let size = bytes.len() as u64;
        let damaged = |detail: String| damaged(file, detail);
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged(e.to_string()))?;
        let names: Vec<String> = archive.file_names().filter_map(|n| Some(n.ok()?.to_string())).collect();
        if !names.iter().any(|n| n.ends_with(".npy")) {
            let of_excel = names.iter().any(|n| n.starts_with("xl/"));
            return Err(LogError::Foreign {
                file: file.to_string(),
                what: if of_excel {
                    "an Excel file"
                } else {
                    "a ZIP archive without NumPy arrays"
                },
                remedy: if of_excel {
                    "save it as CSV"
                } else {
                    "give the log itself, arrays of numpy.savez, or the folder of a rosbag2 recording"
                },
            });
        }
        let mut arrays = Vec::new();
        for entry in 0..archive.len().min(MOST_ARRAYS) {
            let mut content = archive.by_index(entry).map_err(|e| damaged(e.to_string()))?;
            let Ok(name) = content.name().map(|n| n.to_string()) else {
                continue;
            };
            let Some(name) = name.strip_suffix(".npy") else { continue };
            if let Some(array) = Array::read(name, entry, &mut content).map_err(|e| damaged(format!("array `{name}`: {e}")))? {
                arrays.push(array);
            }
        }
        let allowed = INPUT_LIMITS
            .log_expansion
            .saturating_mul(size)
            .max(INPUT_LIMITS.log_unpacked_free);
        for array in &arrays {
            let numbers = array.shape.rows.saturating_mul(array.shape.columns);
            if numbers > MOST_NUMBERS || (numbers as u64).saturating_mul(array.number.size as u64) > allowed {
                return Err(too_large(file, "an array", MOST_NUMBERS as u64));
            }
        }
        let shapes: Vec<Shape> = arrays.iter().map(|a| a.shape.clone()).collect();
        let (names, places) = arrays::columns(&shapes);
        if names.is_empty() {
            let detail = "the archive has no arrays of numbers, one or two-dimensional".to_string();
            let file = file.to_string();
            return Err(LogError::NoSeries { file, detail });
        }
        Ok(Self {
            file: file.to_string(),
            archive,
            arrays,
            names,
            places,
        })
    }

    fn array(&mut self, at: usize) -> Result<Vec<f64>, LogError> {
        let array = &self.arrays[at];
        let (name, number) = (&array.shape.name, array.number);
        let damaged = |detail: String| damaged(&self.file, format!("array `{name}`: {detail}"));
        let bytes = array.shape.rows * array.shape.columns * number.size;
        let mut content = self.archive.by_index(array.entry).map_err(|e| damaged(e.to_string()))?;
        let mut raw = Vec::new();
        content
            .by_ref()
            .take((array.header + bytes) as u64)
            .read_to_end(&mut raw)
            .map_err(|e| damaged(e.to_string()))?;
        // The checksum is looked at where the entry ends.
        content.read(&mut [0]).map_err(|e| damaged(e.to_string()))?;
        if raw.len() < array.header + bytes {
            return Err(damaged(format!(
                "ends after {} of {bytes} bytes",
                raw.len().saturating_sub(array.header)
            )));
        }
        Ok(number.read(&raw[array.header..]))
    }
}

impl Sheet for Npz {
    fn names(&self) -> &[Named] {
        &self.names
    }

    fn rows(&self) -> usize {
        let samples = |p: &Place| {
            let shape = &self.arrays[p.array].shape;
            if p.transposed { shape.columns } else { shape.rows }
        };
        self.places.first().map_or(0, samples)
    }

    fn load(&mut self, wanted: &[usize], _: usize) -> Result<Loaded, LogError> {
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by_key(|&k| self.places[wanted[k]].array);
        let mut last: Option<(usize, Vec<f64>)> = None;
        for k in order {
            let place = self.places[wanted[k]];
            if last.as_ref().is_none_or(|(array, _)| *array != place.array) {
                last = Some((place.array, self.array(place.array)?));
            }
            if let Some((array, data)) = &last {
                let array = &self.arrays[*array];
                columns[k] = arrays::values(data, &array.shape, place, array.by_columns);
            }
        }
        Ok(columns.into())
    }
}

fn damaged(file: &str, detail: String) -> LogError {
    LogError::Damaged {
        file: file.to_string(),
        format: "NPZ archive",
        detail,
        remedy: "save it again: numpy.savez_compressed('log.npz', time=t, q=q, tau=tau)",
    }
}

impl Array {
    /// The header of an array; `None` for one that is no series of numbers.
    fn read(name: &str, entry: usize, content: &mut impl Read) -> Result<Option<Self>, String> {
        let mut head = vec![0; 12];
        content.read_exact(&mut head[..10]).map_err(|e| e.to_string())?;
        if !head.starts_with(b"\x93NUMPY") {
            return Err("has not the first bytes of an array".into());
        }
        let length = if head[6] == 1 {
            head.truncate(10);
            usize::from(u16::from_le_bytes([head[8], head[9]]))
        } else {
            content.read_exact(&mut head[10..]).map_err(|e| e.to_string())?;
            u32::from_le_bytes([head[8], head[9], head[10], head[11]]) as usize
        };
        if length > LONGEST_HEADER {
            return Err(format!("its header is longer than {LONGEST_HEADER} bytes"));
        }
        let text = head.len();
        head.resize(text + length, 0);
        content.read_exact(&mut head[text..]).map_err(|e| e.to_string())?;
        // The parser of the library descends as deep as brackets do.
        if depth(&head[text..]) > DEEPEST {
            return Err("its header has too many brackets".into());
        }
        let header = NpyHeader::from_reader(&head[..]).map_err(|e| e.to_string())?;
        let dims: Vec<usize> = header
            .shape()
            .iter()
            .map(|&n| usize::try_from(n).unwrap_or(usize::MAX))
            .collect();
        let (rows, columns) = match dims[..] {
            [n] => (n, 1),
            [r, c] => (r, c),
            _ => return Ok(None),
        };
        let number = match header.dtype() {
            DType::Plain(kind) => Number::from_type(&kind),
            _ => None,
        };
        Ok(number.map(|number| Self {
            entry,
            shape: Shape {
                name: name.to_string(),
                rows,
                columns,
            },
            number,
            by_columns: header.order() == Order::Fortran && columns > 1,
            header: head.len(),
        }))
    }
}

fn depth(text: &[u8]) -> usize {
    let (mut now, mut most) = (0usize, 0);
    for byte in text {
        match byte {
            b'(' | b'[' | b'{' => now += 1,
            b')' | b']' | b'}' => now = now.saturating_sub(1),
            _ => {}
        }
        most = most.max(now);
    }
    most
}

impl Number {
    fn from_type(kind: &TypeStr) -> Option<Self> {
        let size = kind.num_bytes()?;
        let seconds = match kind.time_units().map(|u| u.to_str()) {
            Some("ns") => 1e-9,
            Some("us") => 1e-6,
            Some("ms") => 1e-3,
            _ => 1.0,
        };
        let known = match kind.type_char() {
            TypeChar::Bool => size == 1,
            TypeChar::Int | TypeChar::Uint => matches!(size, 1 | 2 | 4 | 8),
            TypeChar::Float => matches!(size, 4 | 8),
            TypeChar::DateTime | TypeChar::TimeDelta => size == 8 && kind.time_units().is_some(),
            _ => false,
        };
        known.then_some(Self {
            kind: kind.type_char(),
            size,
            big: kind.endianness() == npyz::Endianness::Big,
            seconds,
        })
    }

    fn read(&self, bytes: &[u8]) -> Vec<f64> {
        let whole = |raw: &[u8]| {
            let mut word = [0u8; 8];
            for (k, &byte) in raw.iter().enumerate() {
                word[if self.big { raw.len() - 1 - k } else { k }] = byte;
            }
            u64::from_le_bytes(word)
        };
        let signed = |raw: &[u8]| {
            let unused = 64 - 8 * self.size as u32;
            (whole(raw) << unused) as i64 >> unused
        };
        let chunks = bytes.chunks_exact(self.size);
        match self.kind {
            TypeChar::Float if self.size == 8 => chunks.map(|c| f64::from_bits(whole(c))).collect(),
            TypeChar::Float => chunks.map(|c| f64::from(f32::from_bits(whole(c) as u32))).collect(),
            TypeChar::Int => chunks.map(|c| signed(c) as f64).collect(),
            TypeChar::DateTime | TypeChar::TimeDelta => since_first(chunks.map(signed), self.seconds),
            _ => chunks.map(|c| whole(c) as f64).collect(),
        }
    }
}

/// Stamps as seconds since the first: doubles do not resolve nanoseconds since 1970.
pub(super) fn since_first(counts: impl Iterator<Item = i64>, seconds: f64) -> Vec<f64> {
    let mut first = None;
    counts
        .map(|count| {
            // The least number stands for none.
            if count == i64::MIN {
                return f64::NAN;
            }
            let since = count.wrapping_sub(*first.get_or_insert(count));
            since as f64 * seconds
        })
        .collect()
}
