//! Columns that are no torques of one unit: motor currents, each with its own torque constant and gear ratio.

use super::fault::{DataFault, FaultKind, Remedy};
use super::order::{Projection, Sampled, root_mean_square};
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::{Chain, Coulomb, inverse_dynamics_batch};
use crate::model::decimals;
use crate::parameters::Layout;

/// Where at least two joints and half of all that go with their priors differ from them by factors beyond `current_factor`, and
/// the rigid model, which couples the joints' torques, leaves clearly less than `plain` with those factors taken out: a heavier
/// arm would fit as it is.
pub(crate) fn other_units(sampled: &Sampled, plain: f64) -> Option<DataFault> {
    let robot = sampled.robot;
    let n = robot.joint_count();
    let factors: Vec<Option<f64>> = factors(sampled)?;
    let known: Vec<f64> = factors.iter().flatten().copied().collect();
    let off = known
        .iter()
        .filter(|k| **k > SETTINGS.data_quality.current_factor || **k < 1.0 / SETTINGS.data_quality.current_factor)
        .count();
    if off < 2 || 2 * off < known.len() {
        return None;
    }
    let scaled = |(torque, factor): (&Vec<f64>, &Option<f64>)| torque.iter().map(|t| t / factor.unwrap_or(1.0)).collect();
    let torque = sampled.torque.iter().zip(&factors).map(scaled).collect();
    let there = Sampled::new(robot, sampled.motion.clone(), torque, &sampled.cancel);
    let (projection, order, signs) = (Projection::new(&there, &[]), (0..n).collect::<Vec<_>>(), vec![1.0; n]);
    let rest = projection.rest(&order, &signs);
    if plain <= SETTINGS.data_quality.clearly_better * (rest + projection.floor()) || !projection.explains(&order, &signs) {
        return None;
    }
    let name = |j: usize| robot.joints()[j].name.clone();
    let said: Vec<String> = (0..n)
        .filter_map(|j| Some(format!("{}: {:.2e}", name(j), factors[j]?)))
        .collect();
    let detail = format!(
        "the torque columns are not in one unit, as motor currents are not: they are so many times what the links' prior parameters make of the motion \
         ({}), and with these factors taken out the model leaves {} times less; give `unit` and `scale` (N m/A times the gear ratio) in `columns`",
        said.join(", "),
        decimals(plain / rest.max(f64::MIN_POSITIVE), 0)
    );
    let joints = (0..n).filter(|&j| factors[j].is_some()).map(name).collect();
    Some(DataFault::new(FaultKind::UnitUnknown, joints, detail, Remedy::Nothing))
}

/// Per joint, how many times the priors' torque its column is; `None` for a joint that does not go with it, and altogether
/// without priors.
fn factors(sampled: &Sampled) -> Option<Vec<Option<f64>>> {
    let robot = sampled.robot;
    let layout = Layout::standard(robot);
    let prior = layout.prior(robot)?;
    let motion = &sampled.motion;
    let predicted = inverse_dynamics_batch(&Chain::new(robot), &layout, prior.as_slice(), motion, Coulomb::Sign);
    let of = |j: usize| {
        let torque = &sampled.torque[j];
        let own = &predicted[j * motion.stride()..][..torque.len()];
        let mean: f64 = torque.iter().zip(own).map(|(t, p)| t * p).sum::<f64>() / torque.len() as f64;
        let (size, other) = (root_mean_square(torque), root_mean_square(own));
        let correlated = sampled.active[j] && mean > SETTINGS.data_quality.current_correlation * size * other && other > 0.0;
        correlated.then(|| mean / (other * other))
    };
    Some((0..robot.joint_count()).map(of).collect())
}
