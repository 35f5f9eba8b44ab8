//! Which effects a format has a place for, and the robot with those in it that are a matter of geometry.

use super::{FinalModel, ModelFormat};
use crate::dynamics::inverse_dynamics;
use crate::effects::{by_code, tilted};
use crate::model::{Joint, ModelError, Robot};
use crate::parameters::Layout;
use crate::regression::Term;
use crate::spatial::Transform;
use nalgebra::DMatrix;

/// The form of `smooth_coulomb_friction` that MuJoCo computes.
const SOFT_CONSTRAINT: usize = 2;

/// `timeconst` and damping ratio of MuJoCo's friction constraints (s, 1): the shortest that MuJoCo allows at its usual time step
/// of 2 ms, so that friction follows the speed as closely as it can.
pub(super) const SOLREF: [f64; 2] = [0.004, 1.0];
/// Impedance of those constraints: the largest that MuJoCo takes. What is left out of 1 makes friction soft.
pub(super) const IMPEDANCE: f64 = 0.9999;

impl ModelFormat {
    /// Whether the format has a place for an effect with these values.
    pub(super) fn holds(self, term: &Term) -> bool {
        let code = term.effect.code();
        let positive = || term.coefficients.iter().all(|c| *c >= 0.0);
        match self {
            Self::Json | Self::Csv => true,
            Self::C | Self::Python => super::source_effects::is_written(term) || super::source_memory::is_remembered(term),
            Self::Urdf => is_geometry(code),
            // A spring that pushes away from its rest is refused by simulators.
            Self::Sdf => is_geometry(code) || code == "joint_spring" && term.coefficients[0] > 0.0,
            Self::Mjcf => match code {
                "joint_spring" => term.coefficients[0] > 0.0,
                "rotor_inertia" | "transmission_coupling" => positive(),
                "torque_gain" => 1.0 + term.shape[0] > 0.0,
                _ => is_geometry(code) || code == "torque_offset",
            },
        }
    }
}

/// A tilted base turns gravity, an encoder's offset turns the next frame: neither needs a place of its own.
fn is_geometry(code: &str) -> bool {
    ["base_tilt", "encoder_offset"].contains(&code)
}

/// Ratio of a transmission coupling, `v = qd_i + k qd_j`.
pub(super) fn coupling_ratio(term: &Term) -> f64 {
    [1.0, -1.0].get(term.form).copied().unwrap_or_else(|| term.shape[0])
}

impl FinalModel {
    /// Terms with this code.
    pub(super) fn with_code<'a>(&'a self, code: &'a str) -> impl Iterator<Item = &'a Term> {
        self.terms.iter().filter(move |t| t.effect.code() == code)
    }

    /// The sum of a coefficient over the terms of one kind on a joint.
    pub(super) fn sum(&self, code: &str, joint: usize, at: usize) -> f64 {
        self.with_code(code)
            .filter(|t| t.joints == [joint])
            .map(|t| t.coefficients[at])
            .sum()
    }

    /// What is added to the position of a joint by its encoder offsets (rad or m).
    pub(super) fn encoder_offset(&self, joint: usize) -> f64 {
        self.with_code("encoder_offset")
            .filter(|t| t.joints == [joint])
            .map(|t| t.shape[0])
            .sum()
    }

    /// Factor on the torque of a joint.
    pub(super) fn gain(&self, joint: usize) -> f64 {
        self.with_code("torque_gain")
            .filter(|t| t.joints == [joint])
            .map(|t| 1.0 + t.shape[0])
            .product()
    }

    /// The robot with gravity as a tilted base has it, and with every encoder's offset in the frame behind it: the same torques
    /// at the positions that the encoders show.
    pub(super) fn absorbed(&self) -> Robot {
        self.try_absorbed().expect("models are read only where this is a robot")
    }

    /// # Errors
    /// Offsets that put joints where none can be.
    pub(crate) fn try_absorbed(&self) -> Result<Robot, ModelError> {
        let robot = self.tilted();
        let joints = robot.joints().iter().enumerate();
        let joints = joints.map(|(j, joint)| offset(joint, self.encoder_offset(j))).collect();
        Robot::new(robot.name(), robot.gravity(), joints, robot.friction())
    }

    /// The robot with gravity as a tilted base has it.
    pub(super) fn tilted(&self) -> Robot {
        let tilts = self.with_code("base_tilt");
        tilts.fold(self.robot.clone(), |robot, tilt| {
            robot.with_gravity(tilted(robot.gravity(), &tilt.shape))
        })
    }

    /// The linear spring of a joint, `[k, c]` of `tau = k q + c` at the position that the encoder shows.
    pub(super) fn spring(&self, joint: usize) -> [f64; 2] {
        let of = self
            .with_code("joint_spring")
            .filter(|t| t.joints == [joint] && t.coefficients[0] > 0.0);
        let shift = self.encoder_offset(joint);
        of.fold([0.0; 2], |[k, c], t| {
            let [stiffness, constant] = [t.coefficients[0], t.coefficients[1]];
            [k + stiffness, c + constant + stiffness * shift]
        })
    }

    /// What a format has instead of something it cannot hold, as effects: MuJoCo's Coulomb friction.
    ///
    /// With `b = 2/(dmax timeconst)` and `R = (1 − d)/d A_jj`, `A` the inverse mass matrix at zero, a friction constraint is
    /// `F clamp((qd + qdd/b) b/(R F), −1, 1)` (Todorov 2014; MuJoCo's documentation, "Computation").
    pub(super) fn own_terms(&self, format: ModelFormat) -> Vec<Term> {
        if format != ModelFormat::Mjcf {
            return Vec::new();
        }
        let Some(inverse) = self.mass_matrix_at_zero().try_inverse() else {
            return Vec::new();
        };
        let rate = 2.0 / (IMPEDANCE * SOLREF[0]);
        let smooth = by_code("smooth_coulomb_friction").expect("is in the list");
        let friction = self
            .robot
            .joints()
            .iter()
            .map(|j| j.prior.as_ref().map_or(0.0, |p| p.coulomb));
        let soft = friction.enumerate().filter(|(_, f)| *f > 0.0);
        soft.map(|(j, force)| Term {
            effect: smooth.into(),
            form: SOFT_CONSTRAINT,
            joints: vec![j],
            coefficients: vec![force],
            shape: vec![(1.0 - IMPEDANCE) / IMPEDANCE * inverse[(j, j)] * force / rate, 1.0 / rate],
            free_shapes: 0,
            bounds: Vec::new(),
        })
        .collect()
    }

    /// Mass matrix of bodies, rotors and couplings where the encoders show zero [kg m², kg m, kg].
    fn mass_matrix_at_zero(&self) -> DMatrix<f64> {
        let robot = self.absorbed();
        let robot = robot.with_gravity(nalgebra::Vector3::zeros());
        let layout = Layout::standard(&robot);
        let n = robot.joint_count();
        let Some(phi) = layout.prior(&robot) else {
            return DMatrix::zeros(n, n);
        };
        let (still, mut mass) = (vec![0.0; n], DMatrix::zeros(n, n));
        for c in 0..n {
            let mut unit = vec![0.0; n];
            unit[c] = 1.0;
            mass.set_column(
                c,
                &inverse_dynamics(&robot, &layout, phi.as_slice(), &still, &still, &unit).into(),
            );
            mass[(c, c)] += self.sum("rotor_inertia", c, 0);
        }
        for term in self.with_code("transmission_coupling") {
            let (i, j, k) = (term.joints[0], term.joints[1], coupling_ratio(term));
            let inertia = term.coefficients[2];
            mass[(i, i)] += inertia;
            mass[(j, j)] += k * k * inertia;
            mass[(i, j)] += k * inertia;
            mass[(j, i)] += k * inertia;
        }
        mass
    }
}

/// The joint with its zero moved.
fn offset(joint: &Joint, by: f64) -> Joint {
    if by == 0.0 {
        return joint.clone();
    }
    let mut moved = joint.clone();
    let turn = joint.is_revolute();
    moved.placement = joint.placement
        * if turn {
            Transform::rot_z(by)
        } else {
            Transform::trans(0.0, 0.0, by)
        };
    if let Some(mdh) = &mut moved.mdh {
        *(if turn { &mut mdh.theta } else { &mut mdh.r }) += by;
    }
    moved
}
