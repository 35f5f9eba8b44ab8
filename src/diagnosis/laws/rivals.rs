//! The rivals of laws that were found.

use super::contest::{Contender, accepted, contains, contenders};
use super::library::{is_of, library};
use crate::diagnosis::alternatives::Contest;
use crate::diagnosis::report::{Rival, joint_names};
use crate::diagnosis::selection::{Candidate, Scored, Selected, Threshold, appraise, reach};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::law::is_law;
use crate::regression::{Data, System, spans};

/// The rivals of every law of `selected`, by its number among the effects.
pub(crate) fn law_contests(
    data: &Data,
    selected: &Selected,
    known: &[Candidate],
    threshold: &Threshold,
) -> Vec<(usize, Contest)> {
    let terms = &selected.system.model.terms;
    let laws = (selected.fixed..terms.len()).filter(|&at| is_law(&terms[at].effect));
    laws.map(|at| (at - selected.fixed, law_contest(data, selected, at, known, threshold)))
        .collect()
}

fn law_contest(data: &Data, selected: &Selected, at: usize, known: &[Candidate], threshold: &Threshold) -> Contest {
    let mut model = selected.system.model.clone();
    let own = model.terms.remove(at);
    let without = data.fit(model);
    let rows = own.acts_on();
    let library = library(&without.model.robot, data, &spans(data.stretches), &rows);
    let Some(mine) = library.iter().find(|h| is_of(&h.candidate, &own)) else {
        return Contest::default();
    };
    let gain = data.gain(&without, &selected.system);
    let cost = own.parameters() - mine.candidate.free_shapes();
    let finding = appraise(
        &without,
        &mine.candidate,
        own.clone(),
        gain,
        cost,
        mine.tried,
        Some(&selected.system),
    );
    let mut contest = Contest::default();
    for rival in contenders(data, &without, &library, known, &rows) {
        let scored = &rival.fit.scored;
        let itself = is_of(&scored.candidate, &own);
        if itself || contains(&scored.candidate, &mine.candidate) || contest.rivals.len() >= SETTINGS.laws.most_rivals {
            continue;
        }
        let evidence = against(&finding, &rival);
        if evidence < SETTINGS.alternatives.not_excluded && accepted(data, &without, &rival, known, threshold).is_some() {
            contest.rivals.push(as_rival(&without, scored, evidence));
            let model = &rival.fit.system.model;
            let term = model.terms.last().expect("the rival was added");
            contest.fitted.push((term.clone(), model.values.clone()));
        }
    }
    contest
}

/// Difference of the Bayesian information criterion in favour of the finding.
fn against(finding: &Scored, rival: &Contender) -> f64 {
    let (_, own) = finding.held_against(std::iter::once(&rival.fit.scored));
    let (_, other) = rival.fit.scored.held_against(std::iter::once(finding));
    own - other
}

fn as_rival(system: &System, scored: &Scored, evidence: f64) -> Rival {
    let robot = &system.model.robot;
    let Candidate {
        effect, form, joints, ..
    } = &scored.candidate;
    let named = match is_law(&scored.candidate.effect) {
        true => reach(&scored.candidate, robot.joint_count()),
        false => joints.clone(),
    };
    Rival {
        effect: effect.code().into(),
        joints: joint_names(robot, &named),
        evidence,
        formula: effect.formula(*form, joints),
    }
}
