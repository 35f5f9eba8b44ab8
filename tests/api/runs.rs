//! Names and notes of jobs, lists of some of them, and jobs that are forgotten.

use crate::queue::wait_until;
use crate::server::{Server, long_request, quick_request};
use serde_json::{Value, json};

fn patch(server: &Server, id: &str, body: &Value) -> crate::server::Answer {
    server.send(
        "PATCH",
        &format!("/jobs/{id}"),
        &[("content-type", "application/json")],
        &body.to_string(),
    )
}

fn ids(server: &Server, query: &str) -> Vec<String> {
    let answer = server.get(&format!("/jobs{query}"));
    assert_eq!(answer.status, 200, "{query}: {}", answer.text);
    let jobs = answer.json()["jobs"].as_array().unwrap().clone();
    jobs.iter().map(|j| j["id"].as_str().unwrap().to_string()).collect()
}

/// Finished designs, each with a seed of its own.
fn designs(server: &Server, count: u64) -> Vec<String> {
    let one = |seed: u64| {
        let mut request = quick_request();
        request["search"] = json!({"seed": seed, "starts": 1, "max_evaluations": 50});
        server.excite(&request).json()["id"].as_str().unwrap().to_string()
    };
    (0..count).map(one).collect()
}

#[test]
fn a_job_is_named_described_and_found_again() {
    let server = Server::start();
    let made = designs(&server, 3);
    let first = &made[0];
    let named = patch(&server, first, &json!({"name": " Monday 50% ", "note": "new grease\nin A2"}));
    assert_eq!(named.status, 200, "{}", named.text);
    assert_eq!(
        (&named.json()["name"], &named.json()["note"]),
        (&json!("Monday 50%"), &json!("new grease\nin A2"))
    );
    assert_eq!(server.get(&format!("/jobs/{first}")).json()["name"], "Monday 50%");
    // What is left out stays; null takes away.
    assert_eq!(patch(&server, first, &json!({"note": null})).json()["name"], "Monday 50%");
    assert_eq!(server.get(&format!("/jobs/{first}")).json()["note"], Value::Null);
    patch(&server, &made[1], &json!({"name": "Tuesday 507"}));
    assert_eq!(ids(&server, "?search=monday"), std::slice::from_ref(first));
    // What means something in a pattern stands for itself.
    assert_eq!(ids(&server, "?search=50%25"), std::slice::from_ref(first));
    assert_eq!(ids(&server, "?search=_").len(), 3, "the name of the robot has one");
    assert_eq!(ids(&server, "?search='%20OR%201=1"), Vec::<String>::new());
    assert_eq!(ids(&server, &format!("?search={}", &made[2][..8])), [made[2].clone()]);
    assert_eq!(ids(&server, "?kind=identification"), Vec::<String>::new());
    assert_eq!(ids(&server, "?kind=excitation&state=finished&robot=planar_two_link").len(), 3);
    assert_eq!(ids(&server, "?robot=iiwa14"), Vec::<String>::new());
}

#[test]
fn a_list_of_some_goes_on_with_its_conditions() {
    let server = Server::start();
    let made = designs(&server, 4);
    for id in &made[..3] {
        patch(&server, id, &json!({"name": "a & b"}));
    }
    let mut address = "/jobs?limit=1&search=a%20%26%20b&state=finished".to_string();
    let mut found = Vec::new();
    for _ in 0..5 {
        let page = server.get(&address).json();
        found.extend(
            page["jobs"]
                .as_array()
                .unwrap()
                .iter()
                .map(|j| j["id"].as_str().unwrap().to_string()),
        );
        let Some(next) = page["next"].as_str() else { break };
        address = next.to_string();
    }
    assert_eq!(found, [made[2].clone(), made[1].clone(), made[0].clone()]);
}

#[test]
fn what_is_wrong_with_a_description_is_named() {
    let server = Server::start();
    let id = &designs(&server, 1)[0];
    let wrong = patch(&server, id, &json!({"name": 5, "note": "x".repeat(10_001), "title": "t"}));
    assert_eq!(wrong.status, 422);
    let errors = wrong.errors();
    for pointer in ["/name: ", "/note: ", "/title: "] {
        assert!(errors.iter().any(|e| e.starts_with(pointer)), "{pointer} in {errors:?}");
    }
    assert_eq!(patch(&server, id, &json!([])).status, 422);
    assert_eq!(
        patch(&server, "nothing", &json!({"name": "x"})).problem()["code"],
        "unknown_job"
    );
    for query in ["?kind=dance", "?state=over", &format!("?search={}", "x".repeat(201))] {
        assert_eq!(
            server.get(&format!("/jobs{query}")).problem()["code"],
            "invalid_query",
            "{query}"
        );
    }
}

#[test]
fn an_ended_job_is_forgotten_with_its_result_and_a_running_one_is_not() {
    let server = Server::start();
    let id = &designs(&server, 1)[0];
    assert_eq!(
        server.delete(&format!("/jobs/{id}")).status,
        200,
        "cancelling what has ended changes nothing"
    );
    assert_eq!(server.get(&format!("/excitation/{id}")).status, 200);
    assert_eq!(server.delete(&format!("/jobs/{id}?forget=true")).status, 204);
    assert_eq!(server.get(&format!("/excitation/{id}")).status, 404);
    assert_eq!(
        server.delete(&format!("/jobs/{id}?forget=true")).problem()["code"],
        "unknown_job"
    );
    let running = server.post_json("/excitation", &long_request().to_string()).json()["id"]
        .as_str()
        .unwrap()
        .to_string();
    let job = format!("/jobs/{running}");
    // One that still waits for its turn ends at once.
    wait_until(|| server.get(&job).json()["state"] == "running");
    assert_eq!(server.delete(&format!("{job}?forget=true")).status, 409);
    assert_eq!(server.delete(&job).status, 202);
}
