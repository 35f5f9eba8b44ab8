//! The robot itself: built once, checked once, shared by every computation.

use super::limits::LimitProblem;
use super::{FieldProblem, Joint, ModelError};
use nalgebra::Vector3;

/// The longest chain accepted. Redundant arms have 7 joints, dual-arm chains 15; the symbolic and numeric base parameters are
/// tested up to 10, and 30 keeps an accidental or hostile document from asking for gigabytes.
pub const MAX_JOINTS: usize = 30;

/// Friction that the declared model has on every joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Friction {
    /// `FV qd`
    pub viscous: bool,
    /// `FS sign(qd)`
    pub coulomb: bool,
}

/// A serial arm. Fields are read through methods: after [`Robot::new`] nothing changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    name: String,
    gravity: Vector3<f64>,
    joints: Vec<Joint>,
    friction: Friction,
}

impl Robot {
    /// A checked robot. `gravity` [m/s²] is given in the base frame (the frame before joint 1), usually `[0, 0, −9.81]`.
    ///
    /// # Errors
    /// Every problem found, each with a pointer into the robot document: no joints, too many, names that are empty or used
    /// twice, numbers that are not finite, placements that are not rigid, limits the wrong way round.
    pub fn new(
        name: impl Into<String>,
        gravity: Vector3<f64>,
        joints: Vec<Joint>,
        friction: Friction,
    ) -> Result<Self, ModelError> {
        let robot = Self {
            name: name.into(),
            gravity,
            joints,
            friction,
        };
        let problems = robot.problems();
        if problems.is_empty() {
            Ok(robot)
        } else {
            Err(ModelError(problems))
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Acceleration of gravity in the base frame [m/s²].
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    pub fn friction(&self) -> Friction {
        self.friction
    }

    /// The same robot with another declared friction.
    pub fn with_friction(&self, friction: Friction) -> Self {
        Self {
            friction,
            ..self.clone()
        }
    }

    /// The same robot where gravity pulls another way [m/s², base frame].
    pub fn with_gravity(&self, gravity: Vector3<f64>) -> Self {
        Self { gravity, ..self.clone() }
    }

    fn problems(&self) -> Vec<FieldProblem> {
        let mut found = Vec::new();
        if !self.gravity.iter().all(|g| g.is_finite()) {
            found.push(FieldProblem::new("/gravity", "is not finite"));
        } else if self.gravity.norm() > 100.0 {
            found.push(
                FieldProblem::new("/gravity", format!("is {:.0} m/s² long", self.gravity.norm()))
                    .with_hint("gravity is in m/s², on Earth 9.81 long: check the unit"),
            );
        }
        match self.joints.len() {
            0 => found.push(FieldProblem::new("/joints", "is empty: a robot has at least one joint")),
            n if n > MAX_JOINTS => {
                found.push(FieldProblem::new(
                    "/joints",
                    format!("has {n} joints, the most accepted is {MAX_JOINTS}"),
                ));
            }
            _ => {}
        }
        for (i, joint) in self.joints.iter().enumerate() {
            self.name_problems(i, &mut found);
            placement_problems(i, joint, &mut found);
            limit_problems(i, joint, &mut found);
            prior_problems(i, joint, &mut found);
            bound_problems(i, joint, &mut found);
        }
        found
    }

    fn name_problems(&self, i: usize, found: &mut Vec<FieldProblem>) {
        let name = &self.joints[i].name;
        let pointer = format!("/joints/{i}/name");
        if name.trim().is_empty() {
            found.push(FieldProblem::new(pointer, "is empty"));
        } else if let Some(first) = self.joints[..i].iter().position(|j| &j.name == name) {
            found.push(FieldProblem::new(
                pointer,
                format!("`{name}` is already the name of joint {}", first + 1),
            ));
        }
    }
}

fn placement_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    if let Some(mdh) = joint.mdh {
        let fields = [("alpha", mdh.alpha), ("d", mdh.d), ("theta", mdh.theta), ("r", mdh.r)];
        for (field, _) in fields.iter().filter(|(_, v)| !v.is_finite()) {
            found.push(FieldProblem::new(format!("/joints/{i}/mdh/{field}"), "is not finite"));
        }
        for (field, v) in [("alpha", mdh.alpha), ("theta", mdh.theta)] {
            if v.is_finite() && v.abs() > 2.0 * std::f64::consts::PI {
                found.push(
                    FieldProblem::new(
                        format!("/joints/{i}/mdh/{field}"),
                        format!("is {v} rad, more than a full turn"),
                    )
                    .with_hint("angles are in radians; this looks like degrees"),
                );
            }
        }
        for (field, v) in [("d", mdh.d), ("r", mdh.r)] {
            if v.is_finite() && v.abs() > LONGEST_LINK {
                found.push(
                    FieldProblem::new(format!("/joints/{i}/mdh/{field}"), format!("is {v} m"))
                        .with_hint("lengths are in metres; this looks like millimetres"),
                );
            }
        }
        if fields.iter().any(|(_, v)| !v.is_finite()) {
            return;
        }
    }
    let r = joint.placement.rotation;
    // Rounding of a product of a few rotations; a matrix that is further off was never a rotation.
    let rigid = (r * r.transpose() - nalgebra::Matrix3::identity()).amax() < 1e-9 && r.determinant() > 0.0;
    if !rigid || !joint.placement.translation.iter().all(|v| v.is_finite()) {
        found.push(FieldProblem::new(
            format!("/joints/{i}"),
            "its place is not a finite rigid transform",
        ));
    }
}

/// No arm has links of 20 m between two joints; millimetres taken for metres land far above.
const LONGEST_LINK: f64 = 20.0;

fn limit_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    for (field, problem) in joint.limits.problems() {
        let pointer = format!("/joints/{i}/limits/{field}");
        found.push(match problem {
            LimitProblem::NotFinite => {
                FieldProblem::new(pointer, "is not finite").with_hint("leave it out or use null for no limit")
            }
            LimitProblem::WrongWayRound { low, high } => FieldProblem::new(
                pointer,
                format!("is [{low}, {high}]: the lower limit must be below the upper one"),
            )
            .with_hint(format!("did you mean [{high}, {low}]?")),
            LimitProblem::NotPositive(v) => {
                FieldProblem::new(pointer, format!("is {v}, but is a magnitude and must be above zero"))
            }
        });
    }
    degree_problems(i, joint, found);
}

/// Limits that were written in degrees. A revolute joint that turns freely has ±2π, dress-pack windings reach a few turns; five
/// turns (31 rad) is beyond any arm, and 40 rad/s (382 rev/min) is beyond any joint behind a gear. A single joint with short travel
/// in degrees (±20) would slip below, but all joints are written in the same unit, and some have a long travel.
fn degree_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    if !joint.is_revolute() {
        return;
    }
    let hint = "limits of revolute joints are in radians; this looks like degrees: multiply by π/180";
    if let Some([low, high]) = joint.limits.position
        && low.is_finite()
        && high.is_finite()
        && low.abs().max(high.abs()) > 31.5
    {
        found.push(FieldProblem::new(format!("/joints/{i}/limits/position"), format!("is [{low}, {high}] rad")).with_hint(hint));
    }
    if let Some(v) = joint.limits.velocity
        && v.is_finite()
        && v > 40.0
    {
        found.push(FieldProblem::new(format!("/joints/{i}/limits/velocity"), format!("is {v} rad/s")).with_hint(hint));
    }
}

fn prior_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    let Some(prior) = &joint.prior else { return };
    let b = &prior.inertia;
    let pointer = |field: &str| format!("/joints/{i}/prior/{field}");
    if !b.mass.is_finite() || b.mass < 0.0 {
        found.push(FieldProblem::new(
            pointer("mass"),
            format!("is {} kg, a mass is finite and not negative", b.mass),
        ));
    }
    if !b.center_of_mass.iter().all(|v| v.is_finite()) {
        found.push(FieldProblem::new(pointer("center_of_mass"), "is not finite"));
    }
    if !b.inertia.iter().all(|v| v.is_finite()) {
        found.push(FieldProblem::new(pointer("inertia"), "is not finite"));
    }
    for (field, v) in [("viscous", prior.viscous), ("coulomb", prior.coulomb)] {
        if !v.is_finite() || v < 0.0 {
            found.push(FieldProblem::new(
                pointer(field),
                format!("is {v}; friction is finite and not negative"),
            ));
        }
    }
}

fn bound_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    for (field, [low, high]) in joint.bounds.stated() {
        let ordered = low.is_finite() && high.is_finite() && low <= high;
        if !ordered {
            found.push(FieldProblem::new(
                format!("/joints/{i}/bounds/{field}"),
                format!("is [{low}, {high}]: a finite lower bound and an upper one that is not below it"),
            ));
        }
    }
}
