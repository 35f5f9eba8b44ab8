//! A motor that turns with two joints at once.

use super::ranges::COUPLING_RATIO;
use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written};
use crate::model::Robot;

/// Friction and inertia of the motor speed `v = qd_i + k qd_j` on joint i, and k times that on joint j:
/// `tau_i += FV v + FS sign v + Ia v̇`, `tau_j += k (FV v + FS sign v + Ia v̇)`.
///
/// Forms: k = 1, k = −1, k free and positive, k free and negative.
pub struct TransmissionCoupling;

impl TransmissionCoupling {
    fn ratio(form: usize, shape: &[f64]) -> f64 {
        [1.0, -1.0].get(form).copied().unwrap_or_else(|| shape[0])
    }
}

impl Effect for TransmissionCoupling {
    fn code(&self) -> &'static str {
        "transmission_coupling"
    }

    fn about(&self) -> About {
        About {
            name: "Transmission coupling",
            phrase: "transmission coupling",
            meaning: "Torque at one joint from the motion of a neighbouring joint, as in coupled wrist gears or belts.",
            over: PlotVariable::Speed,
            identifiable: "when the two joints move independently of each other",
            rivals: &["torque_crosstalk", "rotor_inertia"],
            source: "Gautier, Vandanjon & Janot 2011 (Stäubli TX40, joints 5 and 6)",
        }
    }

    /// Neighbours: joints that are coupled share a housing. Further apart no gear or belt runs, but base parameters that are
    /// missing imitate one.
    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        (1..robot.joint_count())
            .map(|j| vec![j - 1, j])
            .filter(|pair| kinds_agree(robot, pair))
            .collect()
    }

    fn forms(&self) -> usize {
        4
    }

    fn shapes(&self, form: usize, _joints: &[usize], _spans: &[Span]) -> Vec<Shape> {
        // Near zero the second joint takes no part, and what is left is the first joint's own inertia.
        match form {
            2 => vec![Shape {
                low: COUPLING_RATIO[0],
                high: COUPLING_RATIO[1],
                grid: vec![0.4, 0.7, 1.4, 2.0],
            }],
            3 => vec![Shape {
                low: -COUPLING_RATIO[1],
                high: -COUPLING_RATIO[0],
                grid: vec![-2.0, -1.4, -0.7, -0.4],
            }],
            _ => Vec::new(),
        }
    }

    fn columns(&self, form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let (i, j, k) = (joints[0], joints[1], Self::ratio(form, shape));
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + k * b).collect::<Vec<_>>();
        let v = sum(scene.motion.velocities(i), scene.motion.velocities(j));
        let a = sum(scene.motion.accelerations(i), scene.motion.accelerations(j));
        let sign = v.iter().map(|&v| scene.sign(v)).collect();
        let both = |x: Vec<f64>| Column {
            rows: vec![(j, x.iter().map(|x| k * x).collect()), (i, x)],
        };
        vec![both(v), both(sign), both(a)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (i, j, c) = (w.joints[0], w.joints[1], &w.coefficients);
        let k = ["1.0", "-1.0"]
            .get(w.form)
            .map_or_else(|| w.shape[0].clone(), ToString::to_string);
        let sum = |x: &str| format!("({x}[{i}] + {k} * {x}[{j}])");
        let (v, a) = (sum("qd"), sum("qdd"));
        let load = format!("{} * {v} + {} * sign{v} + {} * {a}", c[0], c[1], c[2]);
        let entry = |row: usize, column: usize, factor: &str| (row, column, format!("{factor} * {}", c[2]));
        Some(Statements {
            inertia: vec![
                entry(i, i, "1.0"),
                entry(i, j, &k),
                entry(j, i, &k),
                entry(j, j, &format!("{k} * {k}")),
            ],
            torque: vec![(i, load.clone()), (j, format!("{k} * ({load})"))],
        })
    }

    fn positive(&self, _form: usize) -> &'static [usize] {
        &[0, 1, 2]
    }

    fn parameters(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        let revolute = joint.is_revolute();
        let mut list = vec![
            ParameterInfo::new("viscous", if revolute { "N m s/rad" } else { "N s/m" }),
            ParameterInfo::new("coulomb", joint.effort_unit()),
            ParameterInfo::new("inertia", if revolute { "kg m^2" } else { "kg" }),
        ];
        if form >= 2 {
            list.push(ParameterInfo::new("ratio", "1"));
        }
        list
    }
}

/// Speeds in rad/s and m/s have no sum.
fn kinds_agree(robot: &Robot, pair: &[usize]) -> bool {
    robot.joints()[pair[0]].kind == robot.joints()[pair[1]].kind
}
