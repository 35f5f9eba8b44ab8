//! The gradient held against differences, through the columns of every effect.

use super::*;
use crate::diagnosis::EffectColumns;
use crate::dynamics::{Chain, ColumnSet, MotionGradient, RowBlocks};
use crate::effects::{Effect, EffectKind, Span, all};
use crate::model::{Friction, Joint, JointKind, Mdh, Robot};
use crate::parameters::Layout;
use crate::regression::{AugmentedModel, Term};
use crate::trajectory::harmonic;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::TAU;

const JOINTS: usize = 3;
const ORDER: usize = 3;
const SIZE: usize = 2 * ORDER + 1;
/// A multiple of the vector units' width: nothing is padded.
const SAMPLES: usize = 40;
const FUNDAMENTAL_HZ: f64 = 0.2;
const INTERVAL: f64 = 1.0 / (FUNDAMENTAL_HZ * SAMPLES as f64);
const SMOOTH: Coulomb = Coulomb::Smooth(0.1);
/// Of the central differences that the gradient is held against, in coefficients [rad/s].
const STEP: f64 = 1e-4;

/// A sliding joint between two turning ones.
fn arm() -> Robot {
    let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
    let joint = |(i, kind): (usize, JointKind)| {
        let mdh = Mdh {
            alpha: 0.8 * i as f64,
            d: 0.1,
            theta: 0.2,
            r: 0.3,
        };
        Joint::from_mdh(format!("j{i}"), kind, mdh)
    };
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    let joints = kinds.into_iter().enumerate().map(joint).collect();
    Robot::new("test", Vector3::new(0.0, 2.0, -9.0), joints, friction).unwrap()
}

/// Every effect that has columns, in every form; on the middle one of its places, with the middle one of the shapes that a search
/// tries.
fn terms(robot: &Robot) -> Vec<Term> {
    let mut list = Vec::new();
    // Not every effect has a place on every arm: couplings are between neighbours of a kind.
    let here = |e: &&&'static dyn Effect| e.kind() != EffectKind::BetweenPeriods && !e.places(robot).is_empty();
    for effect in all().iter().filter(here) {
        list.extend((0..effect.forms()).map(|form| term(robot, *effect, form)));
    }
    list
}

fn term(robot: &Robot, effect: &'static dyn Effect, form: usize) -> Term {
    let places = effect.places(robot);
    let joints = places[places.len() / 2].clone();
    let span = Span {
        range: 1.5,
        highest: 0.5,
        speed: 1.2,
        interval: INTERVAL,
        speed_error: 0.0,
    };
    let shapes = effect.shapes(form, &joints, &[span; JOINTS]);
    let (coefficients, shape): (usize, Vec<f64>) = match effect.kind() {
        EffectKind::Distortion => (0, vec![1e-3; effect.steps().len()]),
        _ => (
            effect.parameters(form, robot, &joints).len() - shapes.len(),
            shapes.iter().map(|s| s.grid[s.grid.len() / 2]).collect(),
        ),
    };
    let term = Term {
        effect: effect.into(),
        form,
        joints,
        coefficients: (0..coefficients).map(|i| 0.7 - 0.4 * i as f64).collect(),
        free_shapes: shape.len(),
        bounds: vec![[f64::NEG_INFINITY, f64::INFINITY]; shape.len()],
        shape,
    };
    assert!(term.is_complete(robot), "{term:?}");
    term
}

/// q, qd and qdd per unit of every coefficient.
fn basis() -> [Vec<f64>; 3] {
    let mut parts = [(); 3].map(|()| vec![0.0; SAMPLES * SIZE]);
    for s in 0..SAMPLES {
        for l in 1..=ORDER {
            let [sine, cosine] = harmonic(TAU * FUNDAMENTAL_HZ, l, s as f64 * INTERVAL);
            for d in 0..3 {
                parts[d][(l - 1) * SAMPLES + s] = sine[d];
                parts[d][(ORDER + l - 1) * SAMPLES + s] = cosine[d];
            }
        }
        parts[0][2 * ORDER * SAMPLES + s] = 1.0;
    }
    parts
}

fn motion_of(coefficients: &DMatrix<f64>) -> Motion {
    let basis = basis();
    Motion::from_fn(JOINTS, SAMPLES, |j, s| {
        let part = |d: usize| {
            (0..SIZE)
                .map(|i| coefficients[(i, j)] * basis[d][i * SAMPLES + s])
                .sum::<f64>()
        };
        [part(0), part(1), part(2)]
    })
}

fn columns_along(source: &Added, motion: &Motion) -> Vec<AddedColumn> {
    source.along(&Course {
        motion,
        interval: INTERVAL,
        periodic: true,
        coulomb: SMOOTH,
    })
}

/// Any weight for every value; none for values near zero, where what they are made of may change its sign.
fn weights(columns: &[AddedColumn]) -> Vec<AddedColumn> {
    let weight = |at: usize, j: usize, s: usize, value: f64| {
        if value.abs() < 0.05 {
            0.0
        } else {
            ((5 * at + 3 * j + 7 * s) as f64).sin()
        }
    };
    let of = |column: &AddedColumn| {
        let row = |(j, values): &(usize, Vec<f64>)| -> (usize, Vec<f64>) {
            let numbered = values.iter().enumerate();
            (*j, numbered.map(|(s, v)| weight(column.at, *j, s, *v)).collect())
        };
        AddedColumn {
            at: column.at,
            rows: column.rows.iter().map(row).collect(),
        }
    };
    columns.iter().map(of).collect()
}

fn weighted(columns: &[AddedColumn], weights: &[AddedColumn]) -> f64 {
    let values = |all: &[AddedColumn]| -> Vec<f64> {
        let rows = all.iter().flat_map(|c| &c.rows);
        rows.flat_map(|(_, values)| values.iter().copied()).collect()
    };
    values(columns).iter().zip(values(weights)).map(|(v, w)| v * w).sum()
}

/// By the coefficients, of the sum of all values with these weights.
fn gradient(source: &Added, model: &AugmentedModel, motion: &Motion, weights: &[AddedColumn]) -> DMatrix<f64> {
    let robot = &model.robot;
    let set = ColumnSet::new(robot, &Layout::standard(robot), &model.base.kept[..1]);
    let mut rows = RowBlocks::new(&set, SAMPLES);
    rows.fill(&Chain::new(robot), &set, motion, SMOOTH);
    let mut beside = Beside::new(source, set.len(), JOINTS, INTERVAL, motion.stride());
    beside.see(motion, SMOOTH);
    beside.join(&set, &rows, 0);
    for joint in 0..JOINTS {
        let own = beside.outputs(joint).len() - set.row(joint).len();
        let mut of_joint = vec![0.0; own * SAMPLES];
        for column in weights {
            for (_, values) in column.rows.iter().filter(|(j, _)| *j == joint) {
                let place = beside.outputs(joint).iter().rposition(|&c| c == set.len() + column.at);
                let first = (place.expect("was filled in") - set.row(joint).len()) * SAMPLES;
                of_joint[first..first + SAMPLES].copy_from_slice(values);
            }
        }
        beside.set_weights(joint, 0, &of_joint);
    }
    let (mut local, basis) = (MotionGradient::new(JOINTS, SAMPLES), basis());
    beside.add_local(motion, SMOOTH, &mut local);
    let mut total = DMatrix::from_fn(SIZE, JOINTS, |i, j| {
        let at = |s: usize| {
            let part = local.get(j, s);
            (0..3).map(|d| basis[d][i * SAMPLES + s] * part[d]).sum::<f64>()
        };
        (0..SAMPLES).map(at).sum::<f64>()
    });
    beside.add_course(motion, SMOOTH, &basis, &mut total);
    total
}

/// What each effect says of what it reads is true, and the steps fit all of them: the gradient is that of the columns.
#[test]
fn prop_gradient_goes_through_the_columns_of_every_effect() {
    let declared = AugmentedModel::declared(&arm());
    let model = AugmentedModel {
        values: DVector::from_fn(declared.values.len(), |i, _| 1.0 + 0.3 * (5.0 * i as f64).sin()),
        ..declared
    };
    let x = DMatrix::from_fn(SIZE, JOINTS, |i, j| 0.5 * (3.2 + 2.1 * i as f64 + 1.7 * j as f64).sin());
    let motion = motion_of(&x);
    // Where a joint turns, hysteresis has no derivative: no sample is so near that the differences come there.
    let slowest = (0..JOINTS)
        .flat_map(|j| motion.velocities(j))
        .fold(f64::INFINITY, |least, v| least.min(v.abs()));
    assert!(slowest > 10.0 * STEP, "{slowest}");
    for term in terms(&model.robot) {
        let source = Added(Arc::new(EffectColumns::new(&model.robot, &[(term.clone(), &model)])));
        let weights = weights(&columns_along(&source, &motion));
        let found = gradient(&source, &model, &motion, &weights);
        // Only an offset is the same on every motion.
        let most = found.amax();
        assert_eq!(most > 0.0, term.effect.code() != "torque_offset", "{term:?}");
        for i in 0..SIZE * JOINTS {
            let at = |by: f64| {
                let mut moved = x.clone();
                moved[i] += by;
                weighted(&columns_along(&source, &motion_of(&moved)), &weights)
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            // Columns of distortions are differences themselves: rounding of the torque by the step of the effect and by STEP
            // leaves four digits of the gradient; a joint or a variable left out is a part of order one.
            assert!(
                (difference - found[i]).abs() <= 1e-3 * most,
                "{term:?} coefficient {i}: {difference} {}, the largest is {most}",
                found[i]
            );
        }
    }
}
