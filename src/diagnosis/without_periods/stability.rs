//! Which effect is chosen when some of the blocks are left out (Meinshausen & Bühlmann, Stability selection, 2010).

use super::blocks::{Blocks, Partial};
use super::contender::Contender;
use crate::diagnosis::settings::SETTINGS;
use rand::SeedableRng;
use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Fits of a model to some of the blocks.
pub(crate) struct Subsamples(Vec<(Vec<usize>, Partial)>);

impl Subsamples {
    /// The same for the same number of blocks.
    pub fn of(blocks: &Blocks) -> Option<Self> {
        let count = blocks.times.len();
        let gone = ((SETTINGS.without_periods.left_out_share * count as f64).round() as usize).clamp(1, count);
        let mut rng = ChaCha8Rng::seed_from_u64(count as u64);
        let drawn: Vec<Vec<usize>> = (0..SETTINGS.without_periods.subsamples)
            .map(|_| index::sample(&mut rng, count, gone).into_vec())
            .collect();
        let fitted = |left_out: Vec<usize>| blocks.without(&left_out).map(|partial| (left_out, partial));
        drawn.into_par_iter().map(fitted).collect::<Option<Vec<_>>>().map(Self)
    }
}

/// Laws that only differ in their curve count as one: which of them is best changes with every block, and the torque they predict
/// hardly does.
fn class(code: &str) -> &str {
    match code {
        "stribeck_friction" | "nonlinear_viscous_friction" => "viscous",
        "presliding_hysteresis" | "smooth_coulomb_friction" => "low speed",
        other => other,
    }
}

/// Share of the subsamples in which `contender`, or another law of its class on the same joints, has the best evidence among
/// `rivals`, which explain the same.
pub(crate) fn share_of_choices(
    blocks: &Blocks,
    subsamples: &Subsamples,
    contender: &Contender,
    rivals: &[&Contender],
    evidence: impl Fn(&Contender, f64) -> f64 + Sync,
) -> f64 {
    let of = |c: &Contender| {
        let candidate = &c.members[0].candidate;
        (class(candidate.effect.code()).to_string(), candidate.joints.clone())
    };
    let own = of(contender);
    let chosen = |(left_out, partial): &&(Vec<usize>, Partial)| {
        let score = |c: &Contender| evidence(c, c.beside(blocks, partial, left_out).1);
        let here = score(contender);
        here > 0.0 && rivals.iter().all(|r| of(r) == own || score(r) <= here)
    };
    subsamples.0.par_iter().filter(chosen).count() as f64 / subsamples.0.len() as f64
}
