//! How many rows a log may have, found out before it is read into memory.

use crate::app::{CancelFlag, Code, Error, LogFile};
use crate::formats::logs::{LogError, Rows, rows_of};
use std::io::Read;

/// Bytes a row may have on average: sixty columns of twenty-five characters, and some more. A file that is compressed a
/// thousandfold has no more of them either.
const BYTES_OF_ROW: usize = 2000;

/// Ends without a finding when `cancel` is set.
///
/// # Errors
/// The log has more than `most` rows.
pub fn check(log: &LogFile, most: usize, cancel: &CancelFlag) -> Result<(), Error> {
    let refused = |e: LogError| Error::new(Code::InvalidLog, e.named(&log.name).to_string());
    let within = match rows_of(&log.path).map_err(refused)? {
        // What is wrong with the compression itself is reported by the reader, in more detail.
        Rows::Lines(mut text) => within(&mut text, most, cancel).unwrap_or(true),
        Rows::Counted(rows) => rows <= most,
    };
    let detail = || {
        format!(
            "{}: has more than {most} rows, or more than {BYTES_OF_ROW} bytes a row",
            log.name
        )
    };
    within
        .then_some(())
        .ok_or_else(|| Error::new(Code::InvalidLog, detail()).with_hint("send the log in parts, or at a lower rate"))
}

fn within(text: &mut dyn Read, most: usize, cancel: &CancelFlag) -> std::io::Result<bool> {
    let (mut rows, mut bytes, mut buffer) = (0, 0, vec![0; 1 << 16]);
    loop {
        let read = text.read(&mut buffer)?;
        if read == 0 || cancel.is_cancelled() {
            return Ok(true);
        }
        bytes += read;
        rows += buffer[..read].iter().filter(|&&b| b == b'\n').count();
        // The header is a row more.
        if rows > most + 1 || bytes > most.saturating_mul(BYTES_OF_ROW) {
            return Ok(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    #[test]
    fn rows_are_counted_in_plain_and_compressed_logs() {
        let folder = tempfile::tempdir().unwrap();
        let text = format!("time,q1\n{}", "0,1\n".repeat(100));
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(text.as_bytes()).unwrap();
        for (name, content) in [("a.csv", text.clone().into_bytes()), ("a.csv.gz", encoder.finish().unwrap())] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            let log = LogFile::at(&path);
            assert!(check(&log, 100, &CancelFlag::default()).is_ok(), "{name}");
            let error = check(&log, 99, &CancelFlag::default()).unwrap_err();
            assert!(error.detail.starts_with(&format!("{name}: has more than 99 rows")), "{error}");
        }
    }

    /// Nobody waits for the end of a file that has none.
    #[test]
    fn counting_ends_when_it_is_cancelled() {
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert!(within(&mut std::io::repeat(b'0'), usize::MAX, &cancel).unwrap());
    }

    #[test]
    fn a_file_without_lines_is_not_read_to_its_end() {
        assert!(!within(&mut std::io::repeat(b'0'), 10, &CancelFlag::default()).unwrap());
    }
}
