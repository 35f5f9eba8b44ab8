//! Recordings of messages: topics become streams of columns, joints keep their names, and streams are laid beside each other in
//! time.

use super::super::LogError;
use super::super::names::Named;
use super::super::report::{Finding, FindingKind};
use super::super::sheet::{Loaded, Sheet};
use super::messages::Sample;
use super::{MOST_NUMBERS, too_large};
use crate::model::INPUT_LIMITS;
use std::collections::{BTreeMap, HashMap};

/// Topics, and sets of joints within a topic, that are kept apart.
const MOST_STREAMS: usize = 200;
/// Senders whose stamps are off the time of receipt by the same, within a second (ns), have one clock: delays are far shorter,
/// clocks that nobody has set are off by days.
const ONE_CLOCK: u64 = 1_000_000_000;
/// Values are interpolated over no more than so many of the usual steps of their stream; farther apart there are none.
const WIDEST_STEP: f64 = 5.0;

/// Numbers that messages of other kinds may have together: a quarter of what is read at most.
const MOST_GENERIC: usize = MOST_NUMBERS / 4;
/// Forms that the messages of one such topic may have: arrays that change their lengths all the time are no series.
const MOST_FORMS: usize = 3;

/// What a message has of every joint.
const QUANTITIES: [&str; 3] = ["position", "velocity", "effort"];

/// Messages of one topic about the same joints.
#[derive(Debug, Default)]
struct Stream {
    topic: String,
    /// Of joints, or of the numbers of a message that has no joints.
    names: Vec<String>,
    has_joints: bool,
    log_ns: Vec<i64>,
    stamp_ns: Vec<i64>,
    /// Whether every message had a stamp.
    is_stamped: bool,
    /// Whether the messages are of a kind that is not known to be about joints.
    is_generic: bool,
    /// Message by message; empty where no message had any. Without joints the first has the numbers.
    values: [Vec<f64>; 3],
}

/// A recording while it is read.
pub(super) struct Recording {
    file: String,
    streams: Vec<Stream>,
    by_key: HashMap<(String, Vec<String>), usize>,
    last: usize,
    numbers_left: usize,
    /// Numbers that messages of other kinds may have together, and messages.
    generic_left: usize,
    generic_messages: usize,
    /// Topics that are not read, with the type of their messages.
    unread: BTreeMap<String, String>,
    /// Messages that could not be read, and what was wrong with the first.
    broken: usize,
    first_broken: Option<String>,
    messages: usize,
}

impl Recording {
    pub fn new(file: &str) -> Self {
        Self {
            file: file.to_string(),
            streams: Vec::new(),
            by_key: HashMap::new(),
            last: 0,
            numbers_left: MOST_NUMBERS,
            generic_left: MOST_GENERIC,
            generic_messages: 0,
            unread: BTreeMap::new(),
            broken: 0,
            first_broken: None,
            messages: 0,
        }
    }

    pub fn unread(&mut self, topic: &str, kind: &str) {
        if self.unread.len() < MOST_STREAMS {
            let short = |text: &str| text.chars().take(100).collect();
            self.unread.insert(short(topic), short(kind));
        }
    }

    /// Takes a message of a kind that is not known to be about joints. Such topics give way: one that cannot be read, changes its
    /// fields, or is larger than what is left for all of them, is left out with its type.
    pub fn take_generic(
        &mut self,
        topic: &str,
        kind: &str,
        log_ns: i64,
        message: impl FnOnce() -> Result<Sample, String>,
    ) -> Result<(), LogError> {
        if self.unread.contains_key(topic) {
            return Ok(());
        }
        self.generic_messages += 1;
        let sample = message().ok().filter(|s| !s.data.is_empty());
        let room = sample.as_ref().and_then(|s| self.generic_left.checked_sub(s.data.len() + 2));
        let streams = self.streams.iter().filter(|s| s.topic == topic).count();
        let (Some(sample), Some(left)) = (sample, room) else {
            self.drop_topic(topic, kind);
            return Ok(());
        };
        let is_new = !self.by_key.contains_key(&(topic.to_string(), sample.names.clone()));
        let others = self.streams.iter().filter(|s| s.is_generic).count();
        if is_new && (streams >= MOST_FORMS || others >= MOST_STREAMS / 2) || self.generic_messages > INPUT_LIMITS.log_rows {
            self.drop_topic(topic, kind);
            return Ok(());
        }
        self.generic_left = left;
        self.keep(topic, log_ns, sample, true)
    }

    /// Forgets a topic.
    fn drop_topic(&mut self, topic: &str, kind: &str) {
        self.unread(topic, kind);
        for stream in self.streams.iter_mut().filter(|s| s.topic == topic && s.is_generic) {
            self.generic_left += stream.log_ns.len() * (stream.names.len() + 2);
            // A stream without names has no columns.
            *stream = Stream {
                topic: stream.topic.clone(),
                is_generic: true,
                ..Stream::default()
            };
        }
        self.by_key.retain(|(of, _), _| of != topic);
        self.last = usize::MAX;
    }

    /// Takes a message that was received at `log_ns`.
    pub fn take(&mut self, topic: &str, log_ns: i64, message: Result<Sample, String>) -> Result<(), LogError> {
        self.messages += 1;
        if self.messages > INPUT_LIMITS.log_rows {
            return Err(LogError::TooLong {
                file: self.file.clone(),
                limit: INPUT_LIMITS.log_rows,
            });
        }
        let sample = match message {
            Ok(sample) => sample,
            Err(detail) => {
                self.broken += 1;
                self.first_broken
                    .get_or_insert_with(|| format!("message {} of {topic} {detail}", self.messages));
                return Ok(());
            }
        };
        self.keep(topic, log_ns, sample, false)
    }

    fn keep(&mut self, topic: &str, log_ns: i64, sample: Sample, is_generic: bool) -> Result<(), LogError> {
        let at = self.stream(topic, &sample)?;
        let stream = &mut self.streams[at];
        stream.is_generic = is_generic;
        let count = stream.names.len();
        let kept = if is_generic {
            0
        } else if stream.has_joints {
            3 * count + 2
        } else {
            count + 2
        };
        self.numbers_left = match self.numbers_left.checked_sub(kept) {
            Some(left) => left,
            None => return Err(too_large(&self.file, "all topics", MOST_NUMBERS as u64)),
        };
        stream.is_stamped &= sample.stamp_ns.is_some();
        stream.log_ns.push(log_ns);
        stream.stamp_ns.push(sample.stamp_ns.unwrap_or(log_ns));
        let rows = stream.log_ns.len();
        let of = if stream.has_joints {
            [sample.position, sample.velocity, sample.effort]
        } else {
            [sample.data, Vec::new(), Vec::new()]
        };
        for (kept, values) in stream.values.iter_mut().zip(of) {
            if values.len() == count && count > 0 {
                kept.resize((rows - 1) * count, f64::NAN);
                kept.extend(values);
            }
        }
        Ok(())
    }

    /// The stream of messages like this one.
    fn stream(&mut self, topic: &str, sample: &Sample) -> Result<usize, LogError> {
        let has_joints = sample.data.is_empty();
        let count = [&sample.position, &sample.velocity, &sample.effort, &sample.data]
            .iter()
            .map(|v| v.len())
            .max()
            .unwrap_or(0);
        let is_same = |s: &Stream| {
            s.topic == topic
                && s.has_joints == has_joints
                && if sample.names.is_empty() {
                    s.names.len() == count
                } else {
                    s.names == sample.names
                }
        };
        if self.streams.get(self.last).is_some_and(is_same) {
            return Ok(self.last);
        }
        let names = if sample.names.is_empty() {
            // The numbers of arrays count from zero, as programs write them.
            (0..count.min(INPUT_LIMITS.log_columns)).map(|k| format!("[{k}]")).collect()
        } else {
            sample.names.clone()
        };
        let key = (topic.to_string(), names.clone());
        if let Some(&at) = self.by_key.get(&key) {
            self.last = at;
            return Ok(at);
        }
        if self.streams.len() >= MOST_STREAMS || names.len() > INPUT_LIMITS.log_columns {
            return Err(too_large(&self.file, "topics with different joints", MOST_STREAMS as u64));
        }
        self.last = self.streams.len();
        self.by_key.insert(key, self.last);
        self.streams.push(Stream {
            topic: topic.to_string(),
            names,
            has_joints,
            is_stamped: true,
            ..Stream::default()
        });
        Ok(self.last)
    }

    /// The columns of what has been read.
    pub fn finish(mut self) -> Result<Bag, LogError> {
        if self.broken * 20 > self.messages {
            return Err(LogError::Damaged {
                file: self.file,
                format: "recording of messages",
                detail: format!(
                    "{} of {} messages cannot be read: {}",
                    self.broken,
                    self.messages,
                    self.first_broken.unwrap_or_default()
                ),
                remedy: "record it again, or convert it to CSV",
            });
        }
        if self.streams.iter().all(|s| s.names.is_empty()) {
            return Err(self.nothing_read());
        }
        for stream in &mut self.streams {
            // Stamps that nobody filled in are all zero.
            stream.is_stamped &= stream.stamp_ns.iter().any(|ns| *ns != 0);
            let whole = stream.log_ns.len() * stream.names.len();
            stream
                .values
                .iter_mut()
                .filter(|v| !v.is_empty())
                .for_each(|v| v.resize(whole, f64::NAN));
        }
        self.streams.retain(|s| !(s.is_generic && s.names.is_empty()));
        // The joints that a topic is mostly about have its plain name; others, such as those of a gripper, a number behind it.
        self.streams
            .sort_by_key(|s| (s.is_generic, std::cmp::Reverse(s.log_ns.len())));
        let (mut names, mut places) = (Vec::new(), Vec::new());
        let mut seen: HashMap<String, usize> = HashMap::new();
        for (at, stream) in self.streams.iter().enumerate() {
            let times = seen.entry(stream.topic.clone()).or_default();
            *times += 1;
            let topic = if *times > 1 {
                format!("{}~{times}", stream.topic)
            } else {
                stream.topic.clone()
            };
            let mut add = |name: String, column: Column| {
                names.push(Named {
                    is_other: stream.is_generic,
                    ..Named::plain(name, at)
                });
                places.push(column);
            };
            add(format!("{topic}/log_time"), Column::LogTime);
            if stream.is_stamped {
                add(format!("{topic}/stamp"), Column::Stamp);
            }
            for (quantity, word) in QUANTITIES.iter().enumerate().filter(|(q, _)| !stream.values[*q].is_empty()) {
                for (joint, name) in stream.names.iter().enumerate() {
                    let full = match (stream.has_joints, name.starts_with('[')) {
                        (true, true) => format!("{topic}/{word}{name}"),
                        (true, false) => format!("{topic}/{name}/{word}"),
                        (false, true) => format!("{topic}/data{name}"),
                        (false, false) => format!("{topic}/{name}"),
                    };
                    add(full, Column::Value { quantity, joint });
                }
            }
        }
        Ok(Bag {
            streams: self.streams,
            names,
            places,
        })
    }

    fn nothing_read(&self) -> LogError {
        const SHOWN: usize = 12;
        let topics: Vec<String> = self
            .unread
            .iter()
            .take(SHOWN)
            .map(|(topic, kind)| format!("{topic} ({kind})"))
            .collect();
        let more = if self.unread.len() > SHOWN { ", …" } else { "" };
        let there = if topics.is_empty() {
            "it has no messages".to_string()
        } else {
            format!("its topics are {}{more}", topics.join(", "))
        };
        LogError::NoSeries {
            file: self.file.clone(),
            detail: format!(
                "{there}; messages with numbers are read where the recording defines them (bags in SQLite since ROS 2 Iron): record /joint_states too"
            ),
        }
    }
}

/// The columns of a recording.
pub(super) struct Bag {
    streams: Vec<Stream>,
    names: Vec<Named>,
    places: Vec<Column>,
}

#[derive(Debug, Clone, Copy)]
enum Column {
    LogTime,
    Stamp,
    Value { quantity: usize, joint: usize },
}

impl Sheet for Bag {
    fn names(&self) -> &[Named] {
        &self.names
    }

    fn rows(&self) -> usize {
        self.streams.iter().map(|s| s.log_ns.len()).max().unwrap_or(0)
    }

    fn load(&mut self, wanted: &[usize], base: usize) -> Result<Loaded, LogError> {
        // Streams are compared by the stamps of their senders where all have them of one clock.
        let mut others: Vec<usize> = wanted
            .iter()
            .map(|&at| self.names[at].stream)
            .filter(|&s| s != base)
            .collect();
        others.sort_unstable();
        others.dedup();
        let off = |s: usize| {
            let stream = &self.streams[s];
            let first = stream.log_ns.first().zip(stream.stamp_ns.first());
            first.map_or(0, |(log, stamp)| log.wrapping_sub(*stamp))
        };
        let same = |&s: &usize| self.streams[s].is_stamped && off(s).abs_diff(off(base)) < ONE_CLOCK;
        let by_stamp = self.streams[base].is_stamped && others.iter().all(same);
        let clock = |s: usize| {
            if by_stamp {
                &self.streams[s].stamp_ns
            } else {
                &self.streams[s].log_ns
            }
        };
        let mut columns: Vec<Vec<f64>> = wanted
            .iter()
            .map(|&at| {
                let stream = self.names[at].stream;
                let values = self.column(at);
                if stream == base {
                    values
                } else {
                    beside(clock(base), clock(stream), &values)
                }
            })
            .collect();
        let findings = self.aligned(&others, base, by_stamp);
        if !others.is_empty() {
            trim(&mut columns);
        }
        Ok(Loaded { columns, findings })
    }
}

impl Bag {
    fn column(&self, at: usize) -> Vec<f64> {
        let stream = &self.streams[self.names[at].stream];
        let since = |ns: &[i64]| {
            let first = ns.first().copied().unwrap_or(0);
            ns.iter().map(|n| n.wrapping_sub(first) as f64 * 1e-9).collect()
        };
        match self.places[at] {
            Column::LogTime => since(&stream.log_ns),
            Column::Stamp => since(&stream.stamp_ns),
            Column::Value { quantity, joint } => {
                let every = stream.names.len();
                stream.values[quantity].iter().skip(joint).step_by(every).copied().collect()
            }
        }
    }

    fn aligned(&self, others: &[usize], base: usize, by_stamp: bool) -> Vec<Finding> {
        let topics: Vec<&str> = others.iter().map(|&s| self.streams[s].topic.as_str()).collect();
        if topics.is_empty() {
            return Vec::new();
        }
        let by = if by_stamp {
            "the stamps of their senders"
        } else {
            "the times of receipt"
        };
        vec![Finding {
            kind: FindingKind::Aligned,
            count: self.streams[base].log_ns.len(),
            lines: Vec::new(),
            detail: format!(
                "{} laid beside {} by {by}: values are interpolated linearly at the messages of the latter",
                topics.join(" and "),
                self.streams[base].topic
            ),
        }]
    }
}

/// Values at the times `at` of a series with the times `of`: linear between neighbours, NaN where there are none near.
fn beside(at: &[i64], of: &[i64], values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..of.len().min(values.len())).collect();
    order.sort_by_key(|&k| of[k]);
    order.dedup_by_key(|k| of[*k]);
    let widest = widest(at).max(widest(&order.iter().map(|&k| of[k]).collect::<Vec<_>>()));
    let value = |&time: &i64| {
        let after = order.partition_point(|&k| of[k] < time);
        let Some(&k1) = order.get(after) else { return f64::NAN };
        if of[k1] == time {
            return values[k1];
        }
        let Some(&k0) = after.checked_sub(1).and_then(|k| order.get(k)) else {
            return f64::NAN;
        };
        let step = of[k1].abs_diff(of[k0]) as f64;
        if step > widest {
            return f64::NAN;
        }
        let part = time.abs_diff(of[k0]) as f64 / step;
        values[k0] + part * (values[k1] - values[k0])
    };
    at.iter().map(value).collect()
}

/// Several usual steps of a series (ns).
fn widest(of: &[i64]) -> f64 {
    let mut steps: Vec<u64> = of.windows(2).map(|w| w[1].abs_diff(w[0])).collect();
    steps.sort_unstable();
    steps.get(steps.len() / 2).map_or(0.0, |&median| WIDEST_STEP * median as f64)
}

/// Leaves out the rows before all streams have begun, and those after one has ended.
fn trim(columns: &mut [Vec<f64>]) {
    let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
    let whole = |row: &usize| columns.iter().all(|c| c[*row].is_finite());
    let (Some(first), Some(last)) = ((0..rows).find(whole), (0..rows).rev().find(whole)) else {
        return;
    };
    for column in columns {
        column.truncate(last + 1);
        column.drain(..first);
    }
}
