//! Any message with numbers, by its definition: CDR of ROS 2 and the encoding of ROS 1.

use super::definition::{Count, Definition, Number, Resolved, ResolvedKind};
use super::messages::{Coding, Sample, stamp};
use crate::model::INPUT_LIMITS;

/// Messages within messages; those of ROS are nested four deep at most.
const DEEPEST: usize = 12;
/// Longer arrays are pictures, scans and maps.
const LONGEST_ARRAY: usize = 256;

/// Reads a message. Numbers have the names of their fields, `wrench/force/x` and `data[3]`; that of a header's stamp is the
/// sample's.
///
/// # Errors
/// What is wrong with the message, in words.
pub(super) fn read(definition: &Definition, coding: Coding, data: &[u8]) -> Result<Sample, String> {
    let (big_endian, body) = match coding {
        Coding::Ros1 => (false, data),
        Coding::Cdr => {
            let (head, body) = data.split_at_checked(4).ok_or("has no header")?;
            match head[..2] {
                [0, 0] => (true, body),
                [0, 1] => (false, body),
                _ => return Err(format!("is encoded as {:02x}{:02x}, which is no plain CDR", head[0], head[1])),
            }
        }
    };
    let mut reader = Reader {
        definition,
        coding,
        big_endian,
        body,
        at: 0,
        sample: Sample::default(),
        skipped: 0,
    };
    reader
        .message(0, "", 0)
        .ok_or("is cut off, or not what its definition says")?;
    Ok(reader.sample)
}

struct Reader<'a> {
    definition: &'a Definition,
    coding: Coding,
    big_endian: bool,
    body: &'a [u8],
    at: usize,
    sample: Sample,
    /// Fields are passed over without being kept while this is above zero.
    skipped: usize,
}

impl<'a> Reader<'a> {
    /// CDR puts numbers at multiples of their size.
    fn bytes(&mut self, count: usize, align: usize) -> Option<&'a [u8]> {
        if self.coding == Coding::Cdr {
            self.at = self.at.checked_next_multiple_of(align)?;
        }
        let end = self.at.checked_add(count)?;
        let taken = self.body.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn number(&mut self, kind: Number) -> Option<f64> {
        let size = kind.size();
        let taken = self.bytes(size, size)?;
        let mut raw = [0u8; 8];
        for (k, byte) in taken.iter().enumerate() {
            raw[if self.big_endian { size - 1 - k } else { k }] = *byte;
        }
        let bits = u64::from_le_bytes(raw);
        let unused = 64 - 8 * size as u32;
        Some(match kind {
            Number::Bool => f64::from(u8::from(bits != 0)),
            Number::Uint(_) => bits as f64,
            // The sign is the highest bit of the number's own size.
            Number::Int(_) => ((bits << unused) as i64 >> unused) as f64,
            Number::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Number::Float(_) => f64::from_bits(bits),
        })
    }

    fn length(&mut self) -> Option<usize> {
        Some(self.number(Number::Uint(4))? as usize)
    }

    fn message(&mut self, at: usize, path: &str, depth: usize) -> Option<()> {
        let fields: &'a [Resolved] = &self.definition.messages[at];
        if depth > DEEPEST {
            return None;
        }
        // A struct has one member at least.
        if fields.is_empty() && self.coding == Coding::Cdr {
            self.bytes(1, 1)?;
        }
        for field in fields {
            let name = if path.is_empty() {
                field.name.clone()
            } else {
                format!("{path}/{}", field.name)
            };
            self.field(field, &name, depth)?;
        }
        Some(())
    }

    fn field(&mut self, field: &Resolved, name: &str, depth: usize) -> Option<()> {
        let count = match field.count {
            Count::One => return self.value(field.kind, name, depth),
            Count::Fixed(count) => count,
            Count::Many => self.length()?,
        };
        let keeps = count <= LONGEST_ARRAY;
        // What is passed over need not be looked at number by number.
        if let (false, ResolvedKind::Number(kind)) = (keeps, field.kind) {
            return self.bytes(kind.size().checked_mul(count)?, kind.size()).map(|_| ());
        }
        self.skipped += usize::from(!keeps);
        for k in 0..count {
            let before = self.at;
            self.value(field.kind, &if keeps { format!("{name}[{k}]") } else { String::new() }, depth)?;
            // Elements take room: a count that does not fit into the message ends here.
            if self.at == before {
                return None;
            }
        }
        self.skipped -= usize::from(!keeps);
        Some(())
    }

    fn value(&mut self, kind: ResolvedKind, name: &str, depth: usize) -> Option<()> {
        match kind {
            ResolvedKind::Number(number) => {
                let value = self.number(number)?;
                self.keep(name, value)
            }
            ResolvedKind::Text => {
                let length = self.length()?;
                self.bytes(length, 1).map(|_| ())
            }
            ResolvedKind::WideText => {
                let length = self.length()?;
                self.bytes(length.checked_mul(2)?, 2).map(|_| ())
            }
            ResolvedKind::Time => {
                let (sec, nanosec) = (self.number(Number::Int(4))?, self.number(Number::Uint(4))?);
                let ns = stamp(sec as i64, nanosec as u32);
                match name {
                    "header/stamp" | "stamp" => self.sample.stamp_ns = Some(ns),
                    _ => self.keep(name, ns as f64 * 1e-9)?,
                }
                Some(())
            }
            ResolvedKind::Message(at) => self.message(at, name, depth + 1),
        }
    }

    fn keep(&mut self, name: &str, value: f64) -> Option<()> {
        // The counter of ROS 1 says nothing.
        if self.skipped > 0 || name == "header/seq" {
            return Some(());
        }
        if self.sample.data.len() >= INPUT_LIMITS.log_columns {
            return None;
        }
        self.sample.names.push(name.to_string());
        self.sample.data.push(value);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_size_are_read_in_both_orders_of_bytes() {
        let text = "int8 a\nfloat64 b\nuint16[3] c\nstring d\nbool e\nfloat32[] f\nint64 g\n";
        let definition = Definition::read("p/msg/M", text).unwrap();
        for big in [false, true] {
            let mut body: Vec<u8> = Vec::new();
            let mut put = |size: usize, bits: u64| {
                body.resize(body.len().next_multiple_of(size), 0);
                let raw = bits.to_le_bytes();
                let mut raw = raw[..size].to_vec();
                if big {
                    raw.reverse();
                }
                body.extend(raw);
            };
            put(1, 0xfd);
            put(8, 2.5f64.to_bits());
            (1..=3).for_each(|v| put(2, v * 1000));
            put(4, 3);
            b"hi\0".iter().for_each(|b| put(1, u64::from(*b)));
            put(1, 1);
            put(4, 2);
            put(4, u64::from(0.5f32.to_bits()));
            put(4, u64::from(1.5f32.to_bits()));
            put(8, (-7i64) as u64);
            let data = [vec![0, u8::from(!big), 0, 0], body].concat();
            let sample = read(&definition, Coding::Cdr, &data).unwrap();
            assert_eq!(sample.data, [-3.0, 2.5, 1000.0, 2000.0, 3000.0, 1.0, 0.5, 1.5, -7.0]);
            assert_eq!(sample.names, ["a", "b", "c[0]", "c[1]", "c[2]", "e", "f[0]", "f[1]", "g"]);
            for cut in 0..data.len() {
                assert!(read(&definition, Coding::Cdr, &data[..cut]).is_err(), "{cut} bytes");
            }
        }
    }

    #[test]
    fn counts_that_do_not_fit_are_refused_at_once() {
        for text in [
            "float64[] x\n",
            "Part[] x\n====================\nMSG: p/Part\nfloat64 y\n",
            "string[] x\n",
            "Empty[] x\n====================\nMSG: p/Empty\n\n",
        ] {
            let Some(definition) = Definition::read("p/msg/M", text) else {
                continue;
            };
            let data = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1, 2, 3];
            assert!(read(&definition, Coding::Cdr, &data).is_err(), "{text}");
        }
        let deep = Definition::read("p/msg/M", "M next\n").unwrap();
        assert!(read(&deep, Coding::Ros1, &[0; 8]).is_err(), "a message within itself");
    }
}
