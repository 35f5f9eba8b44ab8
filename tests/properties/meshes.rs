//! Shapes of links from meshes: STL, OBJ and COLLADA, and ZIP archives of a robot with its meshes.

use crate::mesh::{binary_stl, box_of};
use dynident::formats::{is_archive, robot_archive, shapes_of_meshes};
use dynident::model::urdf_meshes;
use serde_json::{Map, Value};
use std::io::Write;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A box of 0.1 × 0.2 × 0.6 m as twelve triangles, around its centre.
fn triangles() -> Vec<[[f64; 3]; 3]> {
    box_of([0.05, 0.1, 0.3])
}

fn binary() -> Vec<u8> {
    binary_stl(&triangles())
}

/// The same box in each of the other formats; its faces as quadrilaterals, and in millimetres below two nodes.
fn obj() -> Vec<u8> {
    let corner = |t: &[[f64; 3]; 3]| t.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let corners: String = triangles().iter().map(corner).collect();
    let faces: String = (0..12)
        .map(|k| format!("f {}//1 {}//1 {}//1\n", 3 * k + 1, 3 * k + 2, 3 * k + 3))
        .collect();
    // A point that no face uses is none of the link.
    format!("# made by hand\nmtllib none.mtl\no box\n{corners}v 9 9 9\nvn 0 0 1\nusemtl grey\n{faces}").into_bytes()
}

fn collada() -> Vec<u8> {
    let corners: Vec<String> = (0..8)
        .map(|k| {
            // Turned by a quarter about z and moved by the nodes above.
            let half = [100.0, 50.0, 300.0].map(|h: f64| h);
            let c: Vec<f64> = (0..3).map(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] }).collect();
            format!("{} {} {}", c[0] - 10.0, c[1] + 5.0, c[2])
        })
        .collect();
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
        <library_geometries><geometry id="box"><mesh><source id="p"><float_array id="pa" count="24">{}</float_array>
        <technique_common><accessor source="#pa" count="8" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#p"/></vertices></mesh></geometry></library_geometries>
        <library_nodes><node id="part"><translate>10 -5 0</translate><instance_geometry url="#box"/></node></library_nodes>
        <library_visual_scenes><visual_scene id="s"><node><matrix>0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1</matrix><instance_node url="#part"/></node>
        <node><rotate>0 0 1 90</rotate><scale>1 1 1</scale><instance_node url="#part"/></node></visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
        corners.join(" ")
    )
    .into_bytes()
}

fn text() -> Vec<u8> {
    let facet = |t: &[[f64; 3]; 3]| {
        let lines: Vec<String> = t.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}")).collect();
        format!("facet normal 0 0 0\nouter loop\n{}\nendloop\nendfacet\n", lines.join("\n"))
    };
    let facets: String = triangles().iter().map(facet).collect();
    format!("solid box\n{facets}endsolid box\n").into_bytes()
}

fn shapes_of(urdf: &str, load: impl Fn(&str) -> Option<Vec<u8>>) -> (Map<String, Value>, Vec<String>) {
    shapes_of_meshes(&urdf_meshes(urdf).unwrap(), load)
}

#[test]
fn meshes_become_capsules_in_the_frame_of_their_link() {
    let urdf = r#"<robot name="r"><link name="a"/><link name="b">
        <collision><origin xyz="0 0 1" rpy="0 1.5707963267948966 0"/><geometry><mesh filename="package://p/box.stl" scale="2 2 2"/></geometry></collision>
        </link><link name="c"><visual><geometry><mesh filename="no.dae"/></geometry></visual></link></robot>"#;
    for bytes in [binary(), text(), obj(), collada()] {
        let load = |name: &str| {
            Some(if name.ends_with("stl") {
                bytes.clone()
            } else {
                b"<COLLADA/>".to_vec()
            })
        };
        let (shapes, notes) = shapes_of(urdf, load);
        assert_eq!(notes.len(), 1, "{notes:?}");
        let capsule = &shapes["b"][0];
        // Corners are sqrt(0.1² + 0.2²) from the long axis.
        let radius = capsule["radius"].as_f64().unwrap();
        assert!((radius - 0.05f64.sqrt()).abs() < 1e-6, "{capsule}");
        let x = capsule["from"][0].as_f64().unwrap().abs();
        assert!((x - 0.6).abs() < 1e-6, "{capsule}");
        assert!((capsule["from"][2].as_f64().unwrap() - 1.0).abs() < 1e-6, "{capsule}");
    }
    let (shapes, notes) = shapes_of(urdf, |_| Some(vec![0; 200]));
    assert!(shapes.is_empty() && notes.len() == 2, "what is no mesh is said to be none");
}

#[test]
fn damaged_meshes_are_read_or_refused() {
    let urdf =
        r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="a.stl"/></geometry></collision></link></robot>"#;
    for whole in [binary(), text(), obj(), collada()] {
        let mut state = 1u64;
        for _ in 0..400 {
            let mut bytes = whole.clone();
            for _ in 0..3 {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let at = (state >> 33) as usize % bytes.len();
                match state >> 62 {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes[at] = (state >> 20) as u8,
                    _ => bytes[at] ^= 1 << (state >> 59 & 7),
                }
            }
            let (shapes, notes) = shapes_of(urdf, |_| Some(bytes.clone()));
            assert_eq!(shapes.len() + notes.len(), 1);
            let numbers = shapes
                .values()
                .flat_map(|list| list[0]["from"].as_array().into_iter().flatten());
            assert!(numbers.into_iter().all(serde_json::Value::is_number));
        }
    }
}

/// Scenes that are none: instances that call themselves, more than anybody shows, numbers that are none.
#[test]
fn scenes_without_end_are_refused_at_once() {
    let urdf =
        r#"<robot name="r"><link name="a"><collision><geometry><mesh filename="a.dae"/></geometry></collision></link></robot>"#;
    let whole = String::from_utf8(collada()).unwrap();
    let node = |inside: &str| whole.replace(r##"<instance_geometry url="#box"/>"##, inside);
    let doubled: String = (0..40)
        .map(|k| {
            format!(
                r##"<node id="d{k}"><instance_node url="#d{}"/><instance_node url="#d{}"/></node>"##,
                k + 1,
                k + 1
            )
        })
        .collect();
    for bad in [
        node(r##"<instance_node url="#part"/>"##),
        node(r##"<instance_node url="#d0"/>"##)
            .replace("</library_nodes>", &format!(r##"{doubled}<node id="d40"/></library_nodes>"##)),
        whole.replace(r#"stride="3""#, r#"stride="0""#),
        whole.replace(r#"meter="0.001""#, r#"meter="-1""#),
        whole.replace("90</rotate>", "ninety</rotate>"),
        whole.replace("<scale>1 1 1", "<scale>1 1e300 1"),
        whole.replace("#p\"/></vertices>", "#q\"/></vertices>"),
        "<COLLADA>".repeat(100_000),
    ] {
        let start = std::time::Instant::now();
        let (shapes, notes) = shapes_of(urdf, |_| Some(bad.clone().into_bytes()));
        assert!(shapes.is_empty() && notes.len() == 1, "{shapes:?} {notes:?}");
        // Milliseconds; a doubling of every level would take longer than anybody waits.
        assert!(start.elapsed().as_secs_f64() < 10.0);
    }
}

/// A ZIP archive of these files.
pub fn zipped(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in files {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A link for every way of calling a mesh, and one whose mesh is not there.
const MESHED: &str = r#"<robot name="meshed"><link name="l0"/>
    <link name="l1"><collision><geometry><mesh filename="package://my_arm/meshes/l1.stl"/></geometry></collision></link>
    <link name="l2"><visual><geometry><mesh filename="../meshes/l2.obj"/></geometry></visual></link>
    <link name="l3"><collision><geometry><mesh filename="file://../meshes/deep/l3.dae"/></geometry></collision></link>
    <link name="l4"><collision><geometry><mesh filename="package://my_arm/meshes/none.stl"/></geometry></collision></link>
    <joint name="j1" type="continuous"><parent link="l0"/><child link="l1"/></joint><joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/></joint>
    <joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/></joint><joint name="j4" type="continuous"><parent link="l3"/><child link="l4"/></joint></robot>"#;

fn package(root: &str) -> Vec<u8> {
    let files = [
        ("urdf/arm.urdf", MESHED.as_bytes().to_vec()),
        ("package.xml", b"<package/>".to_vec()),
        ("meshes/l1.stl", binary()),
        ("meshes/l2.obj", obj()),
        ("meshes/deep/l3.dae", collada()),
    ];
    let named: Vec<(String, Vec<u8>)> = files
        .into_iter()
        .map(|(name, content)| (format!("{root}{name}"), content))
        .collect();
    let named: Vec<(&str, Vec<u8>)> = named.iter().map(|(name, content)| (name.as_str(), content.clone())).collect();
    zipped(&named)
}

#[test]
fn an_archive_of_a_robot_has_the_shapes_of_its_meshes_wherever_it_begins() {
    for root in ["", "my_arm/", "workspace/src/my_arm/"] {
        let bytes = package(root);
        assert!(is_archive(&bytes));
        let read = robot_archive(&bytes).unwrap_or_else(|e| panic!("{root}: {}", e.detail));
        assert_eq!(read.document["urdf"], Value::from(MESHED), "{root}");
        let shaped: Vec<&String> = read.document["geometry"].as_object().unwrap().keys().collect();
        assert_eq!(shaped, ["l1", "l2", "l3"], "{root}");
        assert!(
            read.notes.len() == 1 && read.notes[0].contains("`package://my_arm/meshes/none.stl`"),
            "{:?}",
            read.notes
        );
    }
}

#[test]
fn archives_without_one_robot_are_refused_with_what_they_have() {
    let urdf = || MESHED.as_bytes().to_vec();
    let cases: [(Vec<u8>, &str, &str); 6] = [
        (
            zipped(&[("a.urdf", urdf()), ("b/c.URDF", urdf())]),
            "has 2 robots: `a.urdf`, `b/c.URDF`",
            "one robot",
        ),
        (
            zipped(&[("package.xml", urdf()), ("a.stl", binary())]),
            "has no robot",
            "URDF or MJCF file",
        ),
        (zipped(&[("arm.urdf.xacro", urdf())]), "xacro files alone", "expand"),
        (zipped(&[("a.urdf", vec![b' '; 65 << 20])]), "more than 64 MiB", "one robot"),
        (package("")[..300].to_vec(), "no ZIP archive that can be read", "pack"),
        (zipped(&[("a.urdf", b"PK\x03\x04".to_vec())]), "", ""),
    ];
    for (bytes, detail, hint) in cases {
        let error = robot_archive(&bytes).unwrap_err();
        let said = error.hint.unwrap_or_default();
        assert!(
            error.detail.contains(detail) && said.contains(hint),
            "{}: {said}",
            error.detail
        );
    }
    // The one MJCF file of an archive, its package beside it.
    let mjcf = b"<mujoco/>".to_vec();
    let read = robot_archive(&zipped(&[("package.xml", urdf()), ("x/arm.xml", mjcf)])).unwrap();
    assert_eq!(read.document["mjcf"], Value::from("<mujoco/>"));
}

/// Bytes changed anywhere in an archive: a robot or an error.
#[test]
fn damaged_archives_are_read_or_refused() {
    let (whole, mut refused) = (package("my_arm/"), 0);
    let mut state = 7u64;
    for _ in 0..300 {
        let mut bytes = whole.clone();
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let at = (state >> 33) as usize % bytes.len();
        match state >> 62 {
            0 => bytes.truncate(at.max(4)),
            _ => bytes[at] ^= 1 << (state >> 59 & 7),
        }
        refused += usize::from(robot_archive(&bytes).is_err());
    }
    assert!((20..300).contains(&refused), "{refused}");
}
