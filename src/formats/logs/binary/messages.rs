//! Messages of ROS 2 and ROS 1, and JSON, as they lie in recordings.

use super::definition::Definition;
use super::generic;
use cdr_encoding::from_bytes;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// Definitions are read as far (bytes); the longest of ROS have some ten thousand.
const LONGEST_DEFINITION: usize = 1 << 20;

/// What a message says of the joints, or numbers without names.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Sample {
    /// Since 1970 (ns); `None` where the sender states none.
    pub stamp_ns: Option<i64>,
    pub names: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
    /// Of a message that is only numbers.
    pub data: Vec<f64>,
}

/// How the messages of a topic are written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Format {
    JointState(Coding),
    Numbers(Coding),
    Json,
    /// Any other message, by its definition.
    Generic(Coding, Arc<Definition>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    Cdr,
    Ros1,
}

impl Format {
    /// Of a topic with messages of type `kind`, encoded as `coding` says and defined by `definition` (empty where the recording
    /// has none); `None` where it is not read.
    pub fn from_definition(kind: &str, coding: &str, definition: &[u8]) -> Option<Self> {
        let coding = match coding {
            "cdr" => Coding::Cdr,
            "ros1" => Coding::Ros1,
            "json" => return Some(Self::Json),
            _ => return None,
        };
        match kind {
            "sensor_msgs/msg/JointState" | "sensor_msgs/JointState" | "sensor_msgs::msg::dds_::JointState_" => {
                Some(Self::JointState(coding))
            }
            "std_msgs/msg/Float64MultiArray" | "std_msgs/Float64MultiArray" => Some(Self::Numbers(coding)),
            _ => {
                let text = String::from_utf8_lossy(definition.get(..LONGEST_DEFINITION).unwrap_or(definition));
                Some(Self::Generic(coding, Arc::new(Definition::read(kind, &text)?)))
            }
        }
    }

    /// Whether the messages are of no kind that is known to hold the quantities of joints.
    pub fn is_generic(&self) -> bool {
        matches!(self, Self::Generic(..))
    }

    /// # Errors
    /// What is wrong with the message, in words.
    pub fn read(&self, data: &[u8]) -> Result<Sample, String> {
        match self {
            Self::JointState(Coding::Cdr) => Ok(cdr::<JointState>(data)?.into()),
            Self::Numbers(Coding::Cdr) => Ok(cdr::<MultiArray>(data)?.into()),
            Self::JointState(Coding::Ros1) => ros1_joint_state(data).ok_or_else(|| "is cut off".to_string()),
            Self::Numbers(Coding::Ros1) => ros1_numbers(data).ok_or_else(|| "is cut off".to_string()),
            Self::Json => json(data),
            Self::Generic(coding, definition) => generic::read(definition, *coding, data),
        }
    }
}

#[derive(Deserialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[derive(Deserialize)]
struct Header {
    sec: i32,
    nanosec: u32,
    _frame_id: String,
}

#[derive(Deserialize)]
struct MultiArray {
    _dim: Vec<Dimension>,
    _offset: u32,
    data: Vec<f64>,
}

#[derive(Deserialize)]
struct Dimension {
    _label: String,
    _size: u32,
    _stride: u32,
}

impl From<JointState> for Sample {
    fn from(m: JointState) -> Self {
        Self {
            stamp_ns: Some(stamp(i64::from(m.header.sec), m.header.nanosec)),
            names: m.name,
            position: m.position,
            velocity: m.velocity,
            effort: m.effort,
            data: Vec::new(),
        }
    }
}

impl From<MultiArray> for Sample {
    fn from(m: MultiArray) -> Self {
        Self {
            data: m.data,
            ..Self::default()
        }
    }
}

pub(super) fn stamp(sec: i64, nanosec: u32) -> i64 {
    sec.saturating_mul(1_000_000_000).saturating_add(i64::from(nanosec))
}

/// A message of DDS: four bytes that say how it is written, and the message.
fn cdr<T: DeserializeOwned>(data: &[u8]) -> Result<T, String> {
    let (head, body) = data.split_at_checked(4).ok_or("has no header")?;
    let read = match head[..2] {
        [0, 0] => from_bytes::<T, byteorder::BigEndian>(body),
        [0, 1] => from_bytes::<T, byteorder::LittleEndian>(body),
        _ => return Err(format!("is encoded as {:02x}{:02x}, which is no plain CDR", head[0], head[1])),
    };
    read.map(|(message, _)| message).map_err(|e| e.to_string())
}

/// Fields of ROS 1: little-endian, without padding.
struct Ros1<'a>(&'a [u8]);

impl<'a> Ros1<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn word(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(4)?.try_into().ok()?))
    }

    fn text(&mut self) -> Option<String> {
        let length = self.word()? as usize;
        Some(String::from_utf8_lossy(self.bytes(length)?).to_string())
    }

    fn texts(&mut self) -> Option<Vec<String>> {
        let count = self.word()?;
        (0..count).map(|_| self.text()).collect()
    }

    fn numbers(&mut self) -> Option<Vec<f64>> {
        let count = self.word()? as usize;
        let raw = self.bytes(count.checked_mul(8)?)?;
        Some(raw.as_chunks::<8>().0.iter().map(|c| f64::from_le_bytes(*c)).collect())
    }
}

fn ros1_joint_state(data: &[u8]) -> Option<Sample> {
    let mut fields = Ros1(data);
    let (_seq, sec, nanosec, _frame) = (fields.word()?, fields.word()?, fields.word()?, fields.text()?);
    Some(Sample {
        stamp_ns: Some(stamp(i64::from(sec), nanosec)),
        names: fields.texts()?,
        position: fields.numbers()?,
        velocity: fields.numbers()?,
        effort: fields.numbers()?,
        data: Vec::new(),
    })
}

fn ros1_numbers(data: &[u8]) -> Option<Sample> {
    let mut fields = Ros1(data);
    for _ in 0..fields.word()? {
        let (_label, _size, _stride) = (fields.text()?, fields.word()?, fields.word()?);
    }
    fields.word()?;
    Some(Sample {
        data: fields.numbers()?,
        ..Sample::default()
    })
}

/// A message in JSON: one of joints by its fields, else its numbers by their names.
fn json(data: &[u8]) -> Result<Sample, String> {
    let value: serde_json::Value = serde_json::from_slice(data).map_err(|e| e.to_string())?;
    let numbers = |key: &str| {
        let items = value.get(key).and_then(|v| v.as_array());
        items.map_or(Vec::new(), |list| {
            list.iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
        })
    };
    let names = value.get("name").or_else(|| value.get("names")).and_then(|v| v.as_array());
    if let Some(names) = names {
        let at = value.pointer("/header/stamp").or_else(|| value.get("timestamp"));
        let part = |keys: [&str; 2]| keys.iter().find_map(|k| at?.get(*k)?.as_i64());
        return Ok(Sample {
            stamp_ns: part(["sec", "secs"]).map(|s| stamp(s, part(["nanosec", "nsec"]).unwrap_or(0) as u32)),
            names: names.iter().map(|n| n.as_str().unwrap_or_default().to_string()).collect(),
            position: numbers("position"),
            velocity: numbers("velocity"),
            effort: numbers("effort"),
            data: Vec::new(),
        });
    }
    let mut sample = Sample::default();
    flatten(&value, "", &mut sample);
    Ok(sample)
}

/// The numbers within a value, named by the way to them. serde_json descends no deeper than 128.
fn flatten(value: &serde_json::Value, path: &str, into: &mut Sample) {
    let below = |key: &str| {
        if path.is_empty() {
            key.to_string()
        } else {
            format!("{path}/{key}")
        }
    };
    match value {
        serde_json::Value::Number(n) => {
            into.names.push(path.to_string());
            into.data.push(n.as_f64().unwrap_or(f64::NAN));
        }
        serde_json::Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(k, v)| flatten(v, &below(&k.to_string()), into)),
        serde_json::Value::Object(fields) => fields.iter().for_each(|(k, v)| flatten(v, &below(k), into)),
        _ => {}
    }
}
