use super::generalisation::generalises_from;
use super::plan::Plan;
use super::planned::{Planned, noise, stretches};
use super::power::{noncentrality, power, quantile};
use super::signals::signals;
use crate::diagnosis::selection::{columns_of, held_out_gain};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::motion_error::tests::two_links;
use crate::regression::{AugmentedModel, Data, SETTINGS as REGRESSION};
use crate::trajectory::FourierSeries;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};

/// The noncentral χ² of SciPy 1.x (`ncx2.sf`) and of textbooks.
#[test]
fn val_powers_and_quantiles_are_those_of_tables() {
    // One degree of freedom: the two tails of a normal deviate of mean √λ.
    let normal = |x: f64| 0.5 * statrs::function::erf::erfc(x / 2f64.sqrt());
    for (threshold, lambda) in [(3.84f64, 7.85f64), (20.0, 33.0), (30.0, 0.5), (25.0, 1600.0)] {
        let (t, m) = (threshold.sqrt(), lambda.sqrt());
        let wanted = normal(t - m) + normal(t + m);
        assert!((power(threshold, 1, lambda) - wanted).abs() < 1e-10, "{threshold} {lambda}");
    }
    for (threshold, freedom, lambda, wanted) in [(30.0, 3, 45.0, 0.9187123475625145), (60.0, 7, 20.0, 0.0028097784323100933)] {
        assert!(
            (power(threshold, freedom, lambda) - wanted).abs() < 1e-10,
            "{threshold} {freedom} {lambda}"
        );
    }
    // Power 0.9 of a test at 5 %: the noncentralities of every textbook (Cohen 1988, table 12.3.2).
    for (freedom, wanted) in [(1, 10.507), (2, 12.654), (3, 14.171), (10, 20.532)] {
        let found = noncentrality(quantile(0.05, freedom), freedom, 0.9);
        assert!((found - wanted).abs() < 2e-3, "{freedom}: {found}");
    }
}

/// Gains on folds left out and of fits, of drawn noise with an effect of the size given: nine in ten draws are as the search
/// asks.
#[test]
fn prop_an_effect_of_the_size_that_generalises_does_so_in_nine_of_ten_draws() {
    const DRAWS: u64 = 300;
    let declared = AugmentedModel::declared(&two_links());
    let model = AugmentedModel {
        values: DVector::from_element(declared.values.len(), 1.0),
        ..declared
    };
    let coefficients = |list: [f64; 6]| DMatrix::from_row_slice(2, 3, &list);
    let series = FourierSeries {
        a: coefficients([0.6, -0.3, 0.4, 0.2, 0.5, -0.4]),
        b: coefficients([-0.2, 0.5, 0.1, 0.4, -0.3, 0.3]),
        ..FourierSeries::at_rest(vec![0.0; 2], 3, 0.1)
    };
    let plan = Plan {
        model: &model,
        series: &[&series],
        rate_hz: 20.0,
        periods: 4.0,
        torque_noise: &[0.1; 2],
        own: &[],
        chance: 1e-3,
    };
    let recorded = stretches(&plan);
    let data = Data::new(&recorded, noise(&plan, &recorded), None).for_comparison();
    let planned = Planned::new(&plan, &data);
    let mut tested = 0;
    for signal in signals(&planned) {
        let candidate = &planned.candidates[signal.candidate];
        let size = generalises_from(&planned, candidate, &signal.shape, &signal);
        let absorbed = signal.left < REGRESSION.hidden_share * signal.own;
        if absorbed || !size.is_finite() || size == 0.0 {
            continue;
        }
        tested += 1;
        let columns = columns_of(planned.data, &planned.system, candidate, std::slice::from_ref(&signal.shape));
        let hits = (0..DRAWS).filter(|&draw| {
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(draw);
            let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
            let mut system = data.linearise(model.clone());
            let mut pull = DVector::zeros(system.covariance.nrows());
            for (blocks, rows) in system.blocks.iter_mut().zip(&signal.rows) {
                for (joint, block) in blocks.iter_mut().enumerate() {
                    block.residual.iter_mut().for_each(|r| *r = normal());
                    if let Some((_, values)) = rows.iter().find(|r| r.0 == joint) {
                        block.residual += values * size;
                    }
                    pull += block.jacobian.tr_mul(&block.residual);
                }
            }
            // What a fit of the declared model leaves.
            let step = &system.covariance * pull;
            for block in system.blocks.iter_mut().flatten() {
                block.residual -= &block.jacobian * &step;
            }
            held_out_gain(&data, &system, &columns).blocks
                > SETTINGS.selection.least_generalisation * system.reduced(&columns).gain
        });
        let hits = hits.count();
        // Four standard errors are 0.07; the normal law of a sum of squares that is not large leaves as much again.
        assert!(
            (0.8..0.98).contains(&(hits as f64 / DRAWS as f64)),
            "{} {:?} {size}: {hits} of {DRAWS}",
            candidate.effect.code(),
            candidate.joints
        );
    }
    assert!(tested > 10, "{tested}");
}
