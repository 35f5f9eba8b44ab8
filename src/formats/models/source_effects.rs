//! Effects as statements that C and Python share: both write sums, indices and calls alike.

use super::FinalModel;
use super::source::{literal, one_line};
use super::source_channels::SourceChannels;
use crate::effects::{ChannelVariable, Effect, OwnEffect, SourceNames, Statements as EffectStatements, Written};
use crate::regression::Term;

/// What an effect adds, in terms of `q, qd, qdd` (with encoder offsets in `q`), `rigid` (torques of the bodies) and `declared`
/// (with friction).
pub(super) struct Statements {
    pub comment: String,
    /// Onto `tau`.
    pub torque: Vec<String>,
    /// Onto `m`, the mass matrix; `r` is that of the bodies alone.
    pub mass: Vec<String>,
}

/// Whether source code has a place for an effect that is a function of the state at one sample.
pub(super) fn is_written(term: &Term) -> bool {
    // These are in the constants.
    let in_constants = ["base_tilt", "encoder_offset", "torque_gain", "payload"];
    let code = term.effect.code();
    in_constants.contains(&code) || term.effect.own().is_some() || written(term, term.joints.len()).is_some()
}

impl FinalModel {
    pub(super) fn statements(&self) -> Vec<Statements> {
        let channels = SourceChannels::of(self);
        let all = self.terms.iter().map(|term| {
            let (torque, mass) = statements(term, self.robot.joint_count(), &channels);
            Statements {
                comment: one_line(&format!("{} on {}", term.effect.code(), self.joint_names(term).join(", "))),
                torque,
                mass,
            }
        });
        all.filter(|s| !s.torque.is_empty()).collect()
    }
}

fn statements(term: &Term, joints: usize, channels: &SourceChannels) -> (Vec<String>, Vec<String>) {
    if let Some(defined) = term.effect.own() {
        return own_effect(term, defined, joints, channels);
    }
    let all = written(term, joints).unwrap_or_default();
    let torque = all.torque.into_iter().map(|(j, value)| format!("tau[{j}] += {value}"));
    let inertia = all.inertia.into_iter().map(|(r, c, value)| format!("m[{r}][{c}] += {value}"));
    (torque.collect(), inertia.collect())
}

/// What an effect says of itself.
fn written(term: &Term, joints: usize) -> Option<EffectStatements> {
    let literals = |values: &[f64]| values.iter().map(|v| literal(*v)).collect();
    let reported = term.effect.reported(term.form, &term.coefficients, &term.shape);
    term.effect.statements(&Written {
        form: term.form,
        joints: &term.joints,
        coefficients: literals(&term.coefficients),
        shape: literals(&term.shape),
        reported: reported.iter().map(|v| format!("({})", literal(*v))).collect(),
        count: joints,
    })
}

/// The formula with its constants as they are reported, and how it grows with the accelerations.
fn own_effect(term: &Term, own: &OwnEffect, joints: usize, channels: &SourceChannels) -> (Vec<String>, Vec<String>) {
    let reported = own.reported(term.form, &term.coefficients, &term.shape);
    let constants: Vec<String> = reported.iter().map(|v| format!("({})", literal(*v))).collect();
    let state = |joint: usize, order: usize| format!("{}[{joint}]", ["q", "qd", "qdd"][order]);
    let channel = |c: &ChannelVariable| channels.value(c);
    let names = SourceNames {
        constants: &constants,
        state: &state,
        channel: &channel,
    };
    let j = own.joint();
    let torque = vec![format!("tau[{j}] += {}", own.source(&names))];
    let entry = |k: usize| Some(format!("m[{j}][{k}] += {}", own.inertia_source(k, &names)?));
    (torque, (0..joints).filter_map(entry).collect())
}
