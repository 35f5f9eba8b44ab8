//! Meshes of MJCF robots, with MuJoCo as the judge of where they are.

use crate::mesh::{Triangle, binary_stl, hexahedron};
use crate::meshes::zipped;
use dynident::documents::{RobotDocument, robot_document};
use dynident::dynamics::{forward_kinematics, inverse_dynamics};
use dynident::formats::{meshes_of, parse, robot_archive};
use dynident::model::{Capsule, LinkMesh};
use dynident::parameters::Layout;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// MuJoCo keeps vertices as 32-bit floats; the reference has seven decimals.
const ROUNDING: f64 = 2e-6;

fn reference() -> Vec<Value> {
    let text = include_bytes!("../data/ref_mjcf_meshes.json");
    let mut whole: Value = serde_json::from_slice(text).unwrap();
    serde_json::from_value(whole["variants"].take()).unwrap()
}

fn points(rows: &Value) -> Vec<Vector3<f64>> {
    let rows: Vec<[f64; 3]> = serde_json::from_value(rows.clone()).unwrap();
    rows.into_iter().map(Vector3::from).collect()
}

fn numbers(list: &Value) -> Vec<f64> {
    serde_json::from_value(list.clone()).unwrap()
}

/// How far outside a capsule a point is.
fn outside(capsule: &Capsule, point: &Vector3<f64>) -> f64 {
    let [a, b] = capsule.ends;
    let along = b - a;
    let part = (along.dot(&(point - a)) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (point - a - part * along).norm() - capsule.radius
}

/// The robot's file and its meshes as one archive.
fn archive(variant: &Value) -> Vec<u8> {
    let mut files = vec![(
        "arm/model/arm.xml".to_string(),
        variant["mjcf"].as_str().unwrap().as_bytes().to_vec(),
    )];
    for (name, file) in variant["files"].as_object().unwrap() {
        let corners: [[f64; 3]; 8] = serde_json::from_value(file["corners"].clone()).unwrap();
        let triangles = hexahedron(&corners);
        let content = match file["format"].as_str().unwrap() {
            "stl" => binary_stl(&triangles),
            _ => obj(&triangles),
        };
        files.push((format!("arm/{name}"), content));
    }
    let named: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, c)| (n.as_str(), c.clone())).collect();
    zipped(&named)
}

fn obj(triangles: &[Triangle]) -> Vec<u8> {
    let vertices: String = triangles
        .iter()
        .flatten()
        .map(|[x, y, z]| format!("v {x} {y} {z}\n"))
        .collect();
    let faces = (0..triangles.len()).map(|k| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3));
    (vertices + &faces.collect::<String>()).into_bytes()
}

fn robot(document: &Value) -> RobotDocument {
    let parsed = parse(document.to_string().as_bytes()).unwrap();
    robot_document(&parsed).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Name of a body, and the points of its meshes.
type Described<'a> = (Option<&'a str>, Vec<Vec<Vector3<f64>>>);

/// The meshes of every body that has some, by the numbers of MuJoCo.
fn described(variant: &Value) -> Vec<Described<'_>> {
    let bodies = variant["bodies"].as_array().unwrap().iter();
    let own = bodies.map(|b| {
        (
            b["body"].as_str(),
            b["meshes"].as_array().unwrap().iter().map(points).collect::<Vec<_>>(),
        )
    });
    own.filter(|(_, meshes)| !meshes.is_empty()).collect()
}

fn file_of<'a>(variant: &'a Value, mesh: &LinkMesh) -> &'a Value {
    let path = match mesh.file.strip_prefix("../") {
        Some(beside) => beside.to_string(),
        None => format!("model/{}", mesh.file.replace("//", "/")),
    };
    let file = &variant["files"][&path];
    assert!(file.is_object(), "{path}");
    file
}

#[test]
fn val_points_of_meshes_are_where_mujoco_puts_them() {
    let (mut seen, mut mirrored) = (0, 0);
    for (k, variant) in reference().iter().enumerate() {
        let ours = meshes_of(&json!({"mjcf": variant["mjcf"]}));
        let theirs: Vec<_> = described(variant)
            .into_iter()
            .flat_map(|(body, meshes)| meshes.into_iter().map(move |m| (body, m)))
            .collect();
        assert_eq!(ours.len(), theirs.len(), "variant {k}");
        for (mesh, (body, vertices)) in ours.iter().zip(&theirs) {
            assert!(body.is_none_or(|b| b == mesh.link), "variant {k}: {body:?} {}", mesh.link);
            for corner in points(&file_of(variant, mesh)["corners"]) {
                let placed = mesh.placed(&corner);
                let nearest = vertices.iter().map(|v| (v - placed).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < ROUNDING, "variant {k}, {}: {nearest}", mesh.link);
            }
            seen += 1;
            mirrored += usize::from(mesh.scale.iter().product::<f64>() < 0.0);
        }
    }
    assert!(seen > 90 && mirrored > 10, "{seen} {mirrored}");
}

#[test]
fn val_an_archive_of_an_mjcf_robot_has_the_shapes_of_its_meshes() {
    for (k, variant) in reference().iter().enumerate() {
        let read = robot_archive(&archive(variant)).unwrap_or_else(|e| panic!("variant {k}: {}", e.detail));
        assert!(read.notes.is_empty(), "variant {k}: {:?}", read.notes);
        let ours = read.document["geometry"].as_object().unwrap();
        let theirs = described(variant);
        assert_eq!(ours.len(), theirs.len(), "variant {k}");
        for (body, meshes) in theirs.iter().filter_map(|(body, meshes)| Some((body.as_ref()?, meshes))) {
            let capsules = ours[*body].as_array().unwrap();
            assert_eq!(capsules.len(), meshes.len(), "variant {k}");
            for (value, vertices) in capsules.iter().zip(meshes) {
                let capsule = Capsule {
                    ends: ["from", "to"].map(|end| Vector3::from_vec(numbers(&value[end]))),
                    radius: value["radius"].as_f64().unwrap(),
                };
                let farthest = vertices
                    .iter()
                    .map(|v| outside(&capsule, v))
                    .fold(f64::NEG_INFINITY, f64::max);
                assert!(farthest.abs() < ROUNDING, "variant {k}, {body}: {farthest}");
            }
        }
    }
}

/// Kinematics, shapes and torques of the whole arm at a random state.
#[test]
fn val_mjcf_robots_with_meshes_move_as_in_mujoco() {
    let mut outermost = f64::NEG_INFINITY;
    for (k, variant) in reference().iter().enumerate() {
        let document = robot_archive(&archive(variant)).unwrap().document;
        let robot = robot(&document).robot;
        let state = &variant["state"];
        let [q, qd, qdd] = ["q", "qd", "qdd"].map(|name| numbers(&state[name]));
        let layout = Layout::standard(&robot);
        let phi = layout.prior(&robot).expect("every body has an inertial");
        let torque = inverse_dynamics(&robot, &layout, phi.as_slice(), &q, &qd, &qdd);
        for (ours, theirs) in torque.iter().zip(numbers(&state["torque"])) {
            // Rounded quarter turns aside, which these files have none of, only rounding is left.
            assert!(
                (ours - theirs).abs() < 1e-9 * (1.0 + theirs.abs()),
                "variant {k}: {ours} {theirs}"
            );
        }
        let poses = forward_kinematics(&robot, &q);
        for seen in state["seen"].as_array().unwrap() {
            let at = robot.joints().iter().position(|j| seen["joint"] == json!(j.name)).unwrap();
            let capsules: Vec<Capsule> = robot.joints()[at].geometry.iter().map(|c| c.moved(&poses[at])).collect();
            for point in points(&seen["points"]) {
                let nearest = capsules.iter().map(|c| outside(c, &point)).fold(f64::INFINITY, f64::min);
                assert!(nearest < ROUNDING, "variant {k}, {}: {nearest}", seen["joint"]);
                outermost = outermost.max(nearest);
            }
        }
    }
    assert!(outermost > -ROUNDING, "some points are on their capsules: {outermost}");
}

#[test]
fn shapes_beside_an_mjcf_file_take_the_place_of_its_geoms() {
    let mjcf = "<mujoco><worldbody><body name='a'><joint name='j'/><geom type='box' size='1 1 1' contype='0' conaffinity='0'/><geom size='0.1'/></body>\
        <geom type='plane' size='1 1 1'/></worldbody></mujoco>";
    let own = robot(&json!({"mjcf": mjcf})).robot;
    // What collides, of the type that geoms have where none is stated.
    assert_eq!(own.joints()[0].geometry.iter().map(|c| c.radius).collect::<Vec<_>>(), [0.1]);
    let capsule = json!({"from": [0, 0, 0], "to": [0, 0, 0.4], "radius": 0.05});
    let other = robot(&json!({"mjcf": mjcf, "geometry": {"a": [capsule]}})).robot;
    let [shape] = other.joints()[0].geometry[..] else {
        panic!("one capsule")
    };
    assert_eq!((shape.radius, shape.ends[1].z), (0.05, 0.4));
    let parsed = parse(json!({"mjcf": mjcf, "geometry": {"b": [capsule]}}).to_string().as_bytes()).unwrap();
    let refused = robot_document(&parsed).unwrap_err();
    assert_eq!(refused[0].pointer, "/geometry");
    assert!(refused[0].to_string().contains("no link `b`"), "{refused:?}");
}

/// Assets that cannot be found or read leave the rest as it is.
#[test]
fn meshes_of_an_mjcf_file_that_are_not_there_are_left_out_with_a_note() {
    let mjcf = |asset: &str, geom: &str| {
        format!(
            "<mujoco><asset><mesh name='m' {asset}/></asset><worldbody><body name='a'><joint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><geom {geom}/></body></worldbody></mujoco>"
        )
    };
    let read = |asset: &str, geom: &str| {
        let files = [("arm.xml", mjcf(asset, geom).into_bytes()), ("bad.stl", vec![b'x'; 90])];
        robot_archive(&zipped(&files)).unwrap()
    };
    let missing = read("file='none.stl'", "type='mesh' mesh='m'");
    assert!(
        missing.notes.len() == 1 && missing.notes[0].contains("`none.stl`"),
        "{:?}",
        missing.notes
    );
    let damaged = read("file='bad.stl'", "type='mesh' mesh='m'");
    assert!(
        damaged.notes.len() == 1 && damaged.notes[0].contains("no STL"),
        "{:?}",
        damaged.notes
    );
    for (asset, geom) in [
        ("file='bad.stl'", "type='mesh' mesh='other'"),
        ("vertex='0 0 0 1 0 0 0 1 0 0 0 1'", "type='mesh' mesh='m'"),
        ("file='bad.stl' scale='1 nonsense 1'", "type='mesh' mesh='m'"),
        ("file='bad.stl' refquat='0 0 0 0'", "type='mesh' mesh='m'"),
    ] {
        let left = read(asset, geom);
        assert!(
            left.notes.is_empty() && left.document.get("geometry").is_none(),
            "{asset} {geom}: {:?}",
            left.notes
        );
        assert_eq!(robot(&left.document).robot.joint_count(), 1);
    }
}

/// A body of more parts than a document takes has one capsule around them all.
#[test]
fn a_body_of_many_meshes_is_contained_by_one_capsule() {
    let geoms: String = (0..40)
        .map(|k| format!("<geom type='mesh' mesh='m' pos='0 0 {}'/>", 0.02 * f64::from(k)))
        .collect();
    let mjcf = format!(
        "<mujoco><asset><mesh name='m' file='m.obj'/></asset><worldbody><body name='a'><joint/>{geoms}</body></worldbody></mujoco>"
    );
    let corners = std::array::from_fn(|k| std::array::from_fn(|i| if k >> i & 1 == 1 { 0.05 } else { -0.05 }));
    let files = [("arm.xml", mjcf.into_bytes()), ("m.obj", obj(&hexahedron(&corners)))];
    let document = robot_archive(&zipped(&files)).unwrap().document;
    assert_eq!(document["geometry"]["a"].as_array().unwrap().len(), 1);
    let shape = robot(&document).robot.joints()[0].geometry[0];
    for height in [-0.05, 0.83] {
        assert!(outside(&shape, &Vector3::new(0.05, -0.05, height)) < 1e-9, "{shape:?}");
    }
}
