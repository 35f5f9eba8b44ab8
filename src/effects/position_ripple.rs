//! Torque that repeats with the position: gear teeth, magnets, sensors.

use super::{About, Column, Effect, ParameterInfo, PlotVariable, Scene, Shape, Span, Statements, Written};
use crate::dynamics::sines_and_cosines;
use crate::model::Robot;

/// `tau_j += A sin(N q) + B cos(N q)`, N in cycles per 2π rad (per 2π m for a sliding joint), not only integers.
pub struct PositionRipple;

/// Gears of arms reach 160 to 1; two waves per motor turn make 320 per joint turn.
const MOST_CYCLES: f64 = 400.0;

impl Effect for PositionRipple {
    fn code(&self) -> &'static str {
        "position_ripple"
    }

    fn about(&self) -> About {
        About {
            name: "Position ripple",
            phrase: "position ripple",
            meaning: "Torque that varies periodically with position: cogging, gear mesh or eccentricity.",
            over: PlotVariable::Position,
            identifiable: "when the joint passes several waves, and fewer than half a wave from sample to sample; at one or two waves per \
                           turn gravity terms hide it",
            rivals: &["joint_spring", "encoder_offset"],
            source: "Ruderman 2012; Zhu & Schutter 1999 (harmonic drives)",
        }
    }

    fn shapes(&self, _form: usize, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        let span = spans[joints[0]];
        // At least one wave over the travel: fewer are a polynomial. At most half a wave per sample at three quarters of the top
        // speed, beyond which the fast parts of the motion alias.
        let low = (2.0 * std::f64::consts::PI / span.range.max(1e-6)).max(2.5);
        let high = (std::f64::consts::PI / (0.75 * span.speed * span.interval).max(1e-12)).min(MOST_CYCLES.max(20.0 * low));
        if high <= low {
            return vec![Shape {
                low,
                high: low,
                grid: Vec::new(),
            }];
        }
        // Two waves that differ by less than a third of a cycle over the travel are one to the search; refinement does the rest.
        let step = 2.0 * std::f64::consts::PI / (3.0 * span.range);
        let count = ((high - low) / step).ceil() as usize + 1;
        vec![Shape {
            low,
            high,
            grid: (0..count).map(|i| (low + i as f64 * step).min(high)).collect(),
        }]
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let angles: Vec<f64> = scene.motion.positions(joints[0]).iter().map(|q| shape[0] * q).collect();
        let (sine, cosine) = sines_and_cosines(&angles);
        vec![Column::on(joints[0], sine), Column::on(joints[0], cosine)]
    }

    fn statements(&self, w: &Written) -> Option<Statements> {
        let (c, n) = (&w.coefficients, &w.shape[0]);
        w.on_own_joint(|[q, _, _]| format!("{} * sin({n} * {q}) + {} * cos({n} * {q})", c[0], c[1]))
    }

    /// Of phase zero.
    fn units(&self, _form: usize, _count: usize, _middle: f64) -> Vec<Vec<f64>> {
        vec![vec![1.0, 0.0]]
    }

    fn is_rare(&self) -> bool {
        true
    }

    fn parameters(&self, _form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
        let joint = &robot.joints()[joints[0]];
        vec![
            ParameterInfo::new("amplitude", joint.effort_unit()),
            ParameterInfo::new("phase", "rad"),
            ParameterInfo::new("cycles", format!("1/{}", joint.position_unit())),
        ]
    }

    /// `A sin x + B cos x = amplitude · sin(x + phase)`.
    fn reported(&self, _form: usize, coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        vec![
            coefficients[0].hypot(coefficients[1]),
            coefficients[1].atan2(coefficients[0]),
            shape[0],
        ]
    }
}
