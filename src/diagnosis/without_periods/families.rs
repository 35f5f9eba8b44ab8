//! What every robot may have, on all joints at once: offsets, rotor inertias, and nuisance offsets.

use super::contender::Contender;
use super::field::{Chosen, Field, OFFSET, chosen};
use super::validation::deviation_of_sum;
use crate::diagnosis::selection::{Accepted, Scored};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{Term, f_tail};
use rayon::prelude::*;

impl<'a> Field<'a> {
    /// The best set of effects that every robot may have: offsets, rotor inertias, or both, those members that the data ask for.
    /// The smallest whose held-out gain is within a standard deviation of the best.
    pub fn families(&self) -> Option<Chosen<'a>> {
        let kind = |code: &str| {
            self.scored
                .iter()
                .filter(|s| s.candidate.effect.code() == code)
                .collect::<Vec<_>>()
        };
        let everyday = crate::effects::all().iter().filter(|e| e.is_everyday());
        let kinds: Vec<Vec<&Scored>> = everyday.map(|e| kind(e.code())).filter(|k| !k.is_empty()).collect();
        let mut sets = kinds.clone();
        if kinds.len() > 1 {
            sets.push(kinds.concat());
        }
        let found: Vec<Chosen<'a>> = sets.into_par_iter().filter_map(|set| self.family(set)).collect();
        let best = found.iter().max_by(|a, b| total(a).total_cmp(&total(b)))?;
        let least = |c: &&Chosen| {
            let differences: Vec<f64> = best.held_out.iter().zip(&c.held_out).map(|(b, o)| b - o).collect();
            differences.iter().sum::<f64>() <= deviation_of_sum(&differences)
        };
        let at = (0..found.len())
            .filter(|&i| least(&&found[i]))
            .min_by_key(|&i| found[i].members.len())?;
        found.into_iter().nth(at)
    }

    /// Offsets of all joints that have none yet, as terms; none where together they do not predict blocks left out better. A
    /// spring holds the offset of its joint.
    pub fn nuisance_offsets(&self) -> Vec<Term> {
        let held = |s: &Scored| {
            let holds = |t: &Term| t.joints == s.candidate.joints && t.effect.contains().contains(&OFFSET);
            self.system.model.terms.iter().any(holds)
        };
        let is_open = |s: &&Scored| s.candidate.effect.code() == OFFSET && !held(s);
        let members: Vec<&Scored> = self.scored.iter().filter(is_open).collect();
        if members.is_empty() {
            return Vec::new();
        }
        let contender = Contender::of(self.data, self.system, &self.blocks, members);
        let own = contender.validated(&self.blocks, &self.folds, &self.all);
        match own.held_out() > 0.0 {
            true => chosen(contender.members, &own, 1.0).terms(),
            false => Vec::new(),
        }
    }

    /// What the only candidate has shown, where it would be a member of a family of as many as there are joints.
    pub fn beyond_doubt(&self) -> Option<Accepted> {
        let contender = Contender::of(self.data, self.system, &self.blocks, vec![self.scored.first()?]);
        let own = contender.validated(&self.blocks, &self.folds, &self.all);
        let chance = f_tail(
            own.coefficients[0].powi(2) / own.covariance[(0, 0)].max(f64::MIN_POSITIVE),
            [1.0, (self.folds.len() - 1) as f64],
        );
        if chance > SETTINGS.without_periods.member_chance / self.system.model.robot.joint_count() as f64 {
            return None;
        }
        let p_value = self.passes(&contender, &own, 3.0)?;
        chosen(contender.members, &own, p_value).accepted.pop()
    }

    /// Members go, the weakest first, until each is beyond chance beside the others.
    fn family(&self, mut members: Vec<&'a Scored>) -> Option<Chosen<'a>> {
        members.sort_by_key(|s| (s.candidate.effect.code(), s.candidate.joints.clone()));
        let mut first = true;
        while members.len() > 1 {
            let contender = Contender::of(self.data, self.system, &self.blocks, members.clone());
            let own = contender.validated(&self.blocks, &self.folds, &self.all);
            let chance = |i: usize| {
                let variance = own.covariance[(i, i)].max(f64::MIN_POSITIVE);
                f_tail(own.coefficients[i].powi(2) / variance, [1.0, (self.folds.len() - 1) as f64])
            };
            let wrong = |i: &usize| {
                let positive = members[*i].candidate.effect.positive(members[*i].candidate.form);
                !positive.is_empty() && own.coefficients[*i] <= 0.0
            };
            // Where a family explains nothing as a whole, its members are not asked for one by one.
            if first && own.held_out() <= 0.0 {
                return None;
            }
            first = false;
            let weakest = (0..members.len())
                .map(|i| (i, if wrong(&i) { 2.0 } else { chance(i) }))
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            if weakest.1 > SETTINGS.without_periods.member_chance / members.len() as f64 {
                members.remove(weakest.0);
                continue;
            }
            return self
                .passes(&contender, &own, 3.0)
                .map(|p_value| chosen(contender.members, &own, p_value));
        }
        None
    }
}

fn total(chosen: &Chosen) -> f64 {
    chosen.held_out.iter().sum()
}
