//! Bounds on speeds and torques and their derivatives in time, by the recursion of Newton and Euler.

use crate::model::Robot;
use crate::parameters::{Layout, ParameterKind};
use crate::trajectory::{FourierSeries, Trajectory};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bounds on the norm of something and of its derivatives in time.
type Bounds = [f64; ORDERS];
/// Positions have to be known up to the fourth derivative: accelerations, and two more.
const ORDERS: usize = 5;
const BINOMIAL: [[f64; ORDERS]; ORDERS] = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0],
];

fn sum(a: &Bounds, b: &Bounds) -> Bounds {
    std::array::from_fn(|n| a[n] + b[n])
}

fn scaled(a: &Bounds, by: f64) -> Bounds {
    a.map(|v| v * by)
}

fn product(a: &Bounds, b: &Bounds) -> Bounds {
    std::array::from_fn(|n| (0..=n).map(|i| BINOMIAL[n][i] * a[i] * b[n - i]).sum())
}

/// The derivative; what is not known of it is infinite, and must not be asked for.
fn derived(a: &Bounds) -> Bounds {
    std::array::from_fn(|n| a.get(n + 1).copied().unwrap_or(f64::INFINITY))
}

/// A vector of this norm fixed in a frame that turns with ω (`times` 1), or a tensor (`times` 2: `İ = ω × I − I × ω`).
fn carried(norm: f64, omega: &Bounds, times: f64) -> Bounds {
    let mut bounds = [0.0; ORDERS];
    bounds[0] = norm;
    for n in 1..ORDERS {
        let product: f64 = (0..n).map(|i| BINOMIAL[n - 1][i] * omega[i] * bounds[n - 1 - i]).sum();
        bounds[n] = times * product;
    }
    bounds
}

/// `sup |d²τ_j/dt²|` of every joint, friction's jumps left out [N·m/s² or N/s²].
pub(super) fn second_derivatives(robot: &Robot, layout: &Layout, parameters: &[f64], series: &FourierSeries) -> Vec<f64> {
    let joints = robot.joints();
    let speeds: Vec<Bounds> = (0..joints.len()).map(|j| speed_bounds(series, j)).collect();
    let mut omega = [0.0; ORDERS];
    let mut acceleration = [robot.gravity().norm(), 0.0, 0.0, 0.0, 0.0];
    // Axis of every joint, step to its frame, and the wrench of its link's own motion.
    let (mut axes, mut steps, mut forces, mut moments) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (k, joint) in joints.iter().enumerate() {
        let axis = carried(1.0, &omega, 1.0);
        let mut step = carried(joint.placement.translation.norm(), &omega, 1.0);
        if joint.is_revolute() {
            omega = sum(&omega, &product(&speeds[k], &axis));
        } else {
            let mut travel = [0.0; ORDERS];
            travel[0] = farthest(series, k);
            travel[1..].copy_from_slice(&speeds[k][..ORDERS - 1]);
            step = sum(&step, &product(&travel, &axis));
        }
        acceleration = sum(&acceleration, &derived(&derived(&step)));
        let body = layout.link_inertia(parameters, k);
        let moment = carried(body.first_moment.norm(), &omega, 1.0);
        let inertia = carried(body.inertia.symmetric_eigenvalues().amax(), &omega, 2.0);
        forces.push(sum(&scaled(&acceleration, body.mass.abs()), &derived(&derived(&moment))));
        moments.push(sum(&derived(&product(&inertia, &omega)), &product(&moment, &acceleration)));
        axes.push(axis);
        steps.push(step);
    }
    let viscous = |j: usize| {
        let of = |p: &&crate::parameters::Parameter| p.link == j && p.kind == ParameterKind::Viscous;
        let at = layout.parameters().iter().enumerate().find(|(_, p)| of(p)).map(|(at, _)| at);
        at.map_or(0.0, |at| parameters[at].abs())
    };
    (0..joints.len())
        .map(|j| {
            let (mut lever, mut load) = ([0.0; ORDERS], [0.0; ORDERS]);
            for k in j..joints.len() {
                if k > j {
                    lever = sum(&lever, &steps[k]);
                }
                load = if joints[j].is_revolute() {
                    sum(&load, &sum(&moments[k], &product(&lever, &forces[k])))
                } else {
                    sum(&load, &forces[k])
                };
            }
            product(&axes[j], &load)[2] + viscous(j) * speeds[j][2]
        })
        .collect()
}

/// Bounds on `|qd|` and its derivatives over all time: largest of N samples over `cos(π L / N)`.
pub(super) fn speed_bounds(series: &FourierSeries, joint: usize) -> Bounds {
    let points = 40 * series.order();
    let certain = (PI * series.order() as f64 / points as f64).cos();
    std::array::from_fn(|n| {
        let value = |k: usize| {
            let t = k as f64 * series.duration() / points as f64;
            (1..=series.order())
                .map(|l| {
                    let frequency = series.angular_frequency() * l as f64;
                    let (s, c) = (frequency * t + n as f64 * FRAC_PI_2).sin_cos();
                    frequency.powi(n as i32) * (series.a[(joint, l - 1)] * c + series.b[(joint, l - 1)] * s)
                })
                .sum::<f64>()
                .abs()
        };
        (0..points).map(value).fold(0.0, f64::max) / certain
    })
}

/// Farthest that a joint is from zero (rad or m).
fn farthest(series: &FourierSeries, joint: usize) -> f64 {
    let amplitude = |l: usize| series.amplitude(joint, l) / (series.angular_frequency() * l as f64);
    series.offset[joint].abs() + (1..=series.order()).map(amplitude).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_bounds_follow_a_vector_in_a_turning_frame() {
        // r = (cos φ, sin φ) with φ = 2 sin t: derivatives by differences stay below the bounds.
        let omega = [2.0; ORDERS];
        let bounds = carried(1.0, &omega, 1.0);
        let r = |t: f64| {
            let phi = 2.0 * f64::sin(t);
            [phi.cos(), phi.sin()]
        };
        let h = 1e-3;
        for k in 0..7000 {
            let t = k as f64 * h;
            let second: f64 = (0..2)
                .map(|i| ((r(t + h)[i] - 2.0 * r(t)[i] + r(t - h)[i]) / (h * h)).powi(2))
                .sum::<f64>()
                .sqrt();
            assert!(second <= bounds[2] * (1.0 + 1e-5), "{second} {}", bounds[2]);
        }
        assert_eq!(bounds[..3], [1.0, 2.0, 6.0]);
    }
}
