//! Friction laws with and without memory.

/// Direction of a speed; none at rest.
pub(super) fn direction(speed: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { speed.signum() }
}

/// Dahl's state over a uniformly sampled speed, `dz/dt = (qd − |qd| z)/width`, by the classical Runge-Kutta method in `SUB_STEPS`
/// steps per sample with the speed interpolated linearly. Starts as if the joint had come a long way in its first direction.
pub(super) fn dahl(speed: &[f64], interval: f64, width: f64) -> Vec<f64> {
    let mut z = speed.iter().copied().find(|&v| v != 0.0).map_or(0.0, direction);
    let mut states = Vec::with_capacity(speed.len());
    for (s, &v) in speed.iter().enumerate() {
        states.push(z);
        let next = speed.get(s + 1).copied().unwrap_or(v);
        // The state settles over the width: a tenth of it per step keeps the method stable and accurate.
        let sub_steps = (SUB_STEPS).max((interval * v.abs().max(next.abs()) / (0.1 * width)).ceil() as usize);
        if sub_steps > MOST_SUB_STEPS {
            z = direction(if next == 0.0 { v } else { next });
            continue;
        }
        let h = interval / sub_steps as f64;
        for k in 0..sub_steps {
            let at = |u: f64| v + (next - v) * (k as f64 + u) / sub_steps as f64;
            let slope = |z: f64, v: f64| (v - v.abs() * z) / width;
            let a = slope(z, at(0.0));
            let b = slope(z + 0.5 * h * a, at(0.5));
            let c = slope(z + 0.5 * h * b, at(0.5));
            let d = slope(z + h * c, at(1.0));
            z += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
    }
    states
}

const SUB_STEPS: usize = 4;
/// A path of so many tenths of the width within a sample leaves nothing of the state before it: `exp(-100)`.
const MOST_SUB_STEPS: usize = 1000;
