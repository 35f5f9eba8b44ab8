//! Effects with formulas of one's own, from the command line: found, declared, exported, validated, and refused.

use crate::identify::{robot, trajectory};
use crate::{Folder, run, stderr, stdout};
use serde_json::{Value, json};

/// A log of the arm with a spring of 1.5 N·m/rad on the second joint, at rest at 0.2 rad.
fn simulate(folder: &Folder, robot: &str, name: &str, phase: f64, seed: u64) -> String {
    let request = json!({"trajectory": trajectory(phase), "periods": 3, "sample_rate_hz": 100, "seed": seed,
        "noise": {"torque": [0.01, 0.01]}, "effects": [{"effect": "joint_spring", "joint": "J2", "stiffness": 1.5, "rest": 0.2}]});
    let request = folder.write(&format!("{name}.json"), &request.to_string());
    let out = folder.file(&format!("{name}.csv"));
    let output = run(&["simulate", "--robot", robot, "--request", &request, "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    out
}

fn hose(declared: bool) -> Value {
    json!({"name": "hose", "joint": "J2", "expression": "k*q_J2 + c", "declared": declared,
        "parameters": [{"name": "k", "unit": "N m/rad", "low": 0}, {"name": "c", "unit": "N m"}]})
}

/// The values of an effect of an answer, within four deviations of the spring's.
fn assert_spring(effect: &Value) {
    for (name, truth) in [("k", 1.5), ("c", -0.3)] {
        let parameters = effect["parameters"].as_array().unwrap();
        let p = parameters.iter().find(|p| p["name"] == name).unwrap();
        let [value, std_dev] = ["value", "std_dev"].map(|f| p[f].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * std_dev && std_dev < 0.1, "{p}");
    }
}

#[test]
fn a_candidate_is_found_with_its_formula_and_a_declared_effect_is_in_the_model() {
    let folder = Folder::new("own");
    let truth = robot(&folder);
    let (log, other) = (
        simulate(&folder, &truth, "run", 0.3, 1),
        simulate(&folder, &truth, "other", 2.0, 2),
    );
    let [out, model] = ["result.json", "model.json"].map(|n| folder.file(n));
    let identify = |robot: &str, request: Value| -> Value {
        let request = folder.write("request.json", &request.to_string());
        let mut arguments = vec!["identify", "--robot", robot, "--request", &request, "--log", &log];
        arguments.extend(["--validation", &other, "--out", &out, "--model", &model]);
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_str(&folder.read("result.json")).unwrap()
    };
    let found = identify(&truth, json!({"effects": [hose(false)]}));
    let finding = &found["residual"]["findings"][0];
    assert_eq!(
        (&finding["effect"], &finding["in_model"]),
        (&json!("hose"), &json!(true)),
        "{}",
        found["residual"]
    );
    assert_spring(finding);
    assert_eq!(finding["law"]["expression"], "k*q2 + c");
    assert_eq!(
        (&finding["law"]["energy"], &finding["law"]["variables"]),
        (&Value::Null, &json!(["q2"]))
    );
    assert!(
        finding["law"]["mathml"][0].as_str().unwrap().starts_with("<math>"),
        "{finding}"
    );
    assert!(
        finding["sentence"]
            .as_str()
            .unwrap()
            .contains("the own effect hose, k*q2 + c on J2"),
        "{finding}"
    );
    assert_eq!(
        (&found["effects"][0]["effect"], &found["effects"][0]["declared"]),
        (&json!("hose"), &json!(false))
    );
    // In the robot's document, without a search.
    let mut described: Value = serde_json::from_str(&folder.read("truth.json")).unwrap();
    described["effects"] = json!([hose(true)]);
    let described = folder.write("described.json", &described.to_string());
    let declared = identify(&described, json!({"trace": false}));
    let effect = &declared["effects"][0];
    assert_eq!(
        (&effect["declared"], &effect["in_model"], &effect["finding"]),
        (&json!(true), &json!(true), &json!(false))
    );
    assert_spring(effect);
    assert_eq!(effect["law"]["expression"], "k*q2 + c");
    // The model has it: predictions, other formats, and what they lack.
    let output = run(&["--json", "validate", "--model", &model, "--log", &other]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let validated: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(validated["effects"][0]["effect"], "hose");
    for joint in 0..2 {
        let rms = validated["logs"][0]["rms"][joint].as_f64().unwrap();
        assert!((rms - 0.01).abs() < 0.001, "{rms}");
    }
    assert_eq!(
        validated["residual"]["verdict"], "nothing_missing",
        "{}",
        validated["residual"]
    );
    let [c, urdf, table] = ["out.c", "out.urdf", "out.csv"].map(|n| folder.file(n));
    let output = run(&["model", &model, "--out", &c, &urdf, &table]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let source = folder.read("out.c");
    assert!(source.contains("hose on J2") && source.contains("*q[1] + ("), "{source}");
    assert!(
        stderr(&output).contains("hose on J2 is not in this file"),
        "{}",
        stderr(&output)
    );
    assert!(folder.read("out.csv").contains("hose.k"), "{}", folder.read("out.csv"));
}

#[test]
fn what_is_wrong_with_own_effects_is_said_at_once_and_at_its_place() {
    let folder = Folder::new("own-wrong");
    let truth = robot(&folder);
    let log = simulate(&folder, &truth, "run", 0.3, 1);
    let fails = |robot: &str, request: Value, words: &[&str]| {
        let request = folder.write("request.json", &request.to_string());
        let output = run(&["identify", "--robot", robot, "--request", &request, "--log", &log]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        for word in words {
            assert!(stderr(&output).contains(word), "`{word}` in {}", stderr(&output));
        }
        assert!(!stderr(&output).contains("NaN"), "{}", stderr(&output));
    };
    let mut wrong = hose(false);
    wrong["parameters"][0]["unit"] = json!("N");
    let mut unknown = hose(false);
    unknown["expression"] = json!("k*q3 + c");
    unknown["joint"] = json!("J7");
    unknown["colour"] = json!("red");
    let deep = format!("k*{}q2{}", "(".repeat(100_000), ")".repeat(100_000));
    let nested = json!({"name": "deep", "joint": "J1", "expression": deep, "parameters": [{"name": "k", "unit": "N m"}]});
    let effects = json!([wrong, unknown, {"name": "torque_gain", "joint": "J1"}, nested]);
    fails(
        &truth,
        json!({"effects": effects, "period_s": 0}),
        &[
            "/effects/0/parameters/0/unit",
            "N m would fit",
            "/effects/1/name",
            "the name of another own effect",
            "/effects/1/colour",
            "/effects/1/joint",
            "one of: J1, J2",
            "/effects/1/expression",
            "`q3` is neither a variable",
            "/effects/2/expression: is missing",
            "/effects/2/parameters: is missing",
            "/effects/3/expression",
            "characters",
            "/period_s",
        ],
    );
    let many: Vec<Value> = (0..33).map(|i| json!({"name": format!("e{i}")})).collect();
    fails(&truth, json!({"effects": many}), &["/effects", "the most accepted is 32"]);
    let mut described: Value = serde_json::from_str(&folder.read("truth.json")).unwrap();
    described["effects"] = json!([hose(true)]);
    let text = described.to_string();
    fails(
        &folder.write("described.json", &text),
        json!({"effects": [hose(false)]}),
        &["/effects/0/name", "robot"],
    );
    described["effects"][0]["expression"] = json!("sin(k)*q2 + 3");
    fails(
        &folder.write("described.json", &described.to_string()),
        json!({}),
        &["/effects/0/expression", "multiply it with a factor"],
    );
    for (expression, words) in [
        ("k*q2 + c*sqrt(q2 - 10)", "no value"),
        ("k*q2 + c/(q1 - q1)", "the value inf"),
    ] {
        let mut none = hose(false);
        none["expression"] = json!(expression);
        fails(
            &truth,
            json!({"effects": [none]}),
            &["invalid_log", "`hose`", words, "where q", "no division by zero"],
        );
    }
}

/// Effects by their names, from files; without a file there is no catalogue.
#[test]
fn requests_and_robots_name_effects_of_files() {
    let folder = Folder::new("catalogue");
    let truth = robot(&folder);
    let log = simulate(&folder, &truth, "run", 0.3, 1);
    let mut spring = hose(true);
    spring.as_object_mut().unwrap().remove("joint");
    spring["expression"] = json!("k*q + c");
    let one = folder.write("one.json", &spring.to_string());
    let listed = folder.write(
        "listed.json",
        &json!({"effects": [{"name": "hose", "mathml": null, "definition": spring}]}).to_string(),
    );
    let request = folder.write(
        "named.json",
        &json!({"trace": false, "effects": [{"use": "hose", "joint": "J2"}]}).to_string(),
    );
    let out = folder.file("named-result.json");
    let identify = |robot: &str, request: &str, more: &[&str]| {
        let arguments = [
            "identify",
            "--robot",
            robot,
            "--request",
            request,
            "--log",
            &log,
            "--out",
            &out,
        ];
        run(&[&arguments, more].concat())
    };
    for file in [&one, &listed] {
        let output = identify(&truth, &request, &["--effects", file]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let found: Value = serde_json::from_str(&folder.read("named-result.json")).unwrap();
        assert_spring(&found["effects"][0]);
        assert_eq!(found["provenance"]["request"]["effects"][0]["joint"], "J2");
    }
    // A robot that names it.
    let mut described: Value = serde_json::from_str(&folder.read("truth.json")).unwrap();
    described["effects"] = json!([{"use": "hose", "joint": "J2"}]);
    let robot = folder.write("names.json", &described.to_string());
    let plain = folder.write("plain.json", &json!({"trace": false}).to_string());
    let output = identify(&robot, &plain, &["--effects", &one]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let found: Value = serde_json::from_str(&folder.read("named-result.json")).unwrap();
    assert_spring(&found["effects"][0]);
    assert_eq!(run(&["robot", &robot, "--effects", &one]).status.code(), Some(0));
    let bare = identify(&truth, &request, &[]);
    assert_eq!(bare.status.code(), Some(2));
    assert!(
        stderr(&bare).contains("/effects/0/use: is `hose`, and there is no catalogue of effects here")
            && stderr(&bare).contains("--effects FILE"),
        "{}",
        stderr(&bare)
    );
    let bad = folder.write("bad.json", &json!([spring, spring, {"name": "x"}]).to_string());
    let refused = identify(&truth, &request, &["--effects", &bad]);
    let said = stderr(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    for part in [
        "bad.json",
        "/1/name: `hose` is the name of another effect",
        "/2/expression: is missing",
    ] {
        assert!(said.contains(part), "{part} not in {said}");
    }
}
