//! Effects with memory in source code: hysteresis, elasticity and delay, over a whole motion or sample by sample.
//!
//! Both languages follow [`AugmentedModel::predict`](crate::regression::AugmentedModel::predict) on a motion that does not
//! repeat, step by step.

use super::FinalModel;
use super::source::{literal, literals};
use crate::effects::{FEWEST, REACH, by_code};
use crate::regression::{SETTINGS, Term};

const C: &str = include_str!("templates/memory.c");
const PYTHON: &str = include_str!("templates/memory.py");

/// What a model keeps from sample to sample.
pub(super) struct Memory {
    /// In the order in which they are applied: the compliance of a joint [rad/(N·m) or m/N], or a delay (s) without a joint.
    distortions: Vec<(Option<usize>, f64)>,
    /// Joint, level [N·m or N] and width [rad or m] of presliding hysteresis.
    hysteresis: Vec<(usize, f64, f64)>,
    /// How often the load of elastic joints is computed again.
    rounds: usize,
}

/// Whether source code holds an effect of other samples. A torque that is earlier than the position would ask for samples to
/// come.
pub(super) fn is_remembered(term: &Term) -> bool {
    match term.effect.code() {
        "presliding_hysteresis" | "joint_elasticity" => true,
        "torque_delay" => term.shape[0] >= 0.0,
        _ => false,
    }
}

impl FinalModel {
    pub(super) fn memory(&self) -> Memory {
        let kept = || self.terms.iter().filter(|t| is_remembered(t));
        let distortions = kept().filter(|t| t.effect.code() != "presliding_hysteresis");
        let hysteresis = kept().filter(|t| t.effect.code() == "presliding_hysteresis");
        // As the identification does: a delay takes earlier samples, and elastic joints bend under the loads of those.
        let mut distortions: Vec<_> = distortions.map(|t| (t.joints.first().copied(), t.shape[0])).collect();
        distortions.sort_by_key(|(joint, _)| joint.is_some());
        // As the identification does: what is within the step of a derivative around zero has the load of the undistorted motion.
        let step = by_code("joint_elasticity").expect("is in the list").steps()[0];
        let bends = distortions
            .iter()
            .any(|(joint, value)| joint.is_some() && value.abs() > 1.5 * step);
        Memory {
            distortions,
            hysteresis: hysteresis.map(|t| (t.joints[0], t.coefficients[0], t.shape[0])).collect(),
            rounds: if bends { SETTINGS.load_rounds } else { 0 },
        }
    }
}

impl Memory {
    pub fn is_empty(&self) -> bool {
        self.distortions.is_empty() && self.hysteresis.is_empty()
    }

    /// Lines for the top of a file.
    pub fn heading(&self) -> Vec<String> {
        let mut lines = vec![
            "inverse_dynamics knows one state alone, and leaves out effects that depend on earlier samples. These have them:"
                .to_string(),
            "predict: torques along a whole motion that is known (planned or recorded), samples sample_time (s) apart.".into(),
            "step: torque for the next sample, with a state that is kept from sample to sample.".into(),
        ];
        if self.rounds > 0 {
            lines.push(
                "step differentiates the load of elastic joints looking back only: noise of the samples grows more than in predict.".into(),
            );
        }
        lines
    }

    fn elastic(&self) -> usize {
        self.distortions.iter().filter(|(joint, _)| joint.is_some()).count()
    }

    fn rows(&self, brackets: [&str; 2]) -> [Vec<String>; 2] {
        let [open, close] = brackets;
        let place = |joint: Option<usize>| joint.map_or("-1".into(), |j| j.to_string());
        let distortion = |&(j, value): &(Option<usize>, f64)| format!("{open}{}, {}{close}", place(j), literal(value));
        let hysteresis =
            |&(j, level, width): &(usize, f64, f64)| format!("{open}{j}, {}, {}{close}", literal(level), literal(width));
        [
            self.distortions.iter().map(distortion).collect(),
            self.hysteresis.iter().map(hysteresis).collect(),
        ]
    }

    pub fn c(&self, gravity: &[f64; 3]) -> String {
        if self.is_empty() {
            return String::new();
        }
        let [distortions, hysteresis] = self.rows(["{", "}"]);
        let delay: f64 = self.distortions.iter().filter(|(j, _)| j.is_none()).map(|(_, v)| v).sum();
        // Arrays of no entries are not C.
        let or = |rows: Vec<String>, none: &str| if rows.is_empty() { none.to_string() } else { rows.join(", ") };
        let tables = format!(
            "enum {{ DISTORTIONS = {}, HYSTERESES = {}, ELASTIC = {}, LOAD_ROUNDS = {}, DELAY_US = {} }};\n\
             static const double LEVEL_GRAVITY[3] = {{{}}};\n\
             /* compliance of a joint (rad/(N m) or m/N); joint -1: delay of the torque (s) */\n\
             static const struct {{ int joint; double value; }} DISTORTION[] = {{{}}};\n\
             /* level (N m or N) and width (rad or m) of presliding friction */\n\
             static const struct {{ int joint; double level, width; }} HYSTERESIS[] = {{{}}};\n",
            self.distortions.len(),
            self.hysteresis.len(),
            self.elastic(),
            self.rounds,
            (1e6 * delay).ceil() as i64,
            literals(gravity),
            or(distortions, "{-1, 0.0}"),
            or(hysteresis, "{0, 0.0, 1.0}"),
        );
        C.replace("@MEMORY@", &tables)
            .replace("@REACH_US@", &((1e6 * REACH).round() as i64).to_string())
            .replace("@FEWEST@", &FEWEST.to_string())
    }

    pub fn python(&self, gravity: &[f64; 3]) -> String {
        if self.is_empty() {
            return String::new();
        }
        let [distortions, hysteresis] = self.rows(["(", ")"]);
        let tables = format!(
            "# Compliance of a joint (rad/(N m) or m/N); joint -1: delay of the torque (s).\nDISTORTION = [{}]\n\
             # Joint, level (N m or N) and width (rad or m) of presliding friction.\nHYSTERESIS = [{}]\n\
             LEVEL_GRAVITY = ({})\nLOAD_ROUNDS = {}\n\
             # Half the window (s) over which the load of an elastic joint is differentiated, and the fewest samples to both sides.\n\
             REACH_S, FEWEST = {}, {FEWEST}\n",
            distortions.join(", "),
            hysteresis.join(", "),
            literals(gravity),
            self.rounds,
            literal(REACH),
        );
        PYTHON.replace("@MEMORY@", &tables)
    }
}
