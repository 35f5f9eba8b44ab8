//! Rivals of the findings, by the linear model: what would explain nearly as much in the place of each.

use super::contender::side_by_side;
use crate::diagnosis::alternatives::Contest;
use crate::diagnosis::report::{Rival, joint_names};
use crate::diagnosis::selection::{Candidate, Scored, Selected, appraise, columns_of, reach, scan_on_grid};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Data, System, Term};
use nalgebra::DVector;
use rayon::prelude::*;

/// The other effects that the data do not exclude in the place of each found beyond the first `fixed` terms.
pub(crate) fn linear_contests(data: &Data, selected: &Selected, fixed: usize, candidates: &[Candidate]) -> Vec<Contest> {
    (0..selected.accepted.len())
        .into_par_iter()
        .map(|i| contest(data, &selected.system, fixed + i, candidates))
        .collect()
}

fn contest(data: &Data, system: &System, at: usize, candidates: &[Candidate]) -> Contest {
    let own = &system.model.terms[at];
    let Some(mine) = candidates.iter().find(|c| c.is_same_effect(own) && c.form == own.form) else {
        return Contest::default();
    };
    let without = system.without_term(data, at);
    let loss = data.gain(&without, system);
    let cost = own.parameters() - mine.free_shapes().min(own.parameters());
    let finding = appraise(&without, mine, own.clone(), loss, cost, mine.grid().len(), Some(system));
    let joints = without.model.robot.joint_count();
    let reached = reach(mine, joints);
    let meets = |c: &&Candidate| !c.is_same_effect(own) && reach(c, joints).iter().any(|j| reached.contains(j));
    let others: Vec<Candidate> = candidates.iter().filter(meets).cloned().collect();
    let columns = columns_of(data, &without, mine, &[shape_of(own)]);
    let alone = without.reduced(&columns).gain;
    let explains_the_same = |s: &Scored| {
        let theirs = columns_of(data, &without, &s.candidate, &[shape_of(&s.term)]);
        let together = without.reduced(&side_by_side(&[theirs, columns.clone()])).gain;
        together - s.gain < SETTINGS.without_periods.same_share * alone
    };
    let mut near: Vec<(f64, Scored)> = scan_on_grid(data, &without, &others)
        .into_iter()
        .map(|s| (finding.evidence - s.evidence, s))
        .filter(|(evidence, s)| *evidence < SETTINGS.alternatives.not_excluded && explains_the_same(s))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut contest = Contest::default();
    for (evidence, scored) in near {
        let names = joint_names(&without.model.robot, &scored.candidate.joints);
        let effect = scored.candidate.effect.code();
        let known = contest.rivals.iter().any(|r| r.effect == effect && r.joints == names);
        if known || contest.rivals.len() == SETTINGS.without_periods.most_rivals {
            continue;
        }
        contest.rivals.push(Rival {
            effect: effect.into(),
            joints: names,
            evidence,
            formula: None,
        });
        contest.fitted.push(beside(data, &without, &scored));
    }
    contest
}

/// A rival's term, and the base parameters beside it, by the linear model.
fn beside(data: &Data, without: &System, scored: &Scored) -> (Term, DVector<f64>) {
    let shape = shape_of(&scored.term);
    let columns = columns_of(data, without, &scored.candidate, std::slice::from_ref(&shape));
    let reduced = without.reduced(&columns);
    let step = &without.covariance * (without.cross(&columns) * &reduced.coefficients);
    let values = &without.model.values - step.rows(0, without.model.values.len());
    (scored.candidate.term(reduced.coefficients.as_slice(), &shape), values)
}

/// What the columns of a term are made at; those of a distortion at zero.
fn shape_of(term: &Term) -> Vec<f64> {
    match term.is_distortion() {
        true => Vec::new(),
        false => term.shape.clone(),
    }
}
