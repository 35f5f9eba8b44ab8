//! Logs in the formats that people have: files that NumPy, SciPy, pandas, pyarrow, `rosbags` and `mcap` wrote
//! (`tests/data/ref_log_formats.py`), columns of well-known programs, and dialects of text.

use dynident::formats::logs::{
    Columns, FindingKind, JointColumns, LogColumn, LogError, LogReport, Source, TimeUnit, Transformation, log_overview, read_log,
};
use dynident::preparation::Log;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/logs/formats")
}

fn joints() -> Vec<String> {
    ["shoulder", "elbow"].map(str::to_string).to_vec()
}

fn read_bytes(name: &str, bytes: &[u8], columns: &Columns) -> Result<(Log, LogReport), LogError> {
    let name = name.to_string();
    read_log(Source { name, bytes }, columns, &joints())
}

fn read(name: &str, columns: &Columns) -> Result<(Log, LogReport), LogError> {
    read_bytes(name, &std::fs::read(folder().join(name)).unwrap(), columns)
}

/// time, q1, q2, qd1, qd2, tau1, tau2, by columns.
fn expected() -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder().join("expected.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    (0..7).map(|c| rows.iter().map(|r| r[c]).collect()).collect()
}

fn headers(names: &[&str]) -> JointColumns {
    JointColumns {
        headers: names.iter().map(|n| n.to_string()).collect(),
        ..JointColumns::default()
    }
}

/// Every number is the one that was written; velocities are compared where the file has them.
fn assert_is_expected(name: &str, (log, report): &(Log, LogReport), has_velocities: bool) {
    let expected = expected();
    let count = log.q[0].len();
    assert_eq!((log.rate_hz, report.resampled), (200.0, false), "{name}");
    assert!(count == expected[0].len() || name == "utf16.csv", "{name}: {count}");
    assert_eq!(log.qd.is_some(), has_velocities, "{name}");
    for j in 0..2 {
        assert_eq!(log.q[j], expected[1 + j][..count], "{name}");
        assert_eq!(log.tau[j], expected[5 + j][..count], "{name}");
        if let Some(qd) = &log.qd {
            assert_eq!(qd[j], expected[3 + j][..count], "{name}");
        }
    }
}

/// Recordings that need no mapping, and whether they have velocities.
const PLAIN: [(&str, bool); 23] = [
    ("expected.csv", true),
    ("savez.npz", true),
    ("transposed.npz", true),
    ("stamps.npz", false),
    ("savetxt.txt", true),
    ("pandas.csv", true),
    ("pandas.parquet", true),
    ("lists.parquet", false),
    ("version5.mat", true),
    ("version7.mat", false),
    ("milliseconds.mat", false),
    ("joint_states.db3", true),
    ("joint_states.mcap", true),
    ("packed_messages.db3", true),
    ("packed.db3.zstd", true),
    ("json.mcap", false),
    ("packed.csv.zst", true),
    ("packed.parquet.gz", true),
    ("utf16.csv", true),
    ("ur_rtde_lists.csv", true),
    ("ur_rtde_arrays.csv", true),
    ("ur_rtde_brackets.csv", true),
    ("split.zip", true),
];

#[test]
fn val_files_of_other_libraries_are_read_to_the_last_digit_without_a_mapping() {
    for (name, has_velocities) in PLAIN {
        let read = read(name, &Columns::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_is_expected(name, &read, has_velocities);
        // A name says nothing of what a file is.
        let bytes = std::fs::read(folder().join(name)).unwrap();
        let renamed = read_bytes("log.csv", &bytes, &Columns::default()).unwrap();
        assert_eq!(renamed.0.q, read.0.q, "{name}");
    }
}

/// The same recording, written now by the libraries as they are installed: NumPy, SciPy, pandas, pyarrow, `rosbags` and `mcap`.
#[test]
fn val_files_that_libraries_write_today_are_read_to_the_last_digit() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join("target/simulators/bin/python");
    assert!(python.exists(), "rosbags and pyarrow are missing: run scripts/setup test");
    let folder = std::env::temp_dir().join(format!("dynident-written-{}", std::process::id()));
    let script = root.join("tests/data/ref_log_formats.py");
    let output = Command::new(python).arg(script).arg(&folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for (name, has_velocities) in PLAIN {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let read = read_bytes(name, &bytes, &Columns::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_is_expected(name, &read, has_velocities);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn val_columns_of_known_programs_need_no_mapping() {
    for (name, has_velocities) in [
        ("ur_rtde.csv", true),
        ("kuka_sunrise.log", false),
        ("kuka_fri.csv", false),
        ("plotjuggler.csv", true),
        ("libfranka.csv", true),
        ("rostopic_echo.csv", true),
    ] {
        let read = read(name, &Columns::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_is_expected(name, &read, has_velocities);
    }
}

#[test]
fn currents_are_no_torques_until_their_constants_are_given() {
    let error = read("ur_rtde_currents.csv", &Columns::default()).unwrap_err().to_string();
    assert!(error.contains("`actual_current_0`") && error.contains("`scale`"), "{error}");
    let columns = Columns {
        torque: JointColumns {
            transformation: Transformation {
                factor: vec![10.0, 10.0],
                ..Transformation::default()
            },
            unit_stated: true,
            scale_stated: true,
            currents: true,
            ..JointColumns::default()
        },
        ..Columns::default()
    };
    let (log, _) = read("ur_rtde_currents.csv", &columns).unwrap();
    let worst = log.tau[0]
        .iter()
        .zip(&expected()[5])
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(worst < 1e-13, "{worst}");
}

/// Torques of a topic of their own, at other times: linear between its messages, where both topics have some.
#[test]
fn val_topics_are_laid_beside_each_other_in_time() {
    let (log, report) = read("apart.mcap", &Columns::default()).unwrap();
    let said = report
        .findings
        .iter()
        .find(|f| f.kind == FindingKind::Aligned)
        .expect("is said");
    assert!(said.detail.contains("/torques laid beside /states"), "{}", said.detail);
    let q = &expected()[1];
    // The torques begin at 40 ms and end at 976 ms.
    assert_eq!((log.q[0].len(), log.rate_hz), (188, 200.0));
    assert_eq!(log.q[0], q[8..196]);
    for (s, (first, second)) in log.tau[0].iter().zip(&log.tau[1]).enumerate() {
        let at = 0.04 + 0.005 * s as f64;
        assert!(
            (first - 3.0 * at).abs() < 1e-12 && (second - (1.0 - at)).abs() < 1e-12,
            "{s}: {first} {second}"
        );
    }
}

#[test]
fn val_arrays_without_names_are_mapped_by_their_numbers() {
    let columns = Columns {
        position: headers(&["/arm/data[0]", "/arm/data[1]"]),
        torque: headers(&["/arm/data[2]", "/arm/data[3]"]),
        ..Columns::default()
    };
    assert_is_expected("arrays.mcap", &read("arrays.mcap", &columns).unwrap(), false);
    let error = read("arrays.mcap", &Columns::default()).unwrap_err().to_string();
    assert!(error.contains("`/arm/data[3]`"), "{error}");
}

/// A message of one's own with messages in an array within it; names of the motors change their length, so that numbers move
/// about in the message.
#[test]
fn val_messages_of_any_kind_are_read_by_their_definition() {
    let columns = Columns {
        position: headers(&["/arm/state/positions[0]", "/arm/state/positions[1]"]),
        torque: headers(&["/arm/state/motors[0]/torque", "/arm/state/motors[1]/torque"]),
        ..Columns::default()
    };
    for name in ["generic.mcap", "generic.db3", "mcap_folder.zip", "db3_folder.zip"] {
        assert_is_expected(name, &read(name, &columns).unwrap_or_else(|e| panic!("{name}: {e}")), false);
        let seen = log_overview(&folder().join(name), name).unwrap();
        let named = |wanted: &str| {
            seen.columns
                .iter()
                .find(|c| c.name == wanted)
                .unwrap_or_else(|| panic!("{name} has no {wanted}"))
        };
        assert_eq!(
            named("/wrench/wrench/force/x").first[..3],
            [0.0, 1.0, 2.0].map(Some),
            "{name}"
        );
        assert_eq!(named("/arm/state/motors[1]/temperature").first[0], Some(21.5), "{name}");
        assert_eq!(named("/arm/state/motors[0]/on").first[0], Some(1.0), "{name}");
        assert!(
            !seen.columns.iter().any(|c| c.name.starts_with("/scan")),
            "{name}: arrays that change are no series"
        );
    }
    // Another topic, at half the rate: linear between its messages.
    let columns = Columns {
        torque: headers(&["/wrench/wrench/force/x", "/wrench/wrench/torque/z"]),
        ..columns
    };
    let (log, _) = read("generic.mcap", &columns).unwrap();
    let steps: Vec<f64> = log.tau[1].windows(2).map(|w| w[1] - w[0]).collect();
    assert!(
        log.tau[1].len() > 190 && steps.iter().all(|s| (s - 1.0).abs() < 1e-3),
        "{steps:?}"
    );
}

#[test]
fn files_that_are_no_logs_are_called_by_what_they_are() {
    for (bytes, words) in [
        (
            std::fs::read(folder().join("single.npy")).unwrap(),
            "a NumPy array without names; save the arrays with their names",
        ),
        (
            std::fs::read(folder().join("no_joints.mcap")).unwrap(),
            "/rosout (std_msgs/msg/String)",
        ),
        (
            b"\x89HDF\r\n\x1a\n\0\0\0".to_vec(),
            "an HDF5 file; for MATLAB, save it as version 7",
        ),
        (b"#ROSBAG V2.0\n".to_vec(), "a ROS 1 bag; convert it: `rosbags-convert"),
        (b"\x89PNG\r\n\x1a\n\0\0".to_vec(), "is a picture"),
        (
            b"\0\x01\x02\x03\xff".repeat(100),
            "a binary file of an unknown kind; logs are CSV, NPZ, MATLAB",
        ),
        (b"{\"q\": [1, 2]}".to_vec(), "is a JSON document"),
        (b"SQLite format 3\0 and no more".to_vec(), "no ROS 2 bag that can be read"),
        (b"PAR1 and no more".to_vec(), "no Parquet file that can be read"),
        (b"PK\x03\x04 and no more".to_vec(), "no NPZ archive that can be read"),
        (b"\x89MCAP0\r\n and no more".to_vec(), "no MCAP recording that can be read"),
        (
            [&b"MATLAB 5.0 MAT-file"[..], &[b' '; 200]].concat(),
            "no MATLAB file that can be read",
        ),
    ] {
        let error = read_bytes("a.log", &bytes, &Columns::default()).unwrap_err().to_string();
        assert!(error.starts_with("a.log") && error.contains(words), "{error}");
        assert!(
            error.chars().all(|c| !c.is_control() || c == '\n') && error.len() < 1000,
            "{error:?}"
        );
    }
}

/// Files that end early, byte by byte from their end, and with a byte changed: an error or a log, never a panic.
#[test]
fn damaged_recordings_are_refused_and_nothing_else() {
    for name in [
        "savez.npz",
        "pandas.parquet",
        "lists.parquet",
        "version5.mat",
        "version7.mat",
        "joint_states.mcap",
        "joint_states.db3",
        "packed.csv.zst",
    ] {
        let whole = std::fs::read(folder().join(name)).unwrap();
        let mut state = 11u64;
        let mut next = |below: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let mut refused = 0;
        for trial in 0..60 {
            let mut bytes = whole.clone();
            match trial % 3 {
                0 => bytes.truncate(next(whole.len())),
                1 => {
                    for _ in 0..1 + next(4) {
                        let at = next(bytes.len());
                        bytes[at] ^= 1 << next(8);
                    }
                }
                // Near the end is what says where everything is.
                _ => {
                    let at = whole.len() - 1 - next(300.min(whole.len() - 1));
                    bytes[at] = next(256) as u8;
                }
            }
            if let Err(e) = read_bytes(name, &bytes, &Columns::default()) {
                assert!(e.to_string().starts_with(name), "{e}");
                refused += 1;
            }
        }
        assert!(refused > 5, "{name}: {refused}");
    }
}

/// Dialects of text: every combination of separator, decimal sign, what stands before the rows, quotes and line ends.
#[test]
fn prop_dialects_of_text_are_one_table() {
    let expected = expected();
    let names = ["time", "q1", "q2", "qd1", "qd2", "tau1", "tau2"];
    let units = ["s", "rad", "rad", "rad/s", "rad/s", "N m", "Nm"];
    let mut tried = 0;
    for separator in [",", ";", "\t", " ", "   ", " \t", ", ", "; ", "|"] {
        for comma in [false, true] {
            for preamble in [
                "",
                "# recorded by hand\n",
                "Robot: two links\nDate;2024-05-01;10:30\n\n",
                "% a remark\n",
            ] {
                for style in [
                    "plain",
                    "quoted",
                    "units",
                    "unit row",
                    "bracket row",
                    "commented",
                    "trailing",
                    "index",
                ] {
                    let quoted = style == "quoted";
                    let blank = separator.trim().is_empty() && separator != "\t";
                    // Combinations that no program writes, or that have two readings.
                    if comma && separator.contains(',') && !quoted || quoted && blank {
                        continue;
                    }
                    if blank && ["units", "unit row", "bracket row", "trailing", "index"].contains(&style)
                        || preamble.contains("Date") && separator == ";" && comma
                    {
                        continue;
                    }
                    let end = if tried % 2 == 0 { "\n" } else { "\r\n" };
                    let cell = |text: String| if quoted { format!("\"{text}\"") } else { text };
                    let head: Vec<String> = names
                        .iter()
                        .zip(units)
                        .map(|(n, u)| {
                            if style == "units" {
                                cell(format!("{n} [{u}]"))
                            } else {
                                cell(n.to_string())
                            }
                        })
                        .collect();
                    let mut text = preamble.replace('\n', end);
                    if style == "commented" {
                        text += "# ";
                    }
                    text += &head.join(separator);
                    if style == "trailing" {
                        text += separator;
                    }
                    text += end;
                    match style {
                        "unit row" => text += &(units.join(separator) + end),
                        "bracket row" => text += &(units.map(|u| format!("[{u}]")).join(separator) + end),
                        _ => {}
                    }
                    for row in 0..100 {
                        let number = |c: &Vec<f64>| {
                            let plain = format!("{:?}", c[row]);
                            cell(if comma { plain.replace('.', ",") } else { plain })
                        };
                        let mut cells: Vec<String> = expected.iter().map(number).collect();
                        if style == "index" {
                            cells.insert(0, row.to_string());
                        }
                        text += &cells.join(separator);
                        if style == "trailing" {
                            text += separator;
                        }
                        text += end;
                    }
                    let what = format!("{separator:?} comma {comma} preamble {preamble:?} {style}");
                    let (log, report) = read_bytes("a.csv", text.as_bytes(), &Columns::default())
                        .unwrap_or_else(|e| panic!("{what}: {e}\n{}", &text[..text.len().min(400)]));
                    assert_eq!((report.rows, report.rows_used, log.rate_hz), (100, 100, 200.0), "{what}");
                    for j in 0..2 {
                        assert_eq!(log.q[j], expected[1 + j][..100], "{what}");
                        assert_eq!(log.tau[j], expected[5 + j][..100], "{what}");
                    }
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 250, "{tried}");
}

#[test]
fn units_in_headers_are_converted_unless_the_request_states_others() {
    let rows: String = (0..100)
        .map(|i| format!("{},{},{},{},{}\n", i * 5, 90 + i, -i, 1000 * i, i))
        .collect();
    let text = format!("time [ms],q1 [deg],q2 (deg),tau1 [mNm],tau2 [N·m]\n{rows}");
    let (log, report) = read_bytes("a.csv", text.as_bytes(), &Columns::default()).unwrap();
    assert_eq!(log.rate_hz, 200.0);
    assert!((log.q[0][0] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!((log.tau[0][7], log.tau[1][7]), (7.0, 7.0));
    let said = report
        .findings
        .iter()
        .find(|f| f.kind == FindingKind::HeaderUnit)
        .expect("is said");
    assert!(said.count == 3 && said.detail.contains("`q1 [deg]`"), "{said:?}");
    let stated = Columns {
        position: JointColumns {
            unit_stated: true,
            ..JointColumns::default()
        },
        time_unit: Some(TimeUnit::Milliseconds),
        ..Columns::default()
    };
    let (log, _) = read_bytes("a.csv", text.as_bytes(), &stated).unwrap();
    assert_eq!(log.q[0][0], 90.0);
    let amperes = text.replace("[mNm]", "[A]");
    let error = read_bytes("a.csv", amperes.as_bytes(), &Columns::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("`tau1 [A]`") && error.contains("`columns.torque.scale` in N m/A"),
        "{error}"
    );
    let ticks = text.replace("(deg)", "(ticks)");
    let error = read_bytes("a.csv", ticks.as_bytes(), &Columns::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no unit of positions"), "{error}");
}

#[test]
fn columns_without_names_are_numbered_and_can_be_mapped() {
    let text: String = (0..100)
        .map(|i| format!("{} {} {} 1 2\n", f64::from(i) * 0.01, i, 2 * i))
        .collect();
    let error = read_bytes("a.csv", text.as_bytes(), &Columns::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("has no header") && error.contains("column1 to column5"),
        "{error}"
    );
    let columns = Columns {
        time: Some("column1".into()),
        position: headers(&["column3", "column2"]),
        torque: headers(&["column4", "column5"]),
        ..Columns::default()
    };
    let (log, _) = read_bytes("a.csv", text.as_bytes(), &columns).unwrap();
    assert_eq!(
        (log.q[0][3], log.q[1][3], log.tau[1][3], log.q[0].len()),
        (6.0, 3.0, 2.0, 100)
    );
}

/// The published bag and the CSV that another library made of it.
#[test]
fn val_the_panda_bag_has_the_numbers_of_its_csv() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/real/panda_rosbag2");
    if !folder.is_dir() {
        eprintln!("skipped: {} is not there", folder.display());
        return;
    }
    let names: Vec<String> = (1..=7).map(|j| format!("fer_joint{j}")).collect();
    let read = |file: &str, columns: &Columns| {
        let bytes = std::fs::read(folder.join(file)).unwrap();
        read_log(
            Source {
                name: file.to_string(),
                bytes: &bytes[..],
            },
            columns,
            &names,
        )
        .unwrap()
    };
    for (of_bag, of_csv) in [("/joint_states/stamp", "stamp"), ("/joint_states/log_time", "time")] {
        let time = |name: &str| Columns {
            time: Some(name.into()),
            ..Columns::default()
        };
        let (bag, report) = read("panda_exciting_trajectory.db3", &time(of_bag));
        let (csv, expected) = read("same_as.csv.gz", &time(of_csv));
        assert_eq!((report.rows, report.rows_used), (expected.rows, expected.rows_used));
        assert_eq!(report.rows, 727);
        assert!(
            (bag.rate_hz / csv.rate_hz - 1.0).abs() < 1e-6,
            "{} {}",
            bag.rate_hz,
            csv.rate_hz
        );
        let of = |log: &Log| [log.q.clone(), log.qd.clone().unwrap(), log.tau.clone()].concat();
        for (bag, csv) in of(&bag).iter().zip(of(&csv)) {
            let worst = bag.iter().zip(&csv).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Nine digits in the CSV, of stamps up to 24 s and of values, and steps between stamps in between: both are laid onto
            // a grid in time.
            let step = csv.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            let largest = csv.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            let bound = 2.0 * 0.5e-7 * 30.0 * step + 0.5e-8 * largest;
            assert!(worst < bound, "{worst} {bound}");
        }
    }
    // As they are, before any grid.
    let columns = |file: &str| log_overview(&folder.join(file), file).unwrap().columns;
    let (bag, csv) = (columns("panda_exciting_trajectory.db3"), columns("same_as.csv.gz"));
    for (quantity, word) in [("q", "position"), ("qd", "velocity"), ("tau", "effort")] {
        for j in 1..=7 {
            let of = |columns: &[LogColumn], name: String| {
                columns
                    .iter()
                    .find(|c| c.name == name)
                    .unwrap_or_else(|| panic!("{name}"))
                    .first
                    .clone()
            };
            let bag = of(&bag, format!("/joint_states/fer_joint{j}/{word}"));
            let csv = of(&csv, format!("{quantity}{j}"));
            assert!(bag.len() == 200 && csv.len() == 200);
            for (a, b) in bag.iter().zip(&csv) {
                let (a, b) = (a.unwrap(), b.unwrap());
                assert!((a - b).abs() <= 0.5000001e-8 * b.abs().max(1e-12), "{word} {j}: {a} {b}");
            }
        }
    }
}
