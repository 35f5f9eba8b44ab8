//! Which column of a file is which quantity.

use super::columns::{Columns, Quantity, TimeUnit, candidates};
use super::error::LogError;
use super::names::{self, Named};
use super::report::{Finding, FindingKind};

/// Whether a quantity is looked for in this file.
pub(super) type Wanted<'a> = dyn Fn(Quantity) -> bool + 'a;

/// The names of a file's columns, and where they stand.
pub(super) struct Heading<'a> {
    pub file: &'a str,
    pub names: &'a [Named],
    /// Line of the names; `None` where they stand in none.
    pub line: Option<u64>,
    /// Whether the columns have only been numbered.
    pub is_numbered: bool,
}

/// Column numbers of everything that is read.
pub(super) struct Places {
    pub time: Option<usize>,
    /// Nanoseconds beside whole seconds.
    pub nanos: Option<usize>,
    /// As the name of the time column has it.
    pub time_unit: Option<TimeUnit>,
    pub q: Vec<usize>,
    /// Empty when the file has no velocities.
    pub qd: Vec<usize>,
    pub tau: Vec<usize>,
    /// Further quantities. A row need not have them.
    pub channels: Vec<usize>,
    /// What the units in the names are times SI, for every column of [`Places::all`].
    pub factors: Vec<f64>,
    pub findings: Vec<Finding>,
}

impl Places {
    pub fn find(heading: &Heading, columns: &Columns, joints: &[String], is_wanted: &Wanted) -> Result<Self, LogError> {
        let file = || heading.file.to_string();
        let all = heading.names;
        if all.is_empty() || all.iter().all(|n| n.name.is_empty()) {
            return Err(LogError::Empty { file: file() });
        }
        let mut missing = Vec::new();
        let [q, qd, tau] = [Quantity::Position, Quantity::Velocity, Quantity::Torque].map(|quantity| {
            if is_wanted(quantity) {
                columns_of(quantity, all, columns, joints).unwrap_or_else(|absent| {
                    missing.extend(absent);
                    Vec::new()
                })
            } else {
                Vec::new()
            }
        });
        // Time goes with the positions.
        let stream = q.first().map_or(0, |&at| all[at].stream);
        let (time, nanos) = match &columns.time {
            _ if !is_wanted(Quantity::Position) => (None, None),
            Some(name) => match all.iter().position(|n| n.is_called(name)) {
                Some(at) => (Some(at), None),
                None => {
                    missing.push(format!("`{name}` (time)"));
                    (None, None)
                }
            },
            None => names::known_time(all, stream).map_or((None, None), |(at, nanos)| (Some(at), nanos)),
        };
        let channels = if is_wanted(Quantity::Position) {
            channels_of(all, columns, &mut missing)
        } else {
            Vec::new()
        };
        if !missing.is_empty() {
            return Err(absent(heading, missing, tau.is_empty(), joints));
        }
        for &at in time.iter().chain(&q).chain(&qd).chain(&tau).chain(&channels) {
            let times = all.iter().filter(|n| n.name == all[at].name).count();
            if times > 1 {
                return Err(LogError::RepeatedColumn {
                    file: file(),
                    column: all[at].name.clone(),
                    times,
                });
            }
        }
        if time.is_none() && columns.sample_rate_hz.is_none() && is_wanted(Quantity::Position) {
            return Err(LogError::NoTimeBase { file: file() });
        }
        let mut found = Self {
            time_unit: time.and_then(|at| names::time_unit(all[at].unit.as_deref()?)),
            time,
            nanos,
            q,
            qd,
            tau,
            channels,
            factors: Vec::new(),
            findings: Vec::new(),
        };
        found.convert(heading, columns)?;
        Ok(found)
    }

    /// Every column beside time, in the order of the table.
    pub fn all(&self) -> impl Iterator<Item = usize> {
        let motion = self.q.iter().chain(&self.qd).chain(&self.tau);
        motion.chain(self.nanos.iter()).chain(&self.channels).copied()
    }

    /// Names of the columns of positions, velocities and torques.
    pub fn names(&self, all: &[Named]) -> [Vec<String>; 3] {
        [&self.q, &self.qd, &self.tau].map(|places| places.iter().map(|&at| all[at].name.clone()).collect())
    }

    /// Takes the units of the names, where the request states none.
    fn convert(&mut self, heading: &Heading, columns: &Columns) -> Result<(), LogError> {
        let (mut factors, mut said) = (Vec::new(), Vec::new());
        for (quantity, places) in [
            (Quantity::Position, &self.q),
            (Quantity::Velocity, &self.qd),
            (Quantity::Torque, &self.tau),
        ] {
            for &at in places {
                let factor = header_factor(heading, at, quantity, columns)?;
                if factor != 1.0 && said.len() < SAID {
                    said.push(format!("`{}`", heading.names[at].name));
                }
                factors.push(factor);
            }
        }
        factors.resize(self.all().count(), 1.0);
        if !said.is_empty() {
            self.findings.push(Finding {
                kind: FindingKind::HeaderUnit,
                count: factors.iter().filter(|f| **f != 1.0).count(),
                lines: Vec::new(),
                detail: format!(
                    "columns are converted from the units in their names ({}); state `unit` in `columns` to overrule them",
                    said.join(", ")
                ),
            });
        }
        self.factors = factors;
        Ok(())
    }
}

/// Columns that are named as examples.
const SAID: usize = 3;

/// The column of every joint, or the names that were not found. Velocities that nobody asked for may be absent.
fn columns_of(quantity: Quantity, names: &[Named], columns: &Columns, joints: &[String]) -> Result<Vec<usize>, Vec<String>> {
    let wanted = &quantity.of(columns).headers;
    let currents = quantity == Quantity::Torque && columns.torque.currents;
    let mut found = Vec::new();
    let mut absent = Vec::new();
    for (j, joint) in joints.iter().enumerate() {
        let accepted = match wanted.get(j) {
            Some(header) => vec![header.clone()],
            None => candidates(quantity, j + 1, joint),
        };
        let place = |name: &String| names.iter().position(|n| &n.name == name);
        let by_stem = |name: &String| names.iter().position(|n| &n.stem == name);
        match accepted.iter().find_map(place).or_else(|| accepted.iter().find_map(by_stem)) {
            Some(at) => found.push(at),
            None => absent.push(format!("`{}` (joint {joint})", accepted[0])),
        }
    }
    if absent.is_empty() {
        return Ok(found);
    }
    if wanted.is_empty()
        && let Some(known) = names::known(names, quantity, joints, currents)
    {
        return Ok(known);
    }
    if quantity == Quantity::Velocity && wanted.is_empty() {
        return Ok(Vec::new());
    }
    Err(absent)
}

/// The columns of further quantities; those that are not there join `missing`.
fn channels_of(names: &[Named], columns: &Columns, missing: &mut Vec<String>) -> Vec<usize> {
    let mut found = Vec::new();
    for channel in &columns.channels {
        match names.iter().position(|n| n.is_called(&channel.header)) {
            Some(at) => found.push(at),
            None => missing.push(format!("`{}` (channel {})", channel.header, channel.name)),
        }
    }
    found
}

fn absent(heading: &Heading, missing: Vec<String>, no_torque: bool, joints: &[String]) -> LogError {
    const SHOWN: usize = 60;
    let (file, n) = (heading.file.to_string(), joints.len());
    let example = format!("`time,q1,…,q{n},tau1,…,tau{n}`");
    if heading.is_numbered {
        let columns = heading.names.len();
        return LogError::NoHeader { file, example, columns };
    }
    let name = |h: &Named| match h.name.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("`{}…`", &h.name[..end]),
        None => format!("`{}`", h.name),
    };
    let mut found: Vec<String> = heading.names.iter().take(SHOWN).map(name).collect();
    if heading.names.len() > SHOWN {
        found.push(format!("and {} more", heading.names.len() - SHOWN));
    }
    let remedy = match names::has_currents(heading.names, joints) {
        Some(places) if no_torque => format!(
            "`{}` and its like are currents: give `columns.torque` with `unit`: \"A\" and `scale`: N m per A of every joint",
            heading.names[places[0]].name
        ),
        _ => format!("name the columns in `columns`, or use {example}"),
    };
    LogError::MissingColumns {
        file,
        line: heading.line,
        missing,
        found,
        remedy,
    }
}

/// What a column is to be multiplied by to be in SI, or in what the request states.
fn header_factor(heading: &Heading, at: usize, quantity: Quantity, columns: &Columns) -> Result<f64, LogError> {
    let (column, stated) = (&heading.names[at], quantity.of(columns));
    let Some(unit) = column.unit.as_deref().filter(|_| !stated.unit_stated) else {
        return Ok(1.0);
    };
    let refused = |remedy: &'static str| LogError::ForeignUnit {
        file: heading.file.to_string(),
        column: column.name.clone(),
        unit: unit.to_string(),
        quantity: quantity.word(),
        remedy,
    };
    match names::factor(unit) {
        Some((Quantity::Torque, _)) if names::is_current(unit) && quantity == Quantity::Torque && !stated.scale_stated => {
            Err(refused("currents are no torques: give `columns.torque.scale` in N m/A"))
        }
        Some((found, factor)) if found == quantity => Ok(factor),
        _ if stated.scale_stated => Ok(1.0),
        _ => Err(refused("state `unit`, or a `scale` to SI, in `columns`")),
    }
}
