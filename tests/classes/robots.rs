//! Robot files: nesting, cycles, sizes, names, limits, inertias, encodings, other formats.

use super::ways::{CommandLine, Way};
use super::written::{good_rows, log};
use super::{Answer, Case, Expect, RobotFile, refused, try_all};
use serde_json::{Value, json};
use std::fmt::Write;
use std::sync::OnceLock;

const INERTIAL: &str =
    r#"<inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"#;
const LIMIT: &str = r#"<limit lower="-2" upper="2" velocity="2" effort="50"/>"#;

fn joint(name: &str, parent: &str, child: &str, kind: &str, more: &str) -> String {
    format!(
        r#"<joint name="{name}" type="{kind}"><origin xyz="0 0 0.3" rpy="1.5707963267948966 0 0"/><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>{more}</joint>"#
    )
}

/// A chain of `n` joints of a kind, with what else the file holds.
fn chain(n: usize, kind: &str, limit: &str, inertial: &str, more: &str) -> String {
    let mut text = r#"<robot name="c"><link name="l0"/>"#.to_string();
    for i in 1..=n {
        let (parent, child) = (format!("l{}", i - 1), format!("l{i}"));
        write!(
            text,
            r#"<link name="{child}">{inertial}</link>{}"#,
            joint(&format!("j{i}"), &parent, &child, kind, limit)
        )
        .unwrap();
    }
    text + more + "</robot>"
}

fn urdf(text: String) -> RobotFile {
    RobotFile::Urdf(text.into_bytes())
}

fn any(_: &Value) -> Result<(), String> {
    Ok(())
}

fn either() -> Expect {
    Expect::Either(Vec::new(), any)
}

#[test]
fn nesting_is_limited_whatever_is_nested() {
    let mut cases = Vec::new();
    for depth in [300, 5_000, 60_000] {
        for element in ["link", "visual", "geometry", "x:y", "robot"] {
            let (open, close) = (format!("<{element}>").repeat(depth), format!("</{element}>").repeat(depth));
            let text = format!(r#"<robot name="d"><link name="a"/>{open}{close}</robot>"#);
            cases.push(Case::read(format!("{depth} × {element}"), urdf(text), refused(["nested"])));
        }
        let open = format!(r#"<robot name="d">{}"#, "<link>".repeat(depth));
        cases.push(Case::read(format!("{depth} open"), urdf(open), refused([])));
        for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
            let inner = if open == "[" { "" } else { "1" };
            let text = format!(
                r#"{{"name": "x", "joints": {}{inner}{}}}"#,
                open.repeat(depth),
                close.repeat(depth)
            );
            cases.push(Case::read(format!("{depth} × {open}"), RobotFile::Json(text), refused([])));
        }
    }
    for depth in [40, 5_000] {
        let text = format!(
            "<mujoco><worldbody>{}{}</worldbody></mujoco>",
            "<body>".repeat(depth),
            "</body>".repeat(depth)
        );
        cases.push(Case::read(format!("MJCF {depth}"), RobotFile::Mjcf(text), refused([])));
    }
    try_all(&cases);
}

#[test]
fn cycles_of_any_size_are_named_wherever_they_are() {
    let mut cases = Vec::new();
    for size in [1, 2, 3, 17, 1000] {
        let mut ring = String::new();
        for i in 0..size {
            let next = format!("x{}", (i + 1) % size);
            write!(
                ring,
                r#"<link name="x{i}">{INERTIAL}</link>{}"#,
                joint(&format!("r{i}"), &format!("x{i}"), &next, "revolute", LIMIT)
            )
            .unwrap();
        }
        let behind = joint("q", "l2", "x0", "revolute", LIMIT);
        let with = |more: &str| chain(2, "revolute", LIMIT, INERTIAL, more);
        let tip = |text: String, tip: &str| RobotFile::Json(json!({"urdf": text, "tip": tip}).to_string());
        cases.push(Case::read(
            format!("ring of {size}"),
            urdf(format!(r#"<robot name="r">{ring}</robot>"#)),
            refused([]),
        ));
        cases.push(Case::read(format!("ring of {size} beside"), urdf(with(&ring)), either()));
        cases.push(Case::read(
            format!("ring of {size} behind"),
            urdf(with(&(ring.clone() + &behind))),
            refused([]),
        ));
        cases.push(Case::read(
            format!("tip in a ring of {size}"),
            tip(with(&(ring.clone() + &behind)), "x0"),
            refused([]),
        ));
        cases.push(Case::read(
            format!("tip in a ring of {size} apart"),
            tip(with(&ring), "x0"),
            refused([]),
        ));
        // The arm itself can be had by its tip.
        cases.push(Case::read(
            format!("tip before a ring of {size}"),
            tip(with(&ring), "l2"),
            either(),
        ));
    }
    let two_parents = chain(2, "revolute", LIMIT, INERTIAL, &joint("again", "l0", "l2", "revolute", LIMIT));
    cases.push(Case::read("two parents", urdf(two_parents), refused([])));
    let own_child = chain(2, "revolute", LIMIT, INERTIAL, &joint("own", "l2", "l2", "fixed", ""));
    cases.push(Case::read("its own child", urdf(own_child), refused([])));
    try_all(&cases);
}

#[test]
fn large_files_take_no_longer_than_their_size() {
    let mut cases = Vec::new();
    for n in [31, 300, 5_000] {
        cases.push(Case::read(
            format!("chain of {n}"),
            urdf(chain(n, "revolute", LIMIT, INERTIAL, "")),
            refused(["30"]),
        ));
    }
    for n in [31, 2_000, 20_000] {
        cases.push(Case::read(
            format!("fixed chain of {n}"),
            urdf(chain(n, "fixed", "", INERTIAL, "")),
            either(),
        ));
        let leaf = |i: usize| {
            format!(
                r#"<link name="e{i}"/>{}"#,
                joint(&format!("k{i}"), "l0", &format!("e{i}"), "revolute", LIMIT)
            )
        };
        let star: String = (0..n).map(leaf).collect();
        cases.push(Case::read(
            format!("star of {n}"),
            urdf(format!(r#"<robot name="s"><link name="l0"/>{star}</robot>"#)),
            refused([]),
        ));
        cases.push(Case::read(
            format!("{n} empty joints"),
            RobotFile::Json(json!({"name": "m", "joints": vec![json!({}); n]}).to_string()),
            refused(["joints"]),
        ));
    }
    for n in [100, 3_000] {
        let mut text = r#"<robot name="t"><link name="l0"/>"#.to_string();
        for i in 1..=n {
            let (parent, own) = (format!("l{}", i - 1), format!("l{i}"));
            write!(text, r#"<link name="{own}">{INERTIAL}</link><link name="e{i}"/>"#).unwrap();
            text += &joint(&format!("j{i}"), &parent, &own, "revolute", LIMIT);
            text += &joint(&format!("k{i}"), &parent, &format!("e{i}"), "revolute", LIMIT);
        }
        text += "</robot>";
        cases.push(Case::read(
            format!("caterpillar of {n}"),
            urdf(text.clone()),
            refused(["tip"]),
        ));
        let with_tip = json!({"urdf": text, "tip": "l7"}).to_string();
        cases.push(Case::read(
            format!("caterpillar of {n} to a tip"),
            RobotFile::Json(with_tip),
            Expect::Result(any),
        ));
    }
    let many: String = (0..5_000).map(|i| format!(" a{i}=\"1\"")).collect();
    cases.push(Case::read(
        "many attributes",
        urdf(format!(r#"<robot name="a"><link name="b"{many}/></robot>"#)),
        refused([]),
    ));
    let entities = r#"<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]><robot name="&c;"><link name="b"/></robot>"#;
    cases.push(Case::read("entities", urdf(entities.into()), refused([])));
    try_all(&cases);
}

#[test]
fn odd_names_are_refused_or_survive_all_formats() {
    let mut cases = Vec::new();
    let long = "x".repeat(201);
    for name in [
        "a\"b",
        "a<b",
        "a&b",
        "a b",
        "ä",
        "関節",
        "-",
        "--",
        "a--b",
        "a,b",
        "a\tb",
        "a\nb",
        "a\r\nb",
        "a\0b",
        &long,
        "",
        "a\u{202e}b",
        "a\u{7f}b",
        "nan",
        "inf",
        "1",
        "a/b",
        "../x",
        "true",
        "a;b",
        "a'b",
        "]]>",
        "%s",
        "{}",
        "\u{feff}a",
    ] {
        let mut robot: Value = serde_json::from_str(
            &std::fs::read_to_string(format!("{}/examples/robots/planar_two_link.json", env!("CARGO_MANIFEST_DIR"))).unwrap(),
        )
        .unwrap();
        robot["joints"][0]["name"] = json!(name);
        // Its limits go with it, and it is no longer the robot that the program knows.
        robot.as_object_mut().unwrap().remove("id");
        let mut case = Case::identify(
            format!("name {name:?}"),
            log(good_rows()),
            Expect::Either(vec!["/joints/0/name".into()], any),
        );
        case.robot = RobotFile::Json(robot.to_string());
        cases.push(case);
    }
    try_all(&cases);
}

#[test]
fn limits_and_inertias_that_are_none_are_said() {
    let mut cases = Vec::new();
    for limit in [
        "",
        r#"<limit velocity="2" effort="5"/>"#,
        r#"<limit lower="-1e16" upper="1e16" velocity="1000" effort="10000"/>"#,
        r#"<limit lower="0" upper="0" velocity="0" effort="0"/>"#,
        r#"<limit lower="-10000" upper="10000" velocity="1e9" effort="1e9"/>"#,
        r#"<limit lower="-1e308" upper="1e308" velocity="1e308" effort="1e308"/>"#,
        r#"<limit lower="-3.4028235e38" upper="3.4028235e38" velocity="3.4028235e38" effort="3.4028235e38"/>"#,
        r#"<limit lower="-6.28" upper="6.28"/>"#,
    ] {
        cases.push(Case::read(
            format!("limit {limit}"),
            urdf(chain(2, "revolute", limit, INERTIAL, "")),
            Expect::Result(any),
        ));
    }
    for limit in [
        r#"<limit lower="2" upper="-2" velocity="2" effort="5"/>"#,
        r#"<limit lower="x" upper="1" velocity="2" effort="5"/>"#,
        r#"<limit lower="-1" upper="1" velocity="-1" effort="5"/>"#,
        r#"<limit lower="nan" upper="inf" velocity="2" effort="5"/>"#,
    ] {
        cases.push(Case::read(
            format!("limit {limit}"),
            urdf(chain(2, "revolute", limit, INERTIAL, "")),
            Expect::Either(vec!["j1".into()], any),
        ));
    }
    let of = |mass: &str, ixx: &str| {
        format!(
            r#"<inertial><mass value="{mass}"/><inertia ixx="{ixx}" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"#
        )
    };
    for (mass, ixx) in [
        ("0", "0.02"),
        ("-1", "0.02"),
        ("1", "-0.02"),
        ("1", "5"),
        ("1e300", "1e300"),
        ("1e-300", "1e-300"),
        ("nan", "1"),
        ("1,5", "0.02"),
        ("", "0.02"),
        ("1e999", "1"),
    ] {
        cases.push(Case::read(
            format!("mass {mass} inertia {ixx}"),
            urdf(chain(2, "revolute", LIMIT, &of(mass, ixx), "")),
            Expect::Either(vec!["line".into()], any),
        ));
    }
    for inertial in [
        "",
        "<inertial/>",
        r#"<inertial><mass value="1"/></inertial>"#,
        r#"<inertial><origin xyz="1 2"/><mass value="1"/></inertial>"#,
    ] {
        cases.push(Case::read(
            format!("inertial {inertial}"),
            urdf(chain(2, "revolute", LIMIT, inertial, "")),
            either(),
        ));
    }
    try_all(&cases);
}

#[test]
fn other_formats_are_called_what_they_are() {
    let mut cases = Vec::new();
    for (text, word) in [
        (r#"<sdf version="1.6"><model name="x"/></sdf>"#, "SDF"),
        (r#"<mujoco model="a"><worldbody/></mujoco>"#, ""),
        (
            r#"<robot xmlns:xacro="http://x" name="a"><xacro:macro name="m"/></robot>"#,
            "xacro",
        ),
        ("<COLLADA/>", ""),
        ("<html><body/></html>", ""),
        ("", ""),
        ("   ", ""),
        ("<", ""),
        ("<robot", ""),
        ("<robot/>", ""),
        (r#"<robot name="a"><link name="b"></robot>"#, ""),
        (r#"<?xml version="1.0"?>"#, ""),
        ("PK\u{3}\u{4}", ""),
        ("solid mesh", ""),
    ] {
        cases.push(Case::read(format!("text {text}"), urdf(text.into()), refused([word])));
    }
    for text in [
        "{",
        "[]",
        "null",
        "\"x\"",
        "1",
        "{}",
        r#"{"joints": null}"#,
        r#"{"joints": {}}"#,
        r#"{"urdf": 1}"#,
        r#"{"urdf": "<robot/>", "mjcf": "<mujoco/>"}"#,
    ] {
        cases.push(Case::read(format!("JSON {text}"), RobotFile::Json(text.into()), refused([])));
    }
    let umlaut = |declared: &str| {
        format!(r#"<?xml version="1.0" encoding="{declared}"?>"#)
            + &chain(2, "revolute", LIMIT, INERTIAL, "").replace("name=\"c\"", "name=\"Gelenk ü\"")
    };
    let latin = |text: String| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    cases.push(Case::read(
        "Latin-1",
        RobotFile::Urdf(latin(umlaut("iso-8859-1"))),
        Expect::Result(any),
    ));
    cases.push(Case::read(
        "Latin-1 called UTF-8",
        RobotFile::Urdf(latin(umlaut("utf-8"))),
        Expect::Either(vec!["UTF-8".into()], any),
    ));
    cases.push(Case::read(
        "a byte order mark",
        urdf("\u{feff}".to_string() + &umlaut("utf-8")),
        Expect::Result(any),
    ));
    let undeclared = chain(2, "revolute", LIMIT, INERTIAL, r#"<gz:plugin name="x"/><a:b:c/>"#);
    cases.push(Case::read("prefixes", urdf(undeclared), either()));
    try_all(&cases);
}

/// As many as the chain with exact quarter turns has: each rounded turn more would be a parameter that is none.
fn as_many_as_exact(document: &Value) -> Result<(), String> {
    static EXACT: OnceLock<Value> = OnceLock::new();
    let exact = EXACT.get_or_init(|| {
        let read = Case::read("exact", urdf(turned("1.5707963267948966 0 0")), Expect::Result(any));
        match CommandLine::new().answer(&read) {
            Ok(Answer::Done(document)) => document["count"].clone(),
            other => panic!("{other:?}"),
        }
    });
    match exact.is_u64() && document["count"] == *exact {
        true => Ok(()),
        false => Err(format!("{} instead of {exact}", document["count"])),
    }
}

fn turned(rpy: &str) -> String {
    chain(3, "revolute", LIMIT, INERTIAL, "").replace("1.5707963267948966 0 0", rpy)
}

#[test]
fn rounded_quarter_turns_are_quarter_turns() {
    let mut cases = Vec::new();
    for rpy in [
        "1.5708 0 0",
        "1.57080 0 0",
        "1.571 0 0",
        "1.57 0 0",
        "-1.57 0 0",
        "1.57079 0 0",
        "1.570796 0 0",
        "1.5707963 0 0",
    ] {
        cases.push(Case::read(
            format!("rpy {rpy}"),
            urdf(turned(rpy)),
            Expect::Result(as_many_as_exact),
        ));
    }
    try_all(&cases);
}

#[test]
fn grippers_and_branches_are_locked_or_chosen_by_tip() {
    let gripper = r#"<link name="f1"/><link name="f2"/>"#.to_string()
        + &joint("g1", "l3", "f1", "prismatic", LIMIT)
        + &joint(
            "g2",
            "l3",
            "f2",
            "prismatic",
            &format!(r#"{LIMIT}<mimic joint="g1" multiplier="-1"/>"#),
        );
    let text = chain(3, "revolute", LIMIT, INERTIAL, &gripper);
    let with = |fields: Value| {
        let mut document = json!({"urdf": text});
        document.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        RobotFile::Json(document.to_string())
    };
    let cases = [
        Case::read("gripper", urdf(text.clone()), either()),
        Case::read("to the flange", with(json!({"tip": "l3"})), Expect::Result(any)),
        Case::read("to no link", with(json!({"tip": "nope"})), refused(["nope"])),
        Case::read("from no link", with(json!({"base": "nope", "tip": "l3"})), refused(["nope"])),
        Case::read("from tip to base", with(json!({"base": "l3", "tip": "l0"})), refused([])),
        Case::read("from a link to itself", with(json!({"base": "l1", "tip": "l1"})), refused([])),
        Case::read("a part", with(json!({"base": "l1", "tip": "l3"})), Expect::Result(any)),
        Case::read("a number for a tip", with(json!({"tip": 3})), refused(["tip"])),
    ];
    try_all(&cases);
}
