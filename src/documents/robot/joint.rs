//! One joint of a robot document with the link it carries, turned into the frames of the dynamics.

use super::read_source;
use crate::documents::bounds::read_bounds;
use crate::documents::cursor::Cursor;
use crate::documents::requests;
use crate::model::{Capsule, INPUT_LIMITS, Joint, JointKind, Limits, LinkPrior, Mdh, Notes, Rounding, body_complaint};
use crate::spatial::{PhysicalInertia, Transform};
use nalgebra::Matrix3;

/// How a document is read, and what a user should know about it.
pub(super) struct Reading {
    pub rounding: Rounding,
    pub notes: Notes,
    /// The part of a standard DH row that stands behind its joint, `Trans_x(a) Rot_x(alpha)`; `None` behind other placements.
    behind: Option<[f64; 2]>,
    /// Convention and alpha of every joint that a DH table places.
    table: Vec<(Convention, f64)>,
}

/// Who writes a DH table how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Convention {
    /// Denavit and Hartenberg: `Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha)`, joint i about z_{i-1}.
    Standard,
    /// Craig: `Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)`; Khalil's with other letters.
    Modified,
}

impl From<requests::DhConvention> for Convention {
    fn from(word: requests::DhConvention) -> Self {
        match word {
            requests::DhConvention::Standard => Self::Standard,
            requests::DhConvention::Craig | requests::DhConvention::Khalil => Self::Modified,
        }
    }
}

impl Reading {
    pub fn new(rounding: Rounding) -> Self {
        Self {
            rounding,
            notes: Notes::default(),
            behind: Some([0.0; 2]),
            table: Vec::new(),
        }
    }

    /// Tables of the two conventions look alike. The first frame of a modified table usually has the direction of the base, so
    /// that its alpha is 0; in a standard table it is the last that is.
    pub fn look_at_table(&mut self, joints: usize) {
        let ([(convention, first), .., (_, last)], true) = (&self.table[..], self.table.len() == joints) else {
            return;
        };
        let note = match (convention, *first == 0.0, *last == 0.0) {
            (Convention::Modified, false, true) => {
                "the table looks like standard DH (alpha of the first joint is not 0, that of the last is) and is read as modified DH: if it is \
                 standard, give its rows as `dh` with the convention `standard`"
            }
            (Convention::Standard, true, false) => {
                "the table looks like modified DH (alpha of the first joint is 0, that of the last is not) and is read as standard DH: if it is \
                 Craig's, give the convention `craig`"
            }
            _ => return,
        };
        self.notes.push(note);
    }

    fn note(&mut self, joint: &str, changes: impl IntoIterator<Item = String>) {
        self.notes
            .extend(changes.into_iter().map(|c| format!("joint `{joint}`: {c}")));
    }
}

/// The joint, and the pose of its link frame in the document within its frame in the dynamics (z along the axis).
pub(super) fn read_joint(cursor: &Cursor, index: usize, to_here: &Transform, reading: &mut Reading) -> (Joint, Transform) {
    // The stand-in for anything unreadable passes the checks of the core, so that those see the rest.
    let stand_in = || {
        (
            Joint::from_mdh(format!("joint {}", index + 1), JointKind::Revolute, ZERO_MDH),
            Transform::identity(),
        )
    };
    let Some(fields) = cursor.fields_of::<requests::Joint>() else {
        return stand_in();
    };
    read_source(&fields);
    let (mut joint, mut link) = stand_in();
    joint.name = fields
        .required("name")
        .and_then(|c| c.string())
        .map_or(joint.name, str::to_string);
    joint.link_name = format!("{}_link", joint.name);
    if let Some(link) = fields.optional("link").and_then(|c| c.string()) {
        joint.link_name = link.to_string();
    }
    joint.kind = fields
        .required("kind")
        .and_then(|c| c.word())
        .map_or(JointKind::Revolute, requests::JointKind::into);
    let given = ["mdh", "dh", "placement"].into_iter().filter(|f| fields.has(f)).count();
    let before = reading.behind.take();
    if given != 1 {
        let detail = match given {
            0 => "has neither `mdh` nor `dh` nor `placement`",
            _ => "has more than one of `mdh`, `dh` and `placement`",
        };
        cursor.complain_with(detail, "give one of them");
    } else if let Some(placement) = fields.optional("placement") {
        let read = read_placement(&placement, &joint.name, reading);
        link = Transform::from_rotation(read.1.transpose());
        joint.placement = *to_here * read.0;
        joint.mdh = None;
        joint.description_frame = read.1;
    } else if let Some(table) = fields.optional("dh") {
        let (row, behind) = read_dh(&table, &joint.name, reading);
        joint.placement = *to_here * row.placement();
        // Turns about x and shifts along it can change places: what stands behind the joint before joins the row.
        joint.mdh = before.map(|[alpha, a]| Mdh {
            alpha: alpha + row.alpha,
            d: a + row.d,
            ..row
        });
        let [alpha, a] = behind.unwrap_or_default();
        link = Transform::trans(a, 0.0, 0.0) * Transform::rot_x(alpha);
        reading.behind = behind;
    } else if let Some(mdh) = fields.optional("mdh") {
        let mdh = read_mdh(&mdh, &joint.name, reading);
        joint.placement = *to_here * mdh.placement();
        // Kept where it is the whole placement; with non-finite angles the core names them.
        joint.mdh = (*to_here == Transform::identity()).then_some(mdh);
        reading.behind = Some([0.0; 2]);
        reading.table.push((Convention::Modified, mdh.alpha));
    }
    joint.limits = fields.nullable("limits").map_or(Limits::unlimited(), |c| read_limits(&c));
    let (limits, dropped) = joint.limits.without_placeholders(joint.is_revolute(), false);
    joint.limits = limits;
    reading.note(&joint.name, dropped);
    joint.prior = fields.nullable("prior").and_then(|c| read_prior(&c, &link));
    if let Some(prior) = &joint.prior
        && let Some(complaint) = body_complaint(prior.inertia.mass, &prior.inertia.inertia)
    {
        reading.notes.push(format!("the link of joint `{}` {complaint}", joint.name));
    }
    let capsules = fields
        .nullable("geometry")
        .and_then(|c| c.items_up_to(INPUT_LIMITS.capsules_per_link, "capsules"))
        .unwrap_or_default();
    joint.geometry = capsules.iter().filter_map(|c| read_capsule(c, &link)).collect();
    if let Some(bounds) = fields.nullable("bounds").and_then(|c| c.fields_of::<requests::JointBounds>()) {
        read_source(&bounds);
        joint.bounds = read_bounds(&bounds);
    }
    joint.slender_axis = fields
        .nullable("slender_axis")
        .and_then(|c| c.word())
        .map(requests::Axis::into);
    (joint, link)
}

/// A capsule in the document's link frame, turned into the frame of the dynamics.
pub(super) fn read_capsule(cursor: &Cursor, link: &Transform) -> Option<Capsule> {
    let fields = cursor.fields_of::<requests::Capsule>()?;
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
        ends: [from?, to?].map(|p| link.rotation * p + link.translation),
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
    let Some(fields) = cursor.fields_of::<requests::Mdh>() else {
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

/// A row of a table as one of modified DH, and what of it stands behind the joint.
fn read_dh(cursor: &Cursor, joint: &str, reading: &mut Reading) -> (Mdh, Option<[f64; 2]>) {
    let Some(fields) = cursor.fields_of::<requests::Dh>() else {
        return (ZERO_MDH, None);
    };
    read_source(&fields);
    let convention = fields
        .required("convention")
        .and_then(|c| c.word())
        .map_or(Convention::Modified, requests::DhConvention::into);
    let number = |name: &str| fields.required(name).and_then(|c| c.number()).unwrap_or(0.0);
    let rounding = reading.rounding;
    let mut kept = |(read, change): (f64, Option<String>)| {
        reading.note(joint, change);
        read
    };
    let [alpha, theta] = ["alpha", "theta"].map(|name| kept(rounding.angle(name, number(name))));
    let [a, d] = ["a", "d"].map(|name| kept(rounding.length(name, number(name))));
    reading.table.push((convention, alpha));
    // Khalil's d is Craig's a, and his r is Craig's d.
    match convention {
        Convention::Modified => (
            Mdh {
                alpha,
                d: a,
                theta,
                r: d,
            },
            Some([0.0; 2]),
        ),
        Convention::Standard => {
            let row = Mdh {
                alpha: 0.0,
                d: 0.0,
                theta,
                r: d,
            };
            (row, Some([alpha, a]))
        }
    }
}

fn read_placement(cursor: &Cursor, joint: &str, reading: &mut Reading) -> (Transform, Matrix3<f64>) {
    let nothing = (Transform::identity(), Matrix3::identity());
    let Some(fields) = cursor.fields_of::<requests::Placement>() else {
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
    let Some(fields) = cursor.fields_of::<requests::Limits>() else {
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
fn read_prior(cursor: &Cursor, link: &Transform) -> Option<LinkPrior> {
    let fields = cursor.fields_of::<requests::LinkPrior>()?;
    read_source(&fields);
    let mass = fields.required("mass").and_then(|c| c.number());
    let center = fields.required("center_of_mass").and_then(|c| c.vector());
    let inertia = fields.required("inertia").and_then(|c| read_inertia(&c));
    let friction = |name: &str| fields.optional(name).and_then(|c| c.number()).unwrap_or(0.0);
    let (viscous, coulomb) = (friction("viscous"), friction("coulomb"));
    let turn = link.rotation;
    let inertia = PhysicalInertia {
        mass: mass?,
        center_of_mass: turn * center? + link.translation,
        inertia: turn * inertia? * turn.transpose(),
    };
    Some(LinkPrior {
        inertia,
        viscous,
        coulomb,
    })
}

fn read_inertia(cursor: &Cursor) -> Option<Matrix3<f64>> {
    let fields = cursor.fields_of::<requests::Inertia>()?;
    let read = ["xx", "xy", "xz", "yy", "yz", "zz"].map(|name| fields.required(name).and_then(|c| c.number()));
    let all: Option<Vec<f64>> = read.into_iter().collect();
    let [xx, xy, xz, yy, yz, zz] = all?.try_into().ok()?;
    Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}
