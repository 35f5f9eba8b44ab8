//! Bounds on the physical parameters of a link, and its slender axis.

use super::cursor::{Cursor, Fields};
use super::requests;
use crate::model::{Axis, LinkBounds};
use serde_json::{Map, Value, json};

pub fn read_bounds(fields: &Fields) -> LinkBounds {
    let one = |name: &str| fields.nullable(name).and_then(|c| range(&c));
    let center = fields.nullable("center_of_mass").and_then(|c| {
        let items = c.items()?;
        if items.len() != 3 {
            c.complain(format!("has {} ranges, expected three: x, y, z", items.len()));
            return None;
        }
        Some([range(&items[0])?, range(&items[1])?, range(&items[2])?])
    });
    let inertia = fields
        .nullable("inertia")
        .and_then(|c| c.fields_of::<requests::InertiaBounds>());
    let entry = |name: &str| inertia.as_ref()?.nullable(name).and_then(|c| range(&c));
    LinkBounds {
        mass: one("mass"),
        center_of_mass: center,
        inertia: ["xx", "xy", "xz", "yy", "yz", "zz"].map(entry),
        viscous: one("viscous"),
        coulomb: one("coulomb"),
    }
}

fn range(cursor: &Cursor) -> Option<[f64; 2]> {
    let ends = cursor.numbers(Some(2))?;
    if ends[0] > ends[1] {
        cursor.complain(format!(
            "is [{}, {}]: the lower bound must not be above the upper one",
            ends[0], ends[1]
        ));
        return None;
    }
    Some([ends[0], ends[1]])
}

/// The bounds as a robot document has them; `None` for none.
pub(super) fn bounds_value(bounds: &LinkBounds) -> Option<Value> {
    let mut value = Map::new();
    let mut put = |name: &str, v: Option<Value>| v.map(|v| value.insert(name.into(), v));
    put("mass", bounds.mass.map(|b| json!(b)));
    put("center_of_mass", bounds.center_of_mass.map(|b| json!(b)));
    let entries = ["xx", "xy", "xz", "yy", "yz", "zz"].iter().zip(bounds.inertia);
    let inertia: Map<String, Value> = entries.filter_map(|(name, b)| Some((name.to_string(), json!(b?)))).collect();
    put("inertia", (!inertia.is_empty()).then_some(Value::Object(inertia)));
    put("viscous", bounds.viscous.map(|b| json!(b)));
    put("coulomb", bounds.coulomb.map(|b| json!(b)));
    (!value.is_empty()).then_some(Value::Object(value))
}

pub(super) fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Z => "z",
    }
}
