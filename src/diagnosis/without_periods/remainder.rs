//! What is left at the end of a search and follows the motion: misfit, and no noise.
//!
//! Nobody knows the noise of a log without periods. But noise of any colour, filtered or not, has nothing to do with where the
//! arm is and how fast it moves. So what [smooth functions of the motion](super::motion_functions) explain is misfit, and no
//! verdict says that nothing is missing beside it. Where such functions predict blocks of time that they were not fitted to,
//! their variables are what it depends on, and effects that they make superfluous were their stand-ins.

use super::contender::side_by_side;
use super::motion_functions::{Following, following};
use super::passing::passing;
use crate::diagnosis::replicates::joined;
use crate::diagnosis::report::Remainder;
use crate::diagnosis::selection::{Selected, reached};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::variable_name;
use crate::regression::{Data, System, Whitened};

/// The selection without stand-ins of smooth functions, and what follows the motion, or comes once, all the same.
pub(crate) fn examine(data: &Data, mut selected: Selected) -> (Selected, Option<Remainder>) {
    let mut found = following(data, &selected.system);
    if withdraw(data, &mut selected, &found) {
        found = following(data, &selected.system);
    }
    let follows = (!found.is_empty()).then(|| described(data, &selected.system, &found));
    let remainder = joined(follows, passing(data, &selected.system));
    (selected, remainder)
}

/// What the torques of every joint change with the parameters of term `at`.
fn columns_of_term(system: &System, at: usize) -> Whitened {
    let (from, count) = (system.model.offset_of(at), system.model.terms[at].parameters());
    let of = |s: usize, j: usize| (j, system.blocks[s][j].jacobian.columns(from, count).into_owned());
    let joints = system.model.robot.joint_count();
    (0..system.blocks.len())
        .map(|s| (0..joints).map(|j| of(s, j)).collect())
        .collect()
}

/// Takes out effects that gain next to nothing beside a function that takes their place; says whether there was one.
fn withdraw(data: &Data, selected: &mut Selected, found: &[Following]) -> bool {
    let joints = selected.system.model.robot.joint_count();
    let before = selected.accepted.len();
    for at in (0..before).rev() {
        let term = &selected.system.model.terms[selected.fixed + at];
        let on = reached(term, joints);
        let functions: Vec<Whitened> = found
            .iter()
            .filter(|f| f.takes_the_place_of_effects() && on.contains(&f.joint))
            .map(|f| f.function.clone())
            .collect();
        if functions.is_empty() {
            continue;
        }
        let without = selected.system.without_term(data, selected.fixed + at);
        let functions = side_by_side(&functions);
        let own = columns_of_term(&selected.system, selected.fixed + at);
        let gain = |columns: &Whitened| without.reduced(columns).gain;
        let beside = gain(&side_by_side(&[own.clone(), functions.clone()])) - gain(&functions);
        if beside < SETTINGS.nonparametric.share_beside * gain(&own) {
            let mut model = selected.system.model.clone();
            model.terms.remove(selected.fixed + at);
            selected.accepted.remove(at);
            selected.system = data.fit(model);
        }
    }
    selected.accepted.len() < before
}

fn described(data: &Data, system: &System, found: &[Following]) -> Remainder {
    let joints = system.model.robot.joint_count();
    let name = |f: &Following| system.model.robot.joints()[f.joint].name.clone();
    let left = data.left_as_noise(system);
    let mean_square = |f: &Following| left[f.joint].std_dev.powi(2);
    let least = |f: &Following| (f.explained.min(1.0) * mean_square(f)).sqrt();
    let mut depends_on: Vec<String> = Vec::new();
    for v in found.iter().filter_map(|f| f.predicted.as_ref()).flat_map(|p| &p.variables) {
        let name = variable_name(*v, joints);
        if !depends_on.contains(&name) {
            depends_on.push(name);
        }
    }
    let of_all = |f: &Following| f.predicted.as_ref().map_or(0.0, |p| p.share.min(1.0) * mean_square(f));
    let predicted_share = found.iter().map(of_all).sum::<f64>() / found.iter().map(mean_square).sum::<f64>();
    let each = |f: &Following| {
        let joint = &system.model.robot.joints()[f.joint];
        let [part, whole] = [least(f), mean_square(f).sqrt()].map(|v| joint.effort(v));
        format!("{part} of {whole} on {}", joint.name)
    };
    let each: Vec<String> = found.iter().map(each).collect();
    let by = match depends_on.is_empty() {
        true => {
            "no function of one or two positions, speeds or loads predicts it on blocks of time that it was not fitted to".into()
        }
        false => format!(
            "functions of {} predict {:.0} % of it on blocks of time that they were not fitted to",
            depends_on.join(", "),
            100.0 * predicted_share
        ),
    };
    Remainder {
        joints: found.iter().map(name).collect(),
        depends_on,
        predicted_share,
        rms: found.iter().map(least).collect(),
        note: format!(
            "what is left follows the motion and is not all noise: at least {} (RMS) is misfit; {by}; the periods of a motion that \
             repeats would tell misfit and noise apart",
            each.join(", ")
        ),
    }
}
