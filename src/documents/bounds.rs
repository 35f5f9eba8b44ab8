//! Bounds on the physical parameters of a link, and its slender axis.

use super::cursor::{Cursor, Fields};
use super::requests;
use crate::model::{Axis, LinkBounds};

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
pub(super) fn written_bounds(bounds: &LinkBounds) -> Option<requests::JointBounds> {
    let [xx, xy, xz, yy, yz, zz] = bounds.inertia;
    let inertia = requests::InertiaBounds { xx, xy, xz, yy, yz, zz };
    let written = requests::JointBounds {
        mass: bounds.mass,
        center_of_mass: bounds.center_of_mass.map(|axes| axes.iter().map(|b| b.to_vec()).collect()),
        inertia: (inertia != requests::InertiaBounds::default()).then_some(inertia),
        viscous: bounds.viscous,
        coulomb: bounds.coulomb,
        source: None,
    };
    (written != requests::JointBounds::default()).then_some(written)
}

pub(super) fn written_axis(axis: Axis) -> requests::Axis {
    match axis {
        Axis::X => requests::Axis::X,
        Axis::Y => requests::Axis::Y,
        Axis::Z => requests::Axis::Z,
    }
}
