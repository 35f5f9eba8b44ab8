//! The conclusion of a diagnosis: the report, the model, and what is known of it.

use super::course::{Course, Decided};
use super::outcome::Diagnosis;
use super::stability::survivals;
use crate::diagnosis::alternatives::{Contest, RivalTerm, border};
use crate::diagnosis::nonparametric::unaccounted;
use crate::diagnosis::replicates::{Separated, joined, remainder_of};
use crate::diagnosis::report::{
    FindingInputs, HeldOut, HeldOutVerdict, JointFit, NotTested, Remainder, ResidualReport, Rival, Undetected, Verdict, at_rest,
    between_findings, findings, fits, nuisance, rms, undetected,
};
use crate::diagnosis::selection::{Candidate, honest_covariance};
use crate::model::Robot;
use crate::regression::{Data, NoiseModel, NoiseSource, Stretch, System, Term};
use nalgebra::DVector;

impl Course<'_> {
    /// The `residual` part of an answer.
    pub fn report(
        &self,
        decided: &Decided,
        separated: Separated,
        list: &[Candidate],
        lack_of_fit: Vec<JointFit>,
    ) -> ResidualReport {
        let Decided {
            data, system, before, ..
        } = decided;
        let remainder = self.remainder(decided, &separated);
        let held_out = self.held_out_report(decided);
        let withheld = decided.stay < decided.accepted.len();
        let doubtful = withheld || held_out.verdict == HeldOutVerdict::NotConfirmed;
        let verdict = match self.explains() {
            true => verdict(decided.stay + separated.found.len(), remainder.is_some(), doubtful),
            false => Verdict::Unexplained,
        };
        // Errors are reported without drift and contacts, which are explained; what nothing explains is left out of the fits
        // alone.
        let reported = match separated.found.is_empty() {
            true => self.measured,
            false => &separated.explained[..],
        };
        let (robot, cleaned) = (self.robot, &separated.explained);
        let mut all = between_findings(robot, separated.found, &before.model, self.measured, cleaned, self.held_out);
        all.extend(findings(&self.finding_inputs(decided), [reported, self.held_out]));
        ResidualReport {
            noise_floor: data.noise.iter().map(floor_of).collect(),
            noise_source: source(&data.noise),
            lack_of_fit,
            verdict,
            held_out,
            data_faults: Vec::new(),
            findings: all,
            remainder,
            undetected: self.not_found(decided, list),
            explains_nothing: !self.explains(),
            not_tested: not_tested(self.robot, data.stretches),
            lack_of_fit_after: fits(data, system),
            rms_before: rms(&before.model, self.measured, self.held_out),
            rms_after: rms(&system.model, reported, self.held_out),
            at_rest: at_rest(&before.model, &system.model, self.measured, self.held_out),
        }
    }

    /// What no effect explains, and what changes between the periods for no known cause.
    fn remainder(&self, decided: &Decided, separated: &Separated) -> Option<Remainder> {
        let rest = decided.remainder.clone();
        let rest = match decided.stay < decided.accepted.len() {
            true => rest.or_else(|| unaccounted(&decided.data, &decided.system)),
            false => rest,
        };
        joined(rest, remainder_of(self.robot, &separated.unsteady)).filter(|_| self.explains())
    }

    fn held_out_report(&self, decided: &Decided) -> HeldOut {
        let names: Vec<String> = self.robot.joints().iter().map(|j| j.name.clone()).collect();
        let judge = self.judge(&decided.data);
        let last = judge.errors(&decided.data, &decided.system);
        match decided.stay {
            0 => judge.nothing(&names, &last),
            _ => judge.whole(&names, &judge.errors(&decided.data, &decided.before), &last),
        }
    }

    /// What the findings are written from.
    fn finding_inputs<'d>(&'d self, decided: &'d Decided) -> FindingInputs<'d> {
        let survive = || {
            survivals(
                decided.data.stretches,
                &decided.system.model,
                decided.fixed,
                &decided.data.noise,
                &self.options.cancel,
            )
        };
        FindingInputs {
            data: &decided.data,
            estimator: self.options.estimator,
            declared: &decided.before.model,
            nuisance: &decided.system.model.terms[self.start.terms.len()..decided.fixed],
            last: &decided.system.model,
            covariances: decided.covariances.clone(),
            terms: decided.terms.clone(),
            stay: decided.stay,
            held_out: decided.tests.clone(),
            accepted: decided.accepted.clone(),
            contests: decided.contests.clone(),
            survivals: self.prior().is_none().then(survive).unwrap_or_default(),
        }
    }

    /// What the data say of the size of effects that were not found.
    fn not_found(&self, decided: &Decided, list: &[Candidate]) -> Vec<Undetected> {
        let covariance = |at: usize| match &decided.estimates {
            Some(estimates) => estimates.found.term_covariance(at),
            None => honest_covariance(&decided.system, at),
        };
        let mut all = nuisance(&decided.system.model, self.start.terms.len()..decided.fixed, covariance);
        all.extend(undetected(&decided.data, &decided.system, list));
        all
    }

    pub fn diagnosis(self, decided: Decided, report: ResidualReport) -> Diagnosis {
        let Decided {
            data,
            system,
            fixed,
            stay,
            ..
        } = decided;
        let mut rival_terms = vec![Vec::new(); fixed];
        let of = |c: &Contest| rival_terms_of(&data, &system, c);
        rival_terms.extend(decided.contests[..stay].iter().map(of));
        Diagnosis {
            report,
            rival_terms,
            rate_hz: rate(data.stretches),
            information: data.known(&system),
            model: system.model,
            explained: self.explained,
            noise: data.noise,
            estimates: decided.estimates,
        }
    }
}

/// Standard deviation of one measurement; NaN, which documents have as null, where a joint has none.
fn floor_of(noise: &NoiseModel) -> f64 {
    if noise.is_absent() { f64::NAN } else { noise.std_dev }
}

/// Joints that no log says anything of, and why.
fn not_tested(robot: &Robot, stretches: &[Stretch]) -> Vec<NotTested> {
    let of = |j: usize| {
        let reason = stretches.iter().find_map(|s| s.excluded[j]);
        NotTested {
            joint: robot.joints()[j].name.clone(),
            reason: reason.map_or_else(|| "no row of it is left".into(), |e| e.to_string()),
        }
    };
    let silent = |j: &usize| stretches.iter().all(|s| !s.has_rows(*j));
    (0..robot.joint_count()).filter(silent).map(of).collect()
}

/// Rivals as they were fitted, with what the data say of them beside the final model.
fn rival_terms_of(data: &Data, system: &System, contest: &Contest) -> Vec<RivalTerm> {
    let of = |(rival, (term, base_values)): (&Rival, &(Term, DVector<f64>))| {
        let (cross, own) = border(data, system, term);
        RivalTerm {
            term: term.clone(),
            base_values: base_values.clone(),
            evidence: rival.evidence,
            cross,
            own,
        }
    };
    contest.rivals.iter().zip(&contest.fitted).map(of).collect()
}

/// Rows of a fit per second of the motion.
fn rate(stretches: &[Stretch]) -> f64 {
    stretches.first().map_or(f64::NAN, |s| 1.0 / s.row_interval())
}

/// `doubtful`: an effect did not stay, or held-out data do not confirm what stays. Then not all is explained, whatever the fit
/// says.
fn verdict(findings: usize, something_left: bool, doubtful: bool) -> Verdict {
    match (findings, something_left || doubtful) {
        (0, false) => Verdict::NothingMissing,
        (_, false) => Verdict::Explained,
        (0, true) => Verdict::Unexplained,
        (_, true) => Verdict::PartlyExplained,
    }
}

fn source(noise: &[NoiseModel]) -> String {
    match noise.first().map(|n| n.source) {
        Some(NoiseSource::Periods) => ResidualReport::FROM_PERIODS.into(),
        _ => "the residual's own course from sample to sample: weaker, what the model lacks can pass for noise".into(),
    }
}
