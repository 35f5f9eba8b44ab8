//! Compressed logs, unpacked as they are read and no further than a recording goes.

use super::LogError;
use super::reader::broken;
use crate::model::INPUT_LIMITS;
use flate2::read::MultiGzDecoder;
use std::io::{self, BufRead, BufReader, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The text of a file, which gzip may have packed.
pub(super) fn unpacked<'a, R: Read + Send + 'a>(file: &str, bytes: R) -> Result<Box<dyn BufRead + Send + 'a>, LogError> {
    let mut bytes = BufReader::with_capacity(1 << 16, bytes);
    let start = bytes.fill_buf().map_err(|e| broken(file, 1, &e))?;
    if start.is_empty() {
        return Err(LogError::Empty { file: file.to_string() });
    }
    if !start.starts_with(&[0x1f, 0x8b]) {
        return Ok(Box::new(bytes));
    }
    let read = Arc::new(AtomicU64::new(0));
    let packed = Counted {
        bytes,
        read: Arc::clone(&read),
    };
    let unpacked = Limited {
        text: MultiGzDecoder::new(packed),
        packed: read,
        unpacked: 0,
    };
    Ok(Box::new(BufReader::with_capacity(1 << 16, unpacked)))
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
                "unpacks to more than {} times its size, as no recording does; send it as plain text if it is one",
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
        let mut text = unpacked("bomb", &bomb[..]).unwrap();
        let error = io::copy(&mut text, &mut io::sink()).unwrap_err();
        assert!(error.to_string().contains("more than 100 times its size"), "{error}");
        let small = packed(b"0,0\n", 1000);
        let mut text = unpacked("small", &small[..]).unwrap();
        assert_eq!(io::copy(&mut text, &mut io::sink()).unwrap(), 4000);
    }
}
