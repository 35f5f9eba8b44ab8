//! Columns of effects as designs take them and as tracing takes them: two ways to the same derivative of the torque.

use crate::bench::{bodies, excitation, four_axes};
use dynident::diagnosis::EffectColumns;
use dynident::dynamics::{Coulomb, Motion};
use dynident::effects::own::ParameterDefinition;
use dynident::effects::{Definition, Effect, EffectKind, Law, OwnEffect, Span, all};
use dynident::excitation::{AddedColumns, Course};
use dynident::model::Robot;
use dynident::regression::{AugmentedModel, Stretch, Term};
use dynident::trajectory::Trajectory;
use nalgebra::DVector;
use std::sync::Arc;

/// Of the motion (Hz).
const RATE: f64 = 50.0;
/// Of the torque stream (s).
const DELAY: f64 = 0.01;

/// Every effect that has columns, in every form. What comes and goes between periods has none.
fn terms(robot: &Robot) -> Vec<Term> {
    let mut list = Vec::new();
    let law: &'static dyn Effect = &Law;
    for effect in all().iter().chain([&law]).filter(|e| e.kind() != EffectKind::BetweenPeriods) {
        list.extend((0..effect.forms()).map(|form| term(robot, *effect, form)));
    }
    list.push(own_term(robot));
    list
}

/// A formula in the states of three joints, with an acceleration and two shape parameters.
fn own_term(robot: &Robot) -> Term {
    let parameter = |name: &str, unit: &str, range: [f64; 2]| ParameterDefinition {
        name: name.into(),
        unit: unit.into(),
        low: Some(range[0]),
        high: Some(range[1]),
    };
    let definition = Definition {
        channels: Vec::new(),
        name: "mine".into(),
        joint: robot.joints()[1].name.clone(),
        expression: "k*sin(q2 - q0)*tanh(qd3/s) + j*qdd2*cos(q4) + c*exp(qd2/s)".into(),
        parameters: vec![
            parameter("k", "N m", [0.0, 9.0]),
            parameter("q0", "rad", [-1.0, 1.0]),
            parameter("s", "rad/s", [0.1, 2.0]),
            parameter("j", "kg m^2", [0.0, 1.0]),
            parameter("c", "N m", [-1.0, 1.0]),
        ],
        declared: false,
    };
    let own = OwnEffect::new(definition, robot).unwrap();
    let term = Term {
        joints: vec![own.joint()],
        effect: Arc::new(own).into(),
        form: 0,
        coefficients: vec![0.7, 0.3, -0.1],
        shape: vec![0.2, 0.8],
        free_shapes: 2,
        bounds: vec![[-1.0, 1.0], [0.1, 2.0]],
    };
    assert!(term.is_complete(robot), "{term:?}");
    term
}

/// The effect on the middle one of its places, with the middle one of the shapes that a search tries.
fn term(robot: &Robot, effect: &'static dyn Effect, form: usize) -> Term {
    let places = effect.places_of(form, robot);
    let joints = places[places.len() / 2].clone();
    let span = Span {
        range: 1.5,
        highest: 0.7,
        speed: 1.2,
        interval: 1.0 / RATE,
        speed_error: 0.0,
    };
    let shapes = effect.shapes(form, &joints, &vec![span; robot.joint_count()]);
    let distorts = effect.kind() == EffectKind::Distortion;
    let shape: Vec<f64> = match distorts {
        true => distortion(effect.code()),
        false => shapes.iter().map(|s| s.grid[s.grid.len() / 2]).collect(),
    };
    let bounds = match distorts {
        true => vec![[f64::NEG_INFINITY, f64::INFINITY]; shape.len()],
        false => shapes.iter().map(|s| [s.low, s.high]).collect(),
    };
    // What is reported are coefficients and shapes, as many as there are.
    let count = match distorts {
        true => 0,
        false => effect.parameters(form, robot, &joints).len() - shapes.len(),
    };
    let term = Term {
        effect: effect.into(),
        form,
        joints,
        coefficients: (0..count).map(|i| 0.7 - 0.4 * i as f64).collect(),
        free_shapes: bounds.iter().filter(|[low, high]| low < high).count(),
        shape,
        bounds,
    };
    assert!(term.is_complete(robot), "{term:?}");
    term
}

/// Sizes at which distortions are found. The gear does not give at all: where it does, tracing also has the load follow the bent
/// arm, which designs leave out as of second order.
fn distortion(code: &str) -> Vec<f64> {
    match code {
        "joint_elasticity" => vec![0.0],
        "encoder_offset" => vec![0.03],
        "base_tilt" => vec![0.02, -0.01],
        "torque_delay" => vec![DELAY],
        "torque_gain" => vec![0.05],
        other => panic!("how large is `{other}`?"),
    }
}

/// Columns with their zeros: per parameter, joint and sample.
struct Dense(Vec<Vec<Vec<f64>>>);

impl Dense {
    fn zeros(parameters: usize, motion: &Motion) -> Self {
        Self(vec![vec![vec![0.0; motion.samples()]; motion.joints()]; parameters])
    }

    /// As the criterion of a design has them.
    fn of_design(robot: &Robot, term: &Term, model: &AugmentedModel, motion: &Motion) -> Self {
        let course = Course {
            motion,
            interval: 1.0 / RATE,
            periodic: true,
            coulomb: Coulomb::Sign,
        };
        let columns = EffectColumns::new(robot, &[(term.clone(), model)]);
        assert_eq!((columns.count(), columns.groups()), (term.parameters(), 1));
        let mut dense = Self::zeros(term.parameters(), motion);
        for column in columns.columns(0, &course) {
            column.rows.into_iter().for_each(|(j, values)| dense.0[column.at][j] = values);
        }
        dense
    }

    /// As tracing differentiates the model that holds the term.
    fn of_model(term: &Term, model: &AugmentedModel, motion: &Motion) -> Self {
        let mut dense = Self::zeros(term.parameters(), motion);
        for (j, columns) in model.effect_columns(motion, 1.0 / RATE, true).into_iter().enumerate() {
            columns.into_iter().for_each(|(at, values)| dense.0[at][j] = values);
        }
        dense
    }
}

/// A model of plausible bodies with nothing but this term.
fn model_with(robot: &Robot, term: &Term) -> AugmentedModel {
    let declared = AugmentedModel::declared(robot);
    let values: DVector<f64> = declared.base.project(&bodies(robot, 5));
    AugmentedModel {
        values,
        terms: vec![term.clone()],
        ..declared
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, v| most.max(v.abs()))
}

/// What both ways may differ by: torques of some hundred operations, each rounded to 2⁻⁵³ of what it adds up, ten times the sum
/// itself where parts cancel; a distortion's column divides their difference by its step.
fn rounding(term: &Term, torque: f64) -> f64 {
    let step = term.effect.steps().iter().copied().fold(1.0, f64::min);
    1000.0 * 0.5 * f64::EPSILON * torque / step
}

#[test]
fn prop_designs_and_tracing_have_the_same_columns_of_every_effect() {
    let robot = four_axes();
    let motion = excitation(4, 3).sample(RATE);
    let mut kinds = std::collections::BTreeSet::new();
    for term in terms(&robot) {
        let model = model_with(&robot, &term);
        let torques = model.predict(&Stretch::of_motion(motion.clone(), 1.0 / RATE, true));
        let tolerance = rounding(&term, largest(torques.into_iter().flatten()));
        let designed = Dense::of_design(&robot, &term, &model, &motion);
        let traced = Dense::of_model(&term, &model, &motion);
        let mut seen = 0;
        for j in 0..4 {
            // Designs take signs along the motion as commanded, tracing along the distorted one: a torque stream that is late has
            // another sign for so long after a reversal, and a difference across one for the step of the derivative beside it.
            let turning = (DELAY + 2e-4) * largest(motion.accelerations(j).iter().copied());
            for s in (0..motion.samples()).filter(|&s| motion.velocities(j)[s].abs() > turning) {
                for at in 0..term.parameters() {
                    let (one, other) = (designed.0[at][j][s], traced.0[at][j][s]);
                    assert!(
                        (one - other).abs() <= tolerance,
                        "{term:?} parameter {at} joint {j} sample {s}: {one} {other}, apart by more than {tolerance}"
                    );
                    seen += usize::from(one != 0.0);
                }
            }
        }
        // Half the samples of one joint at least: nothing was compared with nothing. What smooth Coulomb friction lacks of the
        // jump it lacks near rest alone.
        let least = match term.effect.code() {
            "smooth_coulomb_friction" => 10,
            _ => motion.samples() / 2,
        };
        assert!(seen > least, "{term:?}: {seen} values that are not zero");
        kinds.insert(term.effect.code().to_string());
    }
    assert_eq!(
        kinds.len(),
        all().len() + 1,
        "all but contact, laws, and an own one: {kinds:?}"
    );
}
