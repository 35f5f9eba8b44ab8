//! One joint of a robot document with the link it carries, turned into the frames of the dynamics.

use super::read_source;
use crate::io::bounds_document::{AXES, JOINT_BOUND_FIELDS, read_bounds};
use crate::io::cursor::Cursor;
use crate::model::{Capsule, INPUT_LIMITS, Joint, JointKind, Limits, LinkPrior, Mdh, Notes, Rounding, body_complaint};
use crate::spatial::{PhysicalInertia, Transform};
use nalgebra::Matrix3;

pub const JOINT_FIELDS: &[&str] = &[
    "name",
    "kind",
    "mdh",
    "placement",
    "limits",
    "prior",
    "geometry",
    "bounds",
    "slender_axis",
    "link",
    "source",
];
pub const MDH_FIELDS: &[&str] = &["alpha", "d", "theta", "r", "source"];
pub const PLACEMENT_FIELDS: &[&str] = &["xyz", "rpy", "axis", "source"];
pub const LIMIT_FIELDS: &[&str] = &["position", "velocity", "acceleration", "jerk", "effort", "source"];
pub const PRIOR_FIELDS: &[&str] = &["mass", "center_of_mass", "inertia", "viscous", "coulomb", "source"];
pub const CAPSULE_FIELDS: &[&str] = &["from", "to", "radius", "source"];
pub const INERTIA_FIELDS: &[&str] = &["xx", "xy", "xz", "yy", "yz", "zz"];

/// How a document is read, and what a user should know about it.
pub(super) struct Reading {
    pub rounding: Rounding,
    pub notes: Notes,
}

impl Reading {
    fn note(&mut self, joint: &str, changes: impl IntoIterator<Item = String>) {
        self.notes
            .extend(changes.into_iter().map(|c| format!("joint `{joint}`: {c}")));
    }
}

/// The joint, and the turn from its frame in the dynamics (z along the axis) to its frame in the document.
pub(super) fn read_joint(cursor: &Cursor, index: usize, to_here: &Transform, reading: &mut Reading) -> (Joint, Matrix3<f64>) {
    // The stand-in for anything unreadable passes the checks of the core, so that those see the rest.
    let stand_in = || {
        (
            Joint::from_mdh(format!("joint {}", index + 1), JointKind::Revolute, ZERO_MDH),
            Matrix3::identity(),
        )
    };
    let Some(fields) = cursor.fields(JOINT_FIELDS) else {
        return stand_in();
    };
    read_source(&fields);
    let (mut joint, mut turn) = stand_in();
    joint.name = fields
        .required("name")
        .and_then(|c| c.string())
        .map_or(joint.name, str::to_string);
    joint.link_name = format!("{}_link", joint.name);
    if let Some(link) = fields.optional("link").and_then(|c| c.string()) {
        joint.link_name = link.to_string();
    }
    let kinds = [("revolute", JointKind::Revolute), ("prismatic", JointKind::Prismatic)];
    joint.kind = fields
        .required("kind")
        .and_then(|c| c.choice(&kinds))
        .unwrap_or(JointKind::Revolute);
    if fields.has("mdh") == fields.has("placement") {
        let detail = if fields.has("mdh") {
            "has both `mdh` and `placement`"
        } else {
            "has neither `mdh` nor `placement`"
        };
        cursor.complain_with(detail, "give one of them");
    } else if let Some(placement) = fields.optional("placement") {
        let read = read_placement(&placement, &joint.name, reading);
        turn = read.1;
        joint.placement = *to_here * read.0;
        joint.mdh = None;
        joint.description_frame = turn;
    } else if let Some(mdh) = fields.optional("mdh") {
        let mdh = read_mdh(&mdh, &joint.name, reading);
        joint.placement = *to_here * mdh.placement();
        // Kept where it is the whole placement; with non-finite angles the core names them.
        joint.mdh = (to_here.rotation == Matrix3::identity()).then_some(mdh);
    }
    joint.limits = fields.nullable("limits").map_or(Limits::unlimited(), |c| read_limits(&c));
    let (limits, dropped) = joint.limits.without_placeholders(joint.is_revolute(), false);
    joint.limits = limits;
    reading.note(&joint.name, dropped);
    joint.prior = fields.nullable("prior").and_then(|c| read_prior(&c, &turn));
    if let Some(prior) = &joint.prior
        && let Some(complaint) = body_complaint(prior.inertia.mass, &prior.inertia.inertia)
    {
        reading.notes.push(format!("the link of joint `{}` {complaint}", joint.name));
    }
    let capsules = fields
        .nullable("geometry")
        .and_then(|c| c.items_up_to(INPUT_LIMITS.capsules_per_link, "capsules"))
        .unwrap_or_default();
    joint.geometry = capsules.iter().filter_map(|c| read_capsule(c, &turn)).collect();
    if let Some(bounds) = fields.nullable("bounds").and_then(|c| c.fields(JOINT_BOUND_FIELDS)) {
        read_source(&bounds);
        joint.bounds = read_bounds(&bounds);
    }
    joint.slender_axis = fields.nullable("slender_axis").and_then(|c| c.choice(AXES));
    (joint, turn)
}

/// A capsule in the document's link frame, turned into the frame of the dynamics.
fn read_capsule(cursor: &Cursor, turn: &Matrix3<f64>) -> Option<Capsule> {
    let fields = cursor.fields(CAPSULE_FIELDS)?;
    read_source(&fields);
    let end = |name: &str| fields.required(name).and_then(|c| c.vector());
    let (from, to) = (end("from"), end("to"));
    let radius = fields.required("radius").and_then(|c| {
        let radius = c.number()?;
        // Ten metres: millimetres given for metres, or no arm.
        if !(radius > 0.0 && radius < 10.0) {
            c.complain_with(format!("is {radius}"), "a radius is a positive number of metres");
            return None;
        }
        Some(radius)
    });
    Some(Capsule {
        ends: [turn.transpose() * from?, turn.transpose() * to?],
        radius: radius?,
    })
}

const ZERO_MDH: Mdh = Mdh {
    alpha: 0.0,
    d: 0.0,
    theta: 0.0,
    r: 0.0,
};

fn read_mdh(cursor: &Cursor, joint: &str, reading: &mut Reading) -> Mdh {
    let Some(fields) = cursor.fields(MDH_FIELDS) else {
        return ZERO_MDH;
    };
    read_source(&fields);
    let number = |name: &str| fields.required(name).and_then(|c| c.number()).unwrap_or(0.0);
    let rounding = reading.rounding;
    let mut kept = |(read, change): (f64, Option<String>)| {
        reading.note(joint, change);
        read
    };
    Mdh {
        alpha: kept(rounding.angle("alpha", number("alpha"))),
        d: kept(rounding.length("d", number("d"))),
        theta: kept(rounding.angle("theta", number("theta"))),
        r: kept(rounding.length("r", number("r"))),
    }
}

fn read_placement(cursor: &Cursor, joint: &str, reading: &mut Reading) -> (Transform, Matrix3<f64>) {
    let nothing = (Transform::identity(), Matrix3::identity());
    let Some(fields) = cursor.fields(PLACEMENT_FIELDS) else {
        return nothing;
    };
    read_source(&fields);
    let vector = |name: &str| fields.optional(name).and_then(|c| c.vector()).unwrap_or_default();
    let (xyz, of_lengths) = reading.rounding.lengths("xyz", vector("xyz"));
    let (rpy, of_angles) = reading.rounding.angles("rpy", vector("rpy"));
    reading.note(joint, of_lengths.into_iter().chain(of_angles));
    let placement = Transform::from_xyz_rpy(xyz, rpy);
    let axis = fields.optional("axis").and_then(|c| {
        let axis = c.vector()?;
        // Shorter than 1e-6 is no direction anybody wrote down.
        if axis.norm() < 1e-6 {
            c.complain_with(
                "has no direction",
                "give the axis as a unit vector in the joint's frame, [0, 0, 1] if left out",
            );
            return None;
        }
        Some(reading.rounding.axis(axis.normalize()))
    });
    let turn = axis.map_or(Matrix3::identity(), |a| Transform::z_onto(&a));
    (placement * Transform::from_rotation(turn), turn)
}

fn read_limits(cursor: &Cursor) -> Limits {
    let Some(fields) = cursor.fields(LIMIT_FIELDS) else {
        return Limits::unlimited();
    };
    read_source(&fields);
    let number = |name: &str| fields.nullable(name).and_then(|c| c.number());
    Limits {
        position: fields
            .nullable("position")
            .and_then(|c| c.numbers(Some(2)))
            .map(|p| [p[0], p[1]]),
        velocity: number("velocity"),
        acceleration: number("acceleration"),
        jerk: number("jerk"),
        effort: number("effort"),
    }
}

/// Prior parameters in the document's link frame, turned into the frame of the dynamics.
fn read_prior(cursor: &Cursor, turn: &Matrix3<f64>) -> Option<LinkPrior> {
    let fields = cursor.fields(PRIOR_FIELDS)?;
    read_source(&fields);
    let mass = fields.required("mass").and_then(|c| c.number());
    let center = fields.required("center_of_mass").and_then(|c| c.vector());
    let inertia = fields.required("inertia").and_then(|c| read_inertia(&c));
    let friction = |name: &str| fields.optional(name).and_then(|c| c.number()).unwrap_or(0.0);
    let (viscous, coulomb) = (friction("viscous"), friction("coulomb"));
    let back = turn.transpose();
    let inertia = PhysicalInertia {
        mass: mass?,
        center_of_mass: back * center?,
        inertia: back * inertia? * turn,
    };
    Some(LinkPrior {
        inertia,
        viscous,
        coulomb,
    })
}

fn read_inertia(cursor: &Cursor) -> Option<Matrix3<f64>> {
    let fields = cursor.fields(INERTIA_FIELDS)?;
    let read: Vec<Option<f64>> = INERTIA_FIELDS
        .iter()
        .map(|name| fields.required(name).and_then(|c| c.number()))
        .collect();
    let all: Option<Vec<f64>> = read.into_iter().collect();
    let [xx, xy, xz, yy, yz, zz] = all?.try_into().ok()?;
    Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}
