//! Which column of a file is which quantity of which joint, and how its numbers become SI.

use nalgebra::{DMatrix, DVector};

/// The mapping from a file's header to the joints, as the request's `columns` gives it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// Header of the time column; `None` looks for the usual names.
    pub time: Option<String>,
    /// `None` where the stamps themselves have to say: seconds, if they make a plausible rate.
    pub time_unit: Option<TimeUnit>,
    /// Rate where there is no time column (Hz); with a time column it overrides what the stamps say.
    pub sample_rate_hz: Option<f64>,
    /// Positions (rad or m).
    pub position: JointColumns,
    /// Velocities (rad/s or m/s); no headers if they are differentiated.
    pub velocity: JointColumns,
    /// Torques or forces [N·m or N].
    pub torque: JointColumns,
    /// Further quantities, in the log itself.
    pub channels: Vec<ChannelColumn>,
}

/// A further quantity: a temperature, a pressure, a current.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelColumn {
    /// Name in formulas.
    pub name: String,
    /// Header of its column.
    pub header: String,
    /// Unit of its numbers, which stay as they are.
    pub unit: String,
}

/// The columns of one quantity. Empty `headers` look for the default names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointColumns {
    /// One header per joint, in the order of the joints.
    pub headers: Vec<String>,
    /// Name of the file that has them, row for row beside the log; `None` for the log itself.
    pub file: Option<String>,
    /// Conversion of the raw columns to SI units.
    pub transformation: Transformation,
    /// Whether the unit is stated: one in a header is then not used.
    pub unit_stated: bool,
    /// Whether a scale is stated, as counts and currents need one.
    pub scale_stated: bool,
    /// Whether the columns are currents, which the scale makes torques.
    pub currents: bool,
}

impl Columns {
    /// Names of the files besides the log that columns are in, each once.
    pub fn files(&self) -> Vec<&str> {
        let named = [&self.velocity, &self.torque].into_iter().filter_map(|q| q.file.as_deref());
        let mut found: Vec<&str> = named.collect();
        found.dedup();
        found
    }
}

/// `x = C (s ∘ raw) + o`: factor per column (unit, sign, gear ratio, N m/A together), coupling between columns, offset in SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Transformation {
    /// Per joint; empty for ones.
    pub factor: Vec<f64>,
    /// n × n; `None` for the identity.
    pub coupling: Option<DMatrix<f64>>,
    /// Per joint, SI; empty for zeros.
    pub offset: Vec<f64>,
}

/// Unit of the time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    Seconds,
    /// 1e-3 s.
    Milliseconds,
    /// 1e-6 s.
    Microseconds,
    /// 1e-9 s.
    Nanoseconds,
}

impl TimeUnit {
    /// From the longest to the shortest.
    pub const ALL: [Self; 4] = [Self::Seconds, Self::Milliseconds, Self::Microseconds, Self::Nanoseconds];

    /// Name in words, and as requests have it.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Seconds => ("seconds", "s"),
            Self::Milliseconds => ("milliseconds", "ms"),
            Self::Microseconds => ("microseconds", "us"),
            Self::Nanoseconds => ("nanoseconds", "ns"),
        }
    }

    /// Length of the unit (s).
    pub fn seconds(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e-3,
            Self::Microseconds => 1e-6,
            Self::Nanoseconds => 1e-9,
        }
    }
}

impl Transformation {
    /// Whether values pass unchanged.
    pub fn is_identity(&self) -> bool {
        self.coupling.is_none() && self.factor.iter().all(|&f| f == 1.0) && self.offset.iter().all(|&o| o == 0.0)
    }

    /// Applies to all samples of all joints in place.
    ///
    /// # Panics
    /// When a length is neither zero nor the number of joints.
    pub fn apply(&self, columns: &mut [Vec<f64>], offset: bool) {
        let n = columns.len();
        let at = |values: &[f64], j: usize, otherwise: f64| values.get(j).copied().unwrap_or(otherwise);
        for (j, column) in columns.iter_mut().enumerate() {
            let factor = at(&self.factor, j, 1.0);
            if factor != 1.0 {
                column.iter_mut().for_each(|v| *v *= factor);
            }
        }
        if let Some(coupling) = &self.coupling {
            assert_eq!(coupling.shape(), (n, n), "one row and one column per joint");
            for s in 0..columns[0].len() {
                let raw = DVector::from_fn(n, |j, _| columns[j][s]);
                let mixed = coupling * raw;
                columns.iter_mut().zip(mixed.iter()).for_each(|(column, &v)| column[s] = v);
            }
        }
        for (j, column) in columns.iter_mut().enumerate().filter(|_| offset) {
            let shift = at(&self.offset, j, 0.0);
            if shift != 0.0 {
                column.iter_mut().for_each(|v| *v += shift);
            }
        }
    }
}

/// Names under which the quantities of joint `number` (from 1), called `name`, are looked for, most common first.
pub(super) fn candidates(quantity: Quantity, number: usize, name: &str) -> Vec<String> {
    let stems: &[&str] = match quantity {
        Quantity::Position => &["q", "position", "pos"],
        Quantity::Velocity => &["qd", "velocity", "vel"],
        Quantity::Torque => &["tau", "torque", "effort"],
    };
    let mut found: Vec<String> = stems
        .iter()
        .flat_map(|s| [format!("{s}{number}"), format!("{s}_{number}")])
        .collect();
    found.extend(stems.iter().flat_map(|s| {
        [
            format!("{s}_{name}"),
            format!("{name}_{s}"),
            format!("{s}.{name}"),
            format!("{name}.{s}"),
        ]
    }));
    found
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    Velocity,
    Torque,
}

impl Quantity {
    pub fn word(self) -> &'static str {
        match self {
            Self::Position => "positions",
            Self::Velocity => "velocities",
            Self::Torque => "torques",
        }
    }

    pub fn of(self, columns: &Columns) -> &JointColumns {
        match self {
            Self::Position => &columns.position,
            Self::Velocity => &columns.velocity,
            Self::Torque => &columns.torque,
        }
    }
}
