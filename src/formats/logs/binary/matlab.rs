//! MATLAB files of level 5: versions 5 to 7, compressed or not.
//!
//! The format is that of "MAT-File Format" (The MathWorks): elements of a tag and data, matrices of flags, dimensions, name and
//! numbers, one within the other for structures and cells. It is read here and not by a library, because those there are descend
//! without end and take what a file states of its sizes at its word.

use super::super::LogError;
use super::super::names::Named;
use super::super::sheet::{Loaded, Sheet};
use super::arrays::{self, Place, Shape};
use super::{MOST_NUMBERS, too_large};
use crate::model::INPUT_LIMITS;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Structures within structures; logs are two or three deep.
const DEEPEST: usize = 8;
/// Arrays of one file, empty ones and those within cells too.
const MOST_ARRAYS: usize = 100_000;
const HEADER: usize = 128;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of matrices.
const CELL: u8 = 1;
const STRUCT: u8 = 2;
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;

pub(super) struct Matlab {
    arrays: Vec<(Shape, Vec<f64>)>,
    names: Vec<Named>,
    places: Vec<Place>,
}

impl Sheet for Matlab {
    fn names(&self) -> &[Named] {
        &self.names
    }

    fn rows(&self) -> usize {
        let samples = |p: &Place| {
            let shape = &self.arrays[p.array].0;
            if p.transposed { shape.columns } else { shape.rows }
        };
        self.places.first().map_or(0, samples)
    }

    fn load(&mut self, wanted: &[usize], _: usize) -> Result<Loaded, LogError> {
        let column = |&at: &usize| {
            let place = self.places[at];
            let (shape, data) = &self.arrays[place.array];
            arrays::values(data, shape, place, true)
        };
        Ok(wanted.iter().map(column).collect::<Vec<_>>().into())
    }
}

pub(super) fn open(file: &str, bytes: &[u8]) -> Result<Matlab, LogError> {
    let big = match bytes.get(126..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(refused(file, Refusal::Damaged("its header is not that of a MAT-file"))),
    };
    let packed = bytes.len() as u64;
    let mut reader = Reader {
        big,
        unpacked_left: INPUT_LIMITS
            .log_expansion
            .saturating_mul(packed)
            .max(INPUT_LIMITS.log_unpacked_free),
        numbers_left: MOST_NUMBERS,
        arrays_left: MOST_ARRAYS,
        found: Vec::new(),
    };
    reader.elements(&bytes[HEADER..]).map_err(|r| refused(file, r))?;
    let arrays = reader.found;
    let shapes: Vec<Shape> = arrays.iter().map(|(shape, _)| shape.clone()).collect();
    let (names, places) = arrays::columns(&shapes);
    if names.is_empty() {
        return Err(LogError::NoSeries {
            file: file.to_string(),
            detail:
                "it has no real matrices; objects such as timeseries and table are not read: save their Time and Data as arrays"
                    .into(),
        });
    }
    Ok(Matlab { arrays, names, places })
}

/// Why a file is not read.
enum Refusal {
    Damaged(&'static str),
    TooLarge,
}

fn refused(file: &str, why: Refusal) -> LogError {
    match why {
        Refusal::TooLarge => too_large(file, "all matrices", MOST_NUMBERS as u64),
        Refusal::Damaged(detail) => LogError::Damaged {
            file: file.to_string(),
            format: "MATLAB file",
            detail: detail.to_string(),
            remedy: "save it again: save('log.mat', 'time', 'q', 'tau', '-v7')",
        },
    }
}

const CUT: Refusal = Refusal::Damaged("an element is longer than the file");

struct Reader {
    big: bool,
    unpacked_left: u64,
    numbers_left: usize,
    arrays_left: usize,
    found: Vec<(Shape, Vec<f64>)>,
}

/// One element: its type, its data, and all that follows it.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
    rest: &'a [u8],
}

impl Reader {
    fn word(&self, bytes: &[u8]) -> Option<u32> {
        let four: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        Some(if self.big {
            u32::from_be_bytes(four)
        } else {
            u32::from_le_bytes(four)
        })
    }

    fn element<'a>(&self, bytes: &'a [u8]) -> Result<Element<'a>, Refusal> {
        let first = self.word(bytes).ok_or(CUT)?;
        // Up to four bytes of data stand within the tag.
        if first >> 16 != 0 {
            let data = bytes.get(4..8).ok_or(CUT)?;
            let length = (first >> 16) as usize;
            return Ok(Element {
                kind: first & 0xffff,
                data: data.get(..length).ok_or(CUT)?,
                rest: &bytes[8..],
            });
        }
        let length = self.word(bytes.get(4..).ok_or(CUT)?).ok_or(CUT)? as usize;
        let data = bytes.get(8..).and_then(|b| b.get(..length)).ok_or(CUT)?;
        let padded = if first == COMPRESSED {
            length
        } else {
            length.next_multiple_of(8)
        };
        Ok(Element {
            kind: first,
            data,
            rest: bytes.get(8 + padded..).unwrap_or(&[]),
        })
    }

    /// The variables of a file.
    fn elements(&mut self, mut bytes: &[u8]) -> Result<(), Refusal> {
        while bytes.len() >= 8 {
            let element = self.element(bytes)?;
            bytes = element.rest;
            match element.kind {
                MATRIX => self.matrix(element.data, "", 0)?,
                COMPRESSED => {
                    let inner = self.unpacked(element.data)?;
                    let matrix = self.element(&inner)?;
                    if matrix.kind == MATRIX {
                        self.matrix(matrix.data, "", 0)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn unpacked(&mut self, data: &[u8]) -> Result<Vec<u8>, Refusal> {
        let mut out = Vec::new();
        let read = ZlibDecoder::new(data).take(self.unpacked_left).read_to_end(&mut out);
        if out.len() as u64 >= self.unpacked_left {
            return Err(Refusal::TooLarge);
        }
        self.unpacked_left -= out.len() as u64;
        read.map_err(|_| Refusal::Damaged("a compressed variable cannot be unpacked"))?;
        Ok(out)
    }

    /// A matrix within the variable `path`, or that variable itself.
    fn matrix(&mut self, data: &[u8], path: &str, depth: usize) -> Result<(), Refusal> {
        if data.is_empty() {
            return Ok(());
        }
        self.arrays_left = self.arrays_left.checked_sub(1).ok_or(Refusal::TooLarge)?;
        if depth > DEEPEST {
            return Err(Refusal::Damaged("structures are nested too deep"));
        }
        let flags = self.element(data)?;
        let word = self.word(flags.data).ok_or(CUT)?;
        let (class, is_complex) = ((word & 0xff) as u8, word & 0x0800 != 0);
        if !NUMERIC.contains(&class) && class != STRUCT && class != CELL {
            return Ok(());
        }
        let dims = self.element(flags.rest)?;
        let sizes: Vec<usize> = dims
            .data
            .chunks_exact(4)
            .filter_map(|c| self.word(c))
            .map(|n| n as usize)
            .collect();
        let name = self.element(dims.rest)?;
        let own = text(name.data);
        let path = if path.is_empty() { own } else { path.to_string() };
        let count = sizes
            .iter()
            .try_fold(1usize, |n, &d| n.checked_mul(d))
            .ok_or(Refusal::TooLarge)?;
        match class {
            STRUCT => self.structure(name.rest, &path, count, depth),
            CELL => self
                .members(name.rest, count, depth, |k| format!("{path}{}", k + 1))
                .map(|_| ()),
            _ if is_complex || sizes.len() != 2 || path.is_empty() => Ok(()),
            _ => self.numbers(name.rest, &path, sizes[0], sizes[1]),
        }
    }

    fn structure(&mut self, rest: &[u8], path: &str, count: usize, depth: usize) -> Result<(), Refusal> {
        let length = self.element(rest)?;
        let width = self.word(length.data).ok_or(CUT)? as usize;
        let fields = self.element(length.rest)?;
        if width == 0 {
            return Err(Refusal::Damaged("a structure has fields without names"));
        }
        let names: Vec<String> = fields.data.chunks_exact(width).map(text).collect();
        let number = |k: usize| if count > 1 { (k + 1).to_string() } else { String::new() };
        let mut rest = fields.rest;
        for k in 0..count {
            if rest.is_empty() {
                break;
            }
            rest = self.members(rest, names.len(), depth, |f| format!("{path}{}.{}", number(k), names[f]))?;
        }
        Ok(())
    }

    /// Matrices one after the other, as long as there are any; what follows them.
    fn members<'a>(
        &mut self,
        mut rest: &'a [u8],
        count: usize,
        depth: usize,
        name: impl Fn(usize) -> String,
    ) -> Result<&'a [u8], Refusal> {
        for k in 0..count {
            if rest.len() < 8 {
                return Ok(&[]);
            }
            let member = self.element(rest)?;
            self.matrix(member.data, &name(k), depth + 1)?;
            rest = member.rest;
        }
        Ok(rest)
    }

    fn numbers(&mut self, rest: &[u8], name: &str, rows: usize, columns: usize) -> Result<(), Refusal> {
        let count = rows * columns;
        self.numbers_left = self.numbers_left.checked_sub(count).ok_or(Refusal::TooLarge)?;
        let element = self.element(rest)?;
        let data = self
            .decoded(&element)
            .ok_or(Refusal::Damaged("a matrix has numbers of an unknown type"))?;
        if data.len() < count {
            return Err(Refusal::Damaged("a matrix has fewer numbers than its dimensions say"));
        }
        let shape = Shape {
            name: name.to_string(),
            rows,
            columns,
        };
        self.found.push((shape, data));
        Ok(())
    }

    /// Numbers may be stored in a smaller type than their matrix has.
    fn decoded(&self, element: &Element) -> Option<Vec<f64>> {
        macro_rules! all {
            ($kind:ty) => {{
                const SIZE: usize = size_of::<$kind>();
                let one = |c: &[u8]| {
                    let raw: [u8; SIZE] = c.try_into().expect("chunks of that size");
                    (if self.big {
                        <$kind>::from_be_bytes(raw)
                    } else {
                        <$kind>::from_le_bytes(raw)
                    }) as f64
                };
                element.data.chunks_exact(SIZE).map(one).collect()
            }};
        }
        Some(match element.kind {
            1 => all!(i8),
            2 => all!(u8),
            3 => all!(i16),
            4 => all!(u16),
            5 => all!(i32),
            6 => all!(u32),
            7 => all!(f32),
            9 => all!(f64),
            12 => all!(i64),
            13 => all!(u64),
            _ => return None,
        })
    }
}

/// Text as far as its first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).to_string()
}
