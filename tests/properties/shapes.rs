//! Shapes of links: from collision geometry, from `geometry` beside a file, and along the kinematics where there are none.

use dynident::documents::{NamedRobots, RobotDocument, read_excitation_request, robot_document, shipped::Shipped};
use dynident::dynamics::forward_kinematics;
use dynident::formats::parse;
use dynident::model::{Capsule, Robot};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Two links whose axes are not z, a flange with a shape of its own, and links whose frames are those of the base, moved.
const ARM: &str = r#"<robot name="r">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="a">
    <collision><origin xyz="0 0 0.3" rpy="0 0.4 0"/><geometry><box size="0.1 0.16 0.6"/></geometry></collision>
    <collision><origin xyz="0.05 0 0"/><geometry><sphere radius="0.09"/></geometry></collision>
    <collision><geometry><box size="1 nonsense 1"/></geometry></collision>
  </link>
  <link name="b"><collision><origin rpy="1.2 0 0.3"/><geometry><cylinder length="0.5" radius="0.07"/></geometry></collision></link>
  <link name="tool"><collision><geometry><capsule length="0.1" radius="0.03"/></geometry></collision></link>
  <joint name="j1" type="continuous"><origin xyz="0 0 0.2"/><parent link="base"/><child link="a"/><axis xyz="0 1 0"/></joint>
  <joint name="j2" type="prismatic"><origin xyz="0 0 0.6"/><parent link="a"/><child link="b"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint>
  <joint name="f" type="fixed"><origin xyz="0.2 0 0.5"/><parent link="b"/><child link="tool"/></joint>
</robot>"#;

fn read(document: &Value) -> Result<RobotDocument, String> {
    let parsed = parse(document.to_string().as_bytes()).unwrap();
    robot_document(&parsed).map_err(|e| e.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// How far a point of the base frame is inside the nearest capsule of a joint, at zero.
fn depth(robot: &Robot, joint: usize, point: Vector3<f64>) -> f64 {
    let pose = forward_kinematics(robot, &vec![0.0; robot.joint_count()])[joint];
    let of = |c: &Capsule| {
        let [a, b] = c.ends.map(|e| pose.rotation * e + pose.translation);
        let along = b - a;
        let part = (along.dot(&(point - a)) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        c.radius - (point - a - part * along).norm()
    };
    robot.joints()[joint]
        .geometry
        .iter()
        .map(of)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// A point of a shape at `xyz`, turned by roll, pitch and yaw, in a link at `link`.
fn placed(link: [f64; 3], xyz: [f64; 3], rpy: [f64; 3], point: [f64; 3]) -> Vector3<f64> {
    let turn = nalgebra::Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    Vector3::from(link) + Vector3::from(xyz) + turn * Vector3::from(point)
}

#[test]
fn prop_capsules_contain_the_collision_shapes_of_a_file() {
    let read = read(&json!({"urdf": ARM})).unwrap();
    let robot = &read.robot;
    let counts: Vec<usize> = robot.joints().iter().map(|j| j.geometry.len()).collect();
    assert_eq!(
        counts,
        [2, 2],
        "what cannot be read is left out, a flange is part of its link"
    );
    assert!(
        read.notes
            .iter()
            .any(|n| n.contains("link `a` has 1 collision shapes that cannot be read")),
        "{:?}",
        read.notes
    );
    let signs = [-1.0, 1.0];
    for k in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| signs[k >> axis & 1]);
        let corner = placed(
            [0.0, 0.0, 0.2],
            [0.0, 0.0, 0.3],
            [0.0, 0.4, 0.0],
            [0.05 * x, 0.08 * y, 0.3 * z],
        );
        let inside = depth(robot, 0, corner);
        assert!((-1e-12..0.2).contains(&inside), "{inside}");
    }
    for k in 0..24 {
        let (s, c) = (f64::from(k) * 0.26).sin_cos();
        for end in signs {
            let rim = placed([0.0, 0.0, 0.8], [0.0; 3], [1.2, 0.0, 0.3], [0.07 * c, 0.07 * s, 0.25 * end]);
            assert!(depth(robot, 1, rim).abs() < 1e-12, "the rim of a cylinder is on the capsule");
        }
    }
    for end in signs {
        let tip = placed([0.2, 0.0, 1.3], [0.0; 3], [0.0; 3], [0.0, 0.0, 0.08 * end]);
        assert!(depth(robot, 1, tip).abs() < 1e-12, "the tip of the tool");
    }
}

#[test]
fn shapes_beside_a_file_take_the_place_of_its_own() {
    let capsule = json!({"from": [0, 0, 0], "to": [0, 0, 0.4], "radius": 0.05});
    let read_with = |geometry: Value| read(&json!({"urdf": ARM, "geometry": geometry}));
    let robot = read_with(json!({"a": [capsule], "tool": []})).unwrap().robot;
    assert_eq!(robot.joints().iter().map(|j| j.geometry.len()).collect::<Vec<_>>(), [1, 1]);
    // In the frame of the file's link, which stands 0.2 m above the base.
    assert!((depth(&robot, 0, Vector3::new(0.0, 0.0, 0.65)) - 0.0).abs() < 1e-12);
    let refused = read_with(json!({"nobody": [capsule]})).unwrap_err();
    assert!(
        refused.contains("/geometry") && refused.contains("no link `nobody`") && refused.contains("tool"),
        "{refused}"
    );
    let refused = read_with(json!({"a": [{"from": [0, 0, 0], "to": [0, 0, 1], "radius": -1}]})).unwrap_err();
    assert!(refused.contains("/geometry/a/0/radius"), "{refused}");
}

#[test]
fn every_shipped_robot_can_be_asked_to_keep_off_itself() {
    for name in Shipped.names() {
        let own = Shipped.named(&name).unwrap().robot;
        let (shaped, guessed) = own.with_shape();
        let links = shaped.joints().iter().filter(|j| !j.geometry.is_empty()).count();
        assert!(links >= 2 || own.joint_count() < 4, "{name}: {links}");
        let request = json!({"robot": name, "fourier": {"order": 5, "fundamental_hz": 0.1}, "sample_rate_hz": 20,
            "constraints": {"start": "free", "space": {"self_collision": {}}}, "search": {"seed": 1}});
        let read = read_excitation_request(&parse(request.to_string().as_bytes()).unwrap(), &Shipped);
        let read = read.unwrap_or_else(|e| panic!("{name}: {e:?}"));
        let said = read.notes.iter().any(|n| n.contains("stand in for the links of"));
        assert_eq!(said, !guessed.is_empty(), "{name}: {:?}", read.notes);
    }
}

/// A shape of one's own is never added to.
#[test]
fn prop_robots_with_a_shape_keep_it() {
    let robot = read(&json!({"urdf": ARM})).unwrap().robot;
    assert_eq!(robot.with_shape(), (robot.clone(), Vec::new()));
    let bare = read(&json!({"urdf": ARM, "geometry": {"a": [], "b": [], "tool": []}}))
        .unwrap()
        .robot;
    let (shaped, named) = bare.with_shape();
    assert_eq!(named, ["j1"], "the last link has no masses to reach to");
    // From one joint to the next: 0.6 m, as thick as such arms are.
    let [capsule] = shaped.joints()[0].geometry[..] else {
        panic!("one capsule")
    };
    assert!(((capsule.ends[1] - capsule.ends[0]).norm() - 0.6).abs() < 1e-12 && (capsule.radius - 0.036).abs() < 1e-12);
}
