//! Accelerations of a motion that does not repeat, from noisy positions.

use crate::simulated::{TORQUE_NOISE, Virtual, noisy, way_points};
use dynident::preparation::{FilterSpec, PreparedLog, PreprocessOptions, prepare};
use dynident::trajectory::Trajectory;

/// Root mean square error of derivative `order` of a joint over the rows that are used.
fn error(prepared: &PreparedLog, path: &dyn Trajectory, joint: usize, order: usize) -> f64 {
    let rows: Vec<usize> = prepared.row_filter.rows(prepared.samples()).collect();
    let motion = &prepared.motion;
    let square = |&s: &usize| {
        let states = [
            motion.positions(joint)[s],
            motion.velocities(joint)[s],
            motion.accelerations(joint)[s],
        ];
        (states[order] - path.state(joint, s as f64 / prepared.rate_hz)[order]).powi(2)
    };
    (rows.iter().map(square).sum::<f64>() / rows.len() as f64).sqrt()
}

/// The filter of positions goes with their noise: errors are those that are stated (in trials 0.78 to 1.05 of them), and where
/// noise is large less than half of what a filter beside that of the rows lets through.
#[test]
fn prop_errors_of_derivatives_are_those_stated_whatever_the_noise_and_the_rate() {
    let (robot, path) = (Virtual::iiwa14(), way_points(3));
    for rate in [100.0, 200.0, 1000.0] {
        for noise in [2.5e-5, 2e-4, 1e-3] {
            let log = noisy(&robot.clean(&path, rate, 1), noise, &TORQUE_NOISE, 1);
            let of = |position_filter| {
                let options = PreprocessOptions {
                    position_filter,
                    ..PreprocessOptions::default()
                };
                prepare(&log, 7, &options).unwrap()
            };
            let prepared = of(None);
            for joint in 0..7 {
                for order in [1, 2] {
                    let stated = prepared.motion_error[joint].std_dev[order];
                    let ratio = error(&prepared, &path, joint, order) / stated;
                    assert!(
                        (0.7..1.2).contains(&ratio),
                        "{rate} Hz, {noise} rad, joint {joint}, derivative {order}: {ratio}"
                    );
                }
            }
            let beside_rows = FilterSpec {
                order: 8,
                cutoff_hz: prepared.row_filter.torque.as_ref().unwrap().cutoff_hz * 4.0 / 3.0,
            };
            let [own, other] = [&prepared, &of(Some(beside_rows))].map(|p| error(p, &path, 1, 2));
            let most = if noise == 1e-3 { 0.5 } else { 1.1 };
            assert!(own < most * other, "{rate} Hz, {noise} rad: {own} of {other}");
        }
    }
}
