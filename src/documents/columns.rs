//! The `columns` of a request: which column is what, and its unit, scale, sign, offset and coupling.

use super::cursor::{Cursor, Fields};
use super::requests;
use crate::effects::own::name_fault;
use crate::formats::logs::{ChannelColumn, Columns, JointColumns, PLAUSIBLE_HZ, TimeUnit, Transformation};
use crate::model::{INPUT_LIMITS, counted};
use nalgebra::DMatrix;
use std::f64::consts::PI;

const TIME_UNITS: &[(&str, TimeUnit)] = &[
    ("s", TimeUnit::Seconds),
    ("ms", TimeUnit::Milliseconds),
    ("us", TimeUnit::Microseconds),
    ("ns", TimeUnit::Nanoseconds),
];
const POSITION_UNITS: &[(&str, f64)] = &[("rad", 1.0), ("deg", PI / 180.0), ("rev", 2.0 * PI), ("m", 1.0), ("mm", 1e-3)];
const VELOCITY_UNITS: &[(&str, f64)] = &[
    ("rad/s", 1.0),
    ("deg/s", PI / 180.0),
    ("rpm", PI / 30.0),
    ("m/s", 1.0),
    ("mm/s", 1e-3),
];
/// `A` goes with a scale in N·m/A.
const TORQUE_UNITS: &[(&str, f64)] = &[
    ("N m", 1.0),
    ("Nm", 1.0),
    ("mN m", 1e-3),
    ("kN m", 1e3),
    ("N", 1.0),
    ("kN", 1e3),
    ("A", 1.0),
];

/// Reads the mapping for a robot of `joints` joints (`None` when the robot could not be read: lengths are then not checked).
pub fn read_columns(cursor: &Cursor, joints: Option<usize>) -> Columns {
    let Some(fields) = cursor.fields_of::<requests::Columns>() else {
        return Columns::default();
    };
    let rate = fields.nullable("sample_rate_hz").and_then(|c| {
        let rate = c.number()?;
        let [low, high] = PLAUSIBLE_HZ;
        if !(low..=high).contains(&rate) {
            c.complain(format!("is {rate}; a motion is sampled between {low} Hz and {high} Hz"));
        }
        Some(rate)
    });
    let mut columns = Columns {
        time: fields.nullable("time").and_then(|c| c.string()).map(str::to_string),
        time_unit: fields.nullable("time_unit").and_then(|c| c.choice(TIME_UNITS)),
        sample_rate_hz: rate,
        position: quantity(&fields, "position", POSITION_UNITS, joints),
        velocity: quantity(&fields, "velocity", VELOCITY_UNITS, joints),
        torque: quantity(&fields, "torque", TORQUE_UNITS, joints),
        channels: fields.nullable("channels").map_or_else(Vec::new, |c| channels(&c)),
    };
    if let Some(coupling) = fields.nullable("coupling") {
        couple(&coupling, joints, &mut columns);
    }
    columns
}

fn channels(cursor: &Cursor) -> Vec<ChannelColumn> {
    let items = cursor.items().unwrap_or_default();
    if items.len() > INPUT_LIMITS.channels {
        cursor.complain(format!(
            "has {} channels; at most {} are read",
            items.len(),
            INPUT_LIMITS.channels
        ));
        return Vec::new();
    }
    let mut found: Vec<ChannelColumn> = Vec::new();
    for item in &items {
        let Some(channel) = channel(item) else { continue };
        if found.iter().any(|c| c.name == channel.name) {
            item.complain_with(
                format!("is a second channel `{}`", channel.name),
                "give each a name of its own",
            );
        }
        found.push(channel);
    }
    found
}

fn channel(cursor: &Cursor) -> Option<ChannelColumn> {
    let fields = cursor.fields_of::<requests::ChannelColumn>()?;
    let name = fields.required("name").and_then(|c| {
        let name = c.string()?;
        match name_fault(name) {
            Some(detail) => {
                c.complain_with(detail, "use letters, digits and `_`, such as `temperature`");
                None
            }
            None => Some(name.to_string()),
        }
    });
    let text = |field: &str| fields.nullable(field).and_then(|c| c.string()).map(str::to_string);
    let (header, unit) = (text("header"), text("unit"));
    let name = name?;
    Some(ChannelColumn {
        header: header.unwrap_or_else(|| name.clone()),
        unit: unit.unwrap_or_else(|| "1".into()),
        name,
    })
}

fn quantity(fields: &Fields, name: &str, units: &[(&str, f64)], joints: Option<usize>) -> JointColumns {
    let Some(part) = fields.nullable(name).and_then(|c| c.fields_of::<requests::ColumnQuantity>()) else {
        return JointColumns::default();
    };
    let headers = part.nullable("headers").and_then(|c| {
        let items = c.items()?;
        if joints.is_some_and(|n| n != items.len()) {
            c.complain(format!(
                "has {} headers, the robot has {} joints",
                items.len(),
                joints.unwrap_or(0)
            ));
        }
        items
            .iter()
            .map(|i| i.string().map(str::to_string))
            .collect::<Option<Vec<_>>>()
    });
    let file = part.nullable("file").and_then(|c| {
        if name == "position" {
            c.complain_with(
                "positions are in the log itself",
                "name the file of the torques, and give that of the positions as the log",
            );
        }
        c.string().map(str::to_string)
    });
    let unit = part.nullable("unit").map(|c| per_joint(&c, joints, |c| c.choice(units)));
    let scale = part.nullable("scale").map(|c| per_joint(&c, joints, nonzero));
    if let (Some(c), None) = (part.nullable("unit"), &scale) {
        refuse_bare_currents(&c);
    }
    let sign = part.nullable("sign").map(|c| per_joint(&c, joints, one_or_minus_one));
    let offset = part.nullable("offset").map(|c| per_joint(&c, joints, |c| c.number()));
    let length = [&unit, &scale, &sign]
        .iter()
        .filter_map(|l| l.as_ref().map(Vec::len))
        .max()
        .unwrap_or(0);
    let at = |list: &Option<Vec<f64>>, j: usize| list.as_ref().and_then(|l| l.get(j)).copied().unwrap_or(1.0);
    let currents = part.nullable("unit").is_some_and(|c| names_current(&c));
    JointColumns {
        headers: headers.unwrap_or_default(),
        file,
        unit_stated: unit.is_some(),
        scale_stated: scale.is_some(),
        currents,
        transformation: Transformation {
            factor: (0..length).map(|j| at(&unit, j) * at(&scale, j) * at(&sign, j)).collect(),
            coupling: part.nullable("matrix").and_then(|c| matrix(&c, joints)),
            offset: offset.unwrap_or_default(),
        },
    }
}

/// Amperes are no torques without the constants of the motors.
fn refuse_bare_currents(unit: &Cursor) {
    if names_current(unit) {
        unit.complain_with(
            "is A, and there is no `scale` beside it: currents are no torques",
            "give `scale` in N m/A, torque constant times gear ratio, one number or one per joint",
        );
    }
}

fn names_current(unit: &Cursor) -> bool {
    let is_current = |v: &serde_json::Value| v.as_str() == Some("A");
    let listed = unit.value().as_array().is_some_and(|items| items.iter().any(is_current));
    listed || is_current(unit.value())
}

/// One value for all joints, or a list with one for each.
fn per_joint(cursor: &Cursor, joints: Option<usize>, read: impl Fn(&Cursor) -> Option<f64>) -> Vec<f64> {
    let count = joints.unwrap_or(1);
    if !cursor.value().is_array() {
        return read(cursor).map_or(Vec::new(), |v| vec![v; count]);
    }
    let items = cursor.items().unwrap_or_default();
    if joints.is_some_and(|n| n != items.len()) {
        cursor.complain(format!(
            "has {}, the robot has {}",
            counted(items.len(), "value"),
            counted(count, "joint")
        ));
        return Vec::new();
    }
    items.iter().map(|c| read(c).unwrap_or(1.0)).collect()
}

fn nonzero(cursor: &Cursor) -> Option<f64> {
    let value = cursor.number()?;
    if value == 0.0 {
        cursor.complain("is 0: a column times zero holds nothing");
        return None;
    }
    Some(value)
}

fn one_or_minus_one(cursor: &Cursor) -> Option<f64> {
    let value = cursor.number()?;
    if value.abs() != 1.0 {
        cursor.complain(format!("is {value}, expected 1 or -1"));
        return None;
    }
    Some(value)
}

fn matrix(cursor: &Cursor, joints: Option<usize>) -> Option<DMatrix<f64>> {
    let rows = cursor.items()?;
    let n = joints.unwrap_or(rows.len());
    if rows.len() != n {
        cursor.complain(format!("has {} rows, the robot has {n} joints", rows.len()));
        return None;
    }
    let rows: Option<Vec<Vec<f64>>> = rows.iter().map(|r| r.numbers(Some(n))).collect();
    rows.map(|rows| DMatrix::from_fn(n, n, |r, c| rows[r][c]))
}

/// Motors that turn with several joints: with `p = R q` the motor positions, `q = R⁻¹ p` and `tau = Rᵀ c`.
fn couple(cursor: &Cursor, joints: Option<usize>, columns: &mut Columns) {
    let Some(r) = matrix(cursor, joints) else { return };
    if columns.position.transformation.coupling.is_some() || columns.torque.transformation.coupling.is_some() {
        cursor.complain_with("stands beside a `matrix` of position or torque", "give one or the other");
        return;
    }
    let Some(inverse) = r.clone().try_inverse() else {
        cursor.complain("is singular: motor positions would not determine the joints");
        return;
    };
    columns.velocity.transformation.coupling = Some(inverse.clone());
    columns.position.transformation.coupling = Some(inverse);
    columns.torque.transformation.coupling = Some(r.transpose());
}
