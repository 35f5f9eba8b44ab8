//! What physics allows a law to be: energies are energies on all their joints, and friction does not drive the arm.

use crate::diagnosis::settings::SETTINGS;
use crate::effects::Column;
use crate::effects::law::LawForm;
use crate::parameters::{Layout, ParameterKind};
use crate::regression::{Data, Stretch, System, Term, Thinned};

/// Whether term `at`, a law, is one that a robot can have.
pub(super) fn is_physical_law(data: &Data, system: &System, at: usize) -> bool {
    let form = LawForm::numbered(system.model.terms[at].form);
    match (form.is_gradient(), form.is_friction()) {
        (true, false) => is_one_energy(data, system, at),
        (true, true) => is_one_energy(data, system, at) && brakes(data, system, at),
        (false, true) => brakes(data, system, at),
        (false, false) => true,
    }
}

/// Whether its columns need no other coefficients on one of its two joints than on the other.
fn is_one_energy(data: &Data, system: &System, at: usize) -> bool {
    let term = &system.model.terms[at];
    let first = term.joints[0];
    let coarse: Vec<&Stretch> = data.stretches.iter().map(Stretch::coarse_form).collect();
    let alone = |(stretch, thin): (&&Stretch, &Thinned)| {
        let scene = thin.scene(system, stretch);
        let columns = term.effect.columns(term.form, &scene, &term.joints, &term.shape);
        let on_first = |c: Column| Column {
            rows: c.rows.into_iter().filter(|(j, _)| *j == first).collect(),
        };
        columns.into_iter().map(on_first).collect::<Vec<_>>()
    };
    let columns = coarse.iter().zip(system.thinned(data)).map(alone).collect();
    let freed = system.reduced(&system.whitened(data, &coarse, columns));
    let left = system.mean_square(&term.joints).max(1.0);
    freed.gain / left < SETTINGS.laws.energy_gain * freed.rank.max(1) as f64
}

/// Whether the friction of the joints that it speaks of, with it, takes power out everywhere along the motion, as far as its
/// coefficients are known. One joint's part alone may be positive: a seal between two joints drags one along with the other.
fn brakes(data: &Data, system: &System, at: usize) -> bool {
    let law = &system.model.terms[at];
    let mut joints = law.joints.clone();
    joints.sort_unstable();
    joints.dedup();
    let covariance = system.term_covariance(at);
    let relative = (0..law.coefficients.len())
        .map(|i| covariance[(i, i)].max(0.0).sqrt() / law.coefficients[i].abs().max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    let doubt = SETTINGS.laws.driving_deviations * relative.min(1.0);
    let declared = friction(system);
    let other: Vec<&Term> = system
        .model
        .terms
        .iter()
        .enumerate()
        .filter(|(i, t)| *i != at && t.effect.is_friction(t.form) && t.joints.iter().any(|j| joints.contains(j)))
        .map(|(_, t)| t)
        .collect();
    data.stretches
        .iter()
        .map(Stretch::coarse_form)
        .zip(system.thinned(data))
        .all(|(stretch, thin)| {
            let scene = thin.scene(system, stretch);
            let power = |term: &Term| {
                let columns = term.effect.columns(term.form, &scene, &term.joints, &term.shape);
                let mut sum = vec![0.0; scene.samples()];
                for (column, c) in columns.iter().zip(&term.coefficients) {
                    for (j, values) in &column.rows {
                        let speeds = scene.motion.velocities(*j);
                        let parts = values.iter().zip(speeds).map(|(x, v)| c * x * v);
                        sum.iter_mut().zip(parts).for_each(|(s, p)| *s += p);
                    }
                }
                sum
            };
            let own = power(law);
            let others: Vec<Vec<f64>> = other.iter().map(|t| power(t)).collect();
            let base = |s: usize| {
                let of = |&j: &usize| {
                    let v = scene.motion.velocities(j)[s].abs();
                    declared[j][0] * v * v + declared[j][1] * v
                };
                joints.iter().map(of).sum::<f64>()
            };
            (0..scene.samples()).all(|s| {
                let rest = base(s) + others.iter().map(|o| o[s]).sum::<f64>();
                rest + own[s] + doubt * own[s].abs() >= 0.0
            })
        })
}

/// Viscous and Coulomb friction of every joint in the model's base parameters.
fn friction(system: &System) -> Vec<[f64; 2]> {
    let model = &system.model;
    let layout = Layout::standard(&model.robot);
    let mut all = vec![[0.0; 2]; model.robot.joint_count()];
    for (&at, &value) in model.base.kept.iter().zip(model.values.iter()) {
        let parameter = &layout.parameters()[at];
        match parameter.kind {
            ParameterKind::Viscous => all[parameter.link][0] = value,
            ParameterKind::Coulomb => all[parameter.link][1] = value,
            ParameterKind::Inertial(_) => {}
        }
    }
    all
}
