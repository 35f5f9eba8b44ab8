//! Filter, edges, decimation and dead zone of the rows.

use super::{Chain, Record, SIGN_SIGMAS, describe, padding};
use crate::preparation::cutoff::{POSITION_SETTLED, signal_cutoff};
use crate::preparation::error::PreprocessError;
use crate::preparation::filter::LowPass;
use crate::preparation::options::{Choice, FilterSpec, Method};
use crate::preparation::row_filter::RowFilter;

/// The paper's filter of torques (section 4.3).
const PAPER_TORQUE: FilterSpec = FilterSpec {
    order: 12,
    cutoff_hz: 1.6,
};

/// Order of the parallel filter: run both ways it falls by 48 dB per octave, and rings little.
const PARALLEL_ORDER: usize = 4;

impl Chain<'_> {
    pub(crate) fn row_filter(
        &self,
        record: &Record,
        of_positions: Option<&LowPass>,
        choices: &mut Vec<Choice>,
    ) -> Result<RowFilter, PreprocessError> {
        let periodic = record.periods.is_some();
        let (spec, on_columns, why) = match (self.options.torque_filter, self.method(record)) {
            (Some(spec), Method::Paper) => (Some(spec), false, "given"),
            (Some(spec), _) => (
                Some(spec),
                true,
                "given; the same for torque and every regressor column, which leaves the equation as it is",
            ),
            (None, Method::Paper) => (Some(PAPER_TORQUE), false, "the paper's section 4.3: torque alone is filtered"),
            (None, Method::ParallelFilter) => (
                Some(self.options.position_filter.unwrap_or_else(|| self.parallel_default())),
                true,
                match self.options.band_hz {
                    Some(band) if band < signal_cutoff(self.log, self.cancel) => {
                        "no higher than that of the logs that the model is made from, so that errors compare; the same for torque and every regressor column"
                    }
                    _ => {
                        "as for the positions; the same filter for torque and every regressor column leaves the equation as it is"
                    }
                },
            ),
            (None, _) => (
                None,
                false,
                "averaging is all the filter that least squares needs; the noise of the mean is known from the periods",
            ),
        };
        choices.push(Choice::new("row_filter", spec.map_or("none".to_string(), describe), why));
        let filter = spec
            .map(|spec| self.design(spec, record.rate_hz, "torque_filter"))
            .transpose()?;
        let mut rows = RowFilter {
            columns: filter.clone().filter(|_| on_columns),
            torque: filter,
            padding: padding(periodic),
            ..RowFilter::none()
        };
        self.edges_and_decimation(record, of_positions, &mut rows, choices);
        Ok(rows)
    }

    fn parallel_default(&self) -> FilterSpec {
        FilterSpec {
            order: PARALLEL_ORDER,
            cutoff_hz: signal_cutoff(self.log, self.cancel).min(self.options.band_hz.unwrap_or(f64::INFINITY)),
        }
    }

    fn edges_and_decimation(
        &self,
        record: &Record,
        of_positions: Option<&LowPass>,
        rows: &mut RowFilter,
        choices: &mut Vec<Choice>,
    ) {
        let of_rows = rows.torque.as_ref();
        // The lower filter remembers longer.
        let lower = of_positions.filter(|p| of_rows.is_none_or(|r| p.cutoff_hz < r.cutoff_hz));
        let lower = lower.map_or(0, |p| p.samples_to_decay(POSITION_SETTLED));
        let settling = of_rows.map_or(0, LowPass::settling_samples).max(lower);
        let (edges, why) = match self.options.discard_edges_s {
            Some(seconds) => ((seconds * record.rate_hz).round() as usize, "given"),
            None if record.periods.is_some() => (0, "a period has no ends"),
            None => (
                settling,
                "what the filters remember of the padding beyond the record: that of the rows down to a thousandth, that of the positions to a hundredth",
            ),
        };
        rows.edges = edges;
        choices.push(Choice::new("edges", format!("{:.3} s", edges as f64 / record.rate_hz), why));
        let (decimation, why) = match (self.options.decimation, &rows.torque) {
            (Some(d), _) => (d, "given".to_string()),
            // Four samples per cycle of the cut-off: twice what the filtered signals need, so nothing is lost.
            (None, Some(filter)) if record.periods.is_none() => {
                let d = (record.rate_hz / (4.0 * filter.cutoff_hz)).floor().max(1.0) as usize;
                // A round number lets the rows be made of thinned-out samples too.
                (
                    if d >= 10 { d - d % 5 } else { d },
                    "rows closer together than a quarter of the filter's cut-off period say nothing new".to_string(),
                )
            }
            (None, _) => (1, "every sample of the mean period counts".to_string()),
        };
        rows.decimation = decimation;
        choices.push(Choice::new("decimation", decimation.to_string(), why));
    }

    pub(crate) fn dead_zone(&self, velocity_std: &[f64], still: &[bool], choices: &mut Vec<Choice>) -> Vec<f64> {
        let (mut zone, why) = match (self.options.dead_zone, self.options.method) {
            (Some(v), _) => (vec![v; velocity_std.len()], "given"),
            (None, Method::Paper) => (vec![0.0; velocity_std.len()], "the paper has none"),
            (None, _) => (
                velocity_std.iter().map(|s| SIGN_SIGMAS * s).collect(),
                "three standard deviations of the velocity: closer to zero its sign, and with it the Coulomb torque, is not known",
            ),
        };
        // A joint that never moves has no friction to mistake, and its rows tell of gravity.
        zone.iter_mut()
            .zip(still)
            .filter(|(_, still)| **still)
            .for_each(|(z, _)| *z = 0.0);
        let text: Vec<String> = zone.iter().map(|v| format!("{v:.2e}")).collect();
        choices.push(Choice::new("dead_zone", format!("[{}] rad/s (m/s)", text.join(", ")), why));
        zone
    }
}
