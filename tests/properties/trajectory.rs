//! Velocities and accelerations are the derivatives of positions, for every kind of trajectory.

use crate::support::{rng, uniform};
use dynident::trajectory::{FourierSeries, QuinticWayPoints, SineSeries, Trajectory, sample_count};
use nalgebra::DMatrix;

fn assert_derivatives(trajectory: &dyn Trajectory) {
    let h = 1e-4;
    for joint in 0..trajectory.joints() {
        for k in 1..40 {
            let t = trajectory.duration() * (k as f64 / 40.0 + 1e-3);
            if t + h > trajectory.duration() {
                continue;
            }
            let [_, qd, qdd] = trajectory.state(joint, t);
            let (before, after) = (trajectory.state(joint, t - h), trajectory.state(joint, t + h));
            // Central differences: h²/6 of the next but one derivative (frequencies up to some 10 rad/s, amplitudes of order
            // one).
            assert!((qd - (after[0] - before[0]) / (2.0 * h)).abs() < 1e-4, "qd at {t}");
            assert!((qdd - (after[1] - before[1]) / (2.0 * h)).abs() < 1e-3, "qdd at {t}");
        }
    }
}

#[test]
fn prop_derivatives_match_differences() {
    let mut rng = rng(3);
    let mut coefficients = || DMatrix::from_fn(3, 5, |_, _| uniform(&mut rng, 1.0));
    let (a, b) = (coefficients(), coefficients());
    assert_derivatives(&FourierSeries {
        fundamental_hz: 0.1,
        a,
        b,
        offset: vec![0.1, -0.2, 0.3],
    });
    let terms = vec![vec![(0.4, 1.3), (-0.2, 2.9)], vec![(1.0, 0.7)]];
    assert_derivatives(&SineSeries { terms, duration: 10.0 });
    let way_points = (0..6).map(|_| vec![uniform(&mut rng, 1.5), uniform(&mut rng, 1.5)]).collect();
    assert_derivatives(&QuinticWayPoints::new(way_points, &[1.0, 2.5, 0.9, 3.0, 2.0]));
}

#[test]
fn prop_quintic_rests_at_its_way_points() {
    let trajectory = QuinticWayPoints::new(vec![vec![0.2], vec![-1.0], vec![0.7]], &[1.5, 2.0]);
    for (t, q) in [(0.0, 0.2), (1.5, -1.0), (3.5, 0.7)] {
        let [at, qd, qdd] = trajectory.state(0, t);
        assert!((at - q).abs() < 1e-15 && qd.abs() < 1e-15 && qdd.abs() < 1e-15);
    }
}

#[test]
fn prop_sampling_leaves_the_repeated_end_out() {
    assert_eq!(sample_count(10.0, 100.0), 1000);
    assert_eq!(sample_count(1.0 / 0.3, 1000.0), 3334);
    assert_eq!(sample_count(1.0 / 0.1, 1000.0), 10_000);
}
