//! The pipeline: from stretches of data to a report and an augmented model.

use super::course::Course;
use super::declared_effects::with_declared;
use super::options::DiagnosisOptions;
use super::outcome::Diagnosis;
use super::recorded_filter::{behind, filtered, recorded_filter};
use super::search::searched;
use crate::diagnosis::laws::channel_laws;
use crate::diagnosis::replicates::{Separated, separate, trends};
use crate::diagnosis::report::fits;
use crate::model::Robot;
use crate::regression::{AugmentedModel, Data, Stretch, explained_share, floor};
use std::borrow::Cow;

/// Finds what `robot`'s declared model lacks on `stretches`. `held_out` is only ever predicted: it fits nothing, and has the last
/// word on what stays in the model.
pub fn diagnose(robot: &Robot, stretches: &[Stretch], held_out: &[Stretch], options: &DiagnosisOptions) -> Diagnosis {
    let start = options.start(robot);
    let filter = options
        .existing
        .is_none()
        .then(|| recorded_filter(&start, stretches, &options.cancel))
        .flatten();
    let (stretches, held_out) = (behind(stretches, filter), behind(held_out, filter));
    let (stretches, held_out) = (&stretches[..], &held_out[..]);
    let mut separated = match options.search {
        true => separate(robot, stretches, options.chance),
        false => Separated::nothing(stretches),
    };
    // The mean over all periods hides what follows a channel.
    let follows = !separated.following.is_empty();
    let (measured, held_out) = (grouped(stretches, follows), grouped(held_out, follows));
    if follows {
        separated.steady = grouped(&separated.steady, true).into_owned();
        separated.explained = grouped(&separated.explained, true).into_owned();
    }
    let mut course = Course {
        robot,
        measured: &measured,
        held_out: &held_out,
        options,
        start,
        channel_laws: channel_laws(robot, &separated.following, &measured),
        explained: explained_share(&AugmentedModel::declared(robot), stretches),
    };
    let steady = std::mem::take(&mut separated.steady);
    let list = course.candidates(&steady);
    // What to add is found on the coarse forms, which have the same rows; values and errors are those of all samples.
    let coarse: Vec<Stretch> = steady.iter().map(Stretch::as_coarse).collect();
    let prior = options.existing.as_ref().map(|(_, prior)| prior);
    let mut data = Data::new(&coarse, Vec::new(), prior).for_comparison().until(&options.cancel);
    data.noise = floor(robot, &data, &course.start);
    if options.own.iter().any(|own| own.is_declared()) {
        course.start = with_declared(&data, course.start, &options.own);
        data.noise = floor(robot, &data, &course.start);
    }
    let fine = Data::new(&steady, data.noise.clone(), prior).until(&options.cancel);
    let lack_of_fit = fits(&fine, &fine.fit(course.start.clone()));
    let found = searched(&data, &fine, course.start.clone(), &list, &course.threshold());
    if course.searches() {
        separated.unsteady.extend(trends(&found.data, &found.system, options.chance));
    }
    let decided = course.decided(found);
    let mut report = course.report(&decided, separated, &list, lack_of_fit);
    report.data_faults.extend(filter.map(filtered));
    course.diagnosis(decided, report)
}

/// Logs as groups of periods, where something follows a channel.
fn grouped(stretches: &[Stretch], follows: bool) -> Cow<'_, [Stretch]> {
    match follows {
        true => stretches.iter().flat_map(Stretch::in_groups).collect(),
        false => Cow::Borrowed(stretches),
    }
}
