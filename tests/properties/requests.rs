//! Requests and robots through the types that are their schemas: nothing is lost either way, and the reader takes what comes out.

use dynident::documents::requests::{ExcitationRequest, IdentifyRequest, JointRobot, RobotOrName};
use dynident::documents::shipped::{ROBOTS, Shipped};
use dynident::documents::{NoExcitations, read_excitation_request, read_identify_request, robot_document};
use dynident::formats::{Parsed, parse};
use serde::de::DeserializeOwned;
use serde_aux::serde_introspection::serde_introspect;
use serde_json::{Value, json};

/// `value` as its type writes it, without what is null.
fn through<T: DeserializeOwned + serde::Serialize>(value: &Value) -> Value {
    let typed: T = serde_json::from_value(value.clone()).unwrap_or_else(|e| panic!("{e}: {value}"));
    without_nulls(serde_json::to_value(typed).unwrap())
}

fn without_nulls(value: Value) -> Value {
    match value {
        Value::Object(map) => map
            .into_iter()
            .filter(|(_, v)| !v.is_null())
            .map(|(k, v)| (k, without_nulls(v)))
            .collect(),
        Value::Array(items) => items.into_iter().map(without_nulls).collect(),
        other => other,
    }
}

/// Whole numbers may be written as `2` or as `2.0`.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.as_f64() == b.as_f64(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(k, v)| b.get(k).is_some_and(|other| same(v, other)))
        }
        _ => a == b,
    }
}

fn parsed(value: &Value) -> Parsed {
    parse(value.to_string().as_bytes()).unwrap()
}

#[test]
fn prop_robots_keep_everything_through_their_type() {
    for (name, text) in ROBOTS {
        let value: Value = serde_json::from_str(text).unwrap();
        let written = through::<RobotOrName>(&value);
        assert!(same(&written, &without_nulls(value.clone())), "{name}");
        assert_eq!(
            robot_document(&parsed(&written)).unwrap(),
            robot_document(&parsed(&value)).unwrap(),
            "{name}"
        );
    }
}

/// Every field that a request has, so that one that is added is added here.
fn has_all_fields<T: DeserializeOwned>(value: &Value) {
    for field in serde_introspect::<T>() {
        assert!(value.get(field).is_some(), "{field} is not in the example");
    }
}

fn excitation() -> Value {
    json!({
        "robot": "iiwa14",
        "fourier": {"order": 5, "fundamental_hz": [0.1, 0.2], "harmonics": vec![vec![1, 2, 3]; 7]},
        "sample_rate_hz": 100,
        "criterion": "recommended",
        "effects": [{
            "name": "hose", "joint": "A4", "expression": "k*(q4 - c)", "declared": false,
            "parameters": [{"name": "k", "unit": "N m/rad", "low": 0.0, "high": 9.0}, {"name": "c", "unit": "rad", "low": -2.0, "high": 2.0}],
        }],
        "constraints": {
            "form": "exact", "start": "free", "start_position": vec![0.1; 7],
            "torque": {"limits": vec![100.0; 7], "safety_factor": 1.5},
            "space": {
                "clearance": 0.01,
                "half_spaces": [{"name": "floor", "normal": [0, 0, 1], "offset": -0.5}],
                "boxes": [{"name": "table", "center": [2, 0, 0], "size": [0.1, 0.1, 0.1]}],
                "self_collision": {"ignore": [["A1", "A3"]]},
            },
        },
        "torque_noise": vec![0.1; 7],
        "search": {"seed": 2, "starts": 3, "time_limit_s": 1.5, "max_evaluations": 100, "jobs_per_round": 4},
        "given": [{"coefficients": {"a": vec![vec![0.1]; 7], "b": vec![vec![0.1]; 7]}, "offset": vec![0.0; 7], "fundamental_hz": 0.1, "periods": 2}],
        "periods": 4,
        "trajectories": 2,
        "backoff": 0.5,
        "warm_start": {"coefficients": {"a": vec![vec![0.1; 5]; 7], "b": vec![vec![0.1; 5]; 7]}, "offset": vec![0.0; 7], "fundamental_hz": 0.1},
    })
}

fn identification() -> Value {
    let side = |unit: &str| json!({"headers": ["a", "b"], "unit": [unit, unit], "scale": 2.0, "sign": [1, -1], "offset": 0.1});
    let bounds = json!({"link": 1, "mass": [1, 2], "center_of_mass": [[0, 1], [0, 1], [0, 1]], "inertia": {"xx": [0, 1]}, "viscous": [0, 1], "coulomb": [0, 1]});
    json!({
        "robot": "planar_two_link",
        "excitation": {"fundamental_hz": 0.1, "coefficients": {"a": [[1.0]]}},
        "period_s": 10.0,
        "columns": {"time": "t", "time_unit": "ms", "sample_rate_hz": 100.0, "position": side("deg"), "velocity": side("rpm"), "torque": side("A"), "coupling": [[1, 0], [0.5, 1]],
            "channels": [{"name": "heat", "header": "T_gear", "unit": "degC"}]},
        "preprocess": {
            "method": "parallel_filter", "average": true, "position_filter": {"order": 4, "cutoff_hz": 5.0}, "torque_filter": {"order": 4, "cutoff_hz": 5.0},
            "discard_edges_s": 0.5, "decimation": 2, "dead_zone": 0.01,
        },
        "estimator": "robust",
        "offset": true,
        "feasible": {
            "method": "both", "prior_weight": 0.5, "least_eigenvalue": 1e-3, "least_viscous": 0.1, "bounds": [bounds], "slender_axes": ["x", null], "gazebo": false,
            "triangle": "diagonal", "starts": 4, "seed": 3,
        },
        "prediction_points": 100,
        "trace": false,
        "effects": [{
            "name": "warm", "joint": "J1", "expression": "k*exp(-(heat - 20)/c)*qd1", "declared": true,
            "parameters": [{"name": "k", "unit": "N m s/rad", "low": 0.0, "high": 9.0}, {"name": "c", "unit": "degC", "low": 2.0, "high": 60.0}],
            "channels": [{"name": "heat", "unit": "degC", "reference": 20.0}],
        }],
    })
}

/// An own effect in a quantity that the logs are not read with is refused, with what to do.
#[test]
fn prop_channels_of_effects_are_channels_of_the_logs() {
    let mut value = identification();
    value["columns"]["channels"] = json!([]);
    let problems = read_identify_request(&parsed(&value), &Shipped, &NoExcitations).unwrap_err();
    let text = format!("{problems:?}");
    assert!(
        text.contains("`warm` depends on `heat`") && text.contains("columns.channels"),
        "{text}"
    );
}

#[test]
fn prop_requests_keep_everything_through_their_types() {
    let (excitation, identification) = (excitation(), identification());
    let read = |value: &Value| read_excitation_request(&parsed(value), &Shipped).unwrap_or_else(|e| panic!("{e:?}"));
    let written = through::<ExcitationRequest>(&excitation);
    assert!(same(&written, &excitation), "{written}");
    assert_eq!(
        format!("{:?}", read(&written).problem),
        format!("{:?}", read(&excitation).problem)
    );
    // A model by an id that nobody knows here.
    let mut all = excitation;
    all["model"] = json!({"identification": "x"});
    all["rivals"] = json!({"finding": {"effect": "torque_offset", "joints": ["A1"]}, "rival": 0});
    has_all_fields::<ExcitationRequest>(&all);
    assert!(same(&through::<ExcitationRequest>(&all), &all));

    has_all_fields::<IdentifyRequest>(&identification);
    let read =
        |value: &Value| read_identify_request(&parsed(value), &Shipped, &NoExcitations).unwrap_or_else(|e| panic!("{e:?}"));
    let written = through::<IdentifyRequest>(&identification);
    assert!(same(&written, &without_nulls(identification.clone())), "{written}");
    let again = read(&identification);
    assert_eq!(format!("{:?}", again.preprocess), format!("{:?}", read(&written).preprocess));
    assert_eq!(format!("{:?}", again.columns), format!("{:?}", read(&written).columns));
}

#[test]
fn prop_an_unknown_field_is_told_by_the_type() {
    assert!(serde_introspect::<JointRobot>().contains(&"joints"));
    let errors = robot_document(&parsed(&json!({"name": "x", "joinst": []}))).unwrap_err();
    let all: String = errors.iter().map(|e| format!("{e}\n")).collect();
    assert!(
        all.contains("/joinst: is not a field of this document (did you mean `joints`?)"),
        "{all}"
    );
}
