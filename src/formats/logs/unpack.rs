//! Compressed logs, unpacked as they are read and no further than a recording goes.

use super::LogError;
use super::kind::{Foreign, Kind};
use super::reader::broken;
use crate::model::INPUT_LIMITS;
use flate2::read::MultiGzDecoder;
use std::io::{self, BufRead, BufReader, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of a file, as they are read.
pub(super) type Bytes<'a> = Box<dyn BufRead + Send + 'a>;

/// Bytes at the beginning that say what a file is.
const TELLING: usize = 4096;

/// What a file is and what is in it, which gzip or Zstandard may have packed; text is UTF-8.
pub(super) fn unpacked<'a, R: Read + Send + 'a>(file: &str, bytes: R) -> Result<(Kind, Bytes<'a>), LogError> {
    let (start, bytes) = peeked(file, Box::new(bytes))?;
    let bytes = match start {
        s if s.starts_with(&[0x1f, 0x8b]) => limited(bytes, |packed| Ok(Box::new(MultiGzDecoder::new(packed)))),
        #[cfg(feature = "formats")]
        s if s.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]) => limited(bytes, |packed| Ok(Box::new(zstd::Decoder::new(packed)?))),
        _ => Ok(bytes),
    };
    let bytes = bytes.map_err(|e| broken(file, 1, &e))?;
    let (start, bytes) = peeked(file, bytes)?;
    match Kind::from_start(&start) {
        Kind::Foreign(Foreign { what, remedy }) => Err(LogError::Foreign {
            file: file.to_string(),
            what,
            remedy,
        }),
        Kind::Utf16 => {
            let utf8 = Utf16::new(bytes, start.starts_with(b"\xfe\xff"));
            Ok((Kind::Text, Box::new(BufReader::with_capacity(1 << 16, utf8))))
        }
        kind => Ok((kind, Box::new(BufReader::with_capacity(1 << 16, bytes)))),
    }
}

/// The first bytes, and all of them.
fn peeked<'a>(file: &str, mut bytes: Box<dyn Read + Send + 'a>) -> Result<(Vec<u8>, Box<dyn Read + Send + 'a>), LogError> {
    let mut start = Vec::with_capacity(TELLING);
    let read = bytes.by_ref().take(TELLING as u64).read_to_end(&mut start);
    if start.is_empty() {
        read.map_err(|e| broken(file, 1, &e))?;
        return Err(LogError::Empty { file: file.to_string() });
    }
    // What breaks behind the beginning is found again when it is read.
    let after = read.err();
    let rest: Box<dyn Read + Send + 'a> = match after {
        Some(e) => Box::new(Fails(Some(e))),
        None => bytes,
    };
    Ok((start.clone(), Box::new(io::Cursor::new(start).chain(rest))))
}

/// The end of a file that broke.
struct Fails(Option<io::Error>);

impl Read for Fails {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        self.0.take().map_or(Ok(0), Err)
    }
}

/// The unpacked bytes of a file, no more than a recording has.
fn limited<'a>(
    bytes: Box<dyn Read + Send + 'a>,
    unpack: impl FnOnce(Counted<Box<dyn Read + Send + 'a>>) -> io::Result<Box<dyn Read + Send + 'a>>,
) -> io::Result<Box<dyn Read + Send + 'a>> {
    let read = Arc::new(AtomicU64::new(0));
    let packed = Counted {
        bytes,
        read: Arc::clone(&read),
    };
    Ok(Box::new(Limited {
        text: unpack(packed)?,
        packed: read,
        unpacked: 0,
    }))
}

/// UTF-16 as UTF-8.
struct Utf16<R> {
    bytes: R,
    decoder: encoding_rs::Decoder,
    /// Decoded and not yet handed out.
    text: Vec<u8>,
    at: usize,
    ended: bool,
}

impl<R: Read> Utf16<R> {
    fn new(bytes: R, big_endian: bool) -> Self {
        let encoding = if big_endian {
            encoding_rs::UTF_16BE
        } else {
            encoding_rs::UTF_16LE
        };
        Self {
            bytes,
            decoder: encoding.new_decoder_with_bom_removal(),
            text: Vec::new(),
            at: 0,
            ended: false,
        }
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while self.at == self.text.len() && !self.ended {
            let mut raw = [0; 1 << 14];
            let count = self.bytes.read(&mut raw)?;
            self.ended = count == 0;
            // Two bytes become three at most.
            self.text.resize(2 * raw.len() + 16, 0);
            let (_, _, written, _) = self.decoder.decode_to_utf8(&raw[..count], &mut self.text, self.ended);
            self.text.truncate(written);
            self.at = 0;
        }
        let count = out.len().min(self.text.len() - self.at);
        out[..count].copy_from_slice(&self.text[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}

/// Counts what is read.
struct Counted<R> {
    bytes: R,
    read: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.bytes.read(buffer)?;
        self.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

/// Text that ends with an error where it is larger than a recording of that many packed bytes can be.
struct Limited<R> {
    text: R,
    packed: Arc<AtomicU64>,
    unpacked: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.text.read(buffer)?;
        self.unpacked += count as u64;
        let allowed = INPUT_LIMITS
            .log_expansion
            .saturating_mul(self.packed.load(Ordering::Relaxed))
            .max(INPUT_LIMITS.log_unpacked_free);
        if self.unpacked > allowed {
            let detail = format!(
                "unpacks to more than {} times its size, as no recording does; send it unpacked if it is one",
                INPUT_LIMITS.log_expansion
            );
            return Err(io::Error::other(detail));
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn packed(text: &[u8], times: usize) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        (0..times).for_each(|_| encoder.write_all(text).unwrap());
        encoder.finish().unwrap()
    }

    #[test]
    fn a_file_that_unpacks_a_thousandfold_is_refused_before_it_fills_the_memory() {
        let bomb = packed(&[b'0'; 1 << 20], 200);
        assert!(bomb.len() < 300_000);
        let (_, mut text) = unpacked("bomb", &bomb[..]).unwrap();
        let error = io::copy(&mut text, &mut io::sink()).unwrap_err();
        assert!(error.to_string().contains("more than 100 times its size"), "{error}");
        let small = packed(b"0,0\n", 1000);
        let (_, mut text) = unpacked("small", &small[..]).unwrap();
        assert_eq!(io::copy(&mut text, &mut io::sink()).unwrap(), 4000);
    }
}
