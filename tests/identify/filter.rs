//! Filters against SciPy (tests/data/README.md).

use dynident::preparation::filter::{LowPass, Padding, zero_phase, zero_phase_all};
use serde_json::Value;
use std::f64::consts::PI;

fn signal(samples: usize, rate_hz: f64) -> Vec<f64> {
    let value = |t: f64| {
        let square = (2.0 * PI * 0.45 * t + 0.1).sin().signum();
        (2.0 * PI * 0.3 * t).sin() + 0.5 * (2.0 * PI * 1.7 * t + 0.4).sin() + 0.2 * square + 0.1 * (37.0 * t * t).sin() + 0.3
    };
    (0..samples).map(|i| value(i as f64 / rate_hz)).collect()
}

#[test]
fn val_zero_phase_butterworth_equals_scipy() {
    let path = format!("{}/tests/data/ref_filter.json", env!("CARGO_MANIFEST_DIR"));
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in reference["cases"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let (order, step) = (number("order") as usize, number("step") as usize);
        let filter = LowPass::butterworth(order, number("cutoff_hz"), number("rate_hz")).unwrap();
        let x = signal(number("samples") as usize, number("rate_hz"));
        for (pad, key) in [("pad", "filtered"), ("long_pad", "filtered_long_pad")] {
            let mine = zero_phase(&filter, &x, Padding::Odd, number(pad) as usize);
            let theirs: Vec<f64> = case[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
            let worst = mine
                .iter()
                .step_by(step)
                .zip(&theirs)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-9, "order {order}, {key}: {worst:e}");
        }
    }
}

/// Records side by side are filtered as each alone, whatever their number and the number of sections.
#[test]
fn prop_records_side_by_side_are_filtered_as_each_alone() {
    for (order, count) in [(1, 1), (2, 3), (5, 8), (8, 9), (12, 23)] {
        let filter = LowPass::butterworth(order, 3.0, 100.0).unwrap();
        let records: Vec<Vec<f64>> = (0..count).map(|k| signal(400, 100.0 + k as f64)).collect();
        let borrowed: Vec<&[f64]> = records.iter().map(Vec::as_slice).collect();
        for padding in [Padding::Odd, Padding::Periodic] {
            let alone: Vec<Vec<f64>> = borrowed.iter().map(|x| zero_phase(&filter, x, padding, 70)).collect();
            assert_eq!(
                zero_phase_all(&filter, &borrowed, padding, 70),
                alone,
                "order {order}, {count} records"
            );
        }
    }
    let filter = LowPass::butterworth(4, 3.0, 100.0).unwrap();
    assert_eq!(zero_phase_all(&filter, &[&[1.0], &[2.0]], Padding::Odd, 5), [[1.0], [2.0]]);
    assert!(zero_phase_all(&filter, &[], Padding::Odd, 5).is_empty());
}

#[test]
fn prop_a_constant_and_a_slow_sine_pass_unchanged_and_a_fast_one_is_gone() {
    let filter = LowPass::butterworth(8, 5.0, 200.0).unwrap();
    let pass = |hz: f64, padding| {
        // Four seconds hold whole cycles of both frequencies: periodic padding continues them exactly.
        let x: Vec<f64> = (0..800).map(|i| 2.0 + (2.0 * PI * hz * i as f64 / 200.0).sin()).collect();
        (zero_phase(&filter, &x, padding, 2 * filter.settling_samples()), x)
    };
    let (y, x) = pass(1.0, Padding::Periodic);
    // |H|² at 1 Hz differs from 1 by (1/5)^16, and what the padding leaves is a millionth.
    assert!(y.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-5));
    let (y, _) = pass(25.0, Padding::Periodic);
    assert!(y.iter().all(|v| (v - 2.0).abs() < 1e-5));
}

#[test]
fn prop_a_cutoff_beyond_half_the_rate_or_an_order_of_zero_is_refused() {
    let half = LowPass::butterworth(4, 50.0, 100.0).unwrap_err().to_string();
    assert!(half.contains("half the sample rate, 50 Hz"), "{half}");
    assert!(LowPass::butterworth(0, 5.0, 100.0).is_err());
    assert!(LowPass::butterworth(4, f64::NAN, 100.0).is_err());
}
