//! What a format does not hold, by the torque that is missing along the identification logs.

use super::source_memory::is_remembered;
use super::{FinalModel, ModelFormat};
use crate::formats::significant;
use crate::regression::{AugmentedModel, Stretch, Term};
use serde::{Deserialize, Serialize};

/// What one format does not hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// Name of the format; `patched_urdf` is a file of the user's with the bodies put in.
    pub format: String,
    /// RMS over the logs of the torque that the file does not predict, per joint [N·m or N].
    pub rms: Vec<f64>,
    /// The largest.
    pub max: Vec<f64>,
    /// The effects that the format has no place for, each left out alone.
    pub effects: Vec<MissingEffect>,
    /// What it holds in another form, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
}

/// An effect that a format has no place for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingEffect {
    /// Code of the effect.
    pub effect: String,
    /// Names of the joints that it acts on.
    pub joints: Vec<String>,
    /// As in [`Missing`].
    pub rms: Vec<f64>,
    /// Largest torque that the file leaves out, per joint of `joints` [N·m or N].
    pub max: Vec<f64>,
}

impl Missing {
    pub(crate) fn is_of(&self, joints: usize) -> bool {
        let fits = |rms: &[f64], max: &[f64]| rms.len() == joints && max.len() == joints;
        fits(&self.rms, &self.max) && self.effects.iter().all(|e| fits(&e.rms, &e.max))
    }
}

/// The name under which a user's URDF file with the bodies put in is reported.
pub(super) const PATCHED: &str = "patched_urdf";

/// RMS and largest size per joint of a difference of torques.
type Sizes = (Vec<f64>, Vec<f64>);

impl FinalModel {
    /// Measures what the formats do not hold: `model` is this model with base parameters, `logs` are those that it was identified
    /// from.
    pub fn measure(&mut self, model: &AugmentedModel, logs: &[Stretch]) {
        let whole: Vec<Torques> = logs.iter().map(|log| model.predict(log)).collect();
        let with = |terms: Vec<Term>| AugmentedModel { terms, ..model.clone() };
        let lost = |terms: Vec<Term>| sizes(&whole, &with(terms), logs);
        let formats = [
            ModelFormat::Urdf,
            ModelFormat::Mjcf,
            ModelFormat::Sdf,
            ModelFormat::C,
            ModelFormat::Python,
        ];
        let names = formats.map(|f| (f.name(), Some(f))).into_iter().chain([(PATCHED, None)]);
        let mut alone: Vec<Option<Sizes>> = vec![None; self.terms.len()];
        let mut memory: Option<Sizes> = None;
        let mut all: Vec<Missing> = Vec::new();
        for (name, format) in names {
            let held: Vec<bool> = self.terms.iter().map(|t| format.is_some_and(|f| f.holds(t))).collect();
            let kept = self.terms.iter().zip(&held).filter(|(_, h)| **h).map(|(t, _)| t.clone());
            let own = format.map_or(Vec::new(), |f| self.own_terms(f));
            let terms: Vec<Term> = kept.chain(own.iter().cloned()).collect();
            let nothing = vec![0.0; self.robot.joint_count()];
            let (rms, max) = match own.is_empty() && held.iter().all(|h| *h) {
                true => (nothing.clone(), nothing),
                false => lost(terms),
            };
            let source = matches!(format, Some(ModelFormat::C | ModelFormat::Python));
            let stateless = source.then(|| self.stateless(&mut memory, &lost)).flatten();
            let effects = (0..self.terms.len()).filter(|&t| !held[t]).map(|t| {
                let without = |skip: usize| {
                    self.terms
                        .iter()
                        .enumerate()
                        .filter(|(i, _)| *i != skip)
                        .map(|(_, t)| t.clone())
                        .collect()
                };
                let (rms, max) = alone[t].get_or_insert_with(|| lost(without(t))).clone();
                MissingEffect {
                    effect: self.terms[t].effect.code().into(),
                    joints: self.joint_names(&self.terms[t]),
                    rms,
                    max,
                }
            });
            let effects = effects.collect();
            all.push(Missing {
                format: name.into(),
                rms,
                max,
                effects,
                remarks: own_remarks(format, &own).into_iter().chain(stateless).collect(),
            });
        }
        self.missing = all;
    }

    /// What `inverse_dynamics` of source code leaves to `predict` and `step`, with its size; `known` keeps it.
    fn stateless(&self, known: &mut Option<Sizes>, lost: &dyn Fn(Vec<Term>) -> Sizes) -> Option<String> {
        let with_memory: Vec<&Term> = self.terms.iter().filter(|t| is_remembered(t)).collect();
        if with_memory.is_empty() {
            return None;
        }
        let others = || self.terms.iter().filter(|t| !is_remembered(t)).cloned().collect();
        let (rms, max) = known.get_or_insert_with(|| lost(others()));
        let names: Vec<String> = with_memory
            .iter()
            .map(|t| format!("{} on {}", t.effect.code(), place(&self.joint_names(t))))
            .collect();
        Some(format!(
            "inverse_dynamics alone leaves out {}, which predict and step hold: {}",
            names.join(", "),
            self.figures(rms, max)
        ))
    }

    pub(super) fn joint_names(&self, term: &Term) -> Vec<String> {
        term.acts_on().iter().map(|&j| self.robot.joints()[j].name.clone()).collect()
    }

    /// What the file in a format does not hold, a sentence each.
    pub fn remarks(&self, format: &str) -> Vec<String> {
        let Some(missing) = self.missing.iter().find(|m| m.format == format) else {
            return self.unmeasured(format);
        };
        let mut list: Vec<String> = missing.effects.iter().map(|e| self.remark(e)).collect();
        list.extend(missing.remarks.iter().cloned());
        if missing.max.iter().any(|v| *v > 0.0) {
            list.push(format!(
                "missing in all along the identification logs: {}",
                self.figures(&missing.rms, &missing.max)
            ));
        }
        list
    }

    /// Without logs there are no figures.
    fn unmeasured(&self, name: &str) -> Vec<String> {
        let format = ModelFormat::ALL.iter().find(|(n, _)| *n == name).map(|(_, f)| *f);
        let lost = self.terms.iter().filter(|t| !format.is_some_and(|f| f.holds(t)));
        lost.map(|t| format!("{} on {} is not in this file", t.effect.code(), place(&self.joint_names(t))))
            .collect()
    }

    fn remark(&self, effect: &MissingEffect) -> String {
        format!(
            "{} on {} is not in this file, the JSON model has it; without it: {}",
            effect.effect,
            place(&effect.joints),
            self.figures(&effect.rms, &effect.max)
        )
    }

    /// `RMS 0.3 N m on A1 (at most 1.2)` for every joint with any.
    fn figures(&self, rms: &[f64], max: &[f64]) -> String {
        let joints = self
            .robot
            .joints()
            .iter()
            .zip(rms.iter().zip(max))
            .filter(|(_, (_, max))| **max > 0.0);
        let each = |(joint, (rms, max)): (&crate::model::Joint, (&f64, &f64))| {
            let [rms, max] = [rms, max].map(|v| significant(*v, 3));
            format!("RMS {rms} {} on {} (at most {max})", joint.effort_unit(), joint.name)
        };
        let list: Vec<String> = joints.map(each).collect();
        if list.is_empty() { "nothing".into() } else { list.join(", ") }
    }
}

fn place(joints: &[String]) -> String {
    if joints.is_empty() {
        "the whole robot".into()
    } else {
        joints.join(", ")
    }
}

fn own_remarks(format: Option<ModelFormat>, own: &[Term]) -> Vec<String> {
    if format != Some(ModelFormat::Mjcf) || own.is_empty() {
        return Vec::new();
    }
    let fastest = own.iter().map(|t| t.shape[0]).fold(0.0, f64::max);
    vec![format!(
        "MuJoCo's frictionloss is a soft constraint: below {} rad/s (or m/s) Coulomb friction is proportional to the speed that the joint is about to have",
        significant(fastest, 2)
    )]
}

/// Torque of every joint over the rows of a log.
type Torques = Vec<Vec<f64>>;

fn sizes(whole: &[Torques], part: &AugmentedModel, logs: &[Stretch]) -> Sizes {
    let mut sums = vec![(0.0f64, 0.0f64, 0.0f64); part.robot.joint_count()];
    for (log, whole) in logs.iter().zip(whole) {
        for ((a, b), (squares, count, max)) in whole.iter().zip(&part.predict(log)).zip(&mut sums) {
            for difference in a.iter().zip(b).map(|(a, b)| (a - b).abs()) {
                *squares += difference * difference;
                *max = max.max(difference);
            }
            *count += a.len() as f64;
        }
    }
    let rms = sums
        .iter()
        .map(|(squares, count, _)| (squares / count.max(1.0)).sqrt())
        .collect();
    (rms, sums.iter().map(|s| s.2).collect())
}
