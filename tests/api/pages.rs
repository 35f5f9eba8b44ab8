//! The pages and what they alone ask for.

use crate::server::{Server, quick_request};
use serde_json::json;

#[test]
fn every_page_has_its_modules_and_its_style() {
    let server = Server::start();
    for address in ["/", "/robot", "/design", "/identification", "/loop", "/runs", "/help"] {
        let page = server.get(address);
        assert_eq!(page.status, 200);
        assert!(page.header("content-type").unwrap().starts_with("text/html"));
        let policy = page.header("content-security-policy").unwrap();
        assert!(
            policy.contains("default-src 'none'") && policy.contains("script-src 'self'"),
            "{policy}"
        );
        let assets: Vec<&str> = page.text.split('"').filter(|part| part.starts_with("/assets/")).collect();
        assert!(assets.len() >= 5, "{assets:?}");
        for asset in assets {
            assert_eq!(server.get(asset).status, 200, "{asset} of {address}");
        }
        for outside in ["http://", "https://", "{title}", "{main}", "{name}"] {
            assert!(!page.text.contains(outside), "{outside} in {address}");
        }
    }
    assert_eq!(server.get("/assets/nothing.js").status, 404);
}

/// At an address where there is nothing, browsers get a page and programs a problem.
#[test]
fn a_wrong_address_is_a_page_for_browsers_and_a_problem_for_programs() {
    let server = Server::start();
    let page = server.send(
        "GET",
        "/identification/nothing/here",
        &[("accept", "text/html,*/*;q=0.8")],
        "",
    );
    assert_eq!(page.status, 404);
    assert!(page.header("content-type").unwrap().starts_with("text/html"));
    assert!(
        page.text.contains("Not found") && page.text.contains("/assets/missing.js"),
        "{}",
        page.text
    );
    assert!(!page.text.contains("{main}"));
    let problem = server.send("GET", "/identification/nothing/here", &[("accept", "*/*")], "");
    assert_eq!(problem.status, 404);
    assert_eq!(problem.header("content-type").unwrap(), "application/problem+json");
}

/// Every module that another one names is there, under that name.
#[test]
fn modules_find_each_other() {
    let server = Server::start();
    let mut open = vec![
        "header.js",
        "lab.js",
        "robot.js",
        "design.js",
        "identification.js",
        "loop.js",
        "runs.js",
        "help.js",
        "missing.js",
    ]
    .into_iter()
    .map(String::from)
    .collect::<Vec<_>>();
    let mut seen = Vec::new();
    while let Some(name) = open.pop() {
        let module = server.get(&format!("/assets/{name}"));
        assert_eq!(module.status, 200, "{name}");
        assert!(module.header("content-type").unwrap().starts_with("text/javascript"));
        let named = module
            .text
            .split("from './")
            .skip(1)
            .filter_map(|rest| rest.split('\'').next());
        open.extend(named.map(String::from).filter(|n| !seen.contains(n)).collect::<Vec<_>>());
        seen.push(name);
    }
    assert!(seen.iter().any(|n| n == "plot.js"));
}

#[test]
fn assets_are_sent_once_while_they_stay_the_same() {
    let server = Server::start();
    let first = server.get("/assets/plotly.js");
    assert!(first.text.len() > 4_000_000);
    let tag = first.header("etag").unwrap();
    let again = server.send("GET", "/assets/plotly.js", &[("if-none-match", tag)], "");
    assert_eq!((again.status, again.text.len()), (304, 0));
}

#[test]
fn a_designed_motion_is_drawn_within_its_limits() {
    let server = Server::start();
    let design = server.excite(&quick_request()).json();
    let trajectory =
        json!({"fundamental_hz": design["fundamental_hz"], "coefficients": design["coefficients"], "offset": design["offset"]});
    let request = json!({"robot": "planar_two_link", "trajectory": trajectory, "samples": 501});
    let drawn = server.post_json("/motion", &request.to_string());
    assert_eq!(drawn.status, 200, "{}", drawn.text);
    let drawn = drawn.json();
    for (j, joint) in drawn["joints"].as_array().unwrap().iter().enumerate() {
        let limit = joint["velocity_limit"].as_f64().unwrap();
        let velocities: Vec<f64> = serde_json::from_value(drawn["motion"]["qd"][j].clone()).unwrap();
        assert_eq!(velocities.len(), 501);
        let top = velocities.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        assert!(top > 0.2 * limit && top <= limit * (1.0 + 1e-12), "{top} of {limit}");
    }
    assert!(drawn["motion"]["torque"][0][0].is_number(), "the shipped arm has priors");
}

#[test]
fn a_wrong_motion_is_refused_by_field() {
    let server = Server::start();
    let answer = server.post_json("/motion", r#"{"robot": "planar_two_link", "trajectry": 1, "samples": 1}"#);
    assert_eq!(answer.status, 422);
    let errors = answer.errors();
    assert!(
        errors
            .iter()
            .any(|e| e.starts_with("/trajectry: ") && e.contains("trajectory")),
        "{errors:?}"
    );
    assert!(errors.iter().any(|e| e.starts_with("/samples: is 1")), "{errors:?}");
}
