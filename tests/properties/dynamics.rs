//! The equations of motion against themselves, written in ways that share nothing.

use crate::support::{general_arm, rng, structured_arm, uniform, vectors};
use dynident::dynamics::*;
use dynident::model::Robot;
use dynident::parameters::{BaseParameters, Layout};
use nalgebra::DVector;

fn arms() -> impl Iterator<Item = (u64, Robot)> {
    (1..=10).flat_map(|joints| {
        (0..6).map(move |i| {
            let seed = 100 * joints as u64 + i;
            (
                seed,
                if i < 3 {
                    general_arm(seed, joints)
                } else {
                    structured_arm(seed, joints)
                },
            )
        })
    })
}

#[test]
fn prop_regressor_times_parameters_is_inverse_dynamics() {
    for (seed, robot) in arms() {
        let n = robot.joint_count();
        let layout = Layout::standard(&robot);
        let mut rng = rng(seed);
        let phi: Vec<f64> = (0..layout.len()).map(|_| uniform(&mut rng, 1.0)).collect();
        for _ in 0..5 {
            let [q, qd, qdd]: [Vec<f64>; 3] = vectors(&mut rng, 3, n, 2.0).try_into().unwrap();
            let y = regressor(&robot, &layout, &q, &qd, &qdd);
            let tau = inverse_dynamics(&robot, &layout, &phi, &q, &qd, &qdd);
            let product = &y * DVector::from_column_slice(&phi);
            // Rounding grows with the size of the terms that cancel: compare with the sum of their magnitudes.
            let scale = (y.abs() * DVector::from_column_slice(&phi).abs()).amax();
            for j in 0..n {
                assert!((product[j] - tau[j]).abs() < 1e-13 * scale, "seed {seed} joint {j}");
            }
        }
    }
}

#[test]
fn prop_batched_inverse_dynamics_equals_sample_by_sample() {
    let robot = structured_arm(77, 6);
    let layout = Layout::standard(&robot);
    let mut rng = rng(5);
    let phi: Vec<f64> = (0..layout.len()).map(|_| uniform(&mut rng, 1.0)).collect();
    let motion = Motion::from_fn(6, 21, |_, _| {
        [uniform(&mut rng, 2.0), uniform(&mut rng, 2.0), uniform(&mut rng, 2.0)]
    });
    let tau = inverse_dynamics_batch(&Chain::new(&robot), &layout, &phi, &motion, Coulomb::Sign);
    for s in 0..21 {
        let state: Vec<[f64; 3]> = (0..6).map(|j| motion.get(j, s)).collect();
        let part = |i: usize| state.iter().map(|x| x[i]).collect::<Vec<_>>();
        let single = inverse_dynamics(&robot, &layout, &phi, &part(0), &part(1), &part(2));
        for j in 0..6 {
            // The same operations in the same order, lane by lane.
            assert_eq!(tau[j * motion.stride() + s], single[j]);
        }
    }
}

#[test]
fn prop_power_balance_without_friction() {
    for (seed, robot) in arms() {
        let n = robot.joint_count();
        let layout = Layout::standard(&robot);
        let mut rng = rng(seed ^ 0xbeef);
        // No friction: FV and FS are the last two of every link.
        let phi: Vec<f64> = (0..layout.len())
            .map(|i| if i % 12 < 10 { uniform(&mut rng, 1.0) } else { 0.0 })
            .collect();
        let [q, qd, qdd]: [Vec<f64>; 3] = vectors(&mut rng, 3, n, 1.0).try_into().unwrap();
        let tau = inverse_dynamics(&robot, &layout, &phi, &q, &qd, &qdd);
        let power: f64 = tau.iter().zip(&qd).map(|(t, v)| t * v).sum();
        let total = |t: f64| {
            let at: Vec<f64> = (0..n).map(|j| q[j] + qd[j] * t + 0.5 * qdd[j] * t * t).collect();
            let speed: Vec<f64> = (0..n).map(|j| qd[j] + qdd[j] * t).collect();
            energy(&robot, &layout, &phi, &at, &speed).total()
        };
        // Five-point stencil: error h⁴/30 of the fifth derivative plus eps/h of rounding, both near 1e-10 of the energy's scale.
        let h = 1e-3;
        let rate = (8.0 * (total(h) - total(-h)) - (total(2.0 * h) - total(-2.0 * h))) / (12.0 * h);
        let scale = tau.iter().zip(&qd).map(|(t, v)| (t * v).abs()).sum::<f64>() + total(0.0).abs();
        assert!((power - rate).abs() < 1e-8 * scale, "seed {seed}: {power} {rate}");
    }
}

#[test]
fn prop_exact_and_numeric_base_parameters_agree() {
    for (seed, robot) in arms().chain((0..200).map(|i| (i, structured_arm(10_000 + i, 1 + i as usize % 7)))) {
        let exact = BaseParameters::exact(&robot);
        let numeric = numeric_base_parameters(&robot, seed);
        assert_eq!(
            exact.kept,
            numeric.base.kept,
            "seed {seed} {:?} {:#?}",
            robot.gravity(),
            robot.joints().iter().map(|j| (j.kind, j.mdh)).collect::<Vec<_>>()
        );
        assert!((&exact.map - &numeric.base.map).amax() < 1e-8, "seed {seed}");
        assert_eq!(exact.names, numeric.base.names, "seed {seed}");
        assert!(
            numeric.weakest_kept > 1e-4 && numeric.strongest_dropped < 1e-11,
            "seed {seed} {} {}",
            numeric.weakest_kept,
            numeric.strongest_dropped
        );
    }
}

#[test]
fn prop_base_columns_times_map_is_the_regressor() {
    for (seed, robot) in arms() {
        let n = robot.joint_count();
        let layout = Layout::standard(&robot);
        let base = BaseParameters::exact(&robot);
        let mut rng = rng(seed + 9);
        let [q, qd, qdd]: [Vec<f64>; 3] = vectors(&mut rng, 3, n, 2.0).try_into().unwrap();
        let y = regressor(&robot, &layout, &q, &qd, &qdd);
        let rebuilt = y.select_columns(&base.kept) * &base.map;
        assert!((&rebuilt - &y).amax() < 1e-12 * y.amax().max(1.0), "seed {seed}");
    }
}

/// F = Σ W ∘ Y for random weights W: its gradient by the adjoint against central differences of Y, away from sign changes.
#[test]
fn prop_adjoint_gradient_equals_differences() {
    for (seed, robot) in arms() {
        let n = robot.joint_count();
        let base = BaseParameters::exact(&robot);
        let columns = ColumnSet::new(&robot, &Layout::standard(&robot), &base.kept);
        let chain = Chain::new(&robot);
        let mut rng = rng(seed + 1234);
        let samples = 5;
        let motion = Motion::from_fn(n, samples, |_, _| {
            let away = |v: f64| v + v.signum() * 0.1;
            [uniform(&mut rng, 2.0), away(uniform(&mut rng, 2.0)), uniform(&mut rng, 2.0)]
        });
        for coulomb in [Coulomb::Sign, Coulomb::Smooth(0.1)] {
            let mut weights = RowBlocks::new(&columns, samples);
            for j in 0..n {
                weights.block_mut(j).iter_mut().for_each(|w| *w = uniform(&mut rng, 1.0));
            }
            let mut rows = RowBlocks::new(&columns, samples);
            let mut value = |m: &Motion| {
                rows.fill(&chain, &columns, m, coulomb);
                (0..n)
                    .map(|j| rows.block(j).iter().zip(weights.block(j)).map(|(y, w)| y * w).sum::<f64>())
                    .sum::<f64>()
            };
            let mut gradient = MotionGradient::new(n, samples);
            gradient.fill(&chain, &columns, &motion, coulomb, &weights);
            for j in 0..n {
                for s in 0..samples {
                    for part in 0..3 {
                        let h = 1e-5;
                        let mut at = |step: f64| {
                            let mut moved = motion.clone();
                            let mut state = motion.get(j, s);
                            state[part] += step;
                            moved.set(j, s, state);
                            value(&moved)
                        };
                        let difference = (at(h) - at(-h)) / (2.0 * h);
                        let exact = gradient.get(j, s)[part];
                        // Truncation h² = 1e-10 and rounding 1e-16/h = 1e-11 of sums of some hundred terms of order 10.
                        assert!(
                            (difference - exact).abs() < 1e-6 * (1.0 + exact.abs()),
                            "seed {seed} {j} {s} {part}: {difference} {exact}"
                        );
                    }
                }
            }
        }
    }
}
