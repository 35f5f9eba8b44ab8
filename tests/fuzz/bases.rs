//! The documents and logs that mutations start from: small, valid, and between them with every field that readers know.

use super::case::{Document, Draft};
use super::json::Node;
use super::table::Table;
use super::target::Target;
use super::xml::Element;
use dynident::cli::run_with;
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Names of parts, which are the names of the files that the program gets.
pub const ROBOT: &str = "robot";
pub const REQUEST: &str = "request.json";
pub const LOG: &str = "log.csv";
pub const VALIDATION: &str = "validation.csv";
pub const MODEL: &str = "model";
pub const GIVEN: &str = "given.json";
/// A URDF file that identified bodies are put into.
pub const OWN_URDF: &str = "own.urdf";
/// Own effects that requests and robots call by name.
pub const EFFECTS: &str = "effects.json";
/// What a robot's file names as the shape of a link.
pub const MESH: &str = "mesh.stl";
pub const SETTINGS: &str = "settings.toml";

/// Every base of a target. Logs and models are made by the program itself.
pub fn of(target: Target) -> Vec<Draft> {
    let maker = Maker::new();
    match target {
        Target::BaseParameters => robots().into_iter().map(Draft::new).collect(),
        Target::Model => models(&maker),
        Target::Excite => excitations(&maker),
        Target::Identify => identifications(&maker).into_iter().chain([with_catalogue(&maker)]).collect(),
        Target::Inspect => identifications(&maker),
        Target::Validate => validations(&maker),
        Target::Simulate => simulations(),
        Target::Motion => motions(),
        Target::Settings => vec![Draft::new(vec![(SETTINGS, Document::Toml(Node::of(&settings())))])],
        Target::Itself => ["", "panic", "abort", "endless", "deep", "memory", "internal"]
            .iter()
            .map(|what| Draft::new(vec![("what", Document::Plain(what.as_bytes().to_vec()))]))
            .collect(),
    }
}

fn shipped(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/robots/{name}.json"));
    serde_json::from_str(&std::fs::read_to_string(path).expect("the shipped robot is there")).expect("it is JSON")
}

fn planar() -> Value {
    let mut robot = shipped("planar_two_link");
    for (j, joint) in robot["joints"].as_array_mut().expect("has joints").iter_mut().enumerate() {
        joint["limits"]["effort"] = json!(60 - 20 * j);
        joint["limits"]["jerk"] = json!(200);
        joint["prior"]["inertia"] = json!({"xx": 0.01, "xy": 0, "xz": 0, "yy": 0.1, "yz": 0, "zz": 0.1});
        joint["prior"]["viscous"] = json!(0.3);
        joint["prior"]["coulomb"] = json!(0.5);
        joint["geometry"] = json!([{"from": [0, 0, 0], "to": [1, 0, 0], "radius": 0.05}]);
    }
    robot
}

/// A candidate with every function, and a declared one.
fn own_effects() -> Value {
    json!([{"name": "hose", "joint": "J2", "expression": "k*tanh((q2 - q0)/s) + c*sign(qd1)*abs(qd2)^0.5 - a*exp(-(q2/2)^2)*cos(2*pi*q1)", "declared": false,
        "parameters": [{"name": "k", "unit": "N m", "low": 0}, {"name": "q0", "unit": "rad", "low": -1, "high": 1}, {"name": "s", "unit": "rad", "low": 0.05, "high": 2},
            {"name": "c", "unit": "N m s^0.5/rad^0.5"}, {"name": "a", "unit": "N m", "low": null, "high": 10}]},
        {"name": "cam", "joint": "J1", "expression": "m*qdd1/(1 + sqrt(q2^2)) + b*ln(2 + sin(q_J1))", "declared": true,
        "parameters": [{"name": "m", "unit": "kg m^2"}, {"name": "b", "unit": "N m"}]}])
}

fn scara() -> Value {
    let mut robot = shipped("scara");
    for joint in robot["joints"].as_array_mut().expect("has joints") {
        joint["prior"] = json!({"mass": 2, "center_of_mass": [0.1, 0, 0.05], "viscous": 1, "coulomb": 2,
            "inertia": {"xx": 0.01, "xy": 0, "xz": 0, "yy": 0.02, "yz": 0, "zz": 0.02}});
    }
    robot
}

/// Placements instead of DH parameters, and bounds.
fn placed() -> Value {
    let joint = |name: &str, kind: &str, xyz: [f64; 3], rpy: [f64; 3]| {
        json!({"name": name, "kind": kind, "placement": {"xyz": xyz, "rpy": rpy, "axis": [0, 0, 1]},
            "limits": {"position": [-2, 2], "velocity": 1.5, "acceleration": 8, "jerk": null, "effort": 100},
            "prior": {"mass": 3, "center_of_mass": [0, 0.1, 0.1], "inertia": {"xx": 0.05, "xy": 0, "xz": 0, "yy": 0.05, "yz": 0, "zz": 0.02}, "viscous": 0.1, "coulomb": 0.1}})
    };
    json!({"name": "placed", "gravity": [0, 0, -9.81], "friction": ["viscous", "coulomb"],
        "joints": [joint("A1", "revolute", [0.0, 0.0, 0.3], [0.0, 0.0, 0.0]), joint("A2", "revolute", [0.0, 0.0, 0.0], [1.571, 0.0, 0.0]),
            joint("A3", "prismatic", [0.4, 0.0, 0.0], [0.0, -1.57, 0.0])]})
}

const URDF: &str = r#"<robot name="two">
<link name="base"/>
<link name="l1"><inertial><origin xyz="0 0 0.2" rpy="0 0 0"/><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0 0 0.2" rpy="0 0.1 0"/><geometry><box size="0.1 0.1 0.4"/></geometry></collision><collision><geometry><sphere radius="0.08"/></geometry></collision></link>
<link name="l2"><collision><origin xyz="0.2 0 0"/><geometry><cylinder length="0.4" radius="0.05"/></geometry></collision><inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="package://x/y.stl"/></geometry></visual></link>
<link name="tool"><inertial><origin xyz="0 0 0.1"/><mass value="0.5"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j1" type="revolute"><origin xyz="0 0 0.1"/><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2" effort="50"/><dynamics damping="0.1" friction="0.2"/></joint>
<joint name="j2" type="continuous"><origin xyz="0 0 0.4" rpy="-1.5707963267948966 0 0"/><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/><limit velocity="2" effort="50"/></joint>
<joint name="fix" type="fixed"><origin xyz="0.4 0 0"/><parent link="l2"/><child link="tool"/></joint>
</robot>"#;

const GRIPPER: &str = r#"<robot name="g"><link name="b"/><link name="l1"><inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="f1"/><link name="f2"/>
<joint name="j1" type="revolute"><parent link="b"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2" effort="50"/></joint>
<joint name="g1" type="prismatic"><parent link="l1"/><child link="f1"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="20"/></joint>
<joint name="g2" type="prismatic"><parent link="l1"/><child link="f2"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="20"/></joint></robot>"#;

/// Geoms of default classes and in frames, with what a mesh's place depends on.
const MJCF: &str = r#"<mujoco model="m"><compiler angle="radian" eulerseq="zyx" meshdir="." strippath="true"/>
<default><geom euler="0.1 0.2 0.3"/><mesh scale="0.9 1 1.1"/><default class="seen"><geom type="mesh" mesh="part" contype="0" conaffinity="0" pos="0 0 0.1"/></default></default>
<asset><mesh name="part" file="far/away/mesh.stl" refpos="0.01 0 0" refquat="1 0.1 0 0"/><mesh file="mesh.stl" scale="1 -1 1"/></asset>
<worldbody><body name="a" childclass="seen"><frame pos="0 0 0.2" axisangle="0 0 1 0.5"><joint name="j1" range="-2 2"/><inertial pos="0 0 0.1" mass="2" diaginertia="0.02 0.02 0.01"/><geom/></frame>
<body name="b" pos="0.4 0 0" childclass="main"><joint name="j2" axis="0 1 0"/><inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/><geom type="mesh" mesh="mesh" xyaxes="1 0 0 0 1 0.1"/><geom class="seen" zaxis="0 1 1"/>
<body name="c"><geom type="box" size="0.1 0.2 0.1"/><geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.05"/><inertial pos="0 0 0" mass="0.1" diaginertia="0.001 0.001 0.001"/></body></body></body></worldbody></mujoco>"#;

/// A box as triangles of one corner each: enough for a shape.
fn mesh(binary: bool) -> Document {
    let corners = (0..8).map(|k: u32| {
        [0.05, 0.1, 0.3]
            .map(|h: f32| h)
            .into_iter()
            .enumerate()
            .map(move |(i, h)| if k >> i & 1 == 1 { h } else { -h })
    });
    let triangles: Vec<Vec<f32>> = corners.map(|c| c.collect::<Vec<_>>().repeat(3)).collect();
    let words = |t: &Vec<f32>| {
        let vertices: String = t.chunks(3).map(|c| format!("vertex {} {} {}\n", c[0], c[1], c[2])).collect();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    let text = format!("solid box\n{}endsolid box\n", triangles.iter().map(words).collect::<String>());
    let mut bytes = vec![0u8; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in &triangles {
        bytes.extend([0u8; 12]);
        triangle.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    Document::Plain(if binary { bytes } else { text.into_bytes() })
}

/// The same points as Wavefront OBJ, and as a COLLADA scene with every transformation.
const OBJ: &str = "# box\nmtllib none.mtl\no box\nv -0.05 -0.1 -0.3\nv 0.05 -0.1 -0.3\nv -0.05 0.1 0.3\nv 0.05 0.1 0.3\nvn 0 0 1\nvt 0 0\ng one\ns off\nusemtl grey\nf 1/1/1 2/1/1 4/1/1 3/1/1\nf 1 2 -1\nl 1 2\n";
const DAE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="cm" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">-5 -10 -30 5 -10 -30 -5 10 30 5 10 30</float_array>
<technique_common><accessor source="#a" count="4" stride="3" offset="0"><param name="X" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_nodes><node id="n"><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="top"><translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>1 1 2</scale>
<node><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node><instance_node url="#n"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

/// A description package, its files as they are so that changed bytes reach the readers.
fn package(urdf: &str) -> Document {
    let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, content) in [
        ("arm/urdf/arm.urdf", urdf),
        ("arm/meshes/l2.dae", DAE),
        ("arm/package.xml", "<package/>"),
    ] {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        writer.start_file(name, options).expect("memory can be written");
        writer.write_all(content.as_bytes()).expect("memory can be written");
    }
    Document::Plain(writer.finish().expect("memory can be written").into_inner())
}

/// Robots, and what their files name.
fn robots() -> Vec<Vec<(&'static str, Document)>> {
    let mjcf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/ref_mjcf.xml");
    let mjcf = std::fs::read_to_string(mjcf).expect("the reference is there");
    let meshed = URDF.replace("package://x/y.stl", MESH);
    let with_mesh = |binary: bool| vec![(ROBOT, Document::Xml(Element::parse(&meshed))), (MESH, mesh(binary))];
    let mut all: Vec<Vec<(&'static str, Document)>> = arms().into_iter().map(|robot| vec![(ROBOT, robot)]).collect();
    all.extend([
        vec![(ROBOT, Document::Xml(Element::parse(&mjcf)))],
        vec![(ROBOT, Document::Xml(Element::parse(MJCF))), (MESH, mesh(true))],
        with_mesh(true),
        with_mesh(false),
        vec![
            (ROBOT, Document::Xml(Element::parse(&meshed))),
            (MESH, Document::Plain(OBJ.into())),
        ],
        vec![
            (ROBOT, Document::Xml(Element::parse(&meshed))),
            (MESH, Document::Xml(Element::parse(DAE))),
        ],
        vec![(
            ROBOT,
            package(&URDF.replace("package://x/y.stl", "package://arm/meshes/l2.dae")),
        )],
    ]);
    all
}

fn arms() -> Vec<Document> {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robots/iiwa14.urdf");
    let iiwa = std::fs::read_to_string(example).expect("the shipped robot is there");
    let with_tip = json!({"urdf": GRIPPER, "tip": "f1", "gravity": [0, 0, -9.81], "friction": ["viscous"], "source": "x"});
    let shaped = json!({"urdf": GRIPPER, "tip": "l1", "geometry": {"l1": [{"from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.05}], "f1": []}});
    let mut all: Vec<Document> = [planar(), scara(), placed(), with_tip, shaped]
        .iter()
        .map(|v| Document::Json(Node::of(v)))
        .collect();
    all.extend([URDF, &iiwa].map(|xml| Document::Xml(Element::parse(xml))));
    all
}

fn document(value: Value) -> Document {
    Document::Json(Node::of(&value))
}

/// Two links of 3 kg and 1 kg with friction, in the order of standard parameters.
const TRUTH: [f64; 24] = [
    3.0, 0.6, 0.03, 0.0, 0.02, 0.0, 0.0, 0.2, 0.0, 0.2, 0.3, 0.5, 1.0, 0.2, -0.01, 0.0, 0.01, 0.0, 0.0, 0.06, 0.0, 0.06, 0.1, 0.2,
];

fn planar_motion(phase: f64) -> Value {
    let row = |j: f64| {
        (0..2)
            .map(|l| 0.5 * (phase + 1.3 * j + 2.1 * l as f64).sin())
            .collect::<Vec<f64>>()
    };
    json!({"fundamental_hz": 0.5, "a": [row(0.0), row(1.0)], "b": [row(2.0), row(3.0)], "offset": [0.1, -0.2]})
}

fn scara_motion() -> Value {
    json!({"fundamental_hz": 0.5, "a": [[0.4, 0.2], [0.3, -0.4], [0.05, 0.02], [1, -0.5]],
        "b": [[-0.2, 0.3], [0.5, 0.1], [0.02, -0.04], [-0.8, 0.9]], "offset": [0, 0.2, 0.05, 0]})
}

fn planar_experiment(phase: f64, effects: Value) -> Value {
    json!({"parameters": TRUTH, "trajectory": {"fourier": planar_motion(phase)}, "periods": 3, "sample_rate_hz": 60,
        "noise": {"torque": [0.05, 0.03], "position": 1e-5}, "effects": effects, "seed": 1})
}

/// Runs the program to make logs and models.
struct Maker {
    folder: PathBuf,
}

impl Drop for Maker {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Maker {
    fn new() -> Self {
        let folder = std::env::temp_dir().join(format!("dynident-bases-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("temporary folders can be made");
        Self { folder }
    }

    fn file(&self, name: &str, content: &Value) -> String {
        let path = self.folder.join(name);
        std::fs::write(&path, content.to_string()).expect("temporary files can be written");
        path.display().to_string()
    }

    fn run(&self, arguments: &[&str]) {
        let ended = run_with(["dynident", "--json"].into_iter().chain(arguments.iter().copied()));
        assert!(matches!(ended, Ok(0)), "{arguments:?} ends with {ended:?}");
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).expect("the program wrote it")
    }

    /// The log that the virtual robot writes.
    fn log(&self, robot: &Value, experiment: &Value) -> Table {
        let (robot, request) = (self.file("r.json", robot), self.file("x.json", experiment));
        let out = self.folder.join("log.csv").display().to_string();
        self.run(&["simulate", "--robot", &robot, "--request", &request, "--out", &out]);
        let text = self.read("log.csv");
        let mut lines = text.lines();
        let header: Vec<String> = lines.next().expect("a header").split(',').map(str::to_string).collect();
        let mut columns = vec![Vec::new(); header.len()];
        for line in lines {
            let cells = line.split(',').map(|cell| cell.parse::<f64>().expect("a number"));
            columns.iter_mut().zip(cells).for_each(|(column, cell)| column.push(cell));
        }
        Table::new(header, columns)
    }

    fn planar_log(&self, phase: f64) -> Table {
        self.log(&planar(), &planar_experiment(phase, json!([])))
    }

    /// A log in which the second joint hardly moves, so that a torque offset and a spring look alike.
    fn undecided_log(&self) -> Table {
        let mut experiment = planar_experiment(0.0, json!([{"effect": "torque_offset", "joint": "J2", "offset": 3}]));
        experiment["trajectory"]["fourier"] = json!({"fundamental_hz": 0.5, "a": [[0.3, 0.2], [0.15, 0.075]], "b": [[0.2, -0.3], [0.05, -0.15]], "offset": [0.1, -0.2]});
        self.log(&planar(), &experiment)
    }

    /// A log with something to find.
    fn sprung_log(&self) -> Table {
        let effects = json!([{"effect": "joint_spring", "joint": "J2", "stiffness": 4, "rest": 0.1},
            {"effect": "torque_offset", "joint": "J1", "offset": 2}]);
        self.log(&planar(), &planar_experiment(0.0, effects))
    }

    fn scara_log(&self) -> Table {
        let experiment = json!({"trajectory": {"fourier": scara_motion()}, "periods": 2.5, "sample_rate_hz": 50,
            "noise": {"torque": [0.1, 0.1, 0.2, 0.02]}, "seed": 2});
        self.log(&scara(), &experiment)
    }

    /// The model identified from a log, as JSON and as URDF.
    fn model(&self, log: &Table) -> (Value, String) {
        let robot = self.file("r.json", &planar());
        self.model_of(&robot, log)
    }

    /// The same of the robot in a URDF file.
    fn urdf_model(&self, log: &Table) -> (Value, String) {
        let path = self.folder.join("r.urdf");
        std::fs::write(&path, URDF).expect("temporary files can be written");
        self.model_of(&path.display().to_string(), log)
    }

    fn model_of(&self, robot: &str, log: &Table) -> (Value, String) {
        let path = self.folder.join("sprung.csv");
        std::fs::write(&path, log.render()).expect("temporary files can be written");
        let log = path.display().to_string();
        let [model, urdf] = ["model.json", "model.urdf"].map(|name| self.folder.join(name).display().to_string());
        let out = self.folder.join("out.json").display().to_string();
        self.run(&[
            "identify", "--robot", robot, "--log", &log, "--model", &model, "--urdf", &urdf, "--out", &out,
        ]);
        let json = serde_json::from_str(&self.read("model.json")).expect("the model is JSON");
        (json, self.read("model.urdf"))
    }
}

fn identifications(maker: &Maker) -> Vec<Draft> {
    let bounds = json!({"method": "consistent", "prior_weight": 0.01, "least_eigenvalue": 1e-6, "least_viscous": 0.001,
        "bounds": [{"link": 1, "mass": [0.1, 10], "center_of_mass": [[-1, 1], [-1, 1], [-1, 1]], "inertia": {"xx": [0, 1], "zz": [0, 2]},
            "viscous": [0, 5], "coulomb": [0, 5]}]});
    let paper =
        json!({"method": "both", "starts": 2, "seed": 3, "slender_axes": ["x", null], "gazebo": true, "triangle": "diagonal"});
    let columns = json!({"time": "time", "time_unit": "s", "position": {"headers": ["q1", "q2"], "unit": "rad", "sign": [1, 1], "offset": [0, 0]},
        "torque": {"headers": ["tau1", "tau2"], "unit": "N m", "scale": [1, 1], "matrix": [[1, 0], [0, 1]]}});
    let filters = json!({"method": "parallel_filter", "average": false, "position_filter": {"order": 4, "cutoff_hz": 12},
        "torque_filter": {"order": 2, "cutoff_hz": 8}, "discard_edges_s": 0.1, "decimation": 3, "dead_zone": 0.01});
    let (log, held_out, sprung) = (maker.planar_log(0.0), maker.planar_log(1.0), maker.sprung_log());
    let planar_requests = [
        (json!({}), &log),
        (json!({}), &sprung),
        (
            json!({"period_s": 2, "estimator": "wls", "offset": true, "prediction_points": 200}),
            &sprung,
        ),
        (
            json!({"excitation": {"fundamental_hz": 0.5, "coefficients": {"a": [[0, 0], [0, 0]]}}, "feasible": bounds}),
            &log,
        ),
        (
            json!({"estimator": "robust", "feasible": {"method": "none"}, "columns": columns}),
            &sprung,
        ),
        (json!({"preprocess": filters, "feasible": paper, "estimator": "ols"}), &log),
        (
            json!({"preprocess": {"method": "fourier_fit"}, "columns": {"coupling": [[1, 0], [1, 1]], "sample_rate_hz": 60}}),
            &log,
        ),
        (
            json!({"preprocess": {"method": "paper"}, "trace": false, "estimator": "wls"}),
            &sprung,
        ),
        (json!({"effects": own_effects()}), &sprung),
    ];
    let mut all = Vec::new();
    for (request, table) in planar_requests {
        let parts = vec![
            (ROBOT, document(planar())),
            (REQUEST, document(request)),
            (LOG, Document::Table(table.clone())),
            (VALIDATION, Document::Table(held_out.clone())),
        ];
        all.push(Draft::new(parts));
    }
    let scara_parts = vec![
        (ROBOT, document(scara())),
        (REQUEST, document(json!({}))),
        (LOG, Document::Table(maker.scara_log())),
    ];
    all.push(Draft::new(scara_parts).with_arguments(&["--plot-format", "png"]));
    let urdf_parts = vec![
        (ROBOT, Document::Xml(Element::parse(URDF))),
        (REQUEST, document(json!({}))),
        (LOG, Document::Table(sprung)),
    ];
    all.push(Draft::new(urdf_parts));
    all
}

/// A robot and a request that name effects.
fn with_catalogue(maker: &Maker) -> Draft {
    let mut effects = own_effects();
    effects[0].as_object_mut().expect("a definition").remove("joint");
    effects[0]["expression"] = json!("k*tanh((q - q0)/s) + c*sign(qd)*abs(qd)^0.5 - a*exp(-(q_J2/2)^2)");
    let mut robot = planar();
    robot["effects"] = json!(["cam"]);
    Draft::new(vec![
        (ROBOT, document(robot)),
        (
            REQUEST,
            document(json!({"effects": [{"use": "hose", "joint": "J2", "name": "second", "declared": false}]})),
        ),
        (EFFECTS, document(effects)),
        (LOG, Document::Table(maker.sprung_log())),
    ])
}

fn validations(maker: &Maker) -> Vec<Draft> {
    let (log, sprung) = (maker.planar_log(0.5), maker.sprung_log());
    let (model, urdf) = maker.model(&sprung);
    let request =
        json!({"period_s": 2, "prediction_points": 100, "trace": true, "preprocess": {"average": true, "decimation": 2}});
    let parts = |model: Document, request: Value, log: &Table| {
        Draft::new(vec![
            (MODEL, model),
            (REQUEST, document(request)),
            (LOG, Document::Table(log.clone())),
        ])
    };
    vec![
        parts(document(model.clone()), json!({}), &sprung),
        parts(document(model), request, &log),
        parts(Document::Xml(Element::parse(&urdf)), json!({}), &log),
        parts(document(planar()), json!({"trace": false}), &log),
    ]
}

/// Stored models, written out, and put into files of one's own.
fn models(maker: &Maker) -> Vec<Draft> {
    let log = maker.sprung_log();
    let (model, _) = maker.model(&log);
    let (of_urdf, written) = maker.urdf_model(&log);
    let own = |xml: &str| Document::Xml(Element::parse(xml));
    vec![
        Draft::new(vec![(MODEL, document(model))]),
        Draft::new(vec![(MODEL, document(of_urdf.clone())), (OWN_URDF, own(URDF))]),
        Draft::new(vec![(MODEL, document(of_urdf)), (OWN_URDF, own(&written))]),
    ]
}

fn excitations(maker: &Maker) -> Vec<Draft> {
    let (model, _) = maker.model(&maker.sprung_log());
    let search = json!({"seed": 1, "starts": 2, "time_limit_s": 0.2, "max_evaluations": 30, "jobs_per_round": 2});
    let request = |more: Value| {
        let mut all = json!({"fourier": {"order": 2, "fundamental_hz": 0.5}, "sample_rate_hz": 30, "search": search});
        let fields = all.as_object_mut().expect("an object");
        fields.extend(more.as_object().expect("an object").clone());
        document(all)
    };
    let motion = planar_motion(0.3);
    let earlier =
        json!({"coefficients": {"a": motion["a"], "b": motion["b"]}, "offset": motion["offset"], "fundamental_hz": 0.5});
    let space = json!({"clearance": 0.02, "half_spaces": [{"name": "floor", "normal": [0, 1, 0], "offset": -3}],
        "boxes": [{"name": "table", "center": [3, 0, 0], "size": [0.5, 0.5, 0.5]}]});
    let exact = json!({"form": "exact", "start": "free", "start_position": [0.1, 0.2], "torque": {"limits": [60, 40], "safety_factor": 1.1}});
    let (undecided, _) = maker.model(&maker.undecided_log());
    let finding = json!({"effect": "torque_offset", "joints": ["J2"]});
    let on_planar = [
        request(json!({"criterion": "condition_number", "constraints": {"form": "paper", "start": "zero"}, "backoff": 0.5})),
        request(json!({"criterion": "d_optimality", "constraints": exact, "torque_noise": [0.1, 0.2], "periods": 3})),
        request(json!({"criterion": "i_optimality", "constraints": {"form": "exact", "space": space}, "warm_start": earlier})),
        request(
            json!({"criterion": "a_optimality", "fourier": {"order": 3, "fundamental_hz": [0.3, 0.5], "harmonics": [[1, 3], [2, 3]]}, "given": [earlier], "trajectories": 2}),
        ),
        request(json!({"criterion": "scaled_condition_number", "model": model, "given": [model]})),
        request(json!({"criterion": "rival_evidence", "model": undecided, "rivals": {"finding": finding, "rival": 0}})),
    ];
    let mut all: Vec<Draft> = on_planar
        .into_iter()
        .map(|r| Draft::new(vec![(ROBOT, document(planar())), (REQUEST, r)]))
        .collect();
    all.push(Draft::new(vec![(REQUEST, request(json!({}))), (MODEL, document(model))]));
    all.push(Draft::new(vec![
        (ROBOT, document(scara())),
        (REQUEST, request(json!({"backoff": 0.3}))),
    ]));
    let given =
        json!({"coefficients": earlier["coefficients"], "offset": earlier["offset"], "fundamental_hz": 0.5, "periods": 4});
    all.push(Draft::new(vec![
        (ROBOT, Document::Xml(Element::parse(URDF))),
        (REQUEST, request(json!({}))),
        (GIVEN, document(given)),
    ]));
    all
}

fn simulations() -> Vec<Draft> {
    let effects = json!([
        {"effect": "torque_offset", "joint": "J1", "offset": 1}, {"effect": "stribeck_friction", "joint": "J2", "amplitude": 1, "velocity": 0.1, "exponent": 1},
        {"effect": "presliding_hysteresis", "joint": "J1", "amplitude": 1, "width": 0.01}, {"effect": "joint_spring", "joint": "J2", "stiffness": 4, "rest": 0.1},
        {"effect": "position_ripple", "joint": "J1", "amplitude": 1, "cycles": 12, "phase": 0.2}, {"effect": "base_tilt", "roll": 0.02, "pitch": -0.01},
        {"effect": "payload", "mass": 1, "center_of_mass": [0, 0, 0.1], "inertia": [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01]]},
        {"effect": "torque_delay", "seconds": 0.01}, {"effect": "torque_crosstalk", "joint": "J1", "from": "J2", "coefficient": 0.05},
        {"effect": "friction_drift", "joint": "J1", "viscous": 1, "coulomb": 1, "time_constant": 3},
        {"effect": "external_contact", "start": 1, "end": 2, "torque": [3, 1]}, {"effect": "torque_drift", "joint": "J2", "torque": 1, "time_constant": 2}]);
    let faults = json!([{"fault": "flipped_torque", "joints": ["J2"]}, {"fault": "degrees", "joints": ["J1"]}, {"fault": "swapped_torques", "joints": ["J1", "J2"]},
        {"fault": "constant_torque", "joint": "J2"}, {"fault": "clipped_torque", "joint": "J1", "limit": 5}, {"fault": "frozen", "start": 1, "duration": 0.5},
        {"fault": "repeated_times", "count": 3}, {"fault": "garbage_rows", "count": 2}]);
    let elastic = json!([{"effect": "joint_elasticity", "joint": "J2", "stiffness": 500}, {"effect": "encoder_offset", "joint": "J1", "offset": 0.02}]);
    let points = json!({"way_points": {"positions": [[0, 0], [1, 0.5], [0, 0]], "durations": [1, 1.5]}});
    let sines = json!({"sines": {"terms": [[[0.5, 1]], [[0.3, 2], [0.1, 3]]], "duration": 3}});
    let noise = json!({"torque": [0.1, 0.1], "torque_correlation": 0.5, "position": 1e-4, "position_step": 1e-4, "torque_step": 0.01, "jitter": 1e-4});
    let requests = [
        json!({"parameters": TRUTH, "trajectory": {"fourier": planar_motion(0.0)}, "periods": 2, "sample_rate_hz": 100, "noise": noise, "effects": effects, "faults": faults, "seed": 4}),
        json!({"trajectory": points, "periods": 1.5, "effects": elastic}),
        json!({"trajectory": sines, "sample_rate_hz": 50}),
    ];
    requests
        .map(|r| Draft::new(vec![(ROBOT, document(planar())), (REQUEST, document(r))]))
        .into()
}

fn motions() -> Vec<Draft> {
    let motion = scara_motion();
    let series = json!({"fundamental_hz": 0.5, "coefficients": {"a": motion["a"], "b": motion["b"]}, "offset": motion["offset"]});
    let requests = [
        json!({"robot": scara(), "trajectory": series, "samples": 200}),
        json!({"robot": "scara", "trajectory": series}),
        json!({"robot": {"urdf": GRIPPER, "tip": "f1", "gravity": [0, 0, -9.81], "friction": ["coulomb"]}}),
        json!({"robot": placed(), "samples": 20}),
    ];
    requests.map(|r| Draft::new(vec![(REQUEST, document(r))])).into()
}

fn settings() -> Value {
    json!({"listen": "127.0.0.1:8080", "data": "here", "auth": "auto", "open_to_anyone": false, "concurrent_jobs": 1, "short_jobs": 2,
        "shortest_long_s": 5.0, "running_per_robot": 2, "waiting_jobs": 10, "lease_s": 10.0, "longest_wait_s": 30.0, "longest_search_s": 600.0,
        "most_joints": 20, "highest_order": 30, "most_rows": 100_000, "largest_document": 1_000_000, "requests_per_second": 5, "request_burst": 9,
        "log": "info", "log_format": "json", "database_url": "postgres://a:b@c/d"})
}
