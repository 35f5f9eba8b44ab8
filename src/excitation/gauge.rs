//! The admissible coefficients of one joint as a convex set around rest, and its gauge: the factor by which a motion exceeds
//! the limit that it exceeds most.

use super::extremes::{CertifiedExtremes, SampledBases};
use super::problem::{Form, ProblemSpec, Start};
use crate::model::Limits;
use std::f64::consts::TAU;

/// Limits of one joint, in the form asked for.
#[derive(Debug, Clone)]
pub(super) enum JointSet {
    Paper(TriangleBounds),
    Exact(CertifiedExtremes),
}

impl JointSet {
    /// `rest`: position around which coefficients scale, strictly inside the position limits. `bases`: those of `spec`, for all
    /// its joints.
    pub fn new(limits: &Limits, rest: f64, spec: &ProblemSpec, bases: &SampledBases) -> Self {
        match spec.form {
            Form::Paper => Self::Paper(TriangleBounds::new(limits, rest, spec)),
            Form::Exact => Self::Exact(CertifiedExtremes::new(limits, rest, bases)),
        }
    }

    /// Gauge at `c = [a, b, offset − rest]` and its (sub)gradient; positively homogeneous: `gauge(s c) = s gauge(c)` for s > 0,
    /// and `gauge(c) ≤ 1` exactly when all limits hold.
    pub fn gauge(&self, c: &[f64], gradient: &mut [f64]) -> f64 {
        match self {
            Self::Paper(set) => set.gauge(c, gradient),
            Self::Exact(set) => set.gauge(c, gradient),
        }
    }
}

/// (14d)–(14g): `|offset| + Σ_l w_l sqrt(a_l² + b_l²) ≤ limit` with w = 1/(ω l), 1, ω l, (ω l)² for position, velocity,
/// acceleration and jerk, and boxes on the coefficients.
#[derive(Debug, Clone)]
pub(super) struct TriangleBounds {
    order: usize,
    /// (weight of |offset|, weights of the harmonics), already over the limit.
    sums: Vec<(f64, Vec<f64>)>,
    /// 1 / bound on |a_l| and |b_l|.
    boxes: Vec<f64>,
}

impl TriangleBounds {
    fn new(limits: &Limits, rest: f64, spec: &ProblemSpec) -> Self {
        let order = spec.order;
        let frequency = |l: usize| TAU * spec.fundamental_hz * l as f64;
        let half_range = limits.position.map(|[low, high]| (rest - low).min(high - rest));
        let mut sums = Vec::new();
        let mut bound = |limit: Option<f64>, offset: f64, weight: &dyn Fn(f64) -> f64| {
            if let Some(limit) = limit {
                sums.push((offset / limit, (1..=order).map(|l| weight(frequency(l)) / limit).collect()));
            }
        };
        bound(half_range, 1.0, &|w| 1.0 / w);
        bound(limits.velocity, 0.0, &|_| 1.0);
        bound(limits.acceleration, 0.0, &|w| w);
        bound(limits.jerk, 0.0, &|w| w * w);
        // (14f), (14g): each coefficient at most a fifth (1/L) of the position range, and the velocity limit.
        let boxes = (1..=order)
            .map(|l| {
                let position = half_range.map_or(f64::INFINITY, |q| frequency(l) * q / order as f64);
                1.0 / position.min(limits.velocity.unwrap_or(f64::INFINITY))
            })
            .collect();
        Self {
            order,
            sums,
            boxes: if spec.start == Start::Zero { boxes } else { vec![0.0; order] },
        }
    }

    fn gauge(&self, c: &[f64], gradient: &mut [f64]) -> f64 {
        let (a, b) = (&c[..self.order], &c[self.order..2 * self.order]);
        let offset = c[2 * self.order];
        let amplitudes: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.hypot(*b)).collect();
        let mut largest = 0.0;
        gradient.fill(0.0);
        for (to_offset, weights) in &self.sums {
            let value = to_offset * offset.abs() + weights.iter().zip(&amplitudes).map(|(w, r)| w * r).sum::<f64>();
            if value > largest {
                largest = value;
                for l in 0..self.order {
                    let per_unit = if amplitudes[l] > 0.0 {
                        weights[l] / amplitudes[l]
                    } else {
                        0.0
                    };
                    (gradient[l], gradient[self.order + l]) = (per_unit * a[l], per_unit * b[l]);
                }
                gradient[2 * self.order] = to_offset * offset.signum();
            }
        }
        for i in 0..2 * self.order {
            let value = c[i].abs() * self.boxes[i % self.order];
            if value > largest {
                largest = value;
                gradient.fill(0.0);
                gradient[i] = self.boxes[i % self.order] * c[i].signum();
            }
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::problem::{Criterion, Knowledge, Problem};
    use crate::model::{Friction, Joint, JointKind, Mdh, Robot};
    use crate::trajectory::harmonic;
    use nalgebra::Vector3;

    fn spec(form: Form, start: Start) -> ProblemSpec {
        let mdh = Mdh {
            alpha: 0.0,
            d: 0.0,
            theta: 0.0,
            r: 0.0,
        };
        let robot = Robot::new(
            "one",
            Vector3::zeros(),
            vec![Joint::from_mdh("j", JointKind::Revolute, mdh)],
            Friction {
                viscous: true,
                coulomb: true,
            },
        );
        ProblemSpec {
            robot: robot.unwrap(),
            order: 5,
            fundamental_hz: 0.1,
            sample_rate_hz: 100.0,
            criterion: Criterion::ConditionNumber,
            form,
            start,
            start_position: None,
            torque_noise: None,
            torque: None,
            space: None,
            harmonics: None,
            knowledge: Knowledge::default(),
        }
    }

    const LIMITS: Limits = Limits {
        position: Some([-1.0, 2.0]),
        velocity: Some(1.3),
        acceleration: Some(3.0),
        jerk: Some(9.0),
        effort: None,
    };

    fn coefficients(seed: usize) -> Vec<f64> {
        (0..11).map(|i| ((seed * 31 + i * 17) as f64).sin()).collect()
    }

    #[test]
    fn prop_gauge_is_convex_and_homogeneous_and_its_gradient_is_the_difference() {
        for (form, start) in [
            (Form::Paper, Start::Zero),
            (Form::Paper, Start::Free),
            (Form::Exact, Start::Zero),
            (Form::Exact, Start::Free),
        ] {
            let spec = spec(form, start);
            let set = JointSet::new(&LIMITS, 0.2, &spec, &SampledBases::of(&spec));
            let mut g = vec![0.0; 11];
            let mut unused = g.clone();
            for seed in 0..50 {
                let (c, d) = (coefficients(seed), coefficients(seed + 1000));
                let value = set.gauge(&c, &mut g);
                let scaled: Vec<f64> = c.iter().map(|v| 2.5 * v).collect();
                assert!((set.gauge(&scaled, &mut unused) - 2.5 * value).abs() < 1e-12 * value);
                let middle: Vec<f64> = c.iter().zip(&d).map(|(a, b)| 0.5 * (a + b)).collect();
                let ends = value + set.gauge(&d, &mut unused);
                assert!(set.gauge(&middle, &mut unused) <= 0.5 * ends * (1.0 + 1e-12));
                // Euler's theorem for homogeneous functions holds for every subgradient.
                let euler: f64 = c.iter().zip(&g).map(|(a, b)| a * b).sum();
                assert!((euler - value).abs() < 1e-12 * value);
            }
        }
    }

    #[test]
    fn prop_certified_extremes_are_never_below_a_dense_sampling() {
        let spec = spec(Form::Exact, Start::Free);
        let set = JointSet::new(&LIMITS, 0.2, &spec, &SampledBases::of(&spec));
        let mut unused = vec![0.0; 11];
        for seed in 0..20 {
            let c = coefficients(seed);
            let gauge = set.gauge(&c, &mut unused);
            let mut dense = 0.0f64;
            for k in 0..200_000 {
                let t = k as f64 * 10.0 / 200_000.0;
                let mut state = [c[10], 0.0, 0.0, 0.0];
                for l in 1..=5 {
                    let [s, b] = harmonic(TAU * 0.1, l, t);
                    let w = TAU * 0.1 * l as f64;
                    for d in 0..3 {
                        state[d] += s[d] * c[l - 1] + b[d] * c[4 + l];
                    }
                    state[3] -= w * w * (s[1] * c[l - 1] + b[1] * c[4 + l]);
                }
                let position = (state[0] / 1.8).max(-state[0] / 1.2);
                dense = dense
                    .max(position)
                    .max(state[1].abs() / 1.3)
                    .max(state[2].abs() / 3.0)
                    .max(state[3].abs() / 9.0);
            }
            assert!(gauge >= dense, "a limit exceeded between the samples");
            // The certificate costs less than 0.02 %: 0.01 % on each half range.
            assert!(gauge <= dense * (1.0 + 2e-4), "{gauge} {dense}");
        }
        assert!(
            Problem::new(spec).is_err(),
            "a joint without limits is refused before it gets here"
        );
    }
}
