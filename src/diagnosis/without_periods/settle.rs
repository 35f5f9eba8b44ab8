//! The last word of the search on what it has found: what is not beyond doubt beside all the others goes.

use super::nuisance;
use crate::diagnosis::selection::{Selected, wald};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::EffectKind;
use crate::regression::{AugmentedModel, Data, SETTINGS as REGRESSION_SETTINGS, System, Term, f_tail};

/// Takes out what is not beyond doubt, the weakest first, and says what went. A spring whose stiffness is not gives its place to
/// a torque offset.
pub(crate) fn settle(data: &Data, now: &mut Selected) -> Vec<Term> {
    let mut gone = Vec::new();
    loop {
        let fixed = now.fixed;
        let weakest = (fixed..now.system.model.terms.len())
            .map(|at| (at, doubt(&now.system, at)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((at, _)) = weakest.filter(|(_, chance)| *chance >= SETTINGS.without_periods.doubtful) else {
            return gone;
        };
        if nuisance::demote(now, at) {
            now.system = data.fit(now.system.model.clone());
            continue;
        }
        let mut model = now.system.model.clone();
        match offset_in_place(&model, at) {
            Some(offset) => {
                model.terms[at] = offset;
                now.accepted[at - fixed].effect = "torque_offset".into();
            }
            None => {
                gone.push(model.terms.remove(at));
                now.accepted.remove(at - fixed);
            }
        }
        now.system = data.fit(model);
    }
}

/// Chance of values as large as those of term `at` by the jackknife; of a spring, that of its stiffness.
fn doubt(system: &System, at: usize) -> f64 {
    let term = &system.model.terms[at];
    let covariance = system.jackknife(at);
    let second = (REGRESSION_SETTINGS.jackknife_blocks - 1) as f64;
    if term.effect.code() == "joint_spring" {
        let stiffness = term.coefficients[0];
        return f_tail(
            stiffness * stiffness / covariance[(0, 0)].max(f64::MIN_POSITIVE),
            [1.0, second],
        );
    }
    let (statistic, parameters) = wald(term, &covariance);
    let k = parameters as f64;
    if term.effect.kind() != EffectKind::Distortion && statistic <= 0.0 {
        return 1.0;
    }
    f_tail(
        statistic * (second - k + 1.0).max(1.0) / (k * second),
        [k, (second - k + 1.0).max(1.0)],
    )
}

/// The torque offset that takes the place of a spring, where the joint has none.
fn offset_in_place(model: &AugmentedModel, at: usize) -> Option<Term> {
    let term = &model.terms[at];
    let joint = *term.joints.first()?;
    let has_one = |t: &Term| t.effect.code() == "torque_offset" && t.joints == term.joints;
    (term.effect.code() == "joint_spring" && !model.terms.iter().any(has_one)).then(|| Term::offset(joint))
}
