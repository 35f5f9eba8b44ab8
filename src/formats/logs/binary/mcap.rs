//! MCAP: recordings of ROS 2, ROS 1 and others.

use super::super::LogError;
use super::super::reader::broken;
use super::bag::{Bag, Recording};
use super::messages::Format;
use crate::model::INPUT_LIMITS;
use mcap::McapError;
use mcap::sans_io::linear_reader::LinearReaderOptions;
use mcap::sans_io::message_reader::{MessageReadEvent, MessageReader};
use std::collections::HashMap;
use std::io::Read;

/// Longest message, schema or other record that is read (bytes): a picture or a point cloud, which are skipped.
const LONGEST_RECORD: usize = 256 << 20;

pub(super) fn open(file: &str, bytes: &mut impl Read) -> Result<Bag, LogError> {
    let mut recording = Recording::new(file);
    read_into(file, bytes, &mut recording)?;
    recording.finish()
}

/// The messages of one file of a recording.
pub(super) fn read_into(file: &str, bytes: &mut impl Read, recording: &mut Recording) -> Result<(), LogError> {
    let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
    let mut reader = MessageReader::new_with_options(options);
    let mut raw = Limit::new();
    let mut formats: HashMap<u16, Option<Format>> = HashMap::new();
    while let Some(event) = reader.next_event() {
        match event.map_err(|e| damaged(file, &e))? {
            MessageReadEvent::ReadRequest(size) => {
                let count = bytes.read(reader.insert(size)).map_err(|e| broken(file, 0, &e))?;
                raw.read += count as u64;
                reader.notify_read(count);
            }
            MessageReadEvent::Message(message) => {
                raw.unpacked(message.data.len()).ok_or_else(|| bomb(file))?;
                let channel = &message.channel;
                let kind = channel.schema.as_ref().map_or("", |s| s.name.as_str());
                let format = formats.entry(channel.id).or_insert_with(|| {
                    let definition = channel.schema.as_ref().map_or(&[][..], |s| &s.data[..]);
                    Format::from_definition(kind, &channel.message_encoding, definition)
                });
                match format {
                    Some(format) => {
                        let log_ns = i64::try_from(message.log_time).unwrap_or(i64::MAX);
                        let (topic, data) = (&channel.topic, &message.data);
                        match format.is_generic() {
                            true => recording.take_generic(topic, kind, log_ns, || format.read(data))?,
                            false => recording.take(topic, log_ns, format.read(data))?,
                        }
                    }
                    None => recording.unread(&channel.topic, kind),
                }
            }
        }
    }
    Ok(())
}

/// What chunks unpack to, held against what was read.
struct Limit {
    read: u64,
    unpacked: u64,
}

impl Limit {
    fn new() -> Self {
        Self { read: 0, unpacked: 0 }
    }

    fn unpacked(&mut self, bytes: usize) -> Option<()> {
        self.unpacked += bytes as u64;
        let allowed = INPUT_LIMITS
            .log_expansion
            .saturating_mul(self.read)
            .max(INPUT_LIMITS.log_unpacked_free);
        (self.unpacked <= allowed).then_some(())
    }
}

fn bomb(file: &str) -> LogError {
    LogError::Unreadable {
        file: file.to_string(),
        detail: format!(
            "unpacks to more than {} times its size, as no recording does",
            INPUT_LIMITS.log_expansion
        ),
    }
}

fn damaged(file: &str, e: &McapError) -> LogError {
    LogError::Damaged {
        file: file.to_string(),
        format: "MCAP recording",
        detail: e.to_string(),
        remedy: "`mcap recover log.mcap -o whole.mcap` saves what is whole of it",
    }
}
