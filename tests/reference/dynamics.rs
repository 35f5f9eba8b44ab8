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
