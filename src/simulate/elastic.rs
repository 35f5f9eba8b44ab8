//! Motion of links behind elastic joints whose motors follow the trajectory.

use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::parameters::Layout;

/// Solves `q = θ − tau(q, qd, qdd)/K` for the links, on a grid in time, by fixed-point iteration with fourth-order differences: the slow
/// motion of the elastic joint, without its ringing. `compliance` has 1/K per joint, zero for stiff ones.
///
/// Each iteration multiplies what varies with angular frequency ω by (ω/ω₀)², ω₀ the resonance of the joint's inertia on its spring: what is
/// faster than that, rounding and steps in jerk, would grow. The differences reach over `1/ω₀`'s worth of samples, so that they do not see it.
pub(super) fn link_motion(
    chain: &Chain,
    layout: &Layout,
    phi: &[f64],
    motor: &Motion,
    interval: f64,
    compliance: &[f64],
) -> Motion {
    let mut link = motor.clone();
    let reach: Vec<usize> = (0..compliance.len())
        .map(|j| match compliance[j] {
            0.0 => 0,
            c => (SLOWER * (c * largest_inertia(chain, layout, phi, motor, j)).sqrt() / interval).ceil() as usize,
        })
        .collect();
    for _ in 0..ITERATIONS {
        let tau = inverse_dynamics_batch(chain, layout, phi, &link, Coulomb::Sign);
        let before = motor.clone();
        for (j, c) in compliance.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let load = &tau[j * link.stride()..j * link.stride() + link.samples()];
            for s in 0..link.samples() {
                let [d, dd] = differences(load, s, reach[j].max(1), interval);
                let [q, qd, qdd] = before.get(j, s);
                link.set(j, s, [q - c * load[s], qd - c * d, qdd - c * dd]);
            }
        }
    }
    link
}

/// Second differences of five points multiply at most by 16/3 over the square of their step: with three times 1/ω₀, by 0.6 of ω₀².
const SLOWER: f64 = 3.0;
/// Motions a tenth as fast as the resonance lose two digits per iteration.
const ITERATIONS: usize = 4;

/// The largest inertia that a joint moves along a motion: torque per acceleration of its own.
fn largest_inertia(chain: &Chain, layout: &Layout, phi: &[f64], motion: &Motion, joint: usize) -> f64 {
    let step = (motion.samples() / 200).max(1);
    let at = |extra: f64| {
        let states = Motion::from_fn(motion.joints(), motion.samples().div_ceil(step), |j, s| {
            let [q, qd, qdd] = motion.get(j, s * step);
            [q, qd, if j == joint { qdd + extra } else { qdd }]
        });
        let tau = inverse_dynamics_batch(chain, layout, phi, &states, Coulomb::Sign);
        tau[joint * states.stride()..joint * states.stride() + states.samples()].to_vec()
    };
    let (with, without) = (at(1.0), at(0.0));
    with.iter().zip(&without).map(|(a, b)| a - b).fold(0.0, f64::max)
}

/// First and second derivative by five points `reach` samples apart; at the ends the value nearest inside.
fn differences(x: &[f64], s: usize, reach: usize, interval: f64) -> [f64; 2] {
    let s = s.clamp(2 * reach, x.len() - 1 - 2 * reach);
    let h = interval * reach as f64;
    let [a, b, c, d, e] = [x[s - 2 * reach], x[s - reach], x[s], x[s + reach], x[s + 2 * reach]];
    [
        (a - 8.0 * b + 8.0 * d - e) / (12.0 * h),
        (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * h * h),
    ]
}
