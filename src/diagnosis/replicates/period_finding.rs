//! Something found between the periods of a log, and the rows it is looked for in.

use crate::diagnosis::report::{
    Evaluated, Evidence, Finding, FindingHeldOut, ReportedParameter, RmsPair, is_determined, joint_names,
};
use crate::diagnosis::settings::SETTINGS;
use crate::model::Robot;
use crate::regression::{NoiseModel, Stretch};
use std::ops::Range;

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
    /// Rows that are filled in without it, counted alike.
    pub(crate) filled: Option<Range<usize>>,
    pub rms: Option<(RmsPair, RmsPair)>,
}

impl BetweenFinding {
    /// BIC difference.
    pub(crate) fn evidence(&self) -> f64 {
        self.gain - self.parameters.len() as f64 * SETTINGS.replicates.parameter_price
    }

    /// Whether the periods say what every parameter is: a column that is zero in the rows that count, or too few of them, can be
    /// fitted and tells nothing.
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

/// Rows at which periods have been put together: where the first begins to count, and both ends of what was filled in. Noise does
/// not go on over them, and a whitening filter would make much of the jump.
#[derive(Debug, Clone)]
pub(crate) struct Seams(Vec<usize>);

impl Seams {
    /// Of a stretch whose start is filled.
    pub fn of_start(stretch: &Stretch) -> Self {
        Self(vec![start_rows(stretch)])
    }

    /// Those at both ends of rows counted over all periods.
    pub fn add(&mut self, rows: &Range<usize>, of_period: usize) {
        self.0.extend([rows.start % of_period, rows.end % of_period]);
    }

    /// Rows whose whitened deviation stands on rows that were measured one after the other. A period does not go on at its own
    /// start.
    pub fn whitened_rows(&self, noise: &NoiseModel, mut keep: Vec<bool>) -> Vec<bool> {
        self.0.iter().for_each(|&row| keep[row] = false);
        noise.whitened_rows(&keep, false)
    }
}

/// Deviation of one period from the mean of the others. Of filtered noise it is as smooth as the noise.
pub(crate) fn beside_others(stretch: &Stretch, period: usize, joint: usize) -> Vec<f64> {
    let others = |s: usize| others(stretch, period, joint, s).0;
    let values = stretch.periods[period][joint].iter().enumerate();
    values.map(|(s, t)| t - others(s)).collect()
}

/// Deviation of every period from the mean of the others.
pub(crate) fn all_beside_others(stretch: &Stretch, joint: usize) -> Vec<Vec<f64>> {
    (0..stretch.periods.len()).map(|p| beside_others(stretch, p, joint)).collect()
}

/// Deviation of every period from the median of all, which a single odd period does not move.
pub(crate) fn all_beside_median(stretch: &Stretch, joint: usize) -> Vec<Vec<f64>> {
    let median = median_period(stretch, joint);
    let of = |period: &Vec<Vec<f64>>| period[joint].iter().zip(&median).map(|(t, m)| t - m).collect();
    stretch.periods.iter().map(of).collect()
}

/// Mean of the other periods in a row, and of how many, from the mean of all. The start of the first one is none of them: it has
/// been filled.
pub(crate) fn others(stretch: &Stretch, period: usize, joint: usize, row: usize) -> (f64, usize) {
    let of = |p: usize| stretch.periods[p][joint][row];
    let all = stretch.periods.len();
    let sum = all as f64 * stretch.torque[joint][row] - of(period);
    match period > 0 && row < start_rows(stretch) {
        true => ((sum - of(0)) / (all - 2) as f64, all - 2),
        false => (sum / (all - 1) as f64, all - 1),
    }
}

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
