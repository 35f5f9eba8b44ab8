//! Whether what was found survives changes of the data that should not matter.
//!
//! A cause is there in either half of a log and behind any sensible filter; what only one cut-off or one part of the data shows
//! may be their doing. The final model is fitted anew to the changed data, and every effect of it tested as the search tests it.

use crate::cancel::CancelFlag;
use crate::diagnosis::selection::{doubt, is_physical};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::{AugmentedModel, Data, NoiseModel, Stretch, System};
use rayon::prelude::*;

/// A change of the data that should not matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Perturbation {
    /// Torques rounded to six digits.
    SixDigits,
    /// Every second row left out.
    EverySecondRow,
    /// The first half of the rows, or of the periods, alone.
    FirstHalf,
    /// The second half of the rows, or of the periods, alone.
    SecondHalf,
    /// The cut-off of the row filter a quarter lower, or higher.
    LowerCutoff,
    /// The cut-off of the row filter a quarter higher.
    HigherCutoff,
}

/// What became of an effect under one change.
#[derive(Debug, Clone, PartialEq)]
pub struct Survival {
    /// The change of the data.
    pub perturbation: Perturbation,
    /// Whether the effect is still beyond doubt, physical and of the same sign.
    pub survives: bool,
}

const ALL: [Perturbation; 6] = [
    Perturbation::SixDigits,
    Perturbation::EverySecondRow,
    Perturbation::FirstHalf,
    Perturbation::SecondHalf,
    Perturbation::LowerCutoff,
    Perturbation::HigherCutoff,
];

/// Per term of `model` from number `first` on, what became of it under every change that these data allow.
pub(crate) fn survivals(
    stretches: &[Stretch],
    model: &AugmentedModel,
    first: usize,
    noise: &[NoiseModel],
    cancel: &CancelFlag,
) -> Vec<Vec<Survival>> {
    let terms = first..model.terms.len();
    if terms.is_empty() {
        return Vec::new();
    }
    let under = |&perturbation: &Perturbation| {
        cancel.leave_if_set();
        let changed: Vec<Stretch> = stretches.iter().map(|s| perturbation.of(s)).collect::<Option<_>>()?;
        // Rows further apart, or behind another filter, have noise of another course, where it is measured.
        let measured: Option<Vec<NoiseModel>> = (0..noise.len()).map(|j| NoiseModel::from_periods(&changed, j)).collect();
        let noise = measured.unwrap_or_else(|| noise.to_vec());
        let data = Data::new(&changed, noise, None).for_comparison().until(cancel);
        let system = data.fit(model.clone());
        let each = terms.clone().map(|at| is_still_there(&system, model, at));
        Some((perturbation, each.collect::<Vec<bool>>()))
    };
    let found: Vec<_> = ALL.par_iter().with_max_len(1).filter_map(under).collect();
    let of = |i: usize| {
        let one = |(perturbation, survive): &(Perturbation, Vec<bool>)| Survival {
            perturbation: *perturbation,
            survives: survive[i],
        };
        found.iter().map(one).collect()
    };
    (0..terms.len()).map(of).collect()
}

fn is_still_there(system: &System, model: &AugmentedModel, at: usize) -> bool {
    let values = |m: &AugmentedModel| -> Vec<f64> {
        let term = &m.terms[at];
        match term.is_distortion() {
            true => term.shape[..term.free_shapes].to_vec(),
            false => term.coefficients.clone(),
        }
    };
    let alike: f64 = values(&system.model).iter().zip(values(model)).map(|(a, b)| a * b).sum();
    alike > 0.0 && is_physical(system, at) && doubt(system, at) < SETTINGS.stability.doubtful
}

impl Perturbation {
    /// The stretch after the change, in its coarse form; `None` where the change has no meaning for it.
    fn of(self, stretch: &Stretch) -> Option<Stretch> {
        let coarse = || stretch.as_coarse();
        match self {
            Self::SixDigits => Some(coarse().with_torques(six_digits)),
            Self::EverySecondRow => Some(coarse().every_second_row()),
            Self::FirstHalf => coarse().half(0),
            Self::SecondHalf => coarse().half(1),
            Self::LowerCutoff => stretch
                .with_cutoff(1.0 - SETTINGS.stability.cutoff_step)
                .map(|s| s.as_coarse()),
            Self::HigherCutoff => stretch
                .with_cutoff(1.0 + SETTINGS.stability.cutoff_step)
                .map(|s| s.as_coarse()),
        }
    }
}

fn six_digits(v: f64) -> f64 {
    format!("{v:.5e}").parse().unwrap_or(v)
}
