//! The robots of the program and of the lab.

use crate::server::{Server, in_database, quick_request};
use dynident::service::Config;
use serde_json::json;
use std::io::Write;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const URDF: &str = include_str!("../../examples/robots/iiwa14.urdf");

#[test]
fn shipped_robots_are_listed_and_have_base_parameters() {
    let server = Server::start();
    let list = server.get("/robots").json();
    let ids: Vec<_> = list["robots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| r["id"].as_str().unwrap())
        .collect();
    assert_eq!(
        ids,
        [
            "iiwa14",
            "iiwa7",
            "fr3",
            "ur10",
            "ur3e",
            "ur5e",
            "ur10e",
            "lwr4",
            "panda",
            "tx40",
            "puma560",
            "gen3",
            "scara",
            "planar_two_link"
        ]
    );
    let document = server.get("/robots/iiwa14").json();
    assert_eq!(document["joints"][2]["mdh"]["r"], 0.42);
    let base = server.get("/robots/iiwa14/base-parameters").json();
    assert_eq!(base["count"], 57);
    assert_eq!(base["map"].as_array().unwrap().len(), 57);
    assert_eq!(base["map"][0].as_array().unwrap().len(), 84);
    let named = |name: &str| {
        base["base_parameters"]
            .as_array()
            .unwrap()
            .iter()
            .find(|p| p["name"] == name)
            .cloned()
            .unwrap()
    };
    assert_eq!(named("MYR2")["expression"], "MY2 + MZ3 + 0.42 (M3 + M4 + M5 + M6 + M7)");
    assert_eq!(named("FV1")["unit"], "N m s/rad");
}

#[test]
fn robots_of_the_lab_are_kept_used_and_forgotten() {
    let server = Server::start();
    let put = |path: &str, kind: &str, body: &str| server.send("PUT", path, &[("content-type", kind)], body);
    assert_eq!(put("/robots/lab-iiwa", "application/xml", URDF).status, 201);
    assert_eq!(
        put("/robots/lab-iiwa", "application/json", &json!({"urdf": URDF}).to_string()).status,
        200
    );
    assert_eq!(server.get("/robots/lab-iiwa/base-parameters").json()["count"], 57);
    let mut request = quick_request();
    request["robot"] = json!("lab-iiwa");
    let result = server.excite(&request);
    assert_eq!((result.status, &result.json()["robot"]), (200, &json!("iiwa14")));
    request["robot"] = json!("lab-iiwaa");
    let unknown = server.post_json("/excitation", &request.to_string());
    assert_eq!(unknown.errors(), ["/robot: is `lab-iiwaa` (did you mean `lab-iiwa`?)"]);
    assert_eq!(server.delete("/robots/lab-iiwa").status, 204);
    assert_eq!(server.get("/robots/lab-iiwa").status, 404);
}

#[test]
fn a_posted_robot_gets_an_id_from_its_name_once() {
    let server = Server::start();
    let robot = json!({"name": "My Arm / 2", "joints": [
        {"name": "J1", "kind": "prismatic", "placement": {"xyz": [0, 0, 1], "axis": [0, 1, 0]}, "limits": {"velocity": 1}}]});
    let answer = server.post_json("/robots", &robot.to_string());
    assert_eq!((answer.status, answer.header("location")), (201, Some("/robots/my-arm-2")));
    assert_eq!(server.get("/robots/my-arm-2").json(), robot);
    assert_eq!(
        server.post_json("/robots", &robot.to_string()).problem()["code"],
        "robot_exists"
    );
    let shipped = server.send(
        "PUT",
        "/robots/iiwa14",
        &[("content-type", "application/json")],
        &robot.to_string(),
    );
    assert_eq!(
        (shipped.status, shipped.problem()["code"].as_str()),
        (409, Some("robot_read_only"))
    );
    assert_eq!(server.delete("/robots/ur10").status, 409);
}

/// A document that no version has written, and one that this version does not take: the others are listed all the same.
#[test]
fn regress_one_unreadable_robot_does_not_hide_the_others() {
    let folder = std::env::temp_dir().join(format!("dynident-unreadable-{}", std::process::id()));
    let server = Server::with(Config {
        data: Some(folder.clone()),
        ..Config::default()
    });
    let robot = json!({"name": "arm", "joints": [
        {"name": "J1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}, "limits": {"velocity": 1}}]});
    for id in ["lab-a", "lab-b", "lab-c"] {
        let put = server.send(
            "PUT",
            &format!("/robots/{id}"),
            &[("content-type", "application/json")],
            &robot.to_string(),
        );
        assert_eq!(put.status, 201, "{}", put.text);
    }
    in_database(&folder, "UPDATE robots SET document = '{' WHERE id = 'lab-a'");
    in_database(&folder, "UPDATE robots SET document = '{\"joints\": 3}' WHERE id = 'lab-b'");
    let list = server.get("/robots");
    assert_eq!(list.status, 200, "{}", list.text);
    let robots = list.json()["robots"].as_array().unwrap().clone();
    let ids: Vec<_> = robots
        .iter()
        .filter(|r| r["shipped"] == false)
        .map(|r| r["id"].as_str().unwrap())
        .collect();
    assert_eq!(ids, ["lab-c"]);
    for path in [
        "/robots/lab-a",
        "/robots/lab-a/base-parameters",
        "/robots/lab-b/base-parameters",
    ] {
        let problem = server.get(path).problem();
        assert_eq!(
            (problem["status"].as_u64(), problem["code"].as_str()),
            (Some(500), Some("robot_unreadable")),
            "{path}"
        );
        assert!(problem["hint"].as_str().unwrap().contains("PUT /robots/lab-"), "{problem}");
    }
    for id in ["lab-a", "lab-b"] {
        let mut request = quick_request();
        request["robot"] = json!(id);
        let errors = server.post_json("/excitation", &request.to_string()).errors();
        // Of one that is no JSON there is nothing more to say.
        let why = if id == "lab-b" { ": /name: is missing" } else { "" };
        let expected = format!("/robot: is `{id}`, a robot whose stored document cannot be read{why} (keep it anew");
        assert!(errors.len() == 1 && errors[0].starts_with(&expected), "{errors:?}");
        assert_eq!(server.delete(&format!("/robots/{id}")).status, 204);
    }
    drop(server);
    let _ = std::fs::remove_dir_all(&folder);
}

#[test]
fn bad_robots_are_refused() {
    let server = Server::start();
    let cut_off = server.send("POST", "/robots", &[("content-type", "application/xml")], &URDF[..500]);
    assert_eq!(cut_off.status, 422);
    assert!(
        cut_off.errors()[0].starts_with("/urdf: is not readable XML"),
        "{:?}",
        cut_off.errors()
    );
    let empty = server.post_json("/robots", r#"{"name": "", "joints": []}"#);
    assert_eq!(empty.errors(), ["/joints: is empty: a robot has at least one joint ()"]);
    let kind = server.send("POST", "/robots", &[("content-type", "text/csv")], "a,b");
    assert_eq!(kind.status, 415);
}

#[test]
fn pages_and_health_answer() {
    let server = Server::start();
    assert!(server.get("/").text.contains("/docs/"));
    assert_eq!(server.get("/health/live").json()["status"], "ok");
    assert_eq!(server.get("/health/ready").json()["status"], "ok");
    let docs = server.get("/docs/");
    assert_eq!(docs.status, 200);
    for added in [
        "name=\"viewport\"",
        "/assets/docs.js",
        "/assets/docs.css",
        "<title>API",
        "<main id=\"swagger-ui\">",
    ] {
        assert!(docs.text.contains(added), "{added} in {}", docs.text);
    }
    // Offline: nothing is fetched from elsewhere.
    assert!(
        !docs.text.contains("//cdn") && !docs.text.contains("https://"),
        "{}",
        docs.text
    );
    assert_eq!(server.get("/docs/swagger-ui-bundle.js").status, 200);
}

/// A description package: the URDF file and a mesh in text.
fn package(robot: &str) -> Vec<u8> {
    let corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.4], [0.0, 0.1, 0.4], [0.1, 0.1, 0.0]];
    let corner = |k: usize| format!("vertex {} {} {}\n", corners[k][0], corners[k][1], corners[k][2]);
    let facet = |t: [usize; 3]| {
        format!(
            "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            t.map(corner).concat()
        )
    };
    let mesh = format!("solid m\n{}endsolid m\n", [[0, 1, 2], [0, 1, 3]].map(facet).concat());
    let urdf = r#"<robot name="packed"><link name="base"/><link name="l1"><collision><geometry><mesh filename="package://packed/meshes/l1.stl"/></geometry></collision></link>
        <link name="l2"><visual><geometry><mesh filename="package://packed/meshes/l2.dae"/></geometry></visual></link>
        <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/></joint><joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/></joint></robot>"#
        .to_string();
    let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in [(robot, urdf), ("packed/meshes/l1.stl", mesh)] {
        writer.start_file(name, SimpleFileOptions::default()).unwrap();
        writer.write_all(content.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

#[test]
fn a_robot_may_come_with_its_meshes_in_an_archive() {
    let server = Server::start();
    let post = |path: &str, bytes: &[u8]| server.post_raw(path, "application/zip", bytes, None);
    let answer = post("/robots?tip=l2", &package("packed/urdf/arm.urdf"));
    assert_eq!(answer.status, 201, "{}", answer.text);
    let kept = answer.json();
    assert_eq!((&kept["id"], &kept["joints"]), (&json!("packed"), &json!(["j1", "j2"])));
    assert_eq!(kept["understood"]["joints"][0]["capsules"], 1, "{kept}");
    let notes = kept["notes"].to_string();
    assert!(
        notes.contains("not in the archive") && notes.contains("package://packed/meshes/l2.dae"),
        "{notes}"
    );
    let document = server.get("/robots/packed").json();
    assert_eq!(document["tip"], "l2");
    let capsule = &document["geometry"]["l1"][0];
    assert_eq!(capsule["source"], "around package://packed/meshes/l1.stl");
    assert!(capsule["radius"].as_f64().unwrap() > 0.05, "{capsule}");
    // What is kept is used like any other.
    assert_eq!(server.get("/robots/packed/base-parameters").status, 200);
    // The same document without keeping it.
    let read = post("/robot-archive", &package("packed/urdf/arm.urdf"));
    assert_eq!(read.status, 200, "{}", read.text);
    assert_eq!(read.json()["document"]["geometry"], document["geometry"]);
    assert!(read.json()["notes"][0].as_str().unwrap().contains("l2.dae"), "{}", read.text);
    assert_eq!(post("/robot-archive", b"PK\x03\x04 and no more").status, 400);
    let plain = server.post_raw("/robot-archive", "application/xml", b"<robot/>", None);
    assert_eq!(plain.status, 415, "{}", plain.text);
    assert_eq!(post("/robot-archive", &vec![0; (64 << 20) + 1]).status, 413);
    let none = post("/robots", &package("packed/readme.txt"));
    assert_eq!(
        (none.status, none.problem()["code"].as_str()),
        (400, Some("malformed_document")),
        "{}",
        none.text
    );
    assert!(
        none.problem()["detail"].as_str().unwrap().contains("has no robot"),
        "{}",
        none.text
    );
    let damaged = post("/robots", b"PK\x03\x04 and no more");
    assert_eq!(damaged.status, 400, "{}", damaged.text);
    let large = post("/robots", &vec![0; (64 << 20) + 1]);
    assert_eq!(
        (large.status, large.problem()["code"].as_str()),
        (413, Some("payload_too_large")),
        "{}",
        large.text
    );
    // Other documents are held to the ordinary limit.
    let wordy = server.post_raw("/robots", "application/xml", &vec![b' '; (8 << 20) + 1], None);
    assert_eq!(wordy.status, 413, "{}", wordy.text);
}
