//! Robot files that stopped the server once, over HTTP.

use crate::server::Server;
use dynident::documents::NamedRobots;
use dynident::documents::shipped::Shipped;
use serde_json::{Value, json};
use std::time::Instant;

fn data(file: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Every one of them is refused with its place, and the server goes on.
#[test]
fn regress_no_robot_document_stops_the_server() {
    let server = Server::start();
    let refused = |path: &str, body: &str, expected: &str| {
        let start = Instant::now();
        let answer = server.post_json(path, body);
        assert_eq!(answer.status, 422, "{path}: {}", answer.text);
        let errors = answer.errors().join("\n");
        assert!(errors.contains(expected), "`{expected}` not in {errors}");
        assert!(start.elapsed().as_secs_f64() < 30.0, "{path}");
    };
    refused(
        "/motion",
        &data("requests/deep_motion.json"),
        "/robot/urdf: has elements nested more than 200 levels deep",
    );
    refused(
        "/robots",
        &json!({"urdf": data("robots/deep_link_4000.urdf")}).to_string(),
        "200 levels",
    );
    refused("/robots", &data("robots/urdf_cycle_tip.json"), "closed loop");
    refused(
        "/robots",
        &data("robots/robot_nl_name.json"),
        "/joints/0/name: has the character U+000A",
    );
    refused(
        "/robots",
        &json!({"urdf": data("robots/xacro_macro.urdf")}).to_string(),
        "is xacro",
    );
    refused(
        "/robots",
        &json!({"name": "many", "joints": vec![json!({}); 20_000]}).to_string(),
        "has 20000 joints",
    );
    refused(
        "/excitation",
        &data("requests/x_noisetiny.json"),
        "/torque_noise/0: is 1e-300",
    );
    let rows = vec![vec![0.1; 20_000]; 2];
    let motion = json!({"robot": "planar_two_link", "trajectory": {"fundamental_hz": 0.1, "offset": [0, 0], "coefficients": {"a": rows, "b": rows}}});
    refused("/motion", &motion.to_string(), "has 20000 values, the most accepted is 50");
    assert_eq!(server.get("/health/live").status, 200);
}

/// What was made of a file stands in the answers.
#[test]
fn what_was_made_of_a_file_is_answered() {
    let server = Server::start();
    let xml = [("content-type", "application/xml")];
    let gripper = data("robots/mimic_gripper.urdf");
    let put = |path: &str, body: &str| server.send("PUT", path, &xml, body);
    let kept = put("/robots/gripper?tip=l2", &gripper);
    assert_eq!(kept.status, 201, "{}", kept.text);
    assert_eq!(kept.json()["joints"], json!(["j1", "j2"]));
    let notes = kept.json()["notes"].to_string();
    assert!(notes.contains("`g2` follows `g1`"), "{notes}");
    assert_eq!(server.get("/robots/gripper").json()["tip"], "l2");
    assert_eq!(put("/robots/gripper?tip=nothing", &gripper).status, 422);
    let of_joints = server.send(
        "PUT",
        "/robots/arm?tip=l2",
        &[("content-type", "application/json")],
        &json!({"name": "arm", "joints": []}).to_string(),
    );
    assert!(
        of_joints.errors()[0].starts_with("/query/tip: goes with a robot from a URDF or MJCF file"),
        "{}",
        of_joints.text
    );
    let drawn = server.post_json(
        "/motion",
        &json!({"robot": {"urdf": data("robots/two_joint_31416.urdf")}}).to_string(),
    );
    assert!(drawn.json()["notes"].to_string().contains("half turn"), "{}", drawn.text);
    let placeholder = put("/robots/huge", &data("robots/huge_lim.urdf"));
    assert!(
        placeholder.json()["notes"].to_string().contains("taken as none"),
        "{}",
        placeholder.text
    );
}

/// A limit that nobody stated is not asked of a file, but of a design that needs it.
#[test]
fn a_design_asks_for_the_limits_that_it_needs() {
    let server = Server::start();
    let endless = data("robots/huge_lim.urdf").replace("velocity=\"2\"", "velocity=\"1e16\"");
    let mut request: Value = serde_json::from_str(&data("requests/ex5.json")).unwrap();
    request["robot"] = json!({"urdf": endless});
    let answer = server.post_json("/excitation", &request.to_string());
    assert_eq!(answer.status, 422, "{}", answer.text);
    let errors = answer.errors().join("\n");
    assert!(
        errors.contains("joint `j1` has no limit on its velocity, acceleration or jerk"),
        "{errors}"
    );
    assert!(errors.contains("joint `j2`"), "{errors}");
    for name in Shipped.names() {
        request["robot"] = json!(name);
        request["search"] = json!({"seed": 1, "starts": 1, "max_evaluations": 1});
        assert_ne!(server.post_json("/excitation", &request.to_string()).status, 422, "{name}");
    }
}
