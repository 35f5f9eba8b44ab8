//! Effects as statements that C and Python share: both write sums, indices and calls alike.

use super::FinalModel;
use super::effects_held::coupling_ratio;
use super::source::{literal, one_line};
use super::source_channels::SourceChannels;
use crate::effects::law::{Form, statements as statements_of_law};
use crate::effects::{ChannelVariable, Effect, OwnEffect, SourceNames};
use crate::regression::Term;

/// What an effect adds, in terms of `q, qd, qdd` (with encoder offsets in `q`), `rigid` (torques of the bodies) and `declared` (with friction).
pub(super) struct Statements {
    pub comment: String,
    /// Onto `tau`.
    pub torque: Vec<String>,
    /// Onto `m`, the mass matrix; `r` is that of the bodies alone.
    pub mass: Vec<String>,
}

/// Whether the effect is a function of the state, and written; gains, tilts, offsets of encoders and payloads are in the constants.
pub(super) fn is_written(code: &str) -> bool {
    let of_other_samples = [
        "presliding_hysteresis",
        "joint_elasticity",
        "torque_delay",
        "external_contact",
    ];
    !of_other_samples.contains(&code)
}

impl FinalModel {
    pub(super) fn statements(&self) -> Vec<Statements> {
        let channels = SourceChannels::of(self);
        let written = self.terms.iter().filter(|t| is_written(t.effect.code()));
        let all = written.map(|term| {
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
    let j = term.joints.first().copied().unwrap_or(0);
    let c: Vec<String> = term.coefficients.iter().map(|v| literal(*v)).collect();
    let s: Vec<String> = term.shape.iter().map(|v| literal(*v)).collect();
    let (q, v, a) = (format!("q[{j}]"), format!("qd[{j}]"), format!("qdd[{j}]"));
    let own = |value: String| (vec![format!("tau[{j}] += {value}")], Vec::new());
    if let Some(defined) = term.effect.own() {
        return own_effect(term, defined, joints, channels);
    }
    match term.effect.code() {
        "torque_offset" => own(c[0].clone()),
        "joint_spring" => own(format!("{} * {q} + {}", c[0], c[1])),
        "rotor_inertia" => (own(format!("{} * {a}", c[0])).0, vec![format!("m[{j}][{j}] += {}", c[0])]),
        "asymmetric_viscous_friction" => own(format!("{} * fabs({v})", c[0])),
        "nonlinear_viscous_friction" => {
            let exponent = ["2.0", "3.0", "0.5"]
                .get(term.form)
                .map_or_else(|| s[0].clone(), ToString::to_string);
            own(format!("{} * pow(fabs({v}), {exponent}) * sign({v})", c[0]))
        }
        "stribeck_friction" => {
            let exponent = ["2.0", "1.0"]
                .get(term.form)
                .map_or_else(|| s[1].clone(), ToString::to_string);
            own(format!("{} * exp(-pow(fabs({v}) / {}, {exponent})) * sign({v})", c[0], s[0]))
        }
        "load_dependent_friction" => own(format!("{} * fabs(rigid[{j}]) * sign({v})", c[0])),
        "smooth_coulomb_friction" => {
            let smooth = match term.form {
                0 => format!("tanh({v} / {})", s[0]),
                1 => format!("clamp({v} / {})", s[0]),
                _ => format!("clamp(({v} + {} * {a}) / {})", s[1], s[0]),
            };
            own(format!("{} * ({smooth} - sign({v}))", c[0]))
        }
        "position_ripple" => own(format!("{} * sin({n} * {q}) + {} * cos({n} * {q})", c[0], c[1], n = s[0])),
        "friction_drift" => own(format!("{} * {v} + {} * sign({v})", c[0], c[1])),
        "torque_crosstalk" => {
            let i = term.joints[1];
            let mass = (0..joints).map(|k| format!("m[{j}][{k}] += {} * r[{i}][{k}]", c[0]));
            (own(format!("{} * declared[{i}]", c[0])).0, mass.collect())
        }
        "transmission_coupling" => coupling(term, &c),
        "law" => law(term),
        _ => (Vec::new(), Vec::new()),
    }
}

/// The formula with its constants as they are reported.
fn law(term: &Term) -> (Vec<String>, Vec<String>) {
    let reported = term.effect.reported(term.form, &term.coefficients, &term.shape);
    let constants: Vec<String> = reported.iter().map(|v| format!("({})", literal(*v))).collect();
    let (q, v) = (|j: usize| format!("q[{j}]"), |j: usize| format!("qd[{j}]"));
    let all = statements_of_law(Form::numbered(term.form), &term.joints, &constants, &q, &v);
    let torque = all.into_iter().map(|(j, value)| format!("tau[{j}] += {value}"));
    (torque.collect(), Vec::new())
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

fn coupling(term: &Term, c: &[String]) -> (Vec<String>, Vec<String>) {
    let (i, j, ratio) = (term.joints[0], term.joints[1], coupling_ratio(term));
    let k = literal(ratio);
    let sum = |x: &str| format!("({x}[{i}] + {k} * {x}[{j}])");
    let (v, a) = (sum("qd"), sum("qdd"));
    let load = format!("{} * {v} + {} * sign{v} + {} * {a}", c[0], c[1], c[2]);
    let torque = vec![format!("tau[{i}] += {load}"), format!("tau[{j}] += {k} * ({load})")];
    let entries = [(i, i, 1.0), (i, j, ratio), (j, i, ratio), (j, j, ratio * ratio)];
    let mass = entries.map(|(r, s, f)| format!("m[{r}][{s}] += {} * {}", literal(f), c[2]));
    (torque, mass.to_vec())
}
