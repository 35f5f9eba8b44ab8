//! One joint and the link it carries.

use super::words::three_digits;
use super::{Capsule, Limits};
use crate::spatial::{PhysicalInertia, Transform};
use nalgebra::{Matrix3, Vector3};

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about z; position in rad, torque in N·m.
    Revolute,
    /// Slides along z; position in m, force in N.
    Prismatic,
}

/// Modified DH parameters of Khalil: `T = Rot_x(alpha) Trans_x(d) Rot_z(theta) Trans_z(r)`.
///
/// The joint variable adds to `theta` (revolute) or `r` (prismatic). Craig writes `a` for Khalil's `d` and `d` for Khalil's `r`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mdh {
    /// Angle from z_{j-1} to z_j about x_{j-1} (rad).
    pub alpha: f64,
    /// Distance from z_{j-1} to z_j along x_{j-1} (m).
    pub d: f64,
    /// Angle from x_{j-1} to x_j about z_j at q = 0 (rad).
    pub theta: f64,
    /// Distance from x_{j-1} to x_j along z_j at q = 0 (m).
    pub r: f64,
}

impl Mdh {
    /// Pose of frame j in frame j−1 at q = 0.
    pub fn placement(&self) -> Transform {
        Transform::rot_x(self.alpha)
            * Transform::trans(self.d, 0.0, 0.0)
            * Transform::rot_z(self.theta)
            * Transform::trans(0.0, 0.0, self.r)
    }
}

/// What is known about a link beforehand: from a URDF, a data sheet, or an earlier identification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkPrior {
    /// In the link frame that the dynamics use (z along the joint).
    pub inertia: PhysicalInertia,
    /// Viscous friction [N·m·s/rad or N·s/m].
    pub viscous: f64,
    /// Coulomb friction [N·m or N].
    pub coulomb: f64,
}

/// Axis of a link frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
}

/// What the physical parameters of a link must lie between, `[lower, upper]`: the paper's (10b). In the link frame of the
/// description.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinkBounds {
    /// (kg).
    pub mass: Option<[f64; 2]>,
    /// Per axis (m).
    pub center_of_mass: Option<[[f64; 2]; 3]>,
    /// About the centre of mass: xx, xy, xz, yy, yz, zz [kg m²].
    pub inertia: [Option<[f64; 2]>; 6],
    /// [N·m·s/rad or N·s/m].
    pub viscous: Option<[f64; 2]>,
    /// [N·m or N].
    pub coulomb: Option<[f64; 2]>,
}

impl LinkBounds {
    /// Every bound that is there, by the name of its field.
    pub fn stated(&self) -> Vec<(&'static str, [f64; 2])> {
        let center = self.center_of_mass.iter().flatten().map(|&b| ("center_of_mass", b));
        let inertia = self.inertia.iter().flatten().map(|&b| ("inertia", b));
        let single = |name, bound: Option<[f64; 2]>| bound.map(|b| (name, b));
        single("mass", self.mass)
            .into_iter()
            .chain(center)
            .chain(inertia)
            .chain(single("viscous", self.viscous))
            .chain(single("coulomb", self.coulomb))
            .collect()
    }

    /// These bounds where they say something, `other` where they do not.
    pub fn or(&self, other: &Self) -> Self {
        Self {
            mass: self.mass.or(other.mass),
            center_of_mass: self.center_of_mass.or(other.center_of_mass),
            inertia: std::array::from_fn(|i| self.inertia[i].or(other.inertia[i])),
            viscous: self.viscous.or(other.viscous),
            coulomb: self.coulomb.or(other.coulomb),
        }
    }
}

/// A joint, its place in the chain, and the link behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, one line of text.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Pose of this joint's frame in the previous one at q = 0; the joint moves about or along its z axis.
    pub placement: Transform,
    /// The parameters the placement was made from, if it was given that way.
    pub mdh: Option<Mdh>,
    /// What it must not exceed.
    pub limits: Limits,
    /// What is known of the link beforehand.
    pub prior: Option<LinkPrior>,
    /// Capsules that together contain the link; empty where its shape is not known.
    pub geometry: Vec<Capsule>,
    /// What identification must keep the link's parameters between.
    pub bounds: LinkBounds,
    /// The axis of the description's link frame along which the link is long: the paper's (10d) wants the least moment about it.
    pub slender_axis: Option<Axis>,
    /// Rotation from the dynamics' link frame (z along the joint) to the link frame of the description the robot came from;
    /// the identity for modified DH. The origins coincide.
    pub description_frame: Matrix3<f64>,
    /// Name of the link behind the joint in the description it came from.
    pub link_name: String,
}

impl Joint {
    /// A joint placed by modified DH parameters, without limits or priors.
    pub fn from_mdh(name: impl Into<String>, kind: JointKind, mdh: Mdh) -> Self {
        Self {
            mdh: Some(mdh),
            ..Self::from_placement(name, kind, mdh.placement())
        }
    }

    /// A joint whose z axis sits at `placement` in the previous link frame, without limits or priors.
    pub fn from_placement(name: impl Into<String>, kind: JointKind, placement: Transform) -> Self {
        let name = name.into();
        Self {
            link_name: format!("{name}_link"),
            name,
            kind,
            placement,
            mdh: None,
            limits: Limits::unlimited(),
            prior: None,
            geometry: Vec::new(),
            bounds: LinkBounds::default(),
            slender_axis: None,
            description_frame: Matrix3::identity(),
        }
    }

    /// The same joint with other limits.
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Whether it turns.
    pub fn is_revolute(&self) -> bool {
        self.kind == JointKind::Revolute
    }

    /// Pose of this joint's frame in the previous one at position `q`.
    pub fn pose(&self, q: f64) -> Transform {
        match self.kind {
            JointKind::Revolute => {
                let (s, c) = q.sin_cos();
                let turn = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
                Transform {
                    rotation: self.placement.rotation * turn,
                    translation: self.placement.translation,
                }
            }
            JointKind::Prismatic => {
                let along = self.placement.rotation * Vector3::z();
                Transform {
                    rotation: self.placement.rotation,
                    translation: self.placement.translation + along * q,
                }
            }
        }
    }

    /// `rad` or `m`.
    pub fn position_unit(&self) -> &'static str {
        if self.is_revolute() { "rad" } else { "m" }
    }

    /// `N m` or `N`.
    pub fn effort_unit(&self) -> &'static str {
        if self.is_revolute() { "N m" } else { "N" }
    }

    /// A torque or force to three digits, with its unit: `3.65 N·m`.
    pub fn effort(&self, value: f64) -> String {
        format!("{} {}", three_digits(value), self.effort_unit().replace(' ', "·"))
    }
}
