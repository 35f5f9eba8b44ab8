//! From a plan to sizes and pairs.

use super::between::{drifts, touches};
use super::gains::gains;
use super::pairs::{Inseparable, pairs};
use super::plan::Plan;
use super::planned::{Planned, noise, stretches};
use super::signals::signals;
use super::sizes::{Visible, sizes, with_the_others};
use crate::diagnosis::settings::SETTINGS;
use crate::regression::Data;

/// What a planned recording would reveal.
#[derive(Debug, Clone, PartialEq)]
pub struct Detectable {
    /// Chance that an effect of the size reported is found.
    pub power: f64,
    /// Every effect on every place, one entry per parameter that has a size.
    pub effects: Vec<Visible>,
    /// Effects that cannot be distinguished at that size.
    pub pairs: Vec<Inseparable>,
}

/// The sizes that a planned recording would reveal.
pub fn detectable(plan: &Plan) -> Detectable {
    let recorded = stretches(plan);
    let data = Data::new(&recorded, noise(plan, &recorded), None).for_comparison();
    let planned = Planned::new(plan, &data);
    let all = signals(&planned);
    let fits = gains(&planned, &all);
    let effects = sizes(&planned, &all, &fits);
    Detectable {
        power: SETTINGS.detectable.power,
        pairs: pairs(&planned, &all, &fits, &effects),
        effects: with_the_others(&planned, [effects, drifts(plan, &planned), touches(plan, &planned)].concat()),
    }
}
