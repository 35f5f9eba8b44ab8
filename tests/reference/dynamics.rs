//! Regressor, torques and base-parameter map of the iiwa 14 against an independent library (tests/data/README.md).

use crate::support::iiwa14;
use dynident::dynamics::{inverse_dynamics, numeric_base_parameters, regressor};
use dynident::parameters::{BaseParameters, Layout};
use nalgebra::DMatrix;
use serde_json::Value;

fn data(name: &str) -> Value {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn matrix(v: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = v.as_array().unwrap().iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |r, c| rows[r][c])
}

/// Sums of some twenty products of numbers up to 30: a few hundred units in the last place.
const ROUNDING: f64 = 1e-12;

#[test]
fn val_regressor_and_torques_equal_the_independent_library() {
    let robot = iiwa14();
    let layout = Layout::standard(&robot);
    let reference = data("ref_regressor.json");
    assert_eq!(
        layout.names(),
        serde_json::from_value::<Vec<String>>(reference["param_names"].clone()).unwrap()
    );
    let phi = numbers(&reference["table3_pi"]);
    for sample in reference["samples"].as_array().unwrap() {
        let [q, qd, qdd] = ["q", "qd", "qdd"].map(|k| numbers(&sample[k]));
        let y = regressor(&robot, &layout, &q, &qd, &qdd);
        assert!((&y - matrix(&sample["Y"])).amax() < ROUNDING);
        let tau = inverse_dynamics(&robot, &layout, &phi, &q, &qd, &qdd);
        for (mine, theirs) in tau.iter().zip(numbers(&sample["tau_table3"])) {
            assert!((mine - theirs).abs() < ROUNDING * 100.0, "{mine} {theirs}");
        }
    }
}

#[test]
fn val_base_parameters_equal_the_independent_map() {
    let robot = iiwa14();
    let reference = data("ref_base.json");
    let k = matrix(&reference["K"]);
    let exact = BaseParameters::exact(&robot);
    assert_eq!(exact.len(), 57);
    assert_eq!(
        exact.kept,
        serde_json::from_value::<Vec<usize>>(reference["base_cols"].clone()).unwrap()
    );
    // The paper writes ZZR7 for what is ZZ7 alone: nothing is regrouped into it.
    let names: Vec<_> = exact
        .names
        .iter()
        .map(|n| if n == "ZZ7" { "ZZR7" } else { n.as_str() })
        .collect();
    assert_eq!(
        names,
        serde_json::from_value::<Vec<String>>(reference["base_names"].clone()).unwrap()
    );
    assert!((&exact.map - &k).amax() < 1e-15);
    let numeric = numeric_base_parameters(&robot, 1);
    assert_eq!(numeric.base.kept, exact.kept);
    assert!((numeric.base.map - k).amax() < 1e-11);
    let table3 = numbers(&reference["table3_pi"]);
    let projected = exact.project(&table3);
    for (mine, theirs) in projected.iter().zip(numbers(&reference["table3_base"])) {
        assert!((mine - theirs).abs() < 1e-14);
    }
}

#[test]
fn val_base_parameter_expressions_are_the_papers_equation_6() {
    let exact = BaseParameters::exact(&iiwa14());
    let expression = |name: &str| {
        let at = exact.names.iter().position(|n| n == name).unwrap();
        exact.expressions[at].to_string()
    };
    assert_eq!(expression("ZZR1"), "ZZ1 + YY2");
    assert_eq!(expression("MYR2"), "MY2 + MZ3 + 0.42 (M3 + M4 + M5 + M6 + M7)");
    assert_eq!(
        expression("XXR2"),
        "XX2 - YY2 + YY3 + 0.84 MZ3 + 0.1764 (M3 + M4 + M5 + M6 + M7)"
    );
    assert_eq!(expression("MYR4"), "MY4 - MZ5 - 0.4 (M5 + M6 + M7)");
    assert_eq!(expression("XXR5"), "XX5 - YY5 + YY6");
    assert_eq!(expression("XXR7"), "XX7 - YY7");
    assert_eq!(expression("MX7"), "MX7");
}

/// Base parameters of the Stäubli RX-90 as published: Khalil & Dombre 2004, chapter 9, and the output of SYMORO+ for that arm
/// (rotor inertias left out, which the declared model does not have). D3 and RL4 are given values of our own, so that every
/// product shows.
#[test]
fn val_base_parameters_of_the_rx90_are_the_published_ones() {
    use dynident::model::{Friction, Joint, JointKind, Mdh, Robot};
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, 0.0, -quarter, quarter, -quarter];
    let (d3, rl4) = (0.5, 0.3);
    let joints = (0..6).map(|j| {
        let mdh = Mdh {
            alpha: alphas[j],
            d: if j == 2 { d3 } else { 0.0 },
            theta: 0.0,
            r: if j == 3 { rl4 } else { 0.0 },
        };
        Joint::from_mdh(format!("J{}", j + 1), JointKind::Revolute, mdh)
    });
    let frictionless = Friction {
        viscous: false,
        coulomb: false,
    };
    let robot = Robot::new(
        "RX-90",
        nalgebra::Vector3::new(0.0, 0.0, -9.81),
        joints.collect(),
        frictionless,
    )
    .unwrap();
    let base = BaseParameters::exact(&robot);
    let published = [
        "ZZR1 = ZZ1 + YY2 + YY3 + 0.25 (M3 + M4 + M5 + M6)",
        "XXR2 = XX2 - YY2 - 0.25 (M3 + M4 + M5 + M6)",
        "XY2 = XY2",
        "XZR2 = XZ2 - 0.5 MZ3",
        "YZ2 = YZ2",
        "ZZR2 = ZZ2 + 0.25 (M3 + M4 + M5 + M6)",
        "MXR2 = MX2 + 0.5 (M3 + M4 + M5 + M6)",
        "MY2 = MY2",
        "XXR3 = XX3 - YY3 + YY4 + 0.6 MZ4 + 0.09 (M4 + M5 + M6)",
        "XY3 = XY3",
        "XZ3 = XZ3",
        "YZ3 = YZ3",
        "ZZR3 = ZZ3 + YY4 + 0.6 MZ4 + 0.09 (M4 + M5 + M6)",
        "MX3 = MX3",
        "MYR3 = MY3 + MZ4 + 0.3 (M4 + M5 + M6)",
        "XXR4 = XX4 - YY4 + YY5",
        "XY4 = XY4",
        "XZ4 = XZ4",
        "YZ4 = YZ4",
        "ZZR4 = ZZ4 + YY5",
        "MX4 = MX4",
        "MYR4 = MY4 - MZ5",
        "XXR5 = XX5 - YY5 + YY6",
        "XY5 = XY5",
        "XZ5 = XZ5",
        "YZ5 = YZ5",
        "ZZR5 = ZZ5 + YY6",
        "MX5 = MX5",
        "MYR5 = MY5 + MZ6",
        "XXR6 = XX6 - YY6",
        "XY6 = XY6",
        "XZ6 = XZ6",
        "YZ6 = YZ6",
        "ZZ6 = ZZ6",
        "MX6 = MX6",
        "MY6 = MY6",
    ];
    let mut mine: Vec<String> = base
        .names
        .iter()
        .zip(&base.expressions)
        .map(|(n, e)| format!("{n} = {e}"))
        .collect();
    let mut theirs = published.map(String::from).to_vec();
    mine.sort();
    theirs.sort();
    assert_eq!(mine, theirs);
}
