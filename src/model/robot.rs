//! The robot itself: built once, checked once, shared by every computation.

use super::limits::{BEYOND_ANY_POSITION, FASTEST_REVOLUTE, LARGEST_REVOLUTE, LimitProblem};
use super::{FieldProblem, INPUT_LIMITS, Joint, ModelError, decimals, scientific};
use nalgebra::Vector3;
use std::collections::HashMap;

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

    /// Name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Acceleration of gravity in the base frame [m/s²].
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// Joints from the base to the flange.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Number of joints n.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Friction that is declared on every joint.
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

    /// For what leaves a valid robot one.
    pub(super) fn joints_mut(&mut self) -> &mut [Joint] {
        &mut self.joints
    }

    fn problems(&self) -> Vec<FieldProblem> {
        let mut found = Vec::new();
        if !self.gravity.iter().all(|g| g.is_finite()) {
            found.push(FieldProblem::new("/gravity", "is not finite"));
        } else if self.gravity.norm() > 100.0 {
            found.push(
                FieldProblem::new("/gravity", format!("is {} m/s² long", decimals(self.gravity.norm(), 0)))
                    .with_hint("gravity is in m/s², on Earth 9.81 long: check the unit"),
            );
        }
        match self.joints.len() {
            0 => found.push(FieldProblem::new("/joints", "is empty: a robot has at least one joint")),
            n if n > INPUT_LIMITS.joints => {
                let most = INPUT_LIMITS.joints;
                found.push(FieldProblem::new(
                    "/joints",
                    format!("has {n} joints, the most accepted is {most}"),
                ));
                return found;
            }
            _ => {}
        }
        self.name_problems(&mut found);
        for (i, joint) in self.joints.iter().enumerate() {
            placement_problems(i, joint, &mut found);
            limit_problems(i, joint, &mut found);
            prior_problems(i, joint, &mut found);
            bound_problems(i, joint, &mut found);
            geometry_problems(i, joint, &mut found);
        }
        found
    }

    fn name_problems(&self, found: &mut Vec<FieldProblem>) {
        found.extend(name_problem("/name", &self.name, false));
        let (mut joints, mut links) = (HashMap::new(), HashMap::new());
        for (i, joint) in self.joints.iter().enumerate() {
            let named = [("name", &joint.name, &mut joints), ("link", &joint.link_name, &mut links)];
            let before = found.len();
            // A link is called after its joint where nobody names it: what is wrong with the joint's name is said once.
            for (field, name, known) in named {
                if found.len() > before {
                    break;
                }
                let pointer = format!("/joints/{i}/{field}");
                if let Some(problem) = name_problem(&pointer, name, true) {
                    found.push(problem);
                } else if let Some(first) = known.insert(name.clone(), i) {
                    let of = if field == "name" { "joint" } else { "the link of joint" };
                    found.push(FieldProblem::new(
                        pointer,
                        format!("`{name}` is already the name of {of} {}", first + 1),
                    ));
                }
            }
        }
    }
}

/// Names stand in files of many formats: what would break a line, a field or a tag that cannot be escaped is refused.
fn name_problem(pointer: &str, name: &str, is_required: bool) -> Option<FieldProblem> {
    if is_required && name.trim().is_empty() {
        return Some(FieldProblem::new(pointer, "is empty"));
    }
    if name.chars().count() > INPUT_LIMITS.name_characters {
        let detail = format!("is longer than {} characters", INPUT_LIMITS.name_characters);
        return Some(FieldProblem::new(pointer, detail));
    }
    let bad = name.chars().find(|&c| c.is_control() || UNPRINTABLE.contains(&c))?;
    let detail = format!(
        "has the character U+{:04X}, which no file format holds in a name",
        u32::from(bad)
    );
    Some(FieldProblem::new(pointer, detail).with_hint("names are of one line, without control characters"))
}

/// Line and paragraph separator, and what XML does not allow though it is no control character.
const UNPRINTABLE: [char; 4] = ['\u{2028}', '\u{2029}', '\u{fffe}', '\u{ffff}'];

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
            if v.is_finite() && v.abs() > INPUT_LIMITS.length {
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
    let translation = joint.placement.translation;
    if !rigid || !translation.iter().all(|v| v.is_finite()) {
        found.push(FieldProblem::new(
            format!("/joints/{i}"),
            "its place is not a finite rigid transform",
        ));
    } else if joint.mdh.is_none() && translation.norm() > INPUT_LIMITS.length {
        let detail = format!("is {} m away from the joint before it", scientific(translation.norm(), 3));
        let hint = "lengths are in metres; this looks like millimetres";
        found.push(FieldProblem::new(format!("/joints/{i}/placement/xyz"), detail).with_hint(hint));
    }
}

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

/// Limits that were written in degrees. A single joint with short travel in degrees (±20) would slip below, but all joints are
/// written in the same unit, and some have a long travel.
fn degree_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    let hint = "limits of revolute joints are in radians; this looks like degrees: multiply by π/180";
    if let Some([low, high]) = joint.limits.position
        && low.is_finite()
        && high.is_finite()
    {
        let (pointer, largest) = (format!("/joints/{i}/limits/position"), low.abs().max(high.abs()));
        let unit = joint.position_unit();
        if largest >= BEYOND_ANY_POSITION {
            let detail = format!("is [{low:?}, {high:?}] {unit}: one end is beyond any joint");
            let hint = "give two ends that the joint can reach, or null where it has no limits";
            found.push(FieldProblem::new(pointer, detail).with_hint(hint));
        } else if joint.is_revolute() && largest > LARGEST_REVOLUTE {
            found.push(FieldProblem::new(pointer, format!("is [{low}, {high}] rad")).with_hint(hint));
        }
    }
    if let Some(v) = joint.limits.velocity
        && joint.is_revolute()
        && v.is_finite()
        && v > FASTEST_REVOLUTE
    {
        found.push(FieldProblem::new(format!("/joints/{i}/limits/velocity"), format!("is {v} rad/s")).with_hint(hint));
    }
}

fn prior_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    let Some(prior) = &joint.prior else { return };
    let (b, most) = (&prior.inertia, INPUT_LIMITS);
    let mut complain = |field: &str, detail: String| {
        found.push(FieldProblem::new(format!("/joints/{i}/prior/{field}"), detail));
    };
    if !(0.0..=most.mass).contains(&b.mass) {
        complain("mass", format!("is {:?} kg; a mass is from 0 to {:e} kg", b.mass, most.mass));
    }
    if !b.center_of_mass.iter().all(|v| v.abs() <= most.length) {
        complain(
            "center_of_mass",
            format!("is farther than {} m from the joint: lengths are in metres", most.length),
        );
    }
    if !b.inertia.iter().all(|v| v.abs() <= most.inertia) {
        complain("inertia", format!("has an entry beyond {:e} kg m²", most.inertia));
    }
    for (field, v) in [("viscous", prior.viscous), ("coulomb", prior.coulomb)] {
        if !(0.0..=most.friction).contains(&v) {
            complain(field, format!("is {v:?}; friction is from 0 to {:e}", most.friction));
        }
    }
}

fn geometry_problems(i: usize, joint: &Joint, found: &mut Vec<FieldProblem>) {
    let (count, most) = (joint.geometry.len(), INPUT_LIMITS.capsules_per_link);
    if count > most {
        let detail = format!("has {count} capsules, the most accepted is {most}");
        let hint = "cover the link by a few that contain it";
        found.push(FieldProblem::new(format!("/joints/{i}/geometry"), detail).with_hint(hint));
    }
    let far = |p: &Vector3<f64>| !p.iter().all(|v| v.abs() <= INPUT_LIMITS.length);
    for (k, capsule) in joint.geometry.iter().enumerate().take(most) {
        if capsule.ends.iter().any(far) {
            let detail = format!(
                "has an end farther than {} m from the joint: lengths are in metres",
                INPUT_LIMITS.length
            );
            found.push(FieldProblem::new(format!("/joints/{i}/geometry/{k}"), detail));
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
