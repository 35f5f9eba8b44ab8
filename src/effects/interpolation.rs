//! A sampled motion between its samples, and time derivatives of a sampled signal.

use crate::dynamics::Motion;

/// `[q, qd, qdd]` of a joint at sample position `at` (any fraction): the quintic through position, velocity and acceleration of
/// both neighbours. Beyond the ends of a motion that does not repeat, constant acceleration.
pub(super) fn at_time(motion: &Motion, joint: usize, at: f64, interval: f64, periodic: bool) -> [f64; 3] {
    let n = motion.samples();
    if !periodic && (at < 0.0 || at > (n - 1) as f64) {
        let end = if at < 0.0 { 0 } else { n - 1 };
        let [q, qd, qdd] = motion.get(joint, end);
        let t = (at - end as f64) * interval;
        return [q + qd * t + 0.5 * qdd * t * t, qd + qdd * t, qdd];
    }
    let (floor, u) = (at.floor(), at - at.floor());
    let first = (floor as i64).rem_euclid(n as i64) as usize;
    if u == 0.0 {
        return motion.get(joint, first);
    }
    quintic(motion.get(joint, first), motion.get(joint, (first + 1) % n), u, interval)
}

/// The quintic on [0, h] with the given states at both ends, at u h.
fn quintic([q0, v0, a0]: [f64; 3], [q1, v1, a1]: [f64; 3], u: f64, h: f64) -> [f64; 3] {
    let (v0, v1, a0, a1) = (v0 * h, v1 * h, a0 * h * h, a1 * h * h);
    let d = q1 - q0 - v0 - 0.5 * a0;
    let e = v1 - v0 - a0;
    let f = a1 - a0;
    let c3 = 10.0 * d - 4.0 * e + 0.5 * f;
    let c4 = -15.0 * d + 7.0 * e - f;
    let c5 = 6.0 * d - 3.0 * e + 0.5 * f;
    let q = q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))));
    let v = v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)));
    let a = a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5));
    [q, v / h, a / (h * h)]
}

/// A smooth signal with its first and second time derivative: a local cubic fitted over [`REACH`] to both sides (Savitzky-Golay),
/// which keeps the harmonics of a motion and not the noise of accelerations. Ends of signals that do not repeat are continued by
/// their end values.
pub(super) fn derivatives(signal: &[f64], interval: f64, periodic: bool) -> [Vec<f64>; 3] {
    let n = signal.len() as i64;
    let reach = ((REACH / interval).round() as i64).max(FEWEST);
    let value = |i: i64| signal[if periodic { i.rem_euclid(n) } else { i.clamp(0, n - 1) } as usize];
    let offsets = -reach..=reach;
    let (s2, s4, s6) = offsets.clone().fold((0.0, 0.0, 0.0), |(a, b, c), k| {
        let k = (k * k) as f64;
        (a + k, b + k * k, c + k * k * k)
    });
    let m = (2 * reach + 1) as f64;
    let (odd, even) = (s2 * s6 - s4 * s4, m * s4 - s2 * s2);
    let mut first = Vec::with_capacity(signal.len());
    let mut second = Vec::with_capacity(signal.len());
    for i in 0..n {
        let (mut x0, mut x1, mut x2, mut x3) = (0.0, 0.0, 0.0, 0.0);
        for k in offsets.clone() {
            let (v, k) = (value(i + k), k as f64);
            x0 += v;
            x1 += k * v;
            x2 += k * k * v;
            x3 += k * k * k * v;
        }
        first.push((s6 * x1 - s4 * x3) / odd / interval);
        second.push(2.0 * (m * x2 - s2 * x0) / even / (interval * interval));
    }
    [signal.to_vec(), first, second]
}

/// Half the window (s): a second derivative through it falls to half at 8 Hz. Elastic joints of arms resonate at 5 to 20 Hz;
/// beyond that links do not follow, and the quasi-static law, which would amplify what is there, has no meaning. At 2 Hz, four
/// times the fastest harmonic of a usual excitation, 4 % are lost.
pub const REACH: f64 = 0.06;
/// Samples to both sides at least: a cubic needs fewer.
pub const FEWEST: i64 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_quintic_reproduces_a_quintic_motion() {
        let state = |t: f64| {
            [
                1.0 + t + t.powi(3) - 2.0 * t.powi(5),
                1.0 + 3.0 * t * t - 10.0 * t.powi(4),
                6.0 * t - 40.0 * t.powi(3),
            ]
        };
        let motion = Motion::from_fn(1, 11, |_, s| state(0.1 * s as f64));
        for at in [0.3, 4.7, 9.99] {
            let (have, want) = (at_time(&motion, 0, at, 0.1, false), state(0.1 * at));
            // Accelerations are differences of values of order 10 divided by h² = 1e-2.
            have.iter()
                .zip(want)
                .for_each(|(h, w)| assert!((h - w).abs() < 1e-11, "{h} for {w}"));
        }
    }

    #[test]
    fn prop_derivatives_of_a_cubic_are_exact_inside() {
        let signal: Vec<f64> = (0..40).map(|i| (0.01 * i as f64).powi(3)).collect();
        let [_, d, dd] = derivatives(&signal, 0.01, false);
        assert!((d[20] - 3.0 * 0.2f64.powi(2)).abs() < 1e-12 && (dd[20] - 6.0 * 0.2).abs() < 1e-10);
    }
}
