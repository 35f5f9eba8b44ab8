//! W of a long log, made in blocks, is the W that is held.

use crate::simulated::{POSITION_NOISE, TORQUE_NOISE, Virtual, noisy, way_points};
use dynident::identification::preprocess::Period;
use dynident::identification::{Estimator, Observation, PreparedLog, PreprocessOptions, estimate, normal_equations, prepare};

/// Two minutes at 200 Hz that do not repeat, every row kept: several blocks.
fn long(robot: &Virtual) -> PreparedLog {
    let log = noisy(&robot.clean(&way_points(4), 200.0, 12), POSITION_NOISE, &TORQUE_NOISE, 9);
    let options = PreprocessOptions {
        period: Period::None,
        decimation: Some(1),
        ..PreprocessOptions::default()
    };
    prepare(&log, 7, &options).unwrap()
}

#[test]
fn prop_rows_made_in_blocks_are_those_that_are_held() {
    let robot = Virtual::iiwa14();
    let log = long(&robot);
    let with = |most: usize| {
        let mut observation = Observation::holding(most, &robot.robot, &robot.base.kept, &log);
        observation.push_offsets(&log);
        observation
    };
    let (held, made) = (with(usize::MAX), with(0));
    assert!(held.is_held() && !made.is_held());
    let mut blocks = 0;
    made.for_each_block(|_, _| blocks += 1);
    assert!(blocks > 1, "{blocks}");
    // A filter has forgotten the cut of a block to 1e-18; what is left is rounding.
    let (a, b) = ([held], [made]);
    for (x, y) in normal_equations(&a).iter().zip(&normal_equations(&b)) {
        assert!((&x.gram - &y.gram).amax() < 1e-9 * x.gram.amax());
        assert!((&x.moment - &y.moment).amax() < 1e-9 * x.moment.amax());
    }
    for estimator in [Estimator::Weighted, Estimator::Robust] {
        let (x, y) = (estimate(&a, &[&log], estimator), estimate(&b, &[&log], estimator));
        for c in 0..x.values.len() {
            assert!((x.values[c] - y.values[c]).abs() < 1e-6 * x.std_dev(c), "{c}");
            assert!((x.std_dev(c) / y.std_dev(c) - 1.0).abs() < 1e-6, "{c}");
        }
    }
}
