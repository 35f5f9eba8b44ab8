//! What is wrong with a request is found at once, with its place.

use super::*;
use crate::documents::shipped::Shipped;
use crate::excitation::{Form, SearchOptions, Start};
use crate::formats::parse;

fn findings(text: &str) -> Vec<String> {
    let parsed = parse(text.as_bytes()).unwrap();
    read_excitation_request(&parsed, &Shipped)
        .unwrap_err()
        .iter()
        .map(ToString::to_string)
        .collect()
}

const GOOD: &str = r#"{"robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50}"#;

#[test]
fn defaults_are_those_documented() {
    let request = read_excitation_request(&parse(GOOD.as_bytes()).unwrap(), &Shipped).unwrap();
    assert_eq!(request.search.options, SearchOptions::default());
    assert_eq!(request.search.time_limit_s, 60.0);
    let spec = request.problem.spec();
    assert_eq!(
        (spec.form, spec.start, spec.criterion),
        (Form::Paper, Start::Zero, Criterion::ConditionNumber)
    );
}

#[test]
fn all_that_is_wrong_is_found_at_once() {
    let text = r#"{
        "robot": {"name": "x", "gravity": [0, 0, NaN], "joints": [
            {"name": "A1", "kind": "revolut", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}, "limits": {"position": [-170, 170]}},
            {"name": "A2", "kind": "revolute", "mdh": {"alpha": 0, "d": null, "theta": 0, "r": 0}, "limits": {"position": [2, -2]}},
            {"name": "A2", "kind": "revolute"}]},
        "fourier": {"order": 0, "fundamental": 0.1},
        "sample_rate_hz": -1, "critereon": "x",
        "constraints": {"form": "Paper", "start_position": [0, "1"]},
        "search": {"starts": 0, "time_limit_s": 1e9}}"#;
    let found = findings(text);
    let expected = [
        "/robot/gravity/2: is NaN",
        "/critereon: is not a field of this document (did you mean `criterion`?)",
        "/robot/joints/0/kind: is `revolut` (did you mean `revolute`?)",
        "/robot/joints/0/limits/position: is [-170, 170] rad (limits of revolute joints are in radians; this looks like degrees",
        "/robot/joints/1/mdh/d: is null, expected a number",
        "/robot/joints/1/limits/position: is [2, -2]: the lower limit must be below the upper one (did you mean [-2, 2]?)",
        "/robot/joints/2: has neither `mdh` nor `dh` nor `placement`",
        "/fourier/fundamental: is not a field of this document (did you mean `fundamental_hz`?)",
        "/fourier/fundamental_hz: is missing",
        "/fourier/order: is 0",
        "/sample_rate_hz: is -1",
        "/constraints/form: is `Paper` (did you mean `paper`?)",
        "/constraints/start_position/1: is a string",
        "/search/starts: is 0, expected a whole number from 1 to 100000",
        "/search/time_limit_s: is 1000000000",
    ];
    for text in expected {
        assert!(found.iter().any(|f| f.starts_with(text)), "{text} not among {found:#?}");
    }
    assert_eq!(found.len(), expected.len(), "{found:#?}");
}

#[test]
fn what_does_not_fit_together_is_found() {
    let harmonics = GOOD.replace("50", "1");
    assert!(findings(&harmonics)[0].starts_with("/fourier/order: 3 harmonics need more than 6 samples per period"));
    let start = GOOD.replace(
        "\"sample_rate_hz\"",
        "\"constraints\": {\"start_position\": [0]}, \"sample_rate_hz\"",
    );
    assert!(findings(&start)[0].starts_with("/constraints/start_position: has 1 value, the robot has 2 joints"));
    let noise = GOOD.replace("\"sample_rate_hz\"", "\"torque_noise\": [0, 1], \"sample_rate_hz\"");
    assert!(findings(&noise)[0].starts_with("/torque_noise/0: is 0"));
    let warm = |start: &str| GOOD.replace("\"sample_rate_hz\"", &format!("\"warm_start\": {start}, \"sample_rate_hz\""));
    let rows = r#"{"coefficients": {"a": [[1, 2, 3]], "b": [[1, 2, 3], [1, 2, 3]]}, "offset": [0, 0], "fundamental_hz": 0.1}"#;
    assert!(
        findings(&warm(rows))[0]
            .starts_with("/warm_start/coefficients/a: must have 2 rows, one per joint, with one number per harmonic")
    );
    let torque = GOOD.replace(
        "\"sample_rate_hz\"",
        "\"constraints\": {\"torque\": {\"limits\": [1, 0], \"safety_factor\": 0.5}}, \"sample_rate_hz\"",
    );
    let found = findings(&torque);
    assert!(
        found[0].starts_with("/constraints/torque/safety_factor: is 0.5; torques stay below"),
        "{found:?}"
    );
    assert!(
        found[1].starts_with("/constraints/torque/limits/1: is 0; a torque limit is a positive number"),
        "{found:?}"
    );
    let space = |of: &str| {
        GOOD.replace("planar_two_link", "iiwa14").replace(
            "\"sample_rate_hz\"",
            &format!("\"constraints\": {{\"space\": {of}}}, \"sample_rate_hz\""),
        )
    };
    let found = findings(&space(r#"{"clearance": 20, "self_collision": {"ignore": [["A1", "A9"]]}}"#));
    assert!(
        found[0].starts_with("/constraints/space/self_collision/ignore/0/1: is `A9`"),
        "{found:?}"
    );
    assert!(
        found[1].starts_with("/constraints/space/clearance: is 20; give metres"),
        "{found:?}"
    );
    let name = GOOD.replace("planar_two_link", "iiwa");
    assert_eq!(findings(&name), ["/robot: is `iiwa` (did you mean `iiwa7`?)"]);
    assert_eq!(findings("[]"), [": is an array, expected an object"]);
}
