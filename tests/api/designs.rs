//! Designs that go on from what the server has: models, data, earlier trajectories.

use crate::identify::{identify, simulated_log};
use crate::server::{Server, quick_request};
use serde_json::{Value, json};

fn problems(answer: &crate::server::Answer) -> Vec<String> {
    let list = answer.problem()["errors"].as_array().cloned().unwrap_or_default();
    list.iter().map(|e| e["pointer"].as_str().unwrap().to_string()).collect()
}

/// An identification of the recording has the declared effects of the robot: what they imitate is seen no more, what they do not
/// is seen as before.
#[test]
fn declared_own_effects_of_the_robot_belong_to_what_a_recording_reveals() {
    let server = Server::start();
    let mut request = quick_request();
    let mut robot = server.get("/robots/planar_two_link").json();
    let mut assessed = |effects: serde_json::Value| {
        robot["effects"] = effects;
        request["robot"] = robot.clone();
        let answer = server.excite(&request);
        assert_eq!(answer.status, 200, "{}", answer.text);
        let list = answer.json()["detectable"]["effects"].as_array().unwrap().clone();
        move |effect: &str, joint: &str| {
            let found = list.iter().find(|e| e["effect"] == effect && e["joints"] == json!([joint]));
            found.unwrap_or_else(|| panic!("{effect} on {joint}")).clone()
        }
    };
    let spring = |declared: bool| {
        json!([{"name": "hose", "joint": "J2", "expression": "k*q + c", "declared": declared,
        "parameters": [{"name": "k", "unit": "N m/rad"}, {"name": "c", "unit": "N m"}]}])
    };
    let without = assessed(json!([]));
    assert!(without("joint_spring", "J2")["size"].as_f64().unwrap() > 0.0);
    // The size of a listed spring is that with its rest in the middle of the travel. The k of the formula comes alone, with its
    // rest at zero: where the travel is not around zero it adds a mean torque, which can be seen too, so that less of it is
    // needed.
    let candidate = assessed(spring(false));
    let [own, listed] = [candidate("hose", "J2"), candidate("joint_spring", "J2")].map(|e| e["size"].as_f64().unwrap());
    assert!((0.5..1.02).contains(&(own / listed)), "{own} and {listed}");
    assert_eq!(candidate("hose", "J2")["unit"], "N m/rad");
    let declared = assessed(spring(true));
    assert_eq!(declared("joint_spring", "J2")["hidden"], "absorbed");
    assert_eq!(declared("torque_offset", "J2")["hidden"], "absorbed");
    let [before, after] = [&without, &declared].map(|of| of("joint_spring", "J1")["size"].as_f64().unwrap());
    assert!(after >= before && after < 3.0 * before, "{before} and {after}");
}

#[test]
fn a_design_goes_on_from_data_and_designs_by_their_ids() {
    let server = Server::start();
    let identification = identify(&server)["id"].clone();
    let first = server.excite(&quick_request()).json();
    let mut request = quick_request();
    request.as_object_mut().unwrap().remove("robot");
    request["model"] = json!({"identification": identification});
    request["criterion"] = json!("recommended");
    request["fourier"] = json!({"order": 3, "fundamental_hz": [0.2, 0.25], "harmonics": [[1, 2, 3], [1, 3]]});
    request["given"] = json!([{"identification": identification}, {"excitation": first["id"], "periods": 3}]);
    request["periods"] = json!(4);
    request["trajectories"] = json!(2);
    request["backoff"] = json!(0.4);
    let answer = server.excite(&request);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let design = answer.json();
    assert_eq!(design["criteria"]["minimised"], "i_optimality");
    assert_eq!(design["recommended_criterion"]["criterion"], "i_optimality");
    assert_eq!(design["periods"], 4.0);
    assert!([0.2, 0.25].contains(&design["fundamental_hz"].as_f64().unwrap()));
    // Joint 2 has no second harmonic.
    assert_eq!(design["coefficients"]["a"][1][1], 0.0);
    assert_ne!(design["coefficients"]["a"][0][1], 0.0);
    // The second trajectory adds to the first.
    let further = &design["further"][0];
    let error = |d: &Value| d["criteria"]["i_optimality"].as_f64().unwrap();
    assert!(error(further) < error(&design), "{} {}", error(further), error(&design));
    // What is known already counts: the same without it predicts larger deviations.
    request.as_object_mut().unwrap().remove("given");
    request["trajectories"] = json!(1);
    request["warm_start"] =
        json!({"coefficients": design["coefficients"], "offset": design["offset"], "fundamental_hz": design["fundamental_hz"]});
    let alone = server.excite(&request).json();
    assert!(error(&alone) > error(&design));
    let run = &design["first_run"];
    assert_eq!(run["backoff"], 0.4);
    let ratio = run["coefficients"]["a"][0][0].as_f64().unwrap() / design["coefficients"]["a"][0][0].as_f64().unwrap();
    assert!((ratio - 0.4).abs() < 1e-12);
    assert!(
        run["margins"]
            .as_array()
            .unwrap()
            .iter()
            .all(|m| m["margin"].as_f64().unwrap() > 0.0)
    );
    let id = design["id"].as_str().unwrap();
    let table = |query: &str| {
        server
            .get(&format!("/excitation/{id}/trajectory?format=json&rate_hz=50{query}"))
            .json()
    };
    let (full, slow, second) = (table(""), table("&backoff=0.5&slow=2"), table("&index=1"));
    let cell = |t: &Value, row: usize, column: usize| t["rows"][row][column].as_f64().unwrap();
    // Twice the time, half of the way from the start, a quarter of the velocity.
    let [q0, q1] = [0, 20].map(|row| cell(&full, row, 1));
    assert!((cell(&slow, 40, 1) - (q0 + 0.5 * (q1 - q0))).abs() < 1e-12);
    assert!((cell(&slow, 40, 3) - 0.25 * cell(&full, 20, 3)).abs() < 1e-12);
    assert_ne!(cell(&second, 20, 1), q1);
    for (query, parameter) in [("index=2", "index"), ("backoff=0", "backoff"), ("slow=0.5", "slow")] {
        let answer = server.get(&format!("/excitation/{id}/trajectory?{query}"));
        assert_eq!(
            (answer.status, problems(&answer)),
            (400, vec![format!("/query/{parameter}")]),
            "{query}"
        );
    }
}

/// The first log moves one joint a little only; what it leaves open is decided by a design for just that.
#[test]
fn a_finding_and_its_rival_are_told_apart_by_a_design() {
    let server = Server::start();
    let identification = simulated_log(&server);
    let finding = &identification["residual"]["findings"][0];
    let rival = &finding["rivals"][0];
    assert!(rival.is_object(), "{}", identification["residual"]);
    let place = |f: &Value| json!({"effect": f["effect"], "joints": f["joints"]});
    let mut request = quick_request();
    request["model"] = json!({"identification": identification["id"]});
    request["given"] = json!([{"identification": identification["id"]}]);
    request["criterion"] = json!("rival_evidence");
    request["rivals"] = json!({"finding": place(finding), "rival": place(rival)});
    request["constraints"] = json!({"form": "exact", "start": "free"});
    let answer = server.excite(&request);
    assert_eq!(answer.status, 200, "{}", answer.text);
    let design = answer.json();
    let rivals = &design["rivals"];
    assert_eq!(rivals["finding"]["effect"], finding["effect"]);
    let least = |of: &str| rivals["expected_evidence"][of]["least"].as_f64().unwrap();
    assert!(least("designed") > 10.0 * least("recorded"), "{rivals}");
    assert_eq!(rivals["decides"], true);
    assert_eq!(design["criteria"]["rival_evidence"].as_f64().unwrap(), least("designed"));
    assert_eq!(design["effects"].as_array().unwrap().len(), 2);
    for (wrong, pointer) in [
        (
            json!({"finding": {"effect": "payload", "joints": []}, "rival": 0}),
            "/rivals/finding",
        ),
        (
            json!({"finding": 0, "rival": {"effect": "torque_gain", "joints": ["J1"]}}),
            "/rivals/rival",
        ),
        (json!({"finding": 0, "rival": 99}), "/rivals/rival"),
    ] {
        request["rivals"] = wrong;
        let answer = server.excite(&request);
        assert_eq!(
            (answer.status, problems(&answer)),
            (422, vec![pointer.to_string()]),
            "{}",
            answer.text
        );
    }
}

#[test]
fn what_is_not_there_is_named() {
    let server = Server::start();
    let mut request = quick_request();
    request["model"] = json!({"identification": "nothing"});
    request["given"] = json!([{"excitation": "nothing"}, {"identification": "nothing"}, {"periods": 3}]);
    request["periods"] = json!(0);
    request["trajectories"] = json!(11);
    request["backoff"] = json!(1.5);
    request["fourier"] = json!({"order": 3, "fundamental_hz": [0.2, -1], "harmonics": [[1, 2, 3], [3, 4]]});
    let answer = server.excite(&request);
    assert_eq!(answer.status, 422, "{}", answer.text);
    let found = problems(&answer);
    for pointer in [
        "/model/identification",
        "/given/0/excitation",
        "/given/1/identification",
        "/periods",
        "/trajectories",
        "/backoff",
        "/fourier/fundamental_hz/1",
        "/fourier/harmonics/1",
    ] {
        assert!(found.iter().any(|p| p == pointer), "{pointer} not among {found:?}");
    }
    let mut alone = quick_request();
    alone["criterion"] = json!("rival_evidence");
    assert_eq!(problems(&server.excite(&alone)), ["/rivals"]);
}

/// That there is no trajectory is an outcome with its reason, not an error; the reason names what takes part. A start that the
/// robot cannot take is an error of that field.
#[test]
fn limits_that_leave_no_room_are_named() {
    let server = Server::start();
    let asked = |robot: &str, constraints: Value| {
        let mut request = quick_request();
        request["robot"] = json!(robot);
        request["constraints"] = constraints;
        server.excite(&request)
    };
    let press = json!({"boxes": [{"name": "press", "center": [0, 0, 0.8], "size": [0.5, 1.2, 0.62]}]});
    // The planar arm lies level at its start: 9.81 · (0.5 + 1.5) N m.
    for (robot, constraints, named) in [
        (
            "planar_two_link",
            json!({"torque": {"limits": [10, 100], "safety_factor": 1.25}}),
            ["`J1` needs 19.6200", "constraints.torque allows 8.0000"],
        ),
        ("iiwa14", json!({"space": press}), ["`press`", "constraints.space allows"]),
    ] {
        let answer = asked(robot, constraints);
        assert_eq!(answer.status, 200, "{}", answer.text);
        let design = answer.json();
        assert_eq!(design["status"], "Infeasible");
        let reason = design["reason"].as_str().unwrap();
        for words in named.iter().chain(&["start_position"]) {
            assert!(reason.contains(words), "{words} not in: {reason}");
        }
        let id = design["id"].as_str().unwrap();
        let trajectory = server.get(&format!("/excitation/{id}/trajectory"));
        assert_eq!(
            (trajectory.status, &trajectory.problem()["code"]),
            (409, &json!("no_trajectory"))
        );
        assert_eq!(server.get(&format!("/jobs/{id}")).json()["outcome"], "Infeasible");
    }
    let outside = asked("planar_two_link", json!({"start_position": [0, 3]}));
    assert_eq!(
        (outside.status, problems(&outside)),
        (422, vec!["/constraints/start_position/1".to_string()]),
        "{}",
        outside.text
    );
}

/// Browsers ask for compressed answers: what is streamed comes to its end, packed or not.
#[test]
fn a_compressed_trajectory_is_whole() {
    use std::io::{Read, Write};
    let server = Server::start();
    let id = server.excite(&quick_request()).json()["id"].as_str().unwrap().to_string();
    for (format, columns) in [("csv", "time,q1,"), ("json", "{\"columns\":")] {
        let path = format!("/excitation/{id}/trajectory?format={format}&rate_hz=1000");
        let mut stream = std::net::TcpStream::connect(server.address).unwrap();
        let head = format!("GET {path} HTTP/1.1\r\nhost: localhost\r\naccept-encoding: gzip\r\nconnection: close\r\n\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let at = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let (head, mut rest) = (String::from_utf8_lossy(&answer[..at]).to_lowercase(), &answer[at + 4..]);
        assert!(head.contains("content-encoding: gzip"), "{head}");
        // Chunks (RFC 9112, 7.1): a length, the bytes, and at the end a length of zero.
        let mut packed = Vec::new();
        loop {
            let line = rest.windows(2).position(|w| w == b"\r\n").expect("the answer was cut off");
            let length = usize::from_str_radix(std::str::from_utf8(&rest[..line]).unwrap(), 16).unwrap();
            if length == 0 {
                break;
            }
            packed.extend_from_slice(&rest[line + 2..line + 2 + length]);
            rest = &rest[line + 4 + length..];
        }
        let mut text = String::new();
        flate2::read::GzDecoder::new(packed.as_slice())
            .read_to_string(&mut text)
            .unwrap();
        assert!(text.starts_with(columns), "{format}: {}", &text[..40]);
        assert_eq!(text, server.get(&path).text, "{format}");
    }
}
