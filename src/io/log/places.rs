//! Which field of a row is which quantity.

use super::columns::{Columns, Quantity, candidates};
use super::error::LogError;

/// Whether a quantity is looked for in this file.
pub(super) type Wanted<'a> = dyn Fn(Quantity) -> bool + 'a;

/// The delimiter that the first line of `start` that is no comment has most of.
pub(super) fn delimiter(start: &[u8]) -> u8 {
    let is_names = |l: &&[u8]| !l.starts_with(b"#") && !l.trim_ascii().is_empty();
    let line = start.split(|&b| b == b'\n').find(is_names).unwrap_or(start);
    let count = |d: u8| line.iter().filter(|&&b| b == d).count();
    [b',', b';', b'\t', b' ']
        .into_iter()
        .rev()
        .max_by_key(|&d| count(d))
        .unwrap_or(b',')
}

/// Field numbers of everything that is read.
pub(super) struct Places {
    pub time: Option<usize>,
    pub q: Vec<usize>,
    /// Empty when the file has no velocities.
    pub qd: Vec<usize>,
    pub tau: Vec<usize>,
}

impl Places {
    pub fn find(
        file: &str,
        header: &[String],
        columns: &Columns,
        joints: &[String],
        is_wanted: &Wanted,
    ) -> Result<Self, LogError> {
        let n = joints.len();
        let example = format!("`time,q1,…,q{n},tau1,…,tau{n}`");
        if header.is_empty() || header.iter().all(String::is_empty) {
            return Err(LogError::Empty { file: file.to_string() });
        }
        if header.iter().all(|h| h.parse::<f64>().is_ok()) {
            return Err(LogError::NoHeader {
                file: file.to_string(),
                example,
            });
        }
        let mut missing = Vec::new();
        let mut find = |quantity: Quantity, optional: bool| {
            if !is_wanted(quantity) {
                return Vec::new();
            }
            let wanted = &quantity.of(columns).headers;
            let mut found = Vec::new();
            let mut absent = Vec::new();
            for (j, joint) in joints.iter().enumerate() {
                let names = match wanted.get(j) {
                    Some(header) => vec![header.clone()],
                    None => candidates(quantity, j + 1, joint),
                };
                match names.iter().find_map(|name| header.iter().position(|h| h == name)) {
                    Some(at) => found.push(at),
                    None => absent.push(format!("`{}` (joint {joint})", names[0])),
                }
            }
            if absent.is_empty() {
                return found;
            }
            if !(optional && wanted.is_empty()) {
                missing.extend(absent);
            }
            Vec::new()
        };
        let q = find(Quantity::Position, false);
        let qd = find(Quantity::Velocity, true);
        let tau = find(Quantity::Torque, false);
        // Time goes with the positions.
        let time = match &columns.time {
            _ if !is_wanted(Quantity::Position) => None,
            Some(name) => header.iter().position(|h| h == name).or_else(|| {
                missing.push(format!("`{name}` (time)"));
                None
            }),
            None => ["time", "t", "timestamp", "time_s"]
                .iter()
                .find_map(|name| header.iter().position(|h| h.eq_ignore_ascii_case(name))),
        };
        if !missing.is_empty() {
            const SHOWN: usize = 60;
            let name = |h: &String| match h.char_indices().nth(SHOWN) {
                Some((end, _)) => format!("`{}…`", &h[..end]),
                None => format!("`{h}`"),
            };
            let mut found: Vec<String> = header.iter().take(SHOWN).map(name).collect();
            if header.len() > SHOWN {
                found.push(format!("and {} more", header.len() - SHOWN));
            }
            return Err(LogError::MissingColumns {
                file: file.to_string(),
                missing,
                found,
                example,
            });
        }
        for &at in time.iter().chain(&q).chain(&qd).chain(&tau) {
            let times = header.iter().filter(|h| **h == header[at]).count();
            if times > 1 {
                return Err(LogError::RepeatedColumn {
                    file: file.to_string(),
                    column: header[at].clone(),
                    times,
                });
            }
        }
        if time.is_none() && columns.sample_rate_hz.is_none() && is_wanted(Quantity::Position) {
            return Err(LogError::NoTimeBase { file: file.to_string() });
        }
        Ok(Self { time, q, qd, tau })
    }

    pub fn all(&self) -> impl Iterator<Item = usize> {
        self.q.iter().chain(&self.qd).chain(&self.tau).copied()
    }
}
