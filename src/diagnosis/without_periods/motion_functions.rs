//! Smooth functions of one or two positions, speeds or loads that explain what a joint leaves.
//!
//! A residual that keeps its sign for long gives every smooth column a gain. So a function counts where it gains far more than of
//! noise that keeps its sign for as long as what is left beside the function, and no shorter than noise that is white up to the
//! frequencies that the rows are made of.

use super::blocks::{Blocks, Partial};
use super::contender::Contender;
use super::validation::Pursued;
use crate::diagnosis::held_out::signed_rank_test;
use crate::diagnosis::nonparametric::{function_columns, function_jobs};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::products;
use crate::regression::{Data, Stretch, System, Whitened};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::cmp::Reverse;

/// What follows the motion on a joint.
pub(super) struct Following {
    pub joint: usize,
    /// The function with the best evidence.
    pub function: Whitened,
    /// Share of the squares of what is left that it explains, less what it would explain of noise.
    pub explained: f64,
    /// `None` where what functions predict may be chance.
    pub predicted: Option<Predicted>,
}

impl Following {
    /// Whether effects may be stand-ins of the function: it predicts, or it explains next to all that is left.
    ///
    /// A law that acts in few places leaves most blocks of time alone, and no test of ranks can be sure of it. What next to
    /// nothing is left of was explained by the right function all the same.
    pub fn takes_the_place_of_effects(&self) -> bool {
        self.predicted.is_some() || self.explained > 1.0 - SETTINGS.nonparametric.share_beside
    }
}

/// What functions predict of blocks of time that they were neither chosen nor fitted on.
pub(super) struct Predicted {
    /// Share of the squares.
    pub share: f64,
    /// Variables of most of the functions, the most often chosen first.
    pub variables: Vec<usize>,
}

/// What follows the motion on all joints.
pub(super) fn following(data: &Data, system: &System) -> Vec<Following> {
    let in_band = data.stretches.iter().map(persistence_in_band).fold(1.0, f64::max);
    let slow = |&j: &usize| system.persistence(&[j]) > SETTINGS.without_periods.slow * in_band;
    let joints: Vec<usize> = (0..data.noise.len()).filter(slow).collect();
    if joints.is_empty() {
        return Vec::new();
    }
    let blocks = Blocks::of(data, system);
    let (Some(all), Some(each)) = (blocks.without(&[]), blocks.each_left_out()) else {
        return Vec::new();
    };
    let on = |j: usize| Functions::of(data, system, &blocks, &all, j, in_band).following(&all, &each);
    joints.into_iter().filter_map(on).collect()
}

/// Rows over which noise keeps its sign that is white up to the frequency that the rows are made of: their rate over twice that.
fn persistence_in_band(stretch: &Stretch) -> f64 {
    let band_hz = stretch.source.as_ref().and_then(|s| s.band_hz());
    band_hz.map_or(1.0, |band_hz| 1.0 / (2.0 * band_hz * stretch.row_interval()))
}

/// A function of some variables on the row of a joint, with all its products.
struct Function {
    variables: Vec<usize>,
    contender: Contender<'static>,
    /// What noise makes of a gain, and what a product must gain.
    doubt: f64,
    price: f64,
}

/// All functions on the row of a joint, the best first.
struct Functions<'a> {
    blocks: &'a Blocks,
    joint: usize,
    joints: usize,
    list: Vec<Function>,
    /// Evidence that the best of them must have.
    least: f64,
}

impl<'a> Functions<'a> {
    fn of(data: &Data, system: &System, blocks: &'a Blocks, all: &Partial, joint: usize, in_band: f64) -> Self {
        let joints = system.model.robot.joint_count();
        let mut jobs = function_jobs(joints, &[joint]);
        // Functions on the rows of two joints are not looked for.
        jobs.retain(|job| job.len() <= 3);
        let least = 2.0 * (jobs.len() as f64).ln() + SETTINGS.nonparametric.preference;
        let rows = system.rows(joint) as f64;
        let made = |job: Vec<usize>| {
            let variables = job[1..].to_vec();
            let (_, columns) = function_columns(data, system, &job)?;
            let contender = Contender::with_columns(system, blocks, Vec::new(), columns);
            let price = rows.ln() + 2.0 * (products(&variables, joints) as f64).ln();
            // What the function explains is no noise.
            let beside = contender.pursued(blocks, all, &[], price).beside;
            let doubt = contender.persistence(system, blocks, joint, &beside).max(in_band);
            Some(Function {
                variables,
                price: doubt * price,
                contender,
                doubt,
            })
        };
        let mut found = Self {
            list: jobs.into_par_iter().filter_map(made).collect(),
            blocks,
            joint,
            joints,
            least,
        };
        let evidence: Vec<f64> = found.list.par_iter().map(|f| found.pursued(f, all, &[]).0).collect();
        let mut order: Vec<(f64, Function)> = evidence.into_iter().zip(std::mem::take(&mut found.list)).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.list = order.into_iter().map(|f| f.1).collect();
        found
    }

    /// A function fitted to all blocks but these, and its evidence.
    fn pursued(&self, function: &Function, partial: &Partial, left_out: &[usize]) -> (f64, Pursued) {
        let pursued = function.contender.pursued(self.blocks, partial, left_out, function.price);
        (pursued.evidence / function.doubt, pursued)
    }

    /// The best of the first `count` functions by all blocks but these, if it is beyond chance.
    fn best(&self, count: usize, partial: &Partial, left_out: &[usize]) -> Option<(&Function, Pursued)> {
        let fitted = self
            .list
            .par_iter()
            .take(count)
            .map(|f| (f, self.pursued(f, partial, left_out)));
        let (function, (evidence, pursued)) = fitted.max_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        (evidence > self.least).then_some((function, pursued))
    }

    fn following(&self, all: &Partial, each: &[Partial]) -> Option<Following> {
        let (function, pursued) = self.best(1, all, &[])?;
        let by_noise = function.doubt * pursued.chosen.len() as f64;
        let explained = (pursued.gain - by_noise) / self.blocks.squares[self.joint];
        (explained > SETTINGS.without_periods.remainder_share).then(|| Following {
            joint: self.joint,
            function: columns_at(&function.contender.columns, &pursued.chosen),
            explained,
            predicted: self.predicted(each),
        })
    }

    /// What functions predict of every block that are chosen and fitted on the others.
    fn predicted(&self, each: &[Partial]) -> Option<Predicted> {
        let mut gains = vec![0.0; each.len()];
        let mut chosen: Vec<usize> = Vec::new();
        for (b, partial) in each.iter().enumerate() {
            if let Some((function, pursued)) = self.best(SETTINGS.without_periods.remainder_functions, partial, &[b]) {
                gains[b] = function.contender.gain_on(self.blocks, partial, b, &pursued.beside);
                chosen.extend(&function.variables);
            }
        }
        let times = |v: &usize| chosen.iter().filter(|c| *c == v).count();
        let mut variables: Vec<usize> = chosen.iter().copied().filter(|v| 2 * times(v) > each.len()).collect();
        variables.sort_by_key(|v| (Reverse(times(v)), *v));
        variables.dedup();
        let share = gains.iter().sum::<f64>() / self.blocks.squares[self.joint];
        let (ranks, p_value) = signed_rank_test(&gains);
        let sure = ranks > 0.0 && 0.5 * p_value < SETTINGS.without_periods.remainder_chance / self.joints as f64;
        let named = sure && share > SETTINGS.without_periods.remainder_share && !variables.is_empty();
        named.then_some(Predicted { share, variables })
    }
}

/// Some of the columns.
fn columns_at(columns: &Whitened, which: &[usize]) -> Whitened {
    let stretch = |joints: &Vec<(usize, DMatrix<f64>)>| joints.iter().map(|(j, m)| (*j, m.select_columns(which))).collect();
    columns.iter().map(stretch).collect()
}
