//! Every effect of the list, through `simulate` and `identify`: what was hidden is named, and nothing else.

use crate::{Folder, run, stderr, stdout};
use dynident::documents::IdentifyDocument;
use serde_json::{Value, json};

/// Five harmonics on seven joints, within the iiwa's range.
fn trajectory(phase: f64) -> Value {
    let travel = [0.6, 0.45, 0.6, 0.5, 0.6, 0.6, 0.7];
    let row = |j: usize, p: f64| -> Vec<f64> {
        let wave = |l: usize| (p + 1.3 * j as f64 + 2.1 * l as f64).sin() / (l as f64 + 1.0).sqrt();
        (0..5).map(|l| travel[j] * wave(l)).collect()
    };
    let rows = |p: f64| (0..7).map(|j| row(j, p)).collect::<Vec<_>>();
    json!({"fourier": {"fundamental_hz": 0.1, "a": rows(phase), "b": rows(phase + 1.1)}})
}

/// A log of the virtual iiwa.
fn record(folder: &Folder, name: &str, phase: f64, seed: u64, periods: u32, effects: &Value) -> String {
    let request = json!({
        "trajectory": trajectory(phase), "periods": periods, "sample_rate_hz": 200, "seed": seed, "effects": effects,
        "noise": {"torque": [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06]},
    });
    let request = folder.write(&format!("{name}.request.json"), &request.to_string());
    let out = folder.file(&format!("{name}.csv"));
    let output = run(&["simulate", "--robot", "iiwa14", "--request", &request, "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    out
}

/// `residual` of an identification with the effect in it, and the model.
fn identified(folder: &Folder, effects: &Value) -> (Value, String) {
    let log = record(folder, "log", 0.3, 1, 6, effects);
    let request = folder.write("request.json", "{}");
    let [out, model] = ["result.json", "model.json"].map(|n| folder.file(n));
    let output = run(&[
        "identify",
        "--robot",
        "iiwa14",
        "--request",
        &request,
        "--log",
        &log,
        "--out",
        &out,
        "--model",
        &model,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result: Value = serde_json::from_str(&folder.read("result.json")).unwrap();
    // The document is one type both ways.
    let document: IdentifyDocument = serde_json::from_value(result.clone()).unwrap();
    assert_eq!(serde_json::to_value(&document).unwrap(), result);
    (result["residual"].clone(), model)
}

/// The value of a parameter of the only finding lies within four of its standard deviations: one in 16,000, and there are some
/// forty.
fn assert_told(residual: &Value, effect: &str, joints: &[&str], values: &[(&str, f64)]) {
    let findings = residual["findings"].as_array().unwrap();
    assert_eq!(findings.len(), 1, "{effect}: {findings:?}");
    let finding = &findings[0];
    assert_eq!(finding["effect"], effect);
    if !joints.is_empty() {
        assert_eq!(finding["joints"], json!(joints), "{effect}");
    }
    for (name, truth) in values {
        let parameters = finding["parameters"].as_array().unwrap();
        let parameter = parameters
            .iter()
            .find(|p| p["name"] == *name)
            .unwrap_or_else(|| panic!("{effect}: no {name} in {parameters:?}"));
        let [value, std_dev] = ["value", "std_dev"].map(|f| parameter[f].as_f64().unwrap());
        assert!(
            (value - truth).abs() < 4.0 * std_dev,
            "{effect}: {name} {value} ± {std_dev}, {truth} was hidden"
        );
    }
    assert_eq!(residual["verdict"], "explained", "{effect}");
}

fn assert_traced(effect: &str, hidden: Value, joints: &[&str], values: &[(&str, f64)]) {
    let folder = Folder::new(&format!("effect-{effect}"));
    let mut hidden = hidden;
    hidden["effect"] = effect.into();
    let (residual, _) = identified(&folder, &json!([hidden]));
    assert_told(&residual, effect, joints, values);
}

#[test]
fn prop_friction_is_traced_from_simulated_logs() {
    let stribeck = json!({"joint": "A2", "amplitude": 1.5, "velocity": 0.1, "exponent": 2});
    assert_traced(
        "stribeck_friction",
        stribeck,
        &["A2"],
        &[("amplitude", 1.5), ("velocity", 0.1)],
    );
    let nonlinear = json!({"joint": "A3", "coefficient": 1.2, "exponent": 2});
    assert_traced("nonlinear_viscous_friction", nonlinear, &["A3"], &[("coefficient", 1.2)]);
    let asymmetric = json!({"joint": "A5", "coefficient": 0.4});
    assert_traced("asymmetric_viscous_friction", asymmetric, &["A5"], &[("coefficient", 0.4)]);
    let loaded = json!({"joint": "A2", "coefficient": 0.06});
    assert_traced("load_dependent_friction", loaded, &["A2"], &[("coefficient", 0.06)]);
    let hysteresis = json!({"joint": "A4", "amplitude": 1.0, "width": 0.03});
    assert_traced(
        "presliding_hysteresis",
        hysteresis,
        &["A4"],
        &[("amplitude", 1.0), ("width", 0.03)],
    );
    let smooth = json!({"joint": "A6", "amplitude": 0.5, "velocity": 0.03});
    assert_traced(
        "smooth_coulomb_friction",
        smooth,
        &["A6"],
        &[("amplitude", 0.5), ("velocity", 0.03)],
    );
    let drift = json!({"joint": "A2", "viscous": 1.0, "coulomb": 1.5, "time_constant": 25});
    assert_traced("friction_drift", drift, &["A2"], &[("time_constant", 25.0)]);
}

#[test]
fn prop_what_hangs_on_a_joint_is_traced_from_simulated_logs() {
    assert_traced(
        "torque_offset",
        json!({"joint": "A4", "offset": 0.4}),
        &["A4"],
        &[("offset", 0.4)],
    );
    assert_traced(
        "rotor_inertia",
        json!({"joint": "A4", "inertia": 0.3}),
        &["A4"],
        &[("inertia", 0.3)],
    );
    let coupling = json!({"joints": ["A5", "A6"], "ratio": 1, "viscous": 0.4, "coulomb": 0.4, "inertia": 0.1});
    let truth = [("viscous", 0.4), ("coulomb", 0.4), ("inertia", 0.1)];
    assert_traced("transmission_coupling", coupling, &["A5", "A6"], &truth);
    // As strong as gravity on that joint, and against it.
    let spring = json!({"joint": "A6", "stiffness": 1.0, "rest": 0.2});
    assert_traced("joint_spring", spring, &["A6"], &[("stiffness", 1.0), ("rest_position", 0.2)]);
    let ripple = json!({"joint": "A5", "amplitude": 0.3, "cycles": 12, "phase": 0.5});
    assert_traced("position_ripple", ripple, &["A5"], &[("amplitude", 0.3), ("cycles", 12.0)]);
    let soft = json!({"joint": "A2", "stiffness": 3000});
    assert_traced("joint_elasticity", soft, &["A2"], &[("stiffness", 3000.0)]);
}

#[test]
fn prop_geometry_and_sensors_are_traced_from_simulated_logs() {
    assert_traced(
        "encoder_offset",
        json!({"joint": "A4", "offset": 0.03}),
        &["A4"],
        &[("offset", 0.03)],
    );
    let tilt = json!({"roll": 0.02, "pitch": -0.015});
    assert_traced("base_tilt", tilt, &[], &[("roll", 0.02), ("pitch", -0.015)]);
    assert_traced("torque_delay", json!({"seconds": 0.008}), &[], &[("delay", 0.008)]);
    assert_traced("torque_gain", json!({"joint": "A4", "gain": 1.1}), &["A4"], &[("gain", 1.1)]);
    let crosstalk = json!({"joint": "A3", "from": "A1", "coefficient": 0.05});
    assert_traced("torque_crosstalk", crosstalk, &["A3", "A1"], &[("coefficient", 0.05)]);
    let touch = json!({"start": 23.0, "end": 24.0, "torque": [0, 0, 0, 2.0, 0, 0, 0]});
    // Edges are reported to a sample, 5 ms.
    assert_traced("external_contact", touch, &["A4"], &[("start", 23.0), ("end", 24.0)]);
}

/// Any effect that adds columns can be made by them.
#[test]
fn prop_a_listed_effect_is_traced_from_simulated_logs() {
    let folder = Folder::new("effect-listed");
    let listed = json!({"effect": "listed", "code": "asymmetric_viscous_friction", "joints": ["A5"], "coefficients": [0.4]});
    let (residual, _) = identified(&folder, &json!([listed]));
    assert_told(&residual, "asymmetric_viscous_friction", &["A5"], &[("coefficient", 0.4)]);
    for (field, value, words) in [
        ("code", json!("torque"), "which no effect has"),
        ("code", json!("base_tilt"), "adds no columns"),
        ("form", json!(1), "has forms up to 0"),
        ("coefficients", json!([1.0, 2.0]), "2 entries in `coefficients`, expected 1"),
        ("joints", json!(["A5", "A6"]), "cannot be on these joints"),
    ] {
        let mut wrong = listed.clone();
        wrong[field] = value;
        let request = json!({"trajectory": trajectory(0.3), "effects": [wrong]});
        let request = folder.write("wrong.json", &request.to_string());
        let output = run(&["simulate", "--robot", "iiwa14", "--request", &request]);
        assert_eq!(output.status.code(), Some(2), "{field}");
        let said = stderr(&output);
        assert!(said.contains("/effects/0") && said.contains(words), "{field}: {said}");
    }
}

#[test]
fn prop_a_payload_is_traced_against_the_model_without_it() {
    let folder = Folder::new("effect-payload");
    let (nothing, model) = identified(&folder, &json!([]));
    assert_eq!(nothing["verdict"], "nothing_missing", "{nothing}");
    let body = json!({"effect": "payload", "mass": 1.2, "center_of_mass": [0.01, 0.02, 0.08],
        "inertia": [[0.002, 0, 0], [0, 0.002, 0], [0, 0, 0.002]]});
    let loaded = record(&folder, "loaded", 2.0, 2, 3, &json!([body]));
    let output = run(&["--json", "validate", "--model", &model, "--log", &loaded]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_told(&result["residual"], "payload", &["A7"], &[("mass", 1.2), ("center_z", 0.08)]);
}

/// Rotor inertias on several joints of one log, which came out as `unexplained` and as a coupling of A3 and A6.
#[test]
fn rotor_inertias_of_several_joints_are_found_together() {
    let cases = [
        (
            include_str!("../data/requests/iiwa_rotor567.json"),
            vec![("A5", 0.1), ("A6", 0.1), ("A7", 0.1)],
        ),
        (
            include_str!("../data/requests/iiwa_rotor34567.json"),
            vec![("A3", 0.195), ("A4", 0.195), ("A5", 0.074), ("A6", 0.074), ("A7", 0.074)],
        ),
    ];
    for (i, (request, hidden)) in cases.into_iter().enumerate() {
        let folder = Folder::new(&format!("rotors-{i}"));
        let request = folder.write("request.json", request);
        let [log, out] = ["log.csv", "result.json"].map(|n| folder.file(n));
        let output = run(&["simulate", "--robot", "iiwa14", "--request", &request, "--out", &log]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let output = run(&["identify", "--robot", "iiwa14", "--log", &log, "--out", &out]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let result: Value = serde_json::from_str(&folder.read("result.json")).unwrap();
        let findings = result["residual"]["findings"].as_array().unwrap();
        // In whichever order they came in.
        let mut findings = findings.clone();
        findings.sort_by_key(|f| f["joints"][0].to_string());
        let joints: Vec<&str> = findings.iter().filter_map(|f| f["joints"][0].as_str()).collect();
        assert_eq!(joints, hidden.iter().map(|h| h.0).collect::<Vec<_>>(), "{findings:?}");
        for (finding, (joint, truth)) in findings.iter().zip(hidden) {
            assert_eq!(finding["effect"], "rotor_inertia", "{joint}");
            let [value, std_dev] = ["value", "std_dev"].map(|f| finding["parameters"][0][f].as_f64().unwrap());
            // Four standard deviations: one in 16,000 by chance.
            assert!(
                (value - truth).abs() < 4.0 * std_dev,
                "{joint}: {value} ± {std_dev}, {truth} was hidden"
            );
        }
        assert_eq!(result["residual"]["verdict"], "explained");
    }
}

/// MuJoCo's own friction is named on the joints that show it, and nothing else is: level and lead (half of `dmax timeconst`)
/// within four standard deviations of what the simulator was given.
#[test]
fn val_friction_of_mujoco_is_named() {
    let folder = Folder::new("mujoco-friction");
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/mujoco");
    let arms = [
        ("three_soft", 0.018, [("J1", 1.2), ("J2", 1.0), ("J3", 0.5)]),
        ("four_plain", 0.0095, [("J1", 2.0), ("J3", 0.8), ("J4", 0.4)]),
        ("six_plain", 0.0095, [("J4", 0.6), ("J5", 0.5), ("J6", 0.3)]),
    ];
    for (name, lead, levels) in arms {
        let out = folder.file(&format!("{name}.json"));
        let [robot, log] = ["xml", "csv.gz"].map(|end| format!("{data}/{name}.{end}"));
        let output = run(&["identify", "--robot", &robot, "--log", &log, "--out", &out]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let result: Value = serde_json::from_str(&folder.read(&format!("{name}.json"))).unwrap();
        let residual = &result["residual"];
        assert_eq!(residual["verdict"], "explained", "{name}");
        let findings = residual["findings"].as_array().unwrap();
        assert_eq!(findings.len(), levels.len(), "{name}: {findings:?}");
        for (joint, level) in levels {
            let found = findings.iter().find(|f| f["joints"] == json!([joint]));
            let found = found.unwrap_or_else(|| panic!("{name}: nothing on {joint}"));
            assert_eq!(found["effect"], "smooth_coulomb_friction");
            for (parameter, truth) in [("amplitude", level), ("lead", lead)] {
                let all = found["parameters"].as_array().unwrap();
                let reported = all.iter().find(|p| p["name"] == parameter).expect("has it");
                let [value, deviation] = ["value", "std_dev"].map(|k| reported[k].as_f64().unwrap());
                assert!(
                    (value - truth).abs() < 4.0 * deviation,
                    "{name} {joint}: {parameter} {value} ± {deviation} for {truth}"
                );
            }
        }
    }
}
