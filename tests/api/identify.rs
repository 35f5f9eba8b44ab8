//! Identification over HTTP.

use crate::server::{Answer, Server};
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::{Chain, Coulomb, inverse_dynamics_batch};
use dynident::parameters::Layout;
use dynident::simulate::{Experiment, HiddenEffect, Noise, simulate};
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::fmt::Write;

/// Two links of 3 kg and 1 kg with friction.
pub fn truth(layout: &Layout) -> Vec<f64> {
    let links = [
        [3.0, 0.6, 0.03, 0.0, 0.02, 0.0, 0.0, 0.2, 0.0, 0.2],
        [1.0, 0.2, -0.01, 0.0, 0.01, 0.0, 0.0, 0.06, 0.0, 0.06],
    ];
    let friction = [[0.3, 0.5], [0.1, 0.2]];
    (0..2)
        .flat_map(|k| {
            links[k]
                .into_iter()
                .chain(friction[k].into_iter().take(layout.per_link() - 10))
        })
        .collect()
}

/// A log of the planar arm: three periods of 5 s at 100 Hz, with a pseudo-random torque noise of ±0.01 N m.
pub fn log(phase: f64) -> String {
    log_at(phase, 100.0, 3.0)
}

/// The same at another rate, for as many periods.
pub fn log_at(phase: f64, rate_hz: f64, periods: f64) -> String {
    let robot = Shipped.named("planar_two_link").unwrap().robot;
    let layout = Layout::standard(&robot);
    let coefficient = |j: usize, l: usize, p: f64| 0.5 * (p + 1.3 * j as f64 + 2.1 * l as f64).sin();
    let series = FourierSeries {
        fundamental_hz: 0.2,
        a: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, phase)),
        b: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, phase + 1.0)),
        offset: vec![0.1, -0.2],
    };
    let motion = series.sample(rate_hz);
    let tau = inverse_dynamics_batch(&Chain::new(&robot), &layout, &truth(&layout), &motion, Coulomb::Sign);
    let mut text = "time,q1,q2,tau1,tau2\n".to_string();
    let of_period = (5.0 * rate_hz) as usize;
    for s in 0..(periods * 5.0 * rate_hz) as usize {
        let at = s % of_period;
        let noise = |j: usize| 0.01 * ((s * 7919 + j * 104_729) as f64 * 0.618).sin();
        let (q, t) = (
            |j: usize| motion.positions(j)[at],
            |j: usize| tau[j * motion.stride() + at] + noise(j),
        );
        writeln!(
            text,
            "{:.3},{:.9},{:.9},{:.7},{:.7}",
            s as f64 / rate_hz,
            q(0),
            q(1),
            t(0),
            t(1)
        )
        .unwrap();
    }
    text
}

fn multipart(parts: &[(&str, &str, &str)]) -> String {
    let mut body = String::new();
    for (name, file, content) in parts {
        let file = if file.is_empty() {
            String::new()
        } else {
            format!("; filename=\"{file}\"")
        };
        write!(
            body,
            "--XXboundary\r\nContent-Disposition: form-data; name=\"{name}\"{file}\r\n\r\n{content}\r\n"
        )
        .unwrap();
    }
    body + "--XXboundary--\r\n"
}

pub fn post(server: &Server, path: &str, wait: bool, parts: &[(&str, &str, &str)]) -> Answer {
    let mut headers = vec![("content-type", "multipart/form-data; boundary=XXboundary")];
    if wait {
        headers.push(("prefer", "wait=60"));
    }
    server.send("POST", path, &headers, &multipart(parts))
}

pub fn identify(server: &Server) -> Value {
    let request = json!({"robot": "planar_two_link", "prediction_points": 20}).to_string();
    let parts = [
        ("request", "", request.as_str()),
        ("log", "run.csv", &log(0.3)),
        ("validation", "other.csv", &log(2.0)),
    ];
    let answer = post(server, "/identify", true, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

/// The identification of a log in which the second joint of the planar arm moves a little and feels a constant torque, which a
/// spring would explain nearly as well.
pub fn simulated_log(server: &Server) -> Value {
    let robot = Shipped.named("planar_two_link").unwrap().robot;
    let layout = Layout::standard(&robot);
    let size = |j: usize| [0.6, 0.06][j];
    let coefficient = |j: usize, l: usize, p: f64| size(j) * (p + 1.3 * j as f64 + 2.1 * l as f64).sin();
    let series = FourierSeries {
        fundamental_hz: 0.2,
        a: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, 0.3)),
        b: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, 1.3)),
        offset: vec![0.1, 0.9],
    };
    let log = simulate(&Experiment {
        robot: &robot,
        parameters: &truth(&layout),
        trajectory: &series,
        periods: 6.0,
        rate_hz: 100.0,
        effects: &[HiddenEffect::TorqueOffset { joint: 1, offset: 0.05 }],
        noise: &Noise::white(vec![0.05, 0.02]),
        seed: 4,
    });
    let mut text = "time,q1,q2,tau1,tau2\n".to_string();
    for (s, t) in log.time.iter().enumerate() {
        writeln!(
            text,
            "{t},{},{},{},{}",
            log.q[0][s], log.q[1][s], log.tau[0][s], log.tau[1][s]
        )
        .unwrap();
    }
    let request = json!({"robot": "planar_two_link", "period_s": 5}).to_string();
    let parts = [("request", "", request.as_str()), ("log", "run.csv", &text)];
    let answer = post(server, "/identify", true, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

#[test]
fn an_uploaded_log_becomes_parameters_errors_and_a_report() {
    let server = Server::start();
    let found = identify(&server);
    assert_eq!(found["quality"]["verdict"], "good");
    let robot = Shipped.named("planar_two_link").unwrap().robot;
    let base = dynident::parameters::BaseParameters::exact(&robot);
    let expected = base.project(&truth(&Layout::standard(&robot)));
    for (c, parameter) in found["base_parameters"].as_array().unwrap().iter().enumerate() {
        let number = |key: &str| parameter[key].as_f64().unwrap();
        assert_eq!(parameter["name"], base.names[c]);
        // The noise is no Gaussian, but bounded by 0.01 N m: five of its deviations hold all of it.
        assert!((number("value") - expected[c]).abs() < 5.0 * number("std_dev"), "{parameter}");
    }
    assert_eq!(found["rms"]["validation"][0]["name"], "other.csv");
    for log in ["identification", "validation"] {
        for kind in ["base", "physical"] {
            assert!(
                found["rms"][log][0][kind]["rms"][0].as_f64().unwrap() < 0.012,
                "{}",
                found["rms"]
            );
        }
    }
    assert_eq!(found["log_report"][0]["rows"], 1500);
    assert_eq!(found["predictions"].as_array().unwrap().len(), 4);
    for margin in found["feasibility"]["margins"].as_array().unwrap() {
        assert!(margin["margin"].as_f64().unwrap() > -1e-9, "{margin}");
    }
}

#[test]
fn the_model_is_handed_out_and_validates_as_json_and_urdf() {
    let server = Server::start();
    let found = identify(&server);
    let id = found["id"].as_str().unwrap();
    let model = server.get(&format!("/identify/{id}/model"));
    assert_eq!(model.status, 200);
    let request = json!({"model": model.json()}).to_string();
    let answer = post(
        &server,
        "/validate",
        true,
        &[("request", "", &request), ("log", "other.csv", &log(2.0))],
    );
    assert_eq!(answer.status, 200, "{}", answer.text);
    let rms = &found["rms"]["validation"][0]["physical"]["rms"];
    for j in 0..2 {
        let difference = answer.json()["logs"][0]["rms"][j].as_f64().unwrap() - rms[j].as_f64().unwrap();
        assert!(difference.abs() < 1e-9, "{difference}");
    }
    let urdf = server.get(&format!("/identify/{id}/model?format=urdf"));
    assert_eq!(urdf.header("content-type"), Some("application/xml"));
    // The exported base is turned so that gravity points along -z, as a URDF has it.
    let request = json!({"model": {"urdf": urdf.text}}).to_string();
    let answer = post(
        &server,
        "/validate",
        true,
        &[("request", "", &request), ("log", "other.csv", &log(2.0))],
    );
    assert_eq!(answer.status, 200, "{}", answer.text);
    assert!((answer.json()["logs"][0]["rms"][0].as_f64().unwrap() - rms[0].as_f64().unwrap()).abs() < 1e-9);
    for (format, kind, words) in [
        ("mjcf", "application/xml", "<mujoco"),
        ("sdf", "application/xml", "<sdf"),
        ("csv", "text/csv; charset=utf-8", "kind,name"),
        ("c", "text/x-c; charset=utf-8", "_inverse_dynamics("),
        ("python", "text/x-python; charset=utf-8", "def inverse_dynamics"),
    ] {
        let file = server.get(&format!("/identify/{id}/model?format={format}"));
        assert_eq!((file.status, file.header("content-type")), (200, Some(kind)), "{format}");
        assert!(file.text.contains(words), "{format}: {}", file.text);
    }
    let xml = [("content-type", "application/xml")];
    let own = urdf.text.replace("<robot ", "<!-- mine --><robot ");
    let address = format!("/identify/{id}/model?base=base_link");
    let patched = server.send("POST", &address, &xml, &own);
    assert_eq!(patched.status, 200, "{}", patched.text);
    assert!(patched.text.contains("<!-- mine --><robot "), "{}", patched.text);
    // Its own base, turned as the export has it, has the same gravity at the first joint.
    let whole = server.send("POST", &format!("/identify/{id}/model"), &xml, &own);
    assert_eq!(whole.status, 200, "{}", whole.text);
    assert_eq!(server.get(&format!("/identify/{id}/model?format=step")).status, 400);
    assert_eq!(server.get(&format!("/excitation/{id}")).status, 404);
    assert_eq!(server.get("/identify/nothing").problem()["code"], "unknown_identification");
}

#[test]
fn without_prefer_the_answer_is_a_job_whose_result_is_found_later() {
    let server = Server::start();
    let request = json!({"robot": "planar_two_link"}).to_string();
    let answer = post(
        &server,
        "/identify",
        false,
        &[("request", "", &request), ("log", "run.csv", &log(0.3))],
    );
    assert_eq!(answer.status, 202);
    let job = answer.json();
    assert_eq!(job["kind"], "identification");
    let result = server.send("GET", job["links"]["result"].as_str().unwrap(), &[("prefer", "wait=60")], "");
    assert_eq!(result.status, 200);
    let job = server.get(job["links"]["self"].as_str().unwrap()).json();
    assert_eq!((&job["state"], &job["outcome"]), (&json!("finished"), &json!("Converged")));
}

#[test]
fn bad_requests_and_bad_logs_are_told_with_all_that_is_wrong() {
    let server = Server::start();
    let bad = json!({"robot": "planar_two_link", "period_s": -1, "estimater": "wls", "columns": {"torque": {"sign": [1, 2]}},
        "feasible": {"bounds": [{"link": 3, "mass": [2, 1]}]}});
    let errors = post(
        &server,
        "/identify",
        true,
        &[("request", "", &bad.to_string()), ("log", "a.csv", "x")],
    )
    .errors();
    let pointers: Vec<&str> = errors.iter().map(|e| e.split(':').next().unwrap()).collect();
    for expected in [
        "/estimater",
        "/period_s",
        "/columns/torque/sign/1",
        "/feasible/bounds/0/link",
        "/feasible/bounds/0/mass",
    ] {
        assert!(pointers.contains(&expected), "{expected} in {errors:?}");
    }
    let good = json!({"robot": "planar_two_link"}).to_string();
    let answer = post(
        &server,
        "/identify",
        true,
        &[("request", "", &good), ("log", "a.csv", "time,q1\n0,1\n")],
    );
    assert_eq!(answer.status, 422);
    assert_eq!(answer.problem()["code"], "invalid_log");
    let detail = answer.problem()["detail"].as_str().unwrap().to_string();
    assert!(
        detail.starts_with("a.csv, line 1:") && detail.contains("`q2`") && detail.contains("`tau1`"),
        "{detail}"
    );
    assert_eq!(post(&server, "/identify", true, &[("log", "a.csv", "x")]).status, 400);
    assert_eq!(post(&server, "/identify", true, &[("request", "", &good)]).status, 422);
    assert_eq!(
        post(&server, "/identify", true, &[("request", "", &good), ("lag", "a", "x")]).status,
        400
    );
    assert_eq!(server.post_json("/identify", &good).status, 415);
}

/// SHA-256 of two logs, as `sha256sum` prints it, and series that belong together sample by sample.
#[test]
fn a_result_says_where_it_comes_from_and_has_series_to_draw() {
    let server = Server::start();
    let found = identify(&server);
    let origin = &found["provenance"];
    assert_eq!(
        origin["request"],
        json!({"robot": "planar_two_link", "prediction_points": 20})
    );
    assert_eq!(origin["robot"]["joints"].as_array().unwrap().len(), 2);
    let logs = origin["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 2);
    assert_eq!(logs[0]["bytes"], log(0.3).len());
    assert_ne!(logs[0]["sha256"], logs[1]["sha256"]);
    let numbers = |value: &Value| serde_json::from_value::<Vec<f64>>(value.clone()).unwrap();
    for series in found["predictions"].as_array().unwrap() {
        let (time, measured) = (numbers(&series["time"]), numbers(&series["measured"]));
        assert!(time.len() <= 20 && time.len() > 10 && time.is_sorted(), "{series}");
        for model in ["base", "physical", "declared"] {
            let predicted = numbers(&series[model]);
            assert_eq!(predicted.len(), time.len());
            // Twice the bound of the noise: the model is that of the arm that made the log.
            let worst = predicted
                .iter()
                .zip(&measured)
                .map(|(p, m)| (p - m).abs())
                .fold(0.0f64, f64::max);
            assert!(worst < 0.02, "{model}: {worst}");
        }
        for state in ["q", "qd", "qdd"] {
            assert_eq!(numbers(&series[state]).len(), time.len());
        }
    }
}

#[test]
fn a_log_is_understood_before_it_is_used() {
    let server = Server::start();
    let request = json!({"robot": "planar_two_link"}).to_string();
    let turned: String = log(0.3)
        .lines()
        .enumerate()
        .map(|(i, line)| match line.rsplit_once(',') {
            Some((rest, tau)) if i > 0 => format!("{rest},{}\n", -tau.parse::<f64>().unwrap()),
            _ => format!("{line}\n"),
        })
        .collect();
    let parts = [
        ("request", "", request.as_str()),
        ("log", "run.csv", &log(0.3)),
        ("validation", "turned.csv", &turned),
    ];
    let answer = post(&server, "/identify/preview", false, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let seen = answer.json();
    let (good, wrong) = (&seen["logs"][0], &seen["logs"][1]);
    assert_eq!((good["rows"].as_u64(), good["periods"].as_u64()), (Some(1500), Some(3)));
    assert!((good["period_s"].as_f64().unwrap() - 5.0).abs() < 1e-9 && good["sample_rate_hz"].as_f64() == Some(100.0));
    assert_eq!(good["columns"]["position"], json!(["q1", "q2"]));
    assert_eq!(good["columns"]["torque"], json!(["tau1", "tau2"]));
    assert_eq!(good["faults"], json!([]));
    assert_eq!(good["joints"][1]["joint"], "J2");
    assert_eq!(
        (wrong["role"].as_str(), wrong["faults"][0]["code"].as_str()),
        (Some("validation"), Some("torque_sign"))
    );
    let bad = post(
        &server,
        "/identify/preview",
        false,
        &[("request", "", &request), ("log", "x.csv", "time,a,b\n1,2,3\n")],
    );
    assert_eq!(bad.problem()["code"], "invalid_log");
    assert!(
        server.get("/jobs").json()["jobs"].as_array().unwrap().is_empty(),
        "looking leaves nothing behind"
    );
}

#[test]
fn a_file_beside_the_log_is_previewed_with_it() {
    let server = Server::start();
    let columns = json!({"torque": {"headers": ["tau1", "tau2"], "file": "torques.csv"}});
    let request = json!({"robot": "planar_two_link", "columns": columns}).to_string();
    let whole = log(0.3);
    let heads: Vec<&str> = whole.lines().next().unwrap().split(',').collect();
    let part = |of_torque: bool| -> String {
        let chosen = |line: &str| -> Vec<String> {
            let cells = line
                .split(',')
                .zip(&heads)
                .filter(|(_, head)| head.starts_with("tau") == of_torque);
            cells.map(|(cell, _)| cell.to_string()).collect()
        };
        whole.lines().map(|line| chosen(line).join(",") + "\n").collect()
    };
    let (positions, torques) = (part(false), part(true));
    let parts = [
        ("request", "", request.as_str()),
        ("log", "run.csv", &positions),
        ("log", "torques.csv", &torques),
    ];
    let answer = post(&server, "/identify/preview", false, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let seen = answer.json();
    assert_eq!(seen["logs"].as_array().map(Vec::len), Some(1), "{seen}");
    assert_eq!(seen["logs"][0]["columns"]["torque"], json!(["tau1", "tau2"]));
    assert_eq!(seen["logs"][0]["columns"]["position"], json!(["q1", "q2"]));
    let alone = post(&server, "/identify/preview", false, &parts[..2]);
    assert_eq!(alone.problem()["code"], "invalid_log");
    assert!(alone.text.contains("torques.csv"), "{}", alone.text);
}

#[test]
fn the_report_is_one_file_with_all_that_is_needed() {
    let server = Server::start();
    let found = identify(&server);
    let page = server.get(&format!("/identify/{}/report", found["id"].as_str().unwrap()));
    assert_eq!(page.status, 200);
    assert!(page.header("content-type").unwrap().starts_with("text/html"));
    let hash = found["provenance"]["logs"][1]["sha256"].as_str().unwrap();
    for needed in [
        hash,
        "other.csv",
        "robot.json",
        "Margins of physical consistency",
        "<svg",
        "@media print",
    ] {
        assert!(page.text.contains(needed), "{needed}");
    }
    for outside in ["src=", "<script", "<link"] {
        assert!(!page.text.contains(outside), "{outside} reaches outside the file");
    }
    assert_eq!(
        server.get("/identify/nothing/report").problem()["code"],
        "unknown_identification"
    );
}
