//! Logs that hold nothing, or next to nothing: every one gets a verdict in words, and no number that is none.

use crate::{Folder, ROOT, run, stderr, stdout};
use flate2::read::GzDecoder;
use serde_json::{Value, json};
use std::io::Read;
use std::process::Output;

fn case(name: &str) -> String {
    format!("{ROOT}/tests/data/degenerate/{name}")
}

/// Exit status, standard error, table, document.
struct Identified {
    code: Option<i32>,
    error: String,
    table: String,
    document: Value,
}

/// What an identification says; whatever it is, no panic and no number that is none.
fn identified(folder: &Folder, log: &str, request: &Value) -> Identified {
    let request = folder.write("request.json", &request.to_string());
    let out = folder.file("result.json");
    let table: Output = run(&[
        "identify",
        "--robot",
        "planar_two_link",
        "--request",
        &request,
        "--log",
        log,
        "--out",
        &out,
    ]);
    let (error, text) = (stderr(&table), stdout(&table));
    assert!(matches!(table.status.code(), Some(0 | 2)), "{log}: {error}");
    assert!(!error.contains("panicked"), "{log}: {error}");
    for text in [&error, &text] {
        let numbers: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).collect();
        assert!(!numbers.iter().any(|w| ["NaN", "inf"].contains(w)), "{log}: {text}");
        let longest = text.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
        assert!(longest < 20, "{log}: a number of {longest} digits in {text}");
    }
    let document = match table.status.code() {
        Some(0) => serde_json::from_str(&folder.read("result.json")).unwrap(),
        _ => Value::Null,
    };
    Identified {
        code: table.status.code(),
        error,
        table: text,
        document,
    }
}

fn refused(folder: &Folder, log: &str, words: &[&str]) {
    let identified = identified(folder, log, &json!({}));
    assert_eq!(identified.code, Some(2), "{}", identified.table);
    for word in words {
        assert!(identified.error.contains(word), "`{word}` in {}", identified.error);
    }
}

#[test]
fn logs_of_nothing_are_refused_in_words() {
    let folder = Folder::new("nothing");
    refused(
        &folder,
        &case("n_const_tau.csv.gz"),
        &["no torque column can be used", "constant (1)"],
    );
    refused(&folder, &case("one_bad_row.csv.gz"), &["not rows of numbers", "line 2"]);
    refused(&folder, &case("n_still.csv.gz"), &["no joint moves"]);
}

#[test]
fn a_dead_torque_column_is_named_first_and_the_other_joint_is_not_affected() {
    let folder = Folder::new("dead");
    for (name, code, joint) in [
        ("one_const_tau", "bad_samples", 1),
        ("one_zero_tau", "bad_samples", 1),
        ("sy", "unit_unknown", 0),
    ] {
        let log = case(&format!("{name}.csv.gz"));
        let by = |estimator: &str| identified(&folder, &log, &json!({"estimator": estimator, "trace": false})).document;
        let (ols, wls, robust) = (by("ols"), by("wls"), by("robust"));
        let rms = |d: &Value, j: usize| d["rms"]["identification"][0]["base"]["rms"][j].clone();
        for found in [&ols, &wls, &robust] {
            assert!(rms(found, joint).is_null(), "{name}: {}", found["rms"]);
            assert_eq!(found["quality"]["rank"], ols["quality"]["rank"], "{name}");
        }
        let (a, b) = (rms(&ols, 1 - joint).as_f64().unwrap(), rms(&wls, 1 - joint).as_f64().unwrap());
        assert!((a - b).abs() < 1e-6 * a, "{name}: {a} {b}");
        let found = identified(&folder, &log, &json!({})).document;
        let name_of = ["J1", "J2"][joint];
        let first = &found["residual"]["data_faults"][0];
        assert_eq!(
            (&first["code"], &first["joints"]),
            (&json!(code), &json!([name_of])),
            "{name}: {first}"
        );
        assert_eq!(found["residual"]["not_tested"][0]["joint"], name_of, "{name}");
    }
}

#[test]
fn noise_is_said_to_be_explained_by_nothing_and_accuses_nobody() {
    let folder = Folder::new("noise");
    for seed in 0..3 {
        let identified = identified(&folder, &case(&format!("noise_seed{seed}.csv.gz")), &json!({}));
        assert_eq!(
            identified.document["quality"]["verdict"], "explains_nothing",
            "{}",
            identified.table
        );
        assert!(identified.table.contains("explains nothing"), "{}", identified.table);
        // The same is said where the result goes nowhere.
        let log = case(&format!("noise_seed{seed}.csv.gz"));
        let said = stdout(&run(&["identify", "--robot", "planar_two_link", "--log", &log]));
        assert_eq!(said, identified.table);
        let residual = &identified.document["residual"];
        for list in ["data_faults", "findings"] {
            assert!(residual[list].as_array().is_none_or(Vec::is_empty), "{residual}");
        }
        assert_eq!(residual["verdict"], "unexplained");
    }
}

#[test]
fn a_log_without_noise_has_a_floor_of_its_own_rounding() {
    let folder = Folder::new("noise-free");
    let found = identified(&folder, &case("noisefree_5digits.csv.gz"), &json!({})).document;
    for floor in found["residual"]["noise_floor"].as_array().unwrap() {
        assert!(floor.as_f64().unwrap() > 0.99 * 1e-5 / 12f64.sqrt(), "{floor}");
    }
}

#[test]
fn no_sign_is_accused_on_the_clean_log_of_an_arm_without_friction() {
    let folder = Folder::new("frictionless");
    let (robot, log, out) = (
        case("frictionless_6r.urdf"),
        folder.file("log.csv"),
        folder.file("result.json"),
    );
    let made = run(&[
        "simulate",
        "--robot",
        &robot,
        "--request",
        &case("frictionless_sim.json"),
        "--out",
        &log,
    ]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    let found = run(&["identify", "--robot", &robot, "--log", &log, "--out", &out]);
    assert_eq!(found.status.code(), Some(0), "{}", stderr(&found));
    let document: Value = serde_json::from_str(&folder.read("result.json")).unwrap();
    let faults = &document["residual"]["data_faults"];
    assert!(faults.as_array().is_none_or(Vec::is_empty), "{faults}");
}

#[test]
fn a_simulation_request_of_wrong_types_is_refused_at_the_field() {
    let folder = Folder::new("wrong-types");
    let good =
        json!({"trajectory": {"fourier": {"fundamental_hz": 0.5, "a": [[0.1], [0.2]], "b": [[0.1], [0.2]], "offset": [0, 0]}}});
    for (pointer, value) in [
        ("/noise", json!({"torque": 0.1})),
        ("/noise/torque", json!([0.1, "x"])),
        ("/periods", json!("three")),
        ("/seed", json!(-1)),
        ("/trajectory", json!(null)),
        ("/trajectory", json!({"fourier": null})),
        ("/trajectory/fourier/a/1", json!({"no": "list"})),
        ("/trajectory/fourier/fundamental_hz", json!([0.5])),
    ] {
        let mut document = good.clone();
        document["noise"] = json!({"torque": [0.1, 0.1]});
        match document.pointer_mut(pointer) {
            Some(at) => *at = value.clone(),
            None => document[&pointer[1..]] = value.clone(),
        }
        let request = folder.write("request.json", &document.to_string());
        let refused = run(&["simulate", "--robot", "planar_two_link", "--request", &request]);
        assert_eq!(refused.status.code(), Some(2), "{}", stderr(&refused));
        assert!(
            stderr(&refused).contains(&format!("  {pointer}")),
            "{value} at {pointer}: {}",
            stderr(&refused)
        );
    }
}

/// The rows of a good log: time, two positions, two torques.
fn good_rows() -> Vec<[f64; 5]> {
    let mut text = String::new();
    GzDecoder::new(std::fs::File::open(case("n_ok.csv.gz")).unwrap())
        .read_to_string(&mut text)
        .unwrap();
    let row = |line: &str| -> [f64; 5] {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        values.try_into().unwrap()
    };
    text.lines().skip(1).map(row).collect()
}

fn log_of(folder: &Folder, rows: impl Iterator<Item = [String; 5]>) -> String {
    let lines: Vec<String> = rows.map(|r| r.join(",")).collect();
    folder.write("generated.csv", &format!("time,q1,q2,tau1,tau2\n{}\n", lines.join("\n")))
}

fn plain(row: [f64; 5]) -> [String; 5] {
    row.map(|v| format!("{v:e}"))
}

#[test]
fn prop_torques_of_any_scale_have_a_verdict() {
    let folder = Folder::new("scales");
    let good = good_rows();
    let scaled = |one: f64, other: f64| {
        let log = log_of(
            &folder,
            good.iter().map(|&[t, a, b, x, y]| plain([t, a, b, x * one, y * other])),
        );
        identified(&folder, &log, &json!({}))
    };
    let plain_verdict = scaled(1.0, 1.0).document["quality"]["verdict"].clone();
    for exponent in [-150, -60, -12, -6, -3, 3, 6, 12, 60, 150] {
        let factor = 10f64.powi(exponent);
        let both = scaled(factor, factor);
        match exponent.abs() <= 6 {
            // Prior parameters can show that the torques are too small for the arm.
            true => {
                let verdict = &both.document["quality"]["verdict"];
                let fault = &both.document["residual"]["data_faults"][0]["code"];
                let too_small = exponent < 0 && verdict == "data_fault" && fault == "gravity_compensated_torque";
                assert!(too_small || *verdict == plain_verdict, "1e{exponent}: {verdict}, {fault}");
            }
            false => assert!(
                both.code == Some(2) && both.error.contains("no torque of a joint"),
                "1e{exponent}: {}",
                both.error
            ),
        }
        let one = scaled(1.0, factor);
        assert_eq!(one.code, Some(0), "1e{exponent}: {}", one.error);
        if exponent.abs() > 12 {
            assert_eq!(
                one.document["residual"]["data_faults"][0]["joints"],
                json!(["J2"]),
                "1e{exponent}"
            );
        }
    }
}

#[test]
fn prop_logs_of_any_length_rate_and_number_of_digits_have_a_verdict() {
    let folder = Folder::new("shapes");
    let good = good_rows();
    for rows in [0, 1, 2, 7, 8, 15, 16, 17, 20, 33, 60, 120, 250, 499, 501] {
        let log = log_of(&folder, good.iter().take(rows).map(|&r| plain(r)));
        let identified = identified(&folder, &log, &json!({}));
        assert!(identified.code == Some(0) || !identified.error.is_empty(), "{rows}");
    }
    for rate in [25.0, 40.0, 333.0, 1000.0] {
        let log = log_of(
            &folder,
            good.iter()
                .enumerate()
                .map(|(s, &[_, a, b, x, y])| plain([s as f64 / rate, a, b, x, y])),
        );
        assert_eq!(identified(&folder, &log, &json!({})).code, Some(0), "{rate} Hz");
    }
    for digits in [0, 1, 2, 3, 6] {
        let rounded = |v: f64| format!("{v:.digits$}");
        let log = log_of(
            &folder,
            good.iter()
                .map(|&[t, a, b, x, y]| [t.to_string(), a.to_string(), b.to_string(), rounded(x), rounded(y)]),
        );
        let identified = identified(&folder, &log, &json!({}));
        assert_eq!(identified.code, Some(0), "{digits} digits: {}", identified.error);
        let faults = &identified.document["residual"]["data_faults"];
        assert!(faults.as_array().is_none_or(Vec::is_empty), "{digits} digits: {faults}");
    }
    for (method, average) in [
        ("fourier_fit", true),
        ("parallel_filter", true),
        ("parallel_filter", false),
        ("paper", true),
    ] {
        for name in ["noisefree_5digits", "one_zero_tau", "sy", "noise_seed0"] {
            let request = json!({"preprocess": {"method": method, "average": average}, "feasible": {"method": "none"}});
            identified(&folder, &case(&format!("{name}.csv.gz")), &request);
        }
    }
}

/// A joint that stands still takes no part: no fault, no error that is none, no body of a billion tonnes.
#[test]
fn motions_of_single_joints_are_validated_for_what_moves() {
    let folder = Folder::new("single");
    let good = good_rows();
    let model = folder.file("model.json");
    let made = run(&[
        "identify",
        "--robot",
        "planar_two_link",
        "--log",
        &case("n_ok.csv.gz"),
        "--model",
        &model,
    ]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    for joint in 0..2 {
        let held = |mut row: [f64; 5]| {
            row[1 + joint] = 0.3;
            row
        };
        let log = log_of(&folder, good.iter().map(|&r| plain(held(r))));
        let out = folder.file("validated.json");
        let found = run(&["validate", "--model", &model, "--log", &log, "--out", &out]);
        assert_eq!(found.status.code(), Some(0), "{}", stderr(&found));
        let document: Value = serde_json::from_str(&folder.read("validated.json")).unwrap();
        let rms = &document["logs"][0]["rms"];
        assert!(
            rms[joint].is_null() && rms[1 - joint].as_f64().is_some_and(f64::is_finite),
            "{document}"
        );
        assert!(!stdout(&found).contains("NaN"));
        let residual = &document["residual"];
        let accused = residual["data_faults"].as_array().into_iter().flatten();
        assert!(
            accused
                .clone()
                .all(|f| f["code"] != "torque_sign" && f["code"] != "bad_samples"),
            "{residual}"
        );
        for parameter in residual["findings"]
            .as_array()
            .into_iter()
            .flatten()
            .flat_map(|f| f["parameters"].as_array().cloned().unwrap())
        {
            assert!(parameter["value"].as_f64().is_some_and(|v| v.abs() < 1e6), "{parameter}");
        }
    }
}
