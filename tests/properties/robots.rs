//! Robots from documents: the same arm given in different ways has the same torques.

use crate::support::{rng, vectors};
use dynident::documents::shipped::Shipped;
use dynident::documents::{NamedRobots, RobotDocument, robot_document};
use dynident::dynamics::{forward_kinematics, inverse_dynamics};
use dynident::formats::{parse, robot_file, urdf, urdf_gravity};
use dynident::model::{ChainEnds, Robot, from_urdf};
use dynident::parameters::Layout;
use dynident::spatial::Transform;
use nalgebra::{Matrix3, Vector3};

fn from_text(text: &str) -> RobotDocument {
    let parsed = robot_file(text.as_bytes()).unwrap();
    robot_document(&parsed).unwrap_or_else(|e| panic!("{e:#?}"))
}

/// Torques of the prior parameters at random states.
fn torques(robot: &Robot) -> Vec<Vec<f64>> {
    let layout = Layout::standard(robot);
    let phi = layout.prior(robot).expect("every link has a prior");
    let n = robot.joint_count();
    let mut rng = rng(7);
    let states: Vec<_> = (0..50).map(|_| vectors(&mut rng, 3, n, 2.0)).collect();
    states
        .iter()
        .map(|s| inverse_dynamics(robot, &layout, phi.as_slice(), &s[0], &s[1], &s[2]))
        .collect()
}

fn assert_same_torques(one: &Robot, other: &Robot) {
    for (a, b) in torques(one).iter().flatten().zip(torques(other).iter().flatten()) {
        // Sums of some hundred products of numbers up to 100: rounding stays below 1e-11.
        assert!((a - b).abs() < 1e-11, "{a} {b}");
    }
}

#[test]
fn prop_mdh_and_urdf_of_the_iiwa_have_the_same_torques() {
    let urdf = from_text(include_str!("../../examples/robots/iiwa14.urdf"));
    assert!(urdf.notes.is_empty(), "{:?}", urdf.notes);
    let mdh = Shipped.named("iiwa14").unwrap().robot;
    assert_same_torques(&urdf.robot, &mdh);
    for (a, b) in urdf.robot.joints().iter().zip(mdh.joints()) {
        assert_eq!((&a.name, a.limits), (&b.name, b.limits));
    }
}

/// Exported URDFs have no gravity of their own: the base is turned, so that it points along −z of the root.
#[test]
fn prop_an_exported_urdf_keeps_its_mounting() {
    let upright = Shipped.named("iiwa14").unwrap().robot;
    let size = upright.gravity().norm();
    for along in [
        [0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.3, -0.8, 0.35],
    ] {
        let mounted = upright.with_gravity(Vector3::from(along).normalize() * size);
        let text = urdf(&mounted);
        assert_eq!(text.contains("fixed"), along != [0.0, 0.0, -1.0], "{along:?}");
        let read = from_urdf(&text, urdf_gravity(&mounted), mounted.friction(), ChainEnds::default()).unwrap();
        for (a, b) in torques(&mounted).iter().flatten().zip(torques(&read.robot).iter().flatten()) {
            // Roll, pitch and yaw of a turn are rounded to 1e-16, and so is gravity of 9.81 m/s² with them.
            assert!((a - b).abs() < 1e-10, "{along:?}: {a} {b}");
        }
    }
}

/// A two-joint arm on a tilted pedestal, the first link of two bodies joined by a fixed joint, axes along no coordinate axis.
const SPLIT: &str = r#"<robot name="split">
  <link name="world"/><link name="pedestal"/>
  <joint name="stand" type="fixed"><parent link="world"/><child link="pedestal"/><origin xyz="0.1 0.2 0.3" rpy="0.4 -0.2 0.9"/></joint>
  <link name="a"><inertial><origin xyz="0.1 0 0.05" rpy="0.3 0 0"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0" iyz="-0.002"/></inertial></link>
  <joint name="j1" type="revolute"><parent link="pedestal"/><child link="a"/><origin xyz="0 0 0.2" rpy="0 0.5 0"/><axis xyz="0.6 0 -0.8"/>
    <limit lower="-1" upper="2" velocity="1" effort="9"/></joint>
  <link name="a_motor"><inertial><origin xyz="0 0.02 0" rpy="0 0 0"/><mass value="1.5"/>
    <inertia ixx="0.004" iyy="0.003" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="bolts" type="fixed"><parent link="a"/><child link="a_motor"/><origin xyz="0.2 -0.1 0.3" rpy="1 0.2 -0.4"/></joint>
  <link name="b"><inertial><origin xyz="0 0.3 0" rpy="0 0 0"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.002" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j2" type="prismatic"><parent link="a_motor"/><child link="b"/><origin xyz="0 0.4 0" rpy="0 0 0.7"/><axis xyz="0 2 0"/>
    <limit lower="0" upper="0.5" velocity="1" effort="9"/></joint>
</robot>"#;

/// Torques are linear in the bodies: those of the whole are the sum over robots in which one body alone has mass.
#[test]
fn prop_merged_bodies_have_the_torques_of_the_bodies_one_by_one() {
    let whole = from_text(SPLIT).robot;
    let bodies = [("a\"", 2.0), ("a_motor\"", 1.5), ("b\"", 1.0)];
    let mut sum = vec![vec![0.0; 2]; 50];
    for (link, mass) in bodies {
        // All other masses and inertias are set to zero.
        let alone: String = SPLIT
            .split("<link name=\"")
            .map(|part| {
                if part.starts_with(link) {
                    part.to_string()
                } else {
                    massless(part)
                }
            })
            .collect::<Vec<_>>()
            .join("<link name=\"");
        let robot = from_text(&alone).robot;
        let total: f64 = robot.joints().iter().map(|j| j.prior.unwrap().inertia.mass).sum();
        assert!((total - mass).abs() < 1e-12);
        for (s, t) in sum.iter_mut().flatten().zip(torques(&robot).iter().flatten()) {
            *s += t;
        }
    }
    for (s, t) in sum.iter().flatten().zip(torques(&whole).iter().flatten()) {
        assert!((s - t).abs() < 1e-11, "{s} {t}");
    }
}

fn massless(part: &str) -> String {
    // A body of no mass at all has no centre of mass: 1e-15 kg stand in, far below the bound of the comparison.
    let text = ["2", "1.5", "1"].iter().fold(part.to_string(), |text, mass| {
        text.replace(&format!("<mass value=\"{mass}\""), "<mass value=\"1e-15\"")
    });
    match (text.find("ixx="), text.find("iyz=")) {
        (Some(from), Some(to)) => {
            let end = to + text[to..].find("/>").unwrap();
            format!(
                "{}ixx=\"0\" iyy=\"0\" izz=\"0\" ixy=\"0\" ixz=\"0\" iyz=\"0\"{}",
                &text[..from],
                &text[end..]
            )
        }
        _ => text,
    }
}

/// The joint axis may point anywhere: the pose of the last link is that of the file's own chain, Rodrigues' rotation about the
/// axis.
#[test]
fn prop_axes_in_any_direction_give_the_files_own_poses() {
    let robot = from_text(SPLIT).robot;
    let q = [0.7, 0.3];
    let ours = forward_kinematics(&robot, &q)[1];
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.6, 0.0, -0.8));
    let turn = *nalgebra::Rotation3::from_axis_angle(&axis, q[0]).matrix();
    let file = pose([0.1, 0.2, 0.3], [0.4, -0.2, 0.9])
        * pose([0.0, 0.0, 0.2], [0.0, 0.5, 0.0])
        * Transform::from_rotation(turn)
        * pose([0.2, -0.1, 0.3], [1.0, 0.2, -0.4])
        * pose([0.0, 0.4, 0.0], [0.0, 0.0, 0.7])
        * Transform::trans(0.0, q[1], 0.0);
    assert!((ours.translation - file.translation).amax() < 1e-14);
    // Our link frames have z along the axis; `description_frame` leads back.
    let rotation: Matrix3<f64> = ours.rotation * robot.joints()[1].description_frame.transpose();
    assert!((rotation - file.rotation).amax() < 1e-14);
}

fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Transform {
    Transform::from_xyz_rpy(xyz.into(), rpy.into())
}

/// A document with general placements and axes is the URDF with the same numbers.
#[test]
fn prop_placements_and_axes_are_those_of_urdf() {
    let document = r#"{"name": "as urdf", "joints": [
        {"name": "j1", "kind": "revolute", "placement": {"xyz": [0.1, 0, 0.2], "rpy": [0.3, 0.5, -1], "axis": [0.6, 0, -0.8]},
         "prior": {"mass": 2, "center_of_mass": [0.1, 0.2, 0.3], "inertia": {"xx": 0.02, "xy": 0.001, "xz": 0, "yy": 0.03, "yz": 0, "zz": 0.04}}},
        {"name": "j2", "kind": "revolute", "mdh": {"alpha": 0.4, "d": 0.3, "theta": 0.2, "r": 0.1},
         "prior": {"mass": 1, "center_of_mass": [0, 0.2, 0], "inertia": {"xx": 0.02, "xy": 0, "xz": 0, "yy": 0.03, "yz": 0, "zz": 0.04}}}]}"#;
    let mdh = Transform::rot_x(0.4) * Transform::trans(0.3, 0.0, 0.0) * Transform::rot_z(0.2) * Transform::trans(0.0, 0.0, 0.1);
    let euler = nalgebra::Rotation3::from_matrix_unchecked(mdh.rotation).euler_angles();
    let (t, (r, p, y)) = (mdh.translation, euler);
    let urdf = format!(
        r#"<robot name="as urdf"><link name="base"/>
        <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><origin xyz="0.1 0 0.2" rpy="0.3 0.5 -1"/><axis xyz="0.6 0 -0.8"/></joint>
        <link name="l1"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/><inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial></link>
        <joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="{} {} {}" rpy="{r} {p} {y}"/><axis xyz="0 0 1"/></joint>
        <link name="l2"><inertial><origin xyz="0 0.2 0"/><mass value="1"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial></link>
        </robot>"#,
        t.x, t.y, t.z
    );
    let parsed = parse(document.as_bytes()).unwrap();
    assert_same_torques(&robot_document(&parsed).unwrap().robot, &from_text(&urdf).robot);
}

/// The UR10 in modified DH against the manufacturer's standard DH: the pose of the flange.
#[test]
fn val_ur10_forward_kinematics_is_that_of_the_published_standard_dh() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let a = [0.0, -0.612, -0.5723, 0.0, 0.0, 0.0];
    let d = [0.1273, 0.0, 0.0, 0.163941, 0.1157, 0.0922];
    let alpha = [quarter, 0.0, 0.0, quarter, -quarter, 0.0];
    let robot = Shipped.named("ur10").unwrap().robot;
    for q in vectors(&mut rng(3), 20, 6, 3.0) {
        let standard = (0..6).fold(Transform::identity(), |t, j| {
            t * Transform::rot_z(q[j]) * Transform::trans(a[j], 0.0, d[j]) * Transform::rot_x(alpha[j])
        });
        let ours = forward_kinematics(&robot, &q)[5];
        assert!((standard.translation - ours.translation).amax() < 1e-14);
        assert!((standard.rotation - ours.rotation).amax() < 1e-14);
    }
}

/// Files of real robots, kept outside the repository.
#[test]
fn val_urdf_files_of_real_robots_load() {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/real");
    let folder = std::env::var("DYNIDENT_REAL_DATA").unwrap_or(default.to_string());
    let files = [
        ("kuka_lwr4plus_flobaroid/kuka_lwr4.urdf", 7),
        ("lbr_med7_r800/med7dock.urdf", 7),
        ("staubli_tx40_figaroh/tx40_mdh_modified.urdf", 6),
    ];
    for (file, joints) in files {
        let path = std::path::Path::new(&folder).join(file);
        let Ok(text) = std::fs::read_to_string(&path) else {
            println!("SKIPPED val_urdf_files_of_real_robots_load: {file} is not there (folder: DYNIDENT_REAL_DATA)");
            continue;
        };
        let robot = from_text(&text).robot;
        assert_eq!(robot.joint_count(), joints, "{file}");
        assert!(torques(&robot).iter().flatten().all(|t| t.is_finite()), "{file}");
    }
}
