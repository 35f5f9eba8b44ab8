//! The lab's catalogue of own effects.

use crate::identify::{log, post};
use crate::server::{Answer, Server, in_database};
use dynident::service::Config;
use serde_json::{Value, json};

/// A hose that pulls the joint that it is on back.
pub fn hose() -> Value {
    json!({"name": "hose", "expression": "k*q + c*sign(qd)", "declared": false,
        "parameters": [{"name": "k", "unit": "N m/rad", "low": 0}, {"name": "c", "unit": "N m"}]})
}

fn put(server: &Server, name: &str, body: &Value) -> Answer {
    server.send(
        "PUT",
        &format!("/effects/{name}"),
        &[("content-type", "application/json")],
        &body.to_string(),
    )
}

#[test]
fn effects_are_kept_listed_replaced_and_removed() {
    let server = Server::start();
    assert_eq!(server.get("/effects").json(), json!({"effects": []}));
    let kept = put(&server, "hose", &hose());
    assert_eq!(
        (kept.status, kept.header("location")),
        (201, Some("/effects/hose")),
        "{}",
        kept.text
    );
    assert!(kept.json()["mathml"].as_str().unwrap().starts_with("<math>"), "{}", kept.text);
    let mut stronger = hose();
    stronger["joint"] = json!("A2");
    assert_eq!(put(&server, "hose", &stronger).status, 200);
    let document = server.get("/effects/hose").json();
    assert_eq!(
        (&document["joint"], &document["expression"]),
        (&json!("A2"), &json!("k*q + c*sign(qd)"))
    );
    let list = server.get("/effects").json();
    assert_eq!(list["effects"][0]["definition"], document);
    // What is handed out can be kept again as it is.
    assert_eq!(put(&server, "hose", &document).status, 200);
    assert_eq!(server.get("/effects/hose").json(), document);
    assert_eq!(server.delete("/effects/hose").status, 204);
    for gone in [server.get("/effects/hose"), server.delete("/effects/hose")] {
        assert_eq!((gone.status, gone.problem()["code"].as_str()), (404, Some("unknown_effect")));
    }
}

/// Everything that needs no robot is checked when it is kept; what fits some robot is taken.
#[test]
fn definitions_are_checked_as_far_as_they_need_no_robot() {
    let server = Server::start();
    let refused = |changed: &[(&str, Value)], expected: &[&str]| {
        let mut body = hose();
        changed.iter().for_each(|(field, value)| body[*field] = value.clone());
        let name = body["name"].as_str().unwrap_or("hose").to_string();
        for answer in [
            put(&server, &name, &body),
            server.post_json("/effect-preview", &body.to_string()),
        ] {
            assert_eq!(answer.status, 422, "{body}: {}", answer.text);
            assert_eq!(answer.errors(), expected, "{body}");
        }
    };
    refused(
        &[("name", json!("stribeck_friction"))],
        &["/name: `stribeck_friction` is an effect of the program (give it another name)"],
    );
    refused(
        &[("name", json!("9"))],
        &["/name: is no name of an effect (a letter, then letters, digits, _ and -, 64 at most)"],
    );
    refused(
        &[("expression", json!("k*q + c*sign(qd) + z"))],
        &[
            "/expression: `z` is neither a variable nor a parameter (variables are q1 to q30, qd1 to qd30, qdd1 to qdd30, and q, qd, qdd of its own joint; \
            list every other name in `parameters`)",
        ],
    );
    refused(
        &[(
            "parameters",
            json!([{"name": "k", "unit": "N m/rad", "low": 2, "high": 1}, {"name": "c", "unit": "Nm"}]),
        )],
        &[
            "/parameters/0/high: is 1, not above `low` = 2 (give low < high)",
            "/parameters/1/unit: is `Nm`: `Nm` is not known (write N m)",
        ],
    );
    refused(&[("joint", json!(3))], &["/joint: is a number, expected a string ()"]);
    refused(
        &[("extra", json!(1))],
        &["/extra: is not a field of this document (one of: name, joint, expression, parameters, channels, declared)"],
    );
    // k is no torque per angle and no force per length on any joint.
    let mut body = hose();
    body["parameters"][0]["unit"] = json!("kg");
    let answer = put(&server, "hose", &body);
    assert_eq!(answer.status, 422, "{}", answer.text);
    assert!(
        answer.errors()[0].starts_with("/parameters/0/unit: is `kg`"),
        "{:?}",
        answer.errors()
    );
    // That of a slide is as good as that of a turning joint: the use decides.
    let mut slide = hose();
    slide["parameters"] = json!([{"name": "k", "unit": "N/m"}, {"name": "c", "unit": "N"}]);
    assert_eq!(put(&server, "hose", &slide).status, 201);
    let other = put(&server, "other", &hose());
    assert_eq!(
        other.errors(),
        ["/name: is `hose`, and the address says `other` (let both be the same name)"]
    );
    assert_eq!(server.get("/effects").json()["effects"].as_array().unwrap().len(), 1);
    let malformed = server.send("PUT", "/effects/hose", &[("content-type", "application/json")], "{");
    assert_eq!(malformed.status, 400);
    assert_eq!(
        server
            .send("PUT", "/effects/hose", &[("content-type", "text/plain")], "{}")
            .status,
        415
    );
}

#[test]
fn one_unreadable_effect_does_not_hide_the_others() {
    let folder = std::env::temp_dir().join(format!("dynident-effects-{}", std::process::id()));
    let server = Server::with(Config {
        data: Some(folder.clone()),
        ..Config::default()
    });
    for name in ["a", "b", "c"] {
        let mut body = hose();
        body["name"] = json!(name);
        assert_eq!(put(&server, name, &body).status, 201);
    }
    in_database(&folder, "UPDATE effects SET document = '{' WHERE name = 'a'");
    in_database(&folder, "UPDATE effects SET document = '{\"name\": 3}' WHERE name = 'b'");
    let list = server.get("/effects").json();
    let names: Vec<_> = list["effects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| e["name"].clone())
        .collect();
    assert_eq!(names, ["c"]);
    for name in ["a", "b"] {
        let problem = server.get(&format!("/effects/{name}")).problem();
        assert_eq!(problem["code"], "effect_unreadable", "{problem}");
        assert!(problem["hint"].as_str().unwrap().contains("PUT /effects/"), "{problem}");
        let robot = json!({"urdf": include_str!("../../examples/robots/iiwa14.urdf"), "effects": [name]});
        let errors = server.post_json("/robots", &robot.to_string()).errors();
        let expected = format!("/effects/0: is `{name}`, an effect of the catalogue whose stored document cannot be read");
        assert!(errors.len() == 1 && errors[0].starts_with(&expected), "{errors:?}");
        assert_eq!(server.delete(&format!("/effects/{name}")).status, 204);
    }
    drop(server);
    let _ = std::fs::remove_dir_all(&folder);
}

/// A robot names an effect: it is looked for when the robot is kept, stays while the robot needs it, and the robot says what does
/// not fit.
#[test]
fn robots_name_effects_of_the_catalogue() {
    let server = Server::start();
    let robot = |effects: Value| {
        let urdf = include_str!("../../examples/robots/iiwa14.urdf");
        let body = json!({"urdf": urdf, "effects": effects});
        server.send(
            "PUT",
            "/robots/lab",
            &[("content-type", "application/json")],
            &body.to_string(),
        )
    };
    let unknown = robot(json!(["hose"]));
    assert_eq!(
        unknown.errors(),
        [
            "/effects/0: is `hose`, and there is no catalogue of effects here (write the definition in its place; a server keeps a catalogue at /effects, the \
            command line takes one with --effects FILE)"
        ]
    );
    assert_eq!(put(&server, "hose", &hose()).status, 201);
    assert_eq!(
        robot(json!(["hosse"])).errors(),
        ["/effects/0: is `hosse` (did you mean `hose`?)"]
    );
    assert_eq!(
        robot(json!(["hose"])).errors(),
        [
            "/effects/0: is `hose` of the catalogue, which has no joint of its own (state the joint: {\"use\": \"hose\", \"joint\": …})"
        ]
    );
    let wrong = robot(json!([{"use": "hose", "joint": "A9"}, {"use": "hose", "joint": "A2", "joints": 2}])).errors();
    let starts = [
        "/effects/0/joint: the robot has no joint `A9` (one of: A1, ",
        "/effects/1/use: `hose` is the name of another own effect",
        "/effects/1/joints: is not a field of this document (did you mean `joint`?)",
    ];
    assert_eq!(wrong.len(), starts.len(), "{wrong:?}");
    assert!(wrong.iter().zip(starts).all(|(e, start)| e.starts_with(start)), "{wrong:?}");
    let two = json!([{"use": "hose", "joint": "A2"}, {"use": "hose", "joint": "A4", "name": "hose_4", "declared": true}]);
    assert_eq!(robot(two.clone()).status, 201);
    // As it was given: it names the effects still.
    assert_eq!(server.get("/robots/lab").json()["effects"], two);
    let removed = server.delete("/effects/hose");
    assert_eq!(
        (removed.status, removed.problem()["code"].as_str()),
        (409, Some("effect_in_use"))
    );
    assert!(
        removed.problem()["detail"].as_str().unwrap().ends_with(": lab"),
        "{}",
        removed.text
    );
    // An effect that was changed so that the robot cannot have it.
    let mut changed = hose();
    changed["expression"] = json!("k*q_J9 + c*sign(qd)");
    assert_eq!(put(&server, "hose", &changed).status, 200);
    let motion = json!({"robot": "lab", "trajectory": {"fundamental_hz": 0.1, "offset": [0, 0, 0, 0, 0, 0, 0],
        "coefficients": {"a": vec![[0.1]; 7], "b": vec![[0.1]; 7]}}});
    let errors = server.post_json("/motion", &motion.to_string()).errors();
    assert!(
        errors[0].starts_with("/robot: is `lab`, a robot whose stored document cannot be read: /effects/0: is `hose` of the catalogue, /expression: `q_J9`"),
        "{errors:?}"
    );
    assert_eq!(server.delete("/robots/lab").status, 204);
    assert_eq!(server.delete("/effects/hose").status, 204);
}

fn identified(server: &Server, request: &Value) -> Answer {
    let (request, log) = (request.to_string(), log(0.3));
    post(
        server,
        "/identify",
        true,
        &[("request", "", &request), ("log", "run.csv", &log)],
    )
}

/// A spring on the joint that it acts on, declared.
fn spring(unit: &str) -> Value {
    json!({"name": "spring", "expression": "k*q", "declared": true, "parameters": [{"name": "k", "unit": unit}]})
}

/// One definition serves two joints; the answer has what the names stood for, and a changed catalogue gives another answer.
#[test]
fn requests_name_effects_of_the_catalogue() {
    let server = Server::start();
    let request = |effects: Value| json!({"robot": "planar_two_link", "period_s": 5, "trace": false, "effects": effects});
    assert_eq!(put(&server, "spring", &spring("N m/rad")).status, 201);
    let two = json!([{"use": "spring", "joint": "J1", "name": "first"}, {"use": "spring", "joint": "J2", "declared": true}]);
    let answer = identified(&server, &request(two.clone()));
    assert_eq!(answer.status, 200, "{}", answer.text);
    let found = answer.json();
    let named = |k: usize| (found["effects"][k]["effect"].clone(), found["effects"][k]["joints"].clone());
    assert_eq!(
        [named(0), named(1)],
        [(json!("first"), json!(["J1"])), (json!("spring"), json!(["J2"]))]
    );
    let kept = &found["provenance"]["request"]["effects"];
    assert_eq!(
        (&kept[0]["name"], &kept[0]["joint"], &kept[1]["expression"]),
        (&json!("first"), &json!("J1"), &json!("k*q"))
    );
    // The same numbers with the definitions that the answer has.
    let again = identified(&server, &request(kept.clone())).json();
    assert_eq!(again["base_parameters"], found["base_parameters"]);
    let mut changed = spring("N m");
    changed["expression"] = json!("k*sin(q)");
    assert_eq!(put(&server, "spring", &changed).status, 200);
    let other = identified(&server, &request(two)).json();
    assert_ne!(other["id"], found["id"], "the answer of another definition");
    assert_eq!(other["provenance"]["request"]["effects"][0]["expression"], "k*sin(q)");
    let earlier = server.get(&format!("/identify/{}", found["id"].as_str().unwrap())).json();
    assert_eq!(earlier["provenance"]["request"]["effects"], *kept);
    // A robot that names it has it in every identification.
    let mut robot = server.get("/robots/planar_two_link").json();
    robot["effects"] = json!([{"use": "spring", "joint": "J2"}]);
    let body = robot.to_string();
    let kind = [("content-type", "application/json")];
    assert_eq!(server.send("PUT", "/robots/lab", &kind, &body).status, 201);
    for robot in [json!("lab"), robot] {
        let answer = identified(&server, &json!({"robot": robot, "period_s": 5, "trace": false}));
        assert_eq!(answer.status, 200, "{}", answer.text);
        assert_eq!(answer.json()["effects"][0]["effect"], "spring", "{}", answer.text);
    }
    let unknown = identified(&server, &request(json!(["sprang", {"use": "springs", "joint": "J1"}])));
    assert_eq!(
        unknown.errors(),
        [
            "/effects/0: is `sprang` (did you mean `spring`?)",
            "/effects/1/use: is `springs` (did you mean `spring`?)"
        ]
    );
}

/// The limit on their number, at a server that has nearly as many; replacing one is no new one.
#[test]
fn a_catalogue_has_an_end() {
    let folder = std::env::temp_dir().join(format!("dynident-many-effects-{}", std::process::id()));
    let server = Server::with(Config {
        data: Some(folder.clone()),
        ..Config::default()
    });
    assert_eq!(put(&server, "hose", &hose()).status, 201);
    let text = hose().to_string();
    in_database(
        &folder,
        &format!(
            "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 998) \
             INSERT INTO effects (name, document, updated_us) SELECT 'x' || i, '{text}', 0 FROM n"
        ),
    );
    let named = |name: &str| {
        let mut body = hose();
        body["name"] = json!(name);
        put(&server, name, &body)
    };
    assert_eq!(named("last").status, 201);
    let full = named("one_more");
    assert_eq!((full.status, full.problem()["code"].as_str()), (409, Some("catalogue_full")));
    assert_eq!(named("last").status, 200);
    assert_eq!(server.get("/effects").json()["effects"].as_array().unwrap().len(), 1000);
    drop(server);
    let _ = std::fs::remove_dir_all(&folder);
}
