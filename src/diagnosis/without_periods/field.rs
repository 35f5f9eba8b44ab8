//! All contenders beside one fitted model, and which of them have earned their place.

use super::blocks::{Blocks, Partial, residual};
use super::contender::{Contender, side_by_side};
use super::stability::{Subsamples, share_of_choices};
use super::validation::{Validated, deviation_of_sum};
use crate::diagnosis::held_out::signed_rank_test;
use crate::diagnosis::selection::{Accepted, Candidate, HeldOutGain, Scored, Threshold, hypotheses, is_plausible, is_simpler};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::AnyEffect;
use crate::regression::{Data, System, Term, chance_of};
use rayon::prelude::*;
use std::cell::LazyCell;

pub(crate) const OFFSET: &str = "torque_offset";

/// A single effect with what the blocks say of it.
struct Weighed<'a> {
    contender: Contender<'a>,
    own: Validated,
    evidence: f64,
}

/// A contender that has earned its place.
pub(crate) struct Chosen<'a> {
    pub members: Vec<&'a Scored>,
    coefficients: Vec<f64>,
    pub accepted: Vec<Accepted>,
    pub(super) held_out: Vec<f64>,
}

impl Chosen<'_> {
    /// The members as terms of a model, at the coefficients that they have beside it.
    pub fn terms(&self) -> Vec<Term> {
        let mut from = 0;
        let term = |scored: &&Scored| {
            let mut term = scored.term.clone();
            let k = term.coefficients.len();
            term.coefficients.copy_from_slice(&self.coefficients[from..from + k]);
            from += if term.is_distortion() { term.shape.len() } else { k };
            term
        };
        self.members.iter().map(term).collect()
    }
}

/// All effects beside one fitted model.
pub(crate) struct Field<'a> {
    pub(super) data: &'a Data<'a>,
    pub(super) system: &'a System,
    candidates: &'a [Candidate],
    pub(super) scored: &'a [Scored],
    threshold: &'a Threshold,
    pub(super) blocks: Blocks,
    /// Fits of the model to all blocks, and to all but each.
    pub(super) all: Partial,
    pub(super) folds: Vec<Partial>,
    subsamples: Subsamples,
}

impl<'a> Field<'a> {
    /// `None` where the data do not determine the model.
    pub fn of(
        data: &'a Data<'a>,
        system: &'a System,
        candidates: &'a [Candidate],
        scored: &'a [Scored],
        threshold: &'a Threshold,
    ) -> Option<Self> {
        let blocks = Blocks::of(data, system);
        let folds = blocks.each_left_out()?;
        Some(Self {
            all: blocks.without(&[])?,
            subsamples: Subsamples::of(&blocks)?,
            folds,
            blocks,
            data,
            system,
            candidates,
            scored,
            threshold,
        })
    }

    /// The chance of a contender, where it gains on blocks left out, beyond chance, and no joint pays for it.
    pub(super) fn passes(&self, contender: &Contender, own: &Validated, tried: f64) -> Option<f64> {
        let left: f64 = contender.joints.iter().map(|&j| self.blocks.squares[j]).sum();
        let held_out = own.held_out();
        let gains = LazyCell::new(|| contender.gains_by_joint(self.system, &self.blocks, &self.folds));
        let share = match contender.joints.len() {
            1 => own.gain / left,
            // Of many joints, some can have nothing to do with it: the one that it explains most of counts.
            _ => {
                let share = |(gains, left): (&Vec<f64>, &f64)| gains.iter().sum::<f64>() / left.max(f64::MIN_POSITIVE);
                gains.iter().zip(&self.blocks.squares).map(share).fold(0.0, f64::max)
            }
        };
        if own.rank == 0 || share < self.threshold.share || held_out < self.threshold.generalises * own.gain {
            return None;
        }
        if held_out <= 0.0 || !self.is_sure(contender, own) || self.is_of_one_joint(contender, &gains) {
            return None;
        }
        let p_value = (chance_of(self.system, &contender.columns) * tried).min(1.0);
        if p_value >= self.threshold.chance || self.a_joint_pays(&gains) {
            return None;
        }
        Some(p_value)
    }

    /// Whether a gain on blocks left out is beyond chance: by its scatter, or, where it comes from few blocks, by ranks.
    fn is_sure(&self, contender: &Contender, own: &Validated) -> bool {
        let left = |b: usize| -> f64 {
            let time = &self.blocks.times[b];
            contender
                .joints
                .iter()
                .map(|&j| residual(self.system, time, j).norm_squared())
                .sum()
        };
        let relative = own.gains.iter().enumerate().map(|(b, g)| g / left(b).max(f64::MIN_POSITIVE));
        let (ranks, p_value) = signed_rank_test(&relative.collect::<Vec<_>>());
        own.held_out() > SETTINGS.without_periods.sure * own.deviation()
            || ranks > 0.0 && 0.5 * p_value < SETTINGS.without_periods.rank_chance
    }

    /// Whether an effect of the whole arm gains beyond chance on no more than one joint: then it stands in for what that joint
    /// lacks. A late torque stream or a tilted base shows on several.
    fn is_of_one_joint(&self, contender: &Contender, gains: &[Vec<f64>]) -> bool {
        let of_the_arm = contender.members.iter().all(|s| s.candidate.joints.is_empty());
        // Joints that stand still, or whose torque takes no part, cannot show it.
        let can_show = self.blocks.squares.iter().filter(|s| **s > 0.0).count();
        let sure = |gains: &&Vec<f64>| gains.iter().sum::<f64>() > SETTINGS.without_periods.sure * deviation_of_sum(gains);
        of_the_arm && can_show > 1 && gains.iter().filter(sure).count() < 2
    }

    /// Whether some joint is predicted worse on blocks left out, beyond chance and beyond a sliver of what it leaves.
    fn a_joint_pays(&self, gains: &[Vec<f64>]) -> bool {
        let pays = |(gains, left): (&Vec<f64>, &f64)| {
            let sum: f64 = gains.iter().sum();
            let (ranks, p_value) = signed_rank_test(gains);
            sum < -SETTINGS.without_periods.least_share * left
                && ranks < 0.0
                && 0.5 * p_value < SETTINGS.held_out.beyond_chance / self.blocks.squares.len() as f64
        };
        gains.iter().zip(&self.blocks.squares).any(pays)
    }

    /// Single effects that have earned their place and that no rival replaces when some of the blocks are left out: the best, and
    /// further ones on joints that none before them reaches.
    pub fn singles(&self) -> Vec<Chosen<'a>> {
        let near = self
            .scored
            .iter()
            .filter(|s| s.evidence > 0.0)
            .take(SETTINGS.without_periods.most_contenders)
            .collect::<Vec<_>>();
        // What has no physical sense is nobody's rival either.
        let contenders: Vec<Weighed> = near.into_par_iter().filter_map(|s| self.weighed(s)).collect();
        let mut order: Vec<usize> = (0..contenders.len()).filter(|&i| contenders[i].evidence > 0.0).collect();
        order.sort_by(|&a, &b| contenders[b].evidence.total_cmp(&contenders[a].evidence));
        let mut taken: Vec<usize> = Vec::new();
        let mut found: Vec<Chosen> = Vec::new();
        for i in order {
            if contenders[i].contender.joints.iter().any(|j| taken.contains(j)) {
                continue;
            }
            let places = [self.simpler(&contenders, i), Some(i)].into_iter().flatten();
            let earned = places.map(|i| (i, self.earned(&contenders, i))).find(|(_, p)| p.is_some());
            if let Some((at, Some(p_value))) = earned {
                let Weighed { contender, own, .. } = &contenders[at];
                taken.extend(&contender.joints);
                found.push(chosen(contender.members.clone(), own, p_value));
            }
        }
        found
    }

    fn weighed(&self, scored: &'a Scored) -> Option<Weighed<'a>> {
        let contender = Contender::of(self.data, self.system, &self.blocks, vec![scored]);
        let own = contender.validated(&self.blocks, &self.folds, &self.all);
        let evidence = self.evidence(&contender, own.gain);
        let weighed = Weighed {
            contender,
            own,
            evidence,
        };
        self.is_physical(scored, &weighed.own).then_some(weighed)
    }

    fn earned(&self, contenders: &[Weighed], i: usize) -> Option<f64> {
        let Weighed { contender, own, .. } = &contenders[i];
        let effect = &contender.members[0].candidate.effect;
        let p_value = self.passes(contender, own, hypotheses(self.candidates, effect.code()) * odds(effect))?;
        let share = self.stability(contenders, i);
        (share >= SETTINGS.without_periods.stable_share).then_some(p_value)
    }

    fn stability(&self, contenders: &[Weighed], i: usize) -> f64 {
        let Weighed { contender, own, .. } = &contenders[i];
        let rivals: Vec<&Contender> = contenders
            .par_iter()
            .enumerate()
            .filter(|(o, rival)| *o != i && self.is_rival(&rival.contender, rival.own.gain, contender, own.gain))
            .map(|(_, rival)| &rival.contender)
            .collect();
        share_of_choices(&self.blocks, &self.subsamples, contender, &rivals, |c, gain| {
            self.evidence(c, gain)
        })
    }

    /// Whether a rival explains the same: beside it, the contender loses more than half of its gain.
    fn is_rival(&self, rival: &Contender, theirs: f64, contender: &Contender, own: f64) -> bool {
        if !rival.joints.iter().any(|j| contender.joints.contains(j)) {
            return false;
        }
        let columns = side_by_side(&[rival.columns.clone(), contender.columns.clone()]);
        let both = Contender::with_columns(self.system, &self.blocks, Vec::new(), columns);
        let (_, together, _) = both.beside(&self.blocks, &self.all, &[]);
        together - theirs < SETTINGS.without_periods.same_share * own
    }

    /// Signs and plausibility by what the blocks say of the coefficients.
    fn is_physical(&self, scored: &Scored, own: &Validated) -> bool {
        if scored.term.is_distortion() {
            return true;
        }
        let effect = &scored.candidate.effect;
        let k = own.coefficients.len();
        let of = |i: usize| own.coefficients[i];
        let signs = effect
            .positive(scored.candidate.form)
            .iter()
            .filter(|&&i| i < k)
            .all(|&i| of(i) > 0.0);
        signs
            && is_plausible(
                self.system,
                &scored.candidate.joints,
                effect,
                own.coefficients.as_slice(),
                &own.covariance,
            )
    }

    /// What every robot may have, or the same with fewer parameters, that gains nearly as much.
    fn simpler(&self, contenders: &[Weighed], i: usize) -> Option<usize> {
        let best = &contenders[i];
        let of = |w: &Weighed| w.contender.members[0].candidate.clone();
        (0..contenders.len())
            .filter(|&o| {
                let other = &contenders[o];
                let simpler = is_simpler(&of(other), &of(best));
                o != i
                    && other.evidence > 0.0
                    && simpler
                    && other.own.held_out() > SETTINGS.selection.simpler_share * best.own.held_out()
            })
            .max_by(|&a, &b| contenders[a].own.held_out().total_cmp(&contenders[b].own.held_out()))
    }

    /// Twice the log of the evidence ratio: `−n ln(1 − gain/left)`, n the independent values that the rows are worth, less what
    /// parameters, shapes tried and rarity cost.
    fn evidence(&self, contender: &Contender, gain: f64) -> f64 {
        let sum = |of: &[f64]| contender.joints.iter().map(|&j| of[j]).sum::<f64>();
        let rows = sum(&self.blocks.effective_rows).max(2.0);
        let share = (gain / sum(&self.blocks.squares).max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
        let tried: f64 = contender.members.iter().map(|s| 2.0 * (s.tried as f64).ln()).sum();
        let rare: f64 = contender.members.iter().map(|s| 2.0 * odds(&s.candidate.effect).ln()).sum();
        -rows * (-share).ln_1p() - contender.cost() as f64 * rows.ln() - tried - rare
    }
}

/// Odds against an effect before the data are seen.
fn odds(effect: &AnyEffect) -> f64 {
    if effect.is_rare() {
        SETTINGS.without_periods.rare_preference
    } else {
        1.0
    }
}

pub(super) fn chosen<'a>(members: Vec<&'a Scored>, own: &Validated, p_value: f64) -> Chosen<'a> {
    let share = 1.0 / members.len() as f64;
    let accepted = |s: &&Scored| Accepted {
        effect: s.candidate.effect.code().into(),
        gain: own.gain * share,
        evidence: s.evidence,
        p_value,
        held_out: HeldOutGain {
            blocks: own.held_out() * share,
            periods: None,
        },
    };
    Chosen {
        accepted: members.iter().map(accepted).collect(),
        coefficients: own.coefficients.as_slice().to_vec(),
        held_out: own.gains.clone(),
        members,
    }
}
