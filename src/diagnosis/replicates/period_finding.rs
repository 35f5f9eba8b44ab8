//! Something found between the periods of a log, and the rows it is looked for in.

use crate::diagnosis::report::{
    Evaluated, Evidence, Finding, FindingHeldOut, ReportedParameter, RmsPair, is_determined, joint_names,
};
use crate::diagnosis::settings::SETTINGS;
use crate::model::Robot;
use crate::regression::Stretch;

/// Drift or contact, with its fit.
#[derive(Debug, Clone)]
pub(crate) struct BetweenFinding {
    pub(crate) effect: &'static str,
    pub(crate) joints: Vec<usize>,
    pub(crate) parameters: Vec<ReportedParameter>,
    pub(crate) gain: f64,
    pub(crate) p_value: f64,
    /// First row of an interval, counted over all periods.
    pub(crate) first_row: Option<usize>,
    pub rms: Option<(RmsPair, RmsPair)>,
}

impl BetweenFinding {
    /// BIC difference, at the log of about ten thousand rows for every parameter.
    pub(crate) fn evidence(&self) -> f64 {
        self.gain - self.parameters.len() as f64 * 9.0
    }

    /// Whether the periods say what every parameter is: a column that is zero in the rows that count, or too few of them, can be fitted and tells nothing.
    pub(crate) fn is_determined(&self) -> bool {
        let known = |p: &ReportedParameter| p.value.is_finite() && is_determined(p.std_dev);
        self.gain.is_finite() && self.parameters.iter().all(known)
    }

    pub fn finding(&self, robot: &Robot, otherwise: &RmsPair) -> Finding {
        let (rms_before, rms_after) = self.rms.clone().unwrap_or((otherwise.clone(), otherwise.clone()));
        let note = match self.effect {
            "external_contact" => "the interval is left out of the fit",
            _ => "base parameters are those of the mean over the log",
        };
        Finding {
            effect: self.effect.into(),
            joints: joint_names(robot, &self.joints),
            formula: None,
            covered: Vec::new(),
            parameters: self.parameters.clone(),
            rms_before,
            rms_after,
            evidence: Evidence {
                gain: self.gain,
                log_evidence_ratio: self.evidence(),
                p_value: self.p_value,
                held_out_blocks: Evaluated::NotEvaluated,
                held_out_periods: Evaluated::NotEvaluated,
            },
            held_out: FindingHeldOut::not_tested(),
            in_model: false,
            survivals: Vec::new(),
            rivals: Vec::new(),
            note: Some(note.into()),
        }
    }
}

/// Rows of the first period that do not count.
pub(crate) fn start_rows(stretch: &Stretch) -> usize {
    (SETTINGS.replicates.start_share * stretch.rows() as f64) as usize
}

pub(crate) type Explained = (BetweenFinding, Vec<Vec<Vec<f64>>>);

pub(crate) fn median_period(stretch: &Stretch, j: usize) -> Vec<f64> {
    (0..stretch.rows())
        .map(|s| {
            let mut values: Vec<f64> = stretch.periods.iter().map(|p| p[j][s]).collect();
            values.sort_by(f64::total_cmp);
            let m = values.len();
            0.5 * (values[(m - 1) / 2] + values[m / 2])
        })
        .collect()
}
