//! The paper's chain at the paper's size, against NumPy, SciPy and Pinocchio (`tests/data/ref_paper_chain.py`,
//! tests/data/README.md).

use crate::simulated::Virtual;
use dynident::preparation::{Log, PreprocessOptions, prepare};
use dynident::regression::{Estimator, Stretch, estimate};
use dynident::trajectory::FourierSeries;
use nalgebra::DMatrix;
use serde_json::Value;

const PERIODS: usize = 16;
const RATE_HZ: f64 = 1000.0;

fn trajectory() -> FourierSeries {
    let wave = |phase: f64| {
        DMatrix::from_fn(7, 5, |j, l| {
            0.1 * (l + 1) as f64 * (phase + 1.3 * j as f64 + 2.1 * l as f64).sin()
        })
    };
    FourierSeries {
        fundamental_hz: 0.1,
        a: wave(0.4),
        b: wave(1.7),
        offset: vec![0.0; 7],
    }
}

/// In [-1, 1): splitmix64 of a counter, bit for bit that of the reference.
fn uniform(counter: usize) -> f64 {
    let mut z = (counter as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^= z >> 31;
    (z >> 11) as f64 * 2f64.powi(-52) - 1.0
}

/// 160,000 samples of Table 3's arm with noise.
fn log(robot: &Virtual) -> Log {
    let one = robot.clean(&trajectory(), RATE_HZ, 1);
    let rows = PERIODS * one.samples();
    let amplitude = [1.2, 1.4, 0.5, 0.6, 0.3, 0.7, 0.25];
    let noisy = |x: &[f64], column: usize, size: f64| -> Vec<f64> {
        (0..rows)
            .map(|s| x[s % x.len()] + size * uniform(column * rows + s))
            .collect()
    };
    Log {
        q: (0..7).map(|j| noisy(&one.q[j], j, 2e-5)).collect(),
        tau: (0..7).map(|j| noisy(&one.tau[j], 7 + j, amplitude[j])).collect(),
        usable: vec![true; rows],
        ..one
    }
}

#[test]
fn val_the_papers_chain_at_its_size_equals_scipy_and_pinocchio() {
    let path = format!("{}/tests/data/ref_paper_chain.json", env!("CARGO_MANIFEST_DIR"));
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let numbers = |key: &str| serde_json::from_value::<Vec<f64>>(reference[key].clone()).unwrap();
    let robot = Virtual::iiwa14();
    let log = log(&robot);
    let prepared = prepare(&log, 7, &PreprocessOptions::paper(10.0)).unwrap();
    assert_eq!(prepared.periods.as_ref().unwrap().count, PERIODS);
    let stretch = Stretch::new(&prepared, &log);
    let found = estimate(&robot.robot, std::slice::from_ref(&stretch), Estimator::Ordinary).estimate;
    assert_eq!(found.solution.rank as u64, reference["rank"].as_u64().unwrap());
    // Accelerations are second differences over a millisecond: the filters' rounding of 1e-16 becomes 1e-10 there, and the normal
    // equations multiply that by the condition number, 238, and what they round by its square, 6e4. Values are of the order of
    // one.
    let close = |mine: f64, theirs: f64, scale: f64, what: &str| {
        assert!((mine - theirs).abs() < 1e-7 * scale, "{what}: {mine} {theirs}");
    };
    for (c, (&value, &deviation)) in numbers("value").iter().zip(&numbers("std_dev")).enumerate() {
        close(found.values[c], value, value.abs().max(1.0), &robot.base.names[c]);
        close(found.textbook_std_dev[c], deviation, deviation, &robot.base.names[c]);
    }
    for (j, (&rms, &torque)) in numbers("rms").iter().zip(&numbers("torque_rms")).enumerate() {
        close(found.joints[j].rms, rms, rms, "rms");
        let mean = &stretch.torque[j];
        let size = (mean.iter().map(|t| t * t).sum::<f64>() / mean.len() as f64).sqrt();
        close(size, torque, torque, "torque");
    }
}
