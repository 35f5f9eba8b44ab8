//! Whether stated deviations are those of the errors that are made.

use super::{as_log, bodies, logs};
use dynident::diagnosis::{Diagnosis, DiagnosisOptions, diagnose};
use dynident::model::Robot;
use dynident::preparation::{Period, PreprocessOptions, prepare};
use dynident::regression::Stretch;
use dynident::simulate::{Noise, RecordedLog};
use rayon::prelude::*;

/// The diagnosis of one log, with this knowledge of its period.
pub fn diagnosed(robot: &Robot, log: &RecordedLog, period: Period) -> Diagnosis {
    let options = PreprocessOptions {
        period,
        ..PreprocessOptions::default()
    };
    let log = as_log(log, "log", 1.0 / (log.time[1] - log.time[0]));
    let stretch = Stretch::new(&prepare(&log, robot.joint_count(), &options).unwrap(), &log);
    diagnose(robot, &[stretch], &[], &DiagnosisOptions::default())
}

/// Root mean square of the standardised errors of the base parameters over these seeds, of logs that `recorder` makes of what the
/// sensors say; nothing may be found on them.
pub fn calibration(
    robot: &Robot,
    noise: &Noise,
    period: Period,
    seeds: std::ops::Range<u64>,
    recorder: impl Fn(RecordedLog) -> RecordedLog + Sync,
) -> f64 {
    let of = |seed: u64| {
        let [identify, _] = logs(robot, &[], noise, seed);
        let outcome = diagnosed(robot, &recorder(identify), period);
        let found = &outcome.estimates.as_ref().expect("an identification has estimates").found;
        let truth = found.base.project(&bodies(robot, seed));
        let known: Vec<usize> = (0..found.base.len()).filter(|&c| found.estimate.is_determined(c)).collect();
        let squares = known
            .iter()
            .map(|&c| ((found.estimate.values[c] - truth[c]) / found.estimate.std_dev(c)).powi(2));
        let findings: Vec<_> = outcome
            .report
            .findings
            .iter()
            .map(|f| (&f.effect, &f.joints, &f.parameters))
            .collect();
        let found = (!findings.is_empty()).then(|| format!("{} seed {seed}: {findings:?}", robot.name()));
        (squares.sum::<f64>(), known.len(), found)
    };
    let parts: Vec<(f64, usize, Option<String>)> = seeds.into_par_iter().map(of).collect();
    let findings: Vec<&String> = parts.iter().filter_map(|p| p.2.as_ref()).collect();
    assert!(findings.is_empty(), "{findings:?}");
    let (sum, count) = parts.iter().fold((0.0, 0), |(s, n), p| (s + p.0, n + p.1));
    (sum / count as f64).sqrt()
}
