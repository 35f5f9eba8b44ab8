//! Robot files as people have them: read with a note, or refused with link and remedy.

// Quarter turns rounded as vendors publish them are what is tested.
#![allow(clippy::approx_constant)]

use dynident::documents::{RobotDocument, read_excitation_request, robot_document, robot_value};
use dynident::dynamics::{forward_kinematics, inverse_dynamics};
use dynident::excitation::{Criterion, Form, Knowledge, Problem, ProblemSpec, Start};
use dynident::formats::{parse, robot_file, urdf};
use dynident::model::{ChainEnds, Friction, Rounding, from_urdf, from_urdf_rounded};
use dynident::parameters::{BaseParameters, Layout};
use dynident::spatial::Transform;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;
use std::path::PathBuf;

const FRICTION: Friction = Friction {
    viscous: true,
    coulomb: true,
};

fn data(file: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The robot, or everything that is wrong in one text.
fn read(bytes: &[u8], ends: &[(&str, &str)]) -> Result<RobotDocument, String> {
    let mut parsed = robot_file(bytes).map_err(|e| format!("{} ({})", e.detail, e.hint.unwrap_or_default()))?;
    for (end, link) in ends {
        parsed.value[*end] = json!(link);
    }
    robot_document(&parsed).map_err(|errors| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

fn names(document: &RobotDocument) -> Vec<&str> {
    document.robot.joints().iter().map(|j| j.name.as_str()).collect()
}

/// File, ends of the chain, number of joints, and words of the notes.
type Case = (
    &'static str,
    &'static [(&'static str, &'static str)],
    usize,
    &'static [&'static str],
);

/// Files of one kind of difficulty each: the joints of the robot and what the notes say.
#[test]
fn files_that_are_not_quite_right_are_read_and_the_notes_say_what_was_made_of_them() {
    let cases: [Case; 11] = [
        (
            "two_joint_31416.urdf",
            &[],
            2,
            &["joint `j1` (line 1): rpy 3.1416 is read as a half turn"],
        ),
        (
            "mimic_gripper.urdf",
            &[],
            2,
            &["joint `g1` moves a gripper", "joint `g2` follows `g1` (mimic): it is locked"],
        ),
        (
            "mimic_gripper.urdf",
            &[("tip", "l2")],
            2,
            &["joint `g1` moves a gripper", "joint `g2` follows `g1`"],
        ),
        (
            "mimic_gripper.urdf",
            &[("tip", "f1")],
            3,
            &["joint `g2` follows `g1`", "joint `g1` also moves `g2`"],
        ),
        ("mimic_gripper.urdf", &[("base", "l1")], 1, &["joint `g1` moves a gripper"]),
        ("mimic_gripper_tip.json", &[], 2, &["joint `g2` follows `g1` (mimic)"]),
        (
            "huge_lim.urdf",
            &[],
            2,
            &[
                "joint `j1`: the position limits [-1e16, 1e16] are taken as none",
                "joint `j2`: the position limits",
            ],
        ),
        ("prefix.urdf", &[], 2, &["does not declare the XML prefix `drake`"]),
        (
            "no_inertia.urdf",
            &[],
            2,
            &["link `l2` (line 1) has an <inertial> without <inertia>"],
        ),
        (
            "negative_inertia.urdf",
            &[],
            2,
            &["link `l2` (line 1) has an inertia with the principal moment -1.000e-2"],
        ),
        ("zero_mass.urdf", &[], 2, &["link `l2` (line 1) states a mass of 0"]),
    ];
    for (file, ends, joints, notes) in cases {
        let found = read(&data(&format!("robots/{file}")), ends).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert_eq!(found.robot.joint_count(), joints, "{file} {ends:?}");
        for note in notes {
            assert!(
                found.notes.iter().any(|n| n.contains(note)),
                "{file}: `{note}` not in {:#?}",
                found.notes
            );
        }
    }
    let latin = read(&data("robots/latin1.urdf"), &[]).unwrap();
    assert_eq!((names(&latin), latin.notes.len()), (vec!["j1", "j2"], 0));
    assert_eq!(
        read(&data("robots/prefix.urdf"), &[]).unwrap().robot.joints()[0]
            .limits
            .acceleration,
        Some(15.0)
    );
    // A mass of nothing predicts torques without it, instead of none at all.
    let massless = read(&data("robots/zero_mass.urdf"), &[]).unwrap();
    assert_eq!(massless.robot.joints()[1].prior.unwrap().inertia.mass, 0.0);
}

#[test]
fn files_that_are_no_serial_arm_are_refused_with_the_reason_and_the_remedy() {
    let deep = || data("robots/deep_link_4000.urdf");
    let packed = |file: &str| data(&format!("robots/{file}"));
    let cases: [(Vec<u8>, &[&str]); 9] = [
        (deep(), &["/urdf: has elements nested more than 200 levels deep"]),
        (packed("urdf_cycle_tip.json"), &["/urdf: has a closed loop", "`x`", "`y`", "`j2`", "`j3`", "remove one of these joints"]),
        (packed("cater_rev_300.urdf.gz"), &["has 300 chains", "and 292 more", "in `tip`"]),
        (packed("xacro_macro.urdf"), &["/urdf: is xacro", "in line 1", "xacro robot.urdf.xacro > robot.urdf"]),
        (packed("sdf.urdf"), &["/urdf: is SDF"]),
        (packed("robot_nl_name.json"), &["/joints/0/name: has the character U+000A"]),
        (
            br#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
                <origin xyz="0 0 0,5"/></joint></robot>"#
                .to_vec(),
            &["joint `j`, line 2: xyz of <origin> is `0 0 0,5`", "decimal points"],
        ),
        (
            br#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="floating"><parent link="a"/><child link="b"/></joint>
                <link name="c"/><joint name="k" type="revolute"><parent link="b"/><child link="c"/></joint></robot>"#
                .to_vec(),
            &["joint `j` (line 1) is floating", "`base`: `b`"],
        ),
        (
            br#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>
                <limit lower="-170" upper="170" velocity="1" effort="1"/></joint></robot>"#
                .to_vec(),
            &["joint `j` (line 1): limits/position is [-170, 170] rad", "degrees"],
        ),
    ];
    for (bytes, texts) in cases {
        let error = read(&bytes, &[]).unwrap_err();
        for text in texts {
            assert!(error.contains(text), "`{text}` not in {error}");
        }
    }
    let unknown = read(&data("robots/mimic_gripper.urdf"), &[("tip", "l3")]).unwrap_err();
    assert!(
        unknown.contains("/tip: the file has no link `l3`") && unknown.contains("`l2`"),
        "{unknown}"
    );
    let above = read(&data("robots/mimic_gripper.urdf"), &[("tip", "l1"), ("base", "l2")]).unwrap_err();
    assert!(above.contains("/tip: `l1` does not hang on the link `l2`"), "{above}");
}

/// A base that is no longer rounded has the parameters of the exact one.
#[test]
fn rounded_quarter_turns_have_the_base_parameters_of_exact_ones() {
    let text = String::from_utf8(data("robots/two_joint_31416.urdf")).unwrap();
    let count = |text: &str| BaseParameters::exact(&read(text.as_bytes(), &[]).unwrap().robot).len();
    let exact = count(&text.replace("3.1416", &PI.to_string()));
    for rounded in ["3.1416", "3.14159", "3.14", "3.1415", "-3.14159", "3.142", "3.1415925"] {
        assert_eq!(count(&text.replace("3.1416", rounded)), exact, "{rounded}");
    }
    // One that is tilted on purpose has more.
    assert_eq!(count(&text.replace("3.1416", "3.1302")), exact + 2);
    let iiwa = include_str!("../../examples/robots/iiwa14.urdf");
    for digits in 2..=9 {
        for turn in [FRAC_PI_2, PI] {
            let written = turn.to_string();
            let cut = &written[..written.find('.').unwrap() + 1 + digits];
            let rounded = format!("{turn:.digits$}");
            for other in [cut, &rounded] {
                let variant = iiwa.replace(&written, other);
                assert_eq!(count(&variant), 57, "{written} as {other}");
            }
        }
    }
    let dh = json!({"name": "dh", "joints": [
        {"name": "a", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0.3}},
        {"name": "b", "kind": "revolute", "mdh": {"alpha": 1.5708, "d": 0, "theta": 0, "r": 0}},
        {"name": "c", "kind": "revolute", "mdh": {"alpha": 3.14159, "d": 0.4, "theta": 1.57, "r": 0}}]});
    let of_dh = |v: &Value| robot_document(&parse(v.to_string().as_bytes()).unwrap()).unwrap();
    let mut exact = dh.clone();
    exact["joints"][1]["mdh"]["alpha"] = json!(FRAC_PI_2);
    exact["joints"][2]["mdh"]["alpha"] = json!(PI);
    exact["joints"][2]["mdh"]["theta"] = json!(FRAC_PI_2);
    assert_eq!(of_dh(&dh).robot, of_dh(&exact).robot);
    assert_eq!((of_dh(&dh).notes.len(), of_dh(&exact).notes.len()), (3, 0));
}

/// A random tree of links with its answer: parents, kinds and names are known to whoever made it.
struct RandomTree {
    parent: Vec<usize>,
    kind: Vec<&'static str>,
    follows: Vec<Option<usize>>,
}

impl RandomTree {
    fn new(rng: &mut ChaCha8Rng) -> Self {
        let links = rng.random_range(2..40usize);
        // Long chains or bushes.
        let reach = rng.random_range(1..links + 1);
        let kinds = ["revolute", "continuous", "prismatic", "fixed", "fixed", "floating"];
        let parent: Vec<usize> = (0..links)
            .map(|l| rng.random_range(l.saturating_sub(reach)..l.max(1)))
            .collect();
        let kind = (0..links).map(|_| kinds[rng.random_range(0..kinds.len())]).collect();
        let follows = (0..links)
            .map(|_| (rng.random_range(0..6) == 0).then(|| rng.random_range(1..links)))
            .collect();
        Self { parent, kind, follows }
    }

    fn joint(&self, link: usize, parent: &str) -> String {
        let mimic = self.follows[link].map_or(String::new(), |f| format!("<mimic joint=\"j{f}\"/>"));
        format!(
            "<joint name=\"j{link}\" type=\"{}\"><parent link=\"{parent}\"/><child link=\"l{link}\"/><origin xyz=\"0.1 0 0.2\" rpy=\"1.5708 0 0\"/>\
             <axis xyz=\"0 0 1\"/>{mimic}<limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>\n",
            self.kind[link]
        )
    }

    fn urdf(&self) -> String {
        let mut text = "<robot name=\"random\">\n".to_string();
        for link in 0..self.parent.len() {
            writeln!(
                text,
                "<link name=\"l{link}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
            )
            .unwrap();
        }
        let joints: String = (1..self.parent.len())
            .map(|l| self.joint(l, &format!("l{}", self.parent[l])))
            .collect();
        text + &joints + "</robot>"
    }

    /// Links from the root to `tip`, the root left out.
    fn path(&self, tip: usize) -> Vec<usize> {
        let mut path: Vec<usize> = std::iter::successors(Some(tip), |&l| Some(self.parent[l]))
            .take_while(|&l| l > 0)
            .collect();
        path.reverse();
        path
    }
}

#[test]
fn prop_random_trees_are_read_as_the_chain_to_their_tip_or_refused_by_name() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let (mut chains, mut refused) = (0, 0);
    for _ in 0..400 {
        let tree = RandomTree::new(&mut rng);
        let links = tree.parent.len();
        let tip = rng.random_range(1..links);
        let text = tree.urdf();
        let found = from_urdf(
            &text,
            Vector3::new(0.0, 0.0, -9.81),
            FRICTION,
            ChainEnds {
                base: None,
                tip: Some(&format!("l{tip}")),
            },
        );
        let path = tree.path(tip);
        let moves = |l: &&usize| ["revolute", "continuous", "prismatic"].contains(&tree.kind[**l]);
        // What hangs behind the last movable joint of the path is locked, whatever it is called.
        let last = path.iter().rposition(|l| tree.kind[*l] != "fixed").map_or(0, |at| at + 1);
        let bad = path[..last]
            .iter()
            .find(|&&l| tree.kind[l] == "floating" || tree.follows[l].is_some() && tree.kind[l] != "fixed");
        match (found, bad) {
            (Ok(read), None) => {
                let expected: Vec<String> = path.iter().filter(moves).map(|l| format!("j{l}")).collect();
                let names: Vec<String> = read.robot.joints().iter().map(|j| j.name.clone()).collect();
                assert_eq!(names, expected);
                // Every link below the first movable joint is in exactly one body.
                let first = *path.iter().find(moves).unwrap();
                let carried = (1..links).filter(|&l| tree.path(l).contains(&first)).count();
                let mass: f64 = read.robot.joints().iter().map(|j| j.prior.unwrap().inertia.mass).sum();
                assert_eq!(mass, carried as f64, "{text}");
                chains += 1;
            }
            (Err(e), Some(bad)) => {
                assert!(e.to_string().contains(&format!("joint `j{bad}`")), "{e}");
                refused += 1;
            }
            (Err(e), None) => {
                assert!(path.iter().filter(moves).count() == 0, "{e}\n{text}");
                assert!(e.to_string().contains("no movable joint"), "{e}");
            }
            (Ok(read), Some(bad)) => panic!("j{bad} is on the chain of {:?}", read.robot.joint_count()),
        }
        // Without a tip it ends too, with an arm or with names.
        if let Err(e) = from_urdf(&text, Vector3::zeros(), FRICTION, ChainEnds::default()) {
            let text = e.to_string();
            assert!(text.contains("`") || text.contains("no movable joint"), "{text}");
        }
    }
    assert!(chains > 50 && refused > 50, "{chains} {refused}");
}

#[test]
fn prop_closed_loops_are_named_wherever_they_are() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    for _ in 0..100 {
        let tree = RandomTree::new(&mut rng);
        // A ring of its own beside the tree.
        let ring = rng.random_range(1..30usize);
        let mut text = tree.urdf().replace("</robot>", "");
        for k in 0..ring {
            let next = (k + 1) % ring;
            write!(
                text,
                "<link name=\"r{k}\"/><joint name=\"c{k}\" type=\"continuous\"><parent link=\"r{k}\"/><child link=\"r{next}\"/></joint>"
            )
            .unwrap();
        }
        text += "</robot>";
        for tip in ["l1", "r0"] {
            let ends = ChainEnds {
                base: None,
                tip: Some(tip),
            };
            let error = from_urdf(&text, Vector3::zeros(), FRICTION, ends).unwrap_err().to_string();
            assert!(error.contains("closed loop") && error.contains("`r0`") || ring > 8, "{error}");
        }
    }
}

/// Work grows with the size of a file, not faster.
#[test]
fn large_files_take_work_in_proportion_to_their_size() {
    let caterpillar = |joints: usize| {
        let mut text = "<robot name=\"c\"><link name=\"l0\"/>".to_string();
        for k in 1..=joints {
            let before = k - 1;
            write!(
                text,
                "<link name=\"l{k}\"/><link name=\"e{k}\"/><joint name=\"j{k}\" type=\"revolute\"><parent link=\"l{before}\"/><child link=\"l{k}\"/></joint>\
                 <joint name=\"f{k}\" type=\"revolute\"><parent link=\"l{before}\"/><child link=\"e{k}\"/></joint>"
            )
            .unwrap();
        }
        text + "</robot>"
    };
    let seconds = |joints: usize| {
        let text = caterpillar(joints);
        let best = (0..3).map(|_| {
            let start = std::time::Instant::now();
            let error = read(text.as_bytes(), &[]).unwrap_err();
            assert!(error.contains(&format!("has {} chains", joints + 1)), "{error}");
            start.elapsed().as_secs_f64()
        });
        best.fold(f64::INFINITY, f64::min)
    };
    // Milliseconds; work that grows with the square takes minutes for this file, however busy the machine is.
    let large = seconds(8_000);
    assert!(large < 10.0, "{large} s");
    let joints = json!({"name": "many", "joints": vec![json!({}); 50_000]});
    let start = std::time::Instant::now();
    let error = read(joints.to_string().as_bytes(), &[]).unwrap_err();
    assert_eq!(error, "/joints: has 50000 joints, the most accepted is 30");
    assert!(start.elapsed().as_secs_f64() < 10.0);
}

fn written_and_read(document: &Value) -> (RobotDocument, RobotDocument, RobotDocument) {
    let original = robot_document(&parse(document.to_string().as_bytes()).unwrap()).unwrap_or_else(|e| panic!("{e:#?}"));
    let text = urdf(&original.robot);
    let xml = from_urdf_rounded(
        &text,
        original.robot.gravity(),
        original.robot.friction(),
        ChainEnds::default(),
        Rounding::AsWritten,
    )
    .unwrap_or_else(|e| panic!("{e}\n{text}"));
    let value = robot_value(&original.robot);
    let json = robot_document(&parse(value.to_string().as_bytes()).unwrap()).unwrap();
    let xml = RobotDocument {
        robot: xml.robot,
        notes: xml.notes,
        effects: Vec::new(),
    };
    (original, xml, json)
}

/// Robots without limits, with unusual names and extreme parameters survive being written and read.
#[test]
fn prop_unusual_robots_round_trip_through_urdf_and_json() {
    let body = |mass: f64, size: f64| {
        json!({"mass": mass, "center_of_mass": [size, -size, 0.5 * size], "viscous": 1e-3 * mass, "coulomb": 0,
            "inertia": {"xx": mass * size * size, "xy": 0, "xz": 0, "yy": mass * size * size, "yz": 0, "zz": mass * size * size}})
    };
    let joint = |name: &str, kind: &str, limits: Value, prior: Value| {
        json!({"name": name, "kind": kind, "placement": {"xyz": [0.1, 0.2, 0.3], "rpy": [0.4, 1.5708, -0.2], "axis": [0, 0.6, 0.8]},
            "limits": limits, "prior": prior})
    };
    let extremes = [(1e6, 10.0), (1e-9, 1e-6), (0.0, 0.0), (1e-300, 1e-3), (3.0, 0.2)];
    for (k, (mass, size)) in extremes.into_iter().enumerate() {
        let document = json!({"name": "Größe <&\"'> --> a---b, c;d", "joints": [
            joint("a, \"b\" & <c>", "revolute", json!({"velocity": null}), body(mass, size)),
            joint("A--1---", "prismatic", json!({"velocity": 2}), body(1.0, 0.1)),
            joint("関節 3", "revolute", json!({"position": [-1, 2], "effort": null}), body(2.0, 0.1))]});
        let (original, xml, json) = written_and_read(&document);
        for read in [&xml, &json] {
            assert_eq!(names(read), names(&original));
            for (a, b) in read.robot.joints().iter().zip(original.robot.joints()) {
                assert_eq!(a.limits, b.limits, "{k}");
                let (a, b) = (a.prior.unwrap().inertia, b.prior.unwrap().inertia);
                assert!((a.mass - b.mass).abs() <= 1e-12 * b.mass, "{k}: {} {}", a.mass, b.mass);
                assert!((a.center_of_mass - b.center_of_mass).amax() <= 1e-12 * (1.0 + size), "{k}");
                assert!(
                    (a.inertia - b.inertia).amax() <= 1e-9 * b.inertia.amax().max(mass * size * size),
                    "{k}"
                );
            }
        }
    }
}

/// What a design cannot be asked is said before anything is searched.
#[test]
fn requests_beyond_the_limits_are_refused_at_once() {
    let refused = |text: &[u8], expected: &[&str]| {
        let start = std::time::Instant::now();
        let errors = read_excitation_request(&parse(text).unwrap(), &dynident::documents::shipped::Shipped).unwrap_err();
        let all: String = errors.iter().map(|e| format!("{e}\n")).collect();
        for text in expected {
            assert!(all.contains(text), "`{text}` not in {all}");
        }
        assert!(start.elapsed().as_secs_f64() < 20.0, "{all}");
    };
    refused(&data("requests/x_noisetiny.json"), &["/torque_noise/0: is 1e-300"]);
    let base = json!({"robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50});
    let with = |pointer: &str, value: Value| {
        let mut request = base.clone();
        match pointer.split_once('/') {
            Some((outer, inner)) => request[outer][inner] = value,
            None => request[pointer] = value,
        }
        request.to_string().into_bytes()
    };
    refused(
        &with("fourier/order", json!(999_999)),
        &["/fourier/order: is 999999, the highest accepted is 50"],
    );
    refused(
        &with("fourier/fundamental_hz", json!(1e-300)),
        &["/fourier/fundamental_hz: is 1e-300"],
    );
    refused(
        &with("fourier/harmonics", json!(vec![vec![1; 100_000]; 2])),
        &["has 100000 harmonics"],
    );
    refused(&with("sample_rate_hz", json!(1e300)), &["/sample_rate_hz"]);
    let motion = json!([{"coefficients": {"a": [[1], [1]], "b": [[1], [1]]}, "offset": [0, 0], "fundamental_hz": 1e-4}]);
    let mut request = base.clone();
    request["sample_rate_hz"] = json!(5000);
    request["given"] = motion;
    refused(
        request.to_string().as_bytes(),
        &["/given/0/fundamental_hz: gives 50000000 samples"],
    );
    let boxes = vec![json!({"name": "b", "center": [1, 1, 1], "size": [1, 1, 1]}); 10_000];
    refused(
        &with("constraints", json!({"space": {"boxes": boxes}})),
        &["has 10000 boxes, the most accepted is 200"],
    );
    let nested = format!("{{\"robot\": {}1{}}}", "[".repeat(500), "]".repeat(500));
    assert!(parse(nested.as_bytes()).unwrap_err().detail.contains("100 levels"));
}

/// A million mistakes cost no more than a hundred.
#[test]
fn prop_documents_of_mistakes_are_read_in_time_proportional_to_their_size() {
    let name = "x".repeat(10_000);
    let unknown: String = (0..100_000).map(|i| format!("\"f{i}\": NaN,")).collect();
    for text in [
        format!("{{{unknown} \"robot\": 1}}"),
        format!("{{\"{name}\": [{}0]}}", "NaN,".repeat(100_000)),
        format!(
            "{{\"robot\": {{\"joints\": [{}{{}}]}}}}",
            "{},".repeat(29) + &"{\"a\": 1},".repeat(0)
        ),
        format!("{{\"given\": [{}0]}}", "0,".repeat(100_000)),
    ] {
        let start = std::time::Instant::now();
        let parsed = parse(text.as_bytes()).unwrap();
        let errors = read_excitation_request(&parsed, &dynident::documents::shipped::Shipped).unwrap_err();
        assert!(errors.len() <= 102, "{}", errors.len());
        assert!(start.elapsed().as_secs_f64() < 30.0);
    }
}

/// The regressor of any exact spec still works: limits do not stand in the way of ordinary designs.
#[test]
fn an_ordinary_problem_is_within_all_limits() {
    let robot = read(&data("robots/huge_lim.urdf"), &[]).unwrap().robot;
    let spec = ProblemSpec {
        robot,
        order: 5,
        harmonics: None,
        fundamental_hz: 0.1,
        sample_rate_hz: 100.0,
        criterion: Criterion::ConditionNumber,
        form: Form::Paper,
        start: Start::Zero,
        start_position: None,
        torque_noise: None,
        torque: None,
        space: None,
        knowledge: Knowledge::default(),
    };
    // No position limits, and a velocity limit: that is enough.
    Problem::new(spec).unwrap();
}

/// MuJoCo's own torques of a model with every kind of orientation, default classes, references, anchors, frames and two joints on
/// one body.
#[test]
fn val_torques_of_an_mjcf_file_are_those_of_mujoco() {
    let read = read(&data("ref_mjcf.xml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let reference: Value = serde_json::from_slice(&data("ref_mjcf.json")).unwrap();
    assert_eq!(json!(names(&read)), reference["joints"]);
    assert_eq!(read.robot.gravity(), Vector3::new(0.3, -0.2, -9.7));
    let [low, high] = read.robot.joints()[0].limits.position.unwrap();
    assert!((low.to_degrees() + 170.0).abs() < 1e-12 && (high.to_degrees() - 170.0).abs() < 1e-12);
    let layout = Layout::standard(&read.robot);
    let phi = layout.prior(&read.robot).expect("every body has an inertial");
    for state in reference["states"].as_array().unwrap() {
        let list = |name: &str| -> Vec<f64> { state[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
        let torque = inverse_dynamics(&read.robot, &layout, phi.as_slice(), &list("q"), &list("qd"), &list("qdd"));
        for (ours, theirs) in torque.iter().zip(list("torque")) {
            // The quaternion of the file has eight digits, and MuJoCo reads it as they are.
            assert!((ours - theirs).abs() < 1e-6 * (1.0 + theirs.abs()), "{ours} {theirs}");
        }
    }
    let small = read_document(&data("robots/mjcf.xml"));
    assert_eq!(names(&small), ["j"]);
    let wrong = |xml: &str| read_text(xml).unwrap_err();
    assert!(wrong("<mujoco><include file='a.xml'/></mujoco>").contains("<include> in line 1"));
    assert!(
        wrong("<mujoco><worldbody><body name='b'><freejoint/><body name='c'><joint/></body></body></worldbody></mujoco>")
            .contains("is free")
    );
    assert!(wrong("<mujoco><worldbody><body name='b'><joint axis='0 0'/></body></worldbody></mujoco>").contains("axis is `0 0`"));
    let coupled = "<mujoco><worldbody><body name='b'><joint name='a'/><body name='c'><joint name='f'/></body><body name='d'><joint name='g'/></body></body>\
        </worldbody><equality><joint joint1='g' joint2='f'/></equality></mujoco>";
    let gripper = read_document(coupled.as_bytes());
    assert_eq!(names(&gripper), ["a"], "{:?}", gripper.notes);
}

fn read_document(bytes: &[u8]) -> RobotDocument {
    read(bytes, &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn read_text(text: &str) -> Result<RobotDocument, String> {
    read(text.as_bytes(), &[])
}

/// The three ways of writing one table are one robot, and a table that looks like another is said to.
#[test]
fn dh_tables_of_all_conventions_are_the_same_robot() {
    let body = |mass: f64| json!({"mass": mass, "center_of_mass": [0.1, -0.05, 0.2], "inertia": {"xx": 0.02, "xy": 0, "xz": 0, "yy": 0.03, "yz": 0, "zz": 0.025}});
    let table = [
        [0.0, FRAC_PI_2, 0.16, 0.1],
        [-0.42, 0.0, 0.0, 0.0],
        [-0.39, 0.0, 0.13, 0.3],
        [0.0, FRAC_PI_2, 0.1, 0.0],
        [0.0, 0.0, 0.1, 0.0],
    ];
    let joint = |k: usize| json!({"name": format!("J{k}"), "kind": "revolute", "limits": {"velocity": 1}});
    let standard: Vec<Value> = (0..5)
        .map(|k| {
            let ([a, alpha, d, theta], mut joint) = (table[k], joint(k));
            joint["dh"] = json!({"convention": "standard", "a": a, "alpha": alpha, "d": d, "theta": theta});
            joint["prior"] = body(1.0 + k as f64);
            joint
        })
        .collect();
    // Row i of a modified table has a and alpha of row i − 1 of the standard one.
    let modified = |convention: &str| -> Vec<Value> {
        (0..5)
            .map(|k| {
                let before = if k == 0 { [0.0; 4] } else { table[k - 1] };
                let ([_, _, d, theta], mut joint) = (table[k], joint(k));
                joint["dh"] = json!({"convention": convention, "a": before[0], "alpha": before[1], "d": d, "theta": theta});
                joint
            })
            .collect()
    };
    let of = |joints: &[Value]| read_document(json!({"name": "dh", "joints": joints}).to_string().as_bytes());
    let (one, craig, khalil) = (of(&standard), of(&modified("craig")), of(&modified("khalil")));
    assert_eq!(
        (one.notes.len(), craig.notes.len()),
        (0, 0),
        "{:?} {:?}",
        one.notes,
        craig.notes
    );
    for other in [&craig, &khalil] {
        for (a, b) in one.robot.joints().iter().zip(other.robot.joints()) {
            assert!((a.placement.rotation - b.placement.rotation).amax() < 1e-15);
            assert!((a.placement.translation - b.placement.translation).amax() < 1e-15);
            assert_eq!(a.mdh.is_some(), b.mdh.is_some());
        }
    }
    // The flange of the textbook's own product of rows, and the centre of mass in the frame at the end of a row.
    let q = [0.3, -0.7, 1.1, 0.4, -0.2];
    let end = (0..5).fold(Transform::identity(), |t, k| {
        let [a, alpha, d, theta] = table[k];
        t * Transform::rot_z(q[k] + theta) * Transform::trans(a, 0.0, d) * Transform::rot_x(alpha)
    });
    let frame = forward_kinematics(&one.robot, &q)[4];
    let com = |t: &Transform, c: Vector3<f64>| t.rotation * c + t.translation;
    let ours = com(&frame, one.robot.joints()[4].prior.unwrap().inertia.center_of_mass);
    assert!((ours - com(&end, Vector3::new(0.1, -0.05, 0.2))).amax() < 1e-14);
    let mut mistaken = modified("craig");
    for (k, joint) in mistaken.iter_mut().enumerate() {
        joint["dh"] = json!({"convention": "craig", "a": table[k][0], "alpha": table[k][1], "d": table[k][2], "theta": 0});
    }
    assert!(of(&mistaken).notes[0].contains("looks like standard DH"));
}

/// Forty files as people have them against Pinocchio's reading of the same arms written exactly: joints, number of base
/// parameters, torques.
#[test]
fn val_forty_urdf_variants_have_the_base_parameters_and_torques_of_pinocchio() {
    let reference: Value = serde_json::from_slice(&data("ref_urdf_variants.json")).unwrap();
    let variants = reference["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 40);
    for (k, variant) in variants.iter().enumerate() {
        let tip = variant["tip"].as_str().map(|tip| ("tip", tip));
        let found = read(variant["urdf"].as_str().unwrap().as_bytes(), tip.as_slice());
        let robot = found.unwrap_or_else(|e| panic!("{k} {}: {e}", variant["traits"])).robot;
        let names: Vec<&str> = robot.joints().iter().map(|j| j.name.as_str()).collect();
        assert_eq!(json!(names), variant["joints"], "{k}");
        let inertial = BaseParameters::exact(&robot).len() - 2 * robot.joint_count();
        assert_eq!(
            json!(inertial),
            variant["inertial_base_parameters"],
            "{k} {}",
            variant["traits"]
        );
        let layout = Layout::standard(&robot);
        let phi = layout.prior(&robot).expect("every link has an inertial");
        for state in variant["states"].as_array().unwrap() {
            let list = |name: &str| -> Vec<f64> { state[name].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
            let torque = inverse_dynamics(&robot, &layout, phi.as_slice(), &list("q"), &list("qd"), &list("qdd"));
            for (ours, theirs) in torque.iter().zip(list("torque")) {
                assert!((ours - theirs).abs() < 1e-9 * (1.0 + theirs.abs()), "{k}: {ours} {theirs}");
            }
        }
    }
}
