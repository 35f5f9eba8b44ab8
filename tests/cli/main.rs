//! The program from the command line, end to end.

mod degenerate;
mod effects;
mod identify;
mod log_files;
#[path = "../support/mesh.rs"]
mod mesh;
mod operate;
mod own_effects;
mod robot_files;

use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_dynident");
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A folder of its own for one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        // Tests run side by side, and two may have the same name for it.
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("dynident-{name}-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_string()
    }

    fn write(&self, name: &str, content: &str) -> String {
        std::fs::write(self.0.join(name), content).unwrap();
        self.file(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn run(arguments: &[&str]) -> Output {
    Command::new(PROGRAM).args(arguments).current_dir(ROOT).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn quick() -> Value {
    json!({
        "robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50,
        "search": {"seed": 1, "starts": 2, "max_evaluations": 300}
    })
}

#[test]
fn excite_writes_the_result_and_the_trajectory() {
    let folder = Folder::new("excite");
    let request = folder.write("request.json", &quick().to_string());
    let (out, csv) = (folder.file("design.json"), folder.file("motion.csv"));
    let output = run(&[
        "excite",
        "--request",
        &request,
        "--out",
        &out,
        "--trajectory",
        &csv,
        "--rate-hz",
        "100",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("condition number"));
    assert_eq!(stderr(&output), "", "no bar of progress in a pipe");
    let design: Value = serde_json::from_str(&folder.read("design.json")).unwrap();
    assert!(design["condition_number"].as_f64().unwrap() >= 1.0);
    assert!(stdout(&output).contains("a recording of 2 periods is predicted to reveal"));
    let effects = design["detectable"]["effects"].as_array().unwrap();
    let offsets: Vec<&Value> = effects.iter().filter(|e| e["effect"] == "torque_offset").collect();
    assert_eq!(offsets.len(), 2, "{effects:?}");
    assert!(
        offsets
            .iter()
            .all(|o| o["unit"] == "N m" && o["size"].as_f64().unwrap() > 0.0)
    );
    assert_eq!(folder.read("motion.csv").lines().count(), 502);
    assert_eq!(
        std::fs::read_dir(&folder.0).unwrap().count(),
        3,
        "no half-written files are left"
    );
}

/// From rest at a pose into the motion, and back: continuous, and within the limits of the arm.
#[test]
fn a_trajectory_begins_and_ends_at_a_pose() {
    let folder = Folder::new("run-in");
    let mut document = quick();
    document["constraints"] = json!({"form": "exact", "start": "free"});
    let request = folder.write("request.json", &document.to_string());
    let excite = |more: &[&str]| {
        let (out, csv) = (folder.file("design.json"), folder.file("motion.csv"));
        let mut arguments = vec![
            "excite",
            "--request",
            &request,
            "--out",
            &out,
            "--trajectory",
            &csv,
            "--rate-hz",
            "200",
        ];
        arguments.extend(more);
        run(&arguments)
    };
    let output = excite(&["--periods", "2", "--from", "-1.2,0.9", "--run-out-s", "4"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let table = folder.read("motion.csv");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    let (first, last) = (&rows[0], rows.last().unwrap());
    for row in [first, last] {
        let rest = [-1.2, 0.9, 0.0, 0.0, 0.0, 0.0];
        row[1..]
            .iter()
            .zip(rest)
            .for_each(|(v, r)| assert!((v - r).abs() < 1e-9, "{row:?}"));
    }
    // Two periods of 5 s and 4 s at 200 Hz, and a run-in of at least a second.
    assert!(rows.len() > 2801 + 200 && (last[0] - (rows.len() - 1) as f64 / 200.0).abs() < 1e-9);
    let begun = rows.len() - 2801;
    assert_eq!(rows[begun][1..], rows[begun + 1000][1..]);
    for (k, pair) in rows.windows(2).enumerate() {
        for j in 0..2 {
            let state = |row: &[f64]| [row[1 + j], row[3 + j], row[5 + j]];
            let ([q0, v0, a0], [q1, v1, a1]) = (state(&pair[0]), state(&pair[1]));
            let h = 0.005;
            // Hermite's rule; the fourth derivative of these motions is below 10^3.
            let expected = h * (v0 + v1) / 2.0 + h * h * (a0 - a1) / 12.0;
            assert!((q1 - q0 - expected).abs() < 1e-8, "row {k}, joint {j}");
            assert!((v1 - v0 - h * (a0 + a1) / 2.0).abs() < 1e-4, "row {k}, joint {j}");
            assert!(q0.abs() < 2.618 && v0.abs() <= 2.0 && a0.abs() <= 10.0, "row {k}, joint {j}");
        }
    }
    for (more, words) in [
        (vec!["--from", "1,2,3"], "3 positions, and the robot has 2 joints"),
        (vec!["--from", "1,2.7"], "J2 at 2.7 is not within its limits"),
        (vec!["--from", "1,2", "--run-in-s", "0.02"], "in 0.02 s"),
    ] {
        let output = excite(&more);
        assert_ne!(output.status.code(), Some(0));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
}

#[test]
fn the_same_seed_and_evaluations_give_the_same_answer_whatever_the_threads() {
    let folder = Folder::new("repeat");
    let request = folder.write("request.json", &quick().to_string());
    let coefficients = |threads: &str| {
        let output = Command::new(PROGRAM)
            .args(["excite", "--request", &request])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        let design: Value = serde_json::from_slice(&output.stdout).unwrap();
        (design["coefficients"].clone(), design["search"]["evaluations"].clone())
    };
    let one = coefficients("1");
    assert!(one.1.as_u64().unwrap() > 0);
    assert_eq!(one, coefficients("3"));
}

#[test]
fn a_robot_file_replaces_the_robot_of_the_request() {
    let folder = Folder::new("robot");
    let mut document = quick();
    document["robot"] = Value::Null;
    let request = folder.write("request.json", &document.to_string());
    let robot = "examples/robots/planar_two_link.json";
    let output = run(&[
        "--json",
        "excite",
        "--robot",
        robot,
        "--request",
        &request,
        "--out",
        &folder.file("o.json"),
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let design: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(design["robot"], "Planar two-link arm");
    assert_eq!(design["request"]["robot"]["joints"][0]["name"], "J1");
}

#[test]
fn bad_input_exits_with_2_and_names_all_fields() {
    let folder = Folder::new("bad");
    let request = folder.write(
        "request.json",
        r#"{"robot": "iiwa14", "fourier": {"order": 0, "fundamental_hz": NaN}, "sample_rate_hz": 100}"#,
    );
    let output = run(&["excite", "--request", &request]);
    assert_eq!(output.status.code(), Some(2));
    let text = stderr(&output);
    assert!(text.starts_with("error[invalid_document]: "), "{text}");
    assert!(
        text.contains("/fourier/fundamental_hz: is NaN") && text.contains("/fourier/order: is 0"),
        "{text}"
    );
    let output = run(&["excite", "--json", "--request", &request]);
    let problem: Value = serde_json::from_str(&stderr(&output)).unwrap();
    assert_eq!(
        (&problem["code"], problem["errors"].as_array().unwrap().len()),
        (&json!("invalid_document"), 2)
    );
}

#[test]
fn files_that_are_not_there_and_wrong_usage_exit_with_2() {
    let missing = run(&["excite", "--request", "/nowhere/request.json"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("error[file_unreadable]: cannot read /nowhere/request.json"));
    assert_eq!(run(&["excite"]).status.code(), Some(2));
    assert_eq!(run(&["fly"]).status.code(), Some(2));
    let robot = run(&["base-parameters", "--robot", "iiwa70"]);
    assert_eq!(robot.status.code(), Some(2));
    for shipped in [
        "iiwa14",
        "iiwa7",
        "ur10",
        "ur3e",
        "ur5e",
        "ur10e",
        "fr3",
        "gen3",
        "lwr4",
        "panda",
        "tx40",
        "puma560",
        "scara",
        "planar_two_link",
    ] {
        assert!(stderr(&robot).contains(shipped), "{}", stderr(&robot));
    }
    let folder = Folder::new("unwritable");
    let request = folder.write("request.json", &quick().to_string());
    let unwritable = run(&["excite", "--request", &request, "--out", "/nowhere/out.json"]);
    assert_eq!(unwritable.status.code(), Some(2));
    assert!(stderr(&unwritable).contains("error[file_unwritable]"));
}

#[test]
fn an_infeasible_problem_is_an_outcome_and_exits_with_3() {
    let folder = Folder::new("infeasible");
    let mut document = quick();
    // Right at the upper limit: nowhere to go from there.
    document["constraints"] = json!({"start_position": [0, 2.6179938779914944]});
    let request = folder.write("request.json", &document.to_string());
    let output = run(&["excite", "--request", &request]);
    assert_eq!(output.status.code(), Some(3), "{} {}", stdout(&output), stderr(&output));
    let design: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(design["status"], "Infeasible");
    assert!(design["reason"].as_str().unwrap().contains("J2"));
    assert!(design["coefficients"].is_null() && design["condition_number"].is_null());
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_search_and_keeps_the_best() {
    let folder = Folder::new("interrupt");
    let mut document = quick();
    document["robot"] = json!("ur10");
    document["search"] = json!({"seed": 1, "time_limit_s": 300});
    let request = folder.write("request.json", &document.to_string());
    let out = folder.file("design.json");
    let mut child = Command::new(PROGRAM)
        .args(["excite", "--request", &request, "--out", &out])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Long enough for some local solves; the test does not depend on how many.
    std::thread::sleep(Duration::from_secs(5));
    let asked = Instant::now();
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    assert_eq!(status.code(), Some(4));
    let design: Value = serde_json::from_str(&folder.read("design.json")).unwrap();
    assert_eq!(design["status"], "Cancelled");
    assert!(design["condition_number"].as_f64().unwrap() > 1.0);
}

#[test]
fn base_parameters_are_printed_for_people_and_programs() {
    let output = run(&["base-parameters", "--robot", "examples/robots/iiwa14.urdf"]);
    assert!(
        stdout(&output).starts_with("iiwa14: 57 base parameters\n"),
        "{}",
        stdout(&output)
    );
    assert!(stdout(&output).contains("MYR2     [kg m]  MY2 + MZ3 + 0.42 (M3 + M4 + M5 + M6 + M7)\n"));
    let json = run(&["base-parameters", "--robot", "scara", "--json"]);
    let document: Value = serde_json::from_str(&stdout(&json)).unwrap();
    assert_eq!(document["count"], document["base_parameters"].as_array().unwrap().len());
}

#[test]
fn openapi_prints_the_document() {
    let document: Value = serde_json::from_str(&stdout(&run(&["openapi"]))).unwrap();
    assert!(document["paths"]["/excitation"]["post"].is_object());
}

#[test]
fn serve_refuses_an_address_that_is_taken() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = run(&["serve", "--listen", &address]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("error[address_unavailable]"), "{}", stderr(&output));
}

/// Designs for several robots, recomputed by a program that shares no code with this one.
#[test]
fn val_an_independent_program_agrees_with_the_designs() {
    let has_numpy = Command::new("python3").args(["-c", "import numpy"]).output();
    if !has_numpy.is_ok_and(|o| o.status.success()) {
        println!("SKIPPED val_an_independent_program_agrees_with_the_designs: python3 with numpy is not installed");
        return;
    }
    let folder = Folder::new("independent");
    let cases = [
        ("iiwa14", json!({"form": "paper", "start": "zero"}), 5, 0.1, 100),
        ("iiwa14", json!({"form": "exact", "start": "free"}), 5, 0.1, 100),
        ("ur10", json!({"form": "paper", "start": "zero"}), 4, 0.1, 50),
        ("scara", json!({"form": "exact", "start": "zero"}), 5, 0.5, 200),
        ("planar_two_link", json!({"form": "paper", "start": "free"}), 3, 0.2, 50),
    ];
    for (robot, constraints, order, fundamental, rate) in cases {
        let document = json!({
            "robot": robot, "fourier": {"order": order, "fundamental_hz": fundamental}, "sample_rate_hz": rate,
            "constraints": constraints, "search": {"seed": 1, "time_limit_s": 2}
        });
        let request = folder.write("request.json", &document.to_string());
        let out = folder.file("design.json");
        let robot_file = format!("examples/robots/{robot}.json");
        let output = run(&["excite", "--robot", &robot_file, "--request", &request, "--out", &out]);
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", stderr(&output));
        let check = Command::new("python3")
            .args(["examples/check_design.py", &robot_file, &out])
            .current_dir(ROOT)
            .output()
            .unwrap();
        assert!(
            check.status.success(),
            "{robot} {constraints}:\n{}{}",
            stdout(&check),
            stderr(&check)
        );
        assert!(stdout(&check).contains("all agree"));
    }
}

/// The virtual arm has a spring that nobody declares: the table names it, the pictures and the report show it.
#[test]
fn an_identification_is_a_table_pictures_and_a_report() {
    let folder = Folder::new("pictures");
    let simulation = json!({
        "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}},
        "periods": 4, "sample_rate_hz": 100, "noise": {"torque": [0.5, 0.3]}, "seed": 1,
        "effects": [{"effect": "joint_spring", "joint": "J2", "stiffness": 20.0, "rest": 0.1}]
    });
    let request = folder.write("simulation.json", &simulation.to_string());
    let log = folder.file("log.csv");
    assert!(
        run(&["simulate", "--robot", "planar_two_link", "--request", &request, "--out", &log])
            .status
            .success()
    );
    let (report, plots, result) = (folder.file("report.html"), folder.file("plots"), folder.file("result.json"));
    let output = run(&[
        "identify",
        "--robot",
        "planar_two_link",
        "--log",
        &log,
        "--out",
        &result,
        "--report",
        &report,
        "--plots",
        &plots,
        "--plot-format",
        "png",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let table = stdout(&output);
    for needed in [
        "residual: explained",
        "The residual on joint J2 is",
        "a joint spring explains it",
        "stiffness",
        "noise floor",
        "RMS error",
    ] {
        assert!(table.contains(needed), "{needed} not in\n{table}");
    }
    for name in [
        "errors",
        "before_after",
        "finding_1",
        "parameters_1",
        "torque_log1_joint1",
        "torque_log1_joint2",
    ] {
        let picture = std::fs::read(format!("{plots}/{name}.png")).unwrap();
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 2000, "{name}");
    }
    let page = folder.read("report.html");
    assert!(page.contains("Joint spring on J2") && page.contains("SHA-256") && page.ends_with("</html>\n"));
}

/// Rates of controllers, with periods and without: from 400 Hz on, rows are means over several samples.
#[test]
fn logs_of_every_rate_are_drawn_and_what_the_found_effects_predict_fits() {
    let folder = Folder::new("rates");
    for (rate, periods) in [100, 200, 500, 1000].into_iter().flat_map(|rate| [(rate, 3), (rate, 1)]) {
        let simulation = json!({
            "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}},
            "periods": periods, "sample_rate_hz": rate, "noise": {"torque": [0.05, 0.03]}, "seed": 1,
            "effects": [{"effect": "joint_spring", "joint": "J2", "stiffness": 20.0, "rest": 0.1}]
        });
        let case = format!("{rate}-{periods}");
        let request = folder.write(&format!("{case}.json"), &simulation.to_string());
        let [log, report, plots, result] =
            ["csv", "html", "plots", "result.json"].map(|end| folder.file(&format!("{case}.{end}")));
        let simulated = run(&["simulate", "--robot", "planar_two_link", "--request", &request, "--out", &log]);
        assert!(simulated.status.success(), "{}", stderr(&simulated));
        let output = run(&[
            "identify",
            "--robot",
            "planar_two_link",
            "--log",
            &log,
            "--out",
            &result,
            "--report",
            &report,
            "--plots",
            &plots,
        ]);
        assert!(output.status.success(), "{case}: {}", stderr(&output));
        assert!(
            std::fs::metadata(format!("{plots}/torque_log1_joint2.svg")).unwrap().len() > 2000,
            "{case}"
        );
        assert!(folder.read(&format!("{case}.html")).ends_with("</html>\n"), "{case}");
        let found: Value = serde_json::from_str(&folder.read(&format!("{case}.result.json"))).unwrap();
        let predictions = found["predictions"].as_array().unwrap();
        assert_eq!(predictions.len(), 2, "{case}");
        let numbers = |v: &Value| serde_json::from_value::<Vec<f64>>(v.clone()).unwrap();
        for (series, noise) in predictions.iter().zip([0.05, 0.03]) {
            let (measured, predicted) = (numbers(&series["measured"]), numbers(&series["base"]));
            // A log without periods is filtered, and has rows as its cut-off needs them.
            assert!(
                measured.len() > if periods > 1 { 400 } else { 100 },
                "{case}: {}",
                measured.len()
            );
            // The spring moves the second torque by some 20 N m, and predictions at other samples than their own by a tenth of
            // that. What is drawn keeps the peaks of the noise, so that its own mean square may be a few times that of all rows.
            let squares: f64 = measured.iter().zip(&predicted).map(|(m, p)| (m - p).powi(2)).sum();
            let rms = (squares / measured.len() as f64).sqrt();
            assert!(rms < 3.0 * noise, "{case}: {rms} beside a noise of {noise}");
        }
    }
}

/// A place where no picture can be written costs the picture: result and model are there.
#[test]
fn results_are_written_before_anything_is_drawn() {
    let folder = Folder::new("stored-first");
    let simulation = json!({
        "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}},
        "periods": 3, "sample_rate_hz": 100, "noise": {"torque": [0.05, 0.03]}, "seed": 1
    });
    let request = folder.write("simulation.json", &simulation.to_string());
    let log = folder.file("log.csv");
    assert!(
        run(&["simulate", "--robot", "planar_two_link", "--request", &request, "--out", &log])
            .status
            .success()
    );
    // A file in the place of the folder.
    let plots = folder.write("plots", "");
    let [out, model, report] = ["result.json", "model.json", "report.html"].map(|name| folder.file(name));
    let output = run(&[
        "identify",
        "--robot",
        "planar_two_link",
        "--log",
        &log,
        "--out",
        &out,
        "--model",
        &model,
        "--report",
        &report,
        "--plots",
        &plots,
    ]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("error[file_unwritable]: cannot make the folder"),
        "{}",
        stderr(&output)
    );
    let found: Value = serde_json::from_str(&folder.read("result.json")).unwrap();
    assert_eq!(found["quality"]["verdict"], "good");
    assert!(folder.read("model.json").contains("\"robot\"") && folder.read("report.html").ends_with("</html>\n"));
    assert!(stdout(&output).contains("RMS error"), "{}", stdout(&output));
}

#[test]
fn a_design_is_drawn_as_svg_or_png() {
    let folder = Folder::new("drawn");
    let request = folder.write("request.json", &quick().to_string());
    for (name, start) in [("motion.svg", &b"<svg"[..]), ("motion.png", &b"\x89PNG"[..])] {
        let (out, plot) = (folder.file("design.json"), folder.file(name));
        let output = run(&["excite", "--request", &request, "--out", &out, "--plot", &plot]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(std::fs::read(&plot).unwrap().starts_with(start), "{name}");
    }
}
