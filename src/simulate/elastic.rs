//! Motion of links behind elastic joints whose motors follow the trajectory.

use crate::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use crate::parameters::Layout;

/// Solves `q = θ − tau(q, qd, qdd)/K` for the links, on a grid in time, by fixed-point iteration with fourth-order differences: the slow
/// motion of the elastic joint, without its ringing. `compliance` has 1/K per joint, zero for stiff ones.
pub(super) fn link_motion(
    chain: &Chain,
    layout: &Layout,
    phi: &[f64],
    motor: &Motion,
    interval: f64,
    compliance: &[f64],
) -> Motion {
    let mut link = motor.clone();
    // Each iteration shrinks the error by compliance × (stiffness of gravity + inertia × bandwidth²), about a hundredth, and multiplies rounding
    // by compliance × inertia × (2/interval)², some hundreds: three leave 1e-6 of the deflection and no noise.
    for _ in 0..3 {
        let tau = inverse_dynamics_batch(chain, layout, phi, &link, Coulomb::Sign);
        let before = motor.clone();
        for (j, c) in compliance.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let load = &tau[j * link.stride()..j * link.stride() + link.samples()];
            for s in 0..link.samples() {
                let [d, dd] = differences(load, s, interval);
                let [q, qd, qdd] = before.get(j, s);
                link.set(j, s, [q - c * load[s], qd - c * d, qdd - c * dd]);
            }
        }
    }
    link
}

/// First and second derivative by five points; at the ends the value nearest inside.
fn differences(x: &[f64], s: usize, h: f64) -> [f64; 2] {
    let s = s.clamp(2, x.len() - 3);
    let [a, b, c, d, e] = [x[s - 2], x[s - 1], x[s], x[s + 1], x[s + 2]];
    [
        (a - 8.0 * b + 8.0 * d - e) / (12.0 * h),
        (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * h * h),
    ]
}
