//! `<inertial>`: mass, centre of mass and inertia of a link.

use super::numbers::Element;
use crate::model::xml::single;
use crate::model::{ModelError, scientific};
use crate::spatial::{LinkInertia, PhysicalInertia, Transform};
use nalgebra::{Matrix3, Vector3};

/// Part of the largest principal moment by which the others may miss it: moments of a plate are on the border of the triangle
/// inequality, and files round to two digits. Published moments of the iiwa miss it by 0.6 %.
const ROUNDED: f64 = 1e-2;

/// What is wrong with mass and inertia about the centre of mass (kg, kg m²) of a link as a body, in words; `None` for a body.
pub fn body_complaint(mass: f64, inertia: &Matrix3<f64>) -> Option<String> {
    if !inertia.iter().all(|v| v.is_finite()) || inertia.iter().all(|&v| v == 0.0) {
        return None;
    }
    // Scaled, so that squares of the entries stay within the range of doubles.
    let scale = inertia.amax();
    let mut moments: Vec<f64> = (inertia / scale).symmetric_eigenvalues().iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    let [least, middle, largest] = moments[..] else { return None };
    let wrong = "torques predicted with it are wrong: correct the inertia in the file";
    if least < -ROUNDED * largest.abs() {
        let least = scientific(least * scale, 3);
        return Some(format!(
            "has an inertia with the principal moment {least} kg m², and no body has a negative one; {wrong}"
        ));
    }
    if largest - least - middle > ROUNDED * largest {
        let [a, b, c] = [least, middle, largest].map(|v| scientific(v * scale, 3));
        return Some(format!(
            "has an inertia with the principal moments {a}, {b} and {c} kg m², and no body has one larger than the sum of the \
             others (triangle inequality); {wrong}"
        ));
    }
    (mass == 0.0).then(|| format!("has inertia without mass; {wrong}"))
}

/// The body of a link, about the link's frame, with what is to be known about it.
///
/// # Errors
/// Numbers that are none, a negative mass.
pub(super) fn read_inertial(element: &Element) -> Result<(Option<LinkInertia>, Vec<String>), ModelError> {
    let (text, owner) = (element.text, element.owner);
    let line = text.line(element.node);
    let child = |tag: &str| {
        let node = element.node.children().find(|c| c.has_tag_name(tag))?;
        Some(Element { text, node, owner })
    };
    let mut notes = Vec::new();
    let mut note = |what: String| notes.push(format!("{owner} (line {line}) {what}"));
    let mass = child("mass").map(|m| m.finite("value")).transpose()?.flatten();
    let Some(mass) = mass else {
        note("has an <inertial> without a mass: its prior parameters are unknown".into());
        return Ok((None, notes));
    };
    if mass < 0.0 {
        let detail = format!("{owner}, line {line}: its mass is {mass} kg");
        return Err(single(text.field, detail, "a mass is not negative"));
    }
    let pose = child("origin").map_or(Ok(Transform::identity()), |o| read_pose(&o))?;
    let inertia = match child("inertia") {
        Some(inertia) => {
            let (read, missing) = read_inertia(&inertia)?;
            if !missing.is_empty() {
                note(format!(
                    "states no {} of its inertia, which are taken as 0",
                    missing.join(", ")
                ));
            }
            read
        }
        None => {
            note("has an <inertial> without <inertia>: it is taken as a point mass".into());
            Matrix3::zeros()
        }
    };
    match body_complaint(mass, &inertia) {
        Some(complaint) => note(complaint),
        None if mass == 0.0 => note(
            "states a mass of 0: its part of the predicted torques is missing; give mass and inertia if the link has them".into(),
        ),
        None if inertia.iter().all(|&v| v == 0.0) && child("inertia").is_some() => {
            note("states an inertia of 0: it is taken as a point mass".into());
        }
        None => {}
    }
    let body = PhysicalInertia {
        mass,
        center_of_mass: Vector3::zeros(),
        inertia,
    };
    Ok((Some(body.about_origin().transformed(&pose)), notes))
}

fn read_pose(origin: &Element) -> Result<Transform, ModelError> {
    let xyz = origin.vector("xyz")?.unwrap_or_default();
    Ok(Transform::from_xyz_rpy(xyz, origin.vector("rpy")?.unwrap_or_default()))
}

/// Entries of an inertia tensor as URDF and SDF name them, with row and column.
pub const INERTIA_ENTRIES: [(&str, usize, usize); 6] = [
    ("ixx", 0, 0),
    ("ixy", 0, 1),
    ("ixz", 0, 2),
    ("iyy", 1, 1),
    ("iyz", 1, 2),
    ("izz", 2, 2),
];

/// The tensor, and the entries that are missing.
fn read_inertia(element: &Element) -> Result<(Matrix3<f64>, Vec<&'static str>), ModelError> {
    let (mut inertia, mut missing) = (Matrix3::zeros(), Vec::new());
    for (name, r, c) in INERTIA_ENTRIES {
        match element.finite(name)? {
            Some(v) => (inertia[(r, c)], inertia[(c, r)]) = (v, v),
            None => missing.push(name),
        }
    }
    Ok((inertia, missing))
}
