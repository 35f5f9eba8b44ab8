//! Reading log files, good and bad.

use dynident::formats::logs::{
    ChannelColumn, Columns, FindingKind, JointColumns, LogError, LogReport, Source, TimeUnit, Transformation, read_joined_log,
    read_log,
};
use dynident::preparation::Log;
use flate2::Compression;
use flate2::write::GzEncoder;
use nalgebra::DMatrix;
use std::fmt::Write as _;
use std::io::Write as _;

fn joints(n: usize) -> Vec<String> {
    (1..=n).map(|j| format!("A{j}")).collect()
}

fn read(text: impl AsRef<[u8]>, columns: &Columns, n: usize) -> Result<(Log, LogReport), LogError> {
    read_log(
        Source {
            name: "a.csv".to_string(),
            bytes: text.as_ref(),
        },
        columns,
        &joints(n),
    )
}

/// One joint, 100 Hz, q = sin t, tau = cos t.
fn rows(count: usize) -> Vec<String> {
    (0..count)
        .map(|i| {
            let t = i as f64 / 100.0;
            format!("{t:.4},{:.9},{:.9}", t.sin(), t.cos())
        })
        .collect()
}

fn file(rows: &[String]) -> String {
    format!("time,q1,tau1\n{}\n", rows.join("\n"))
}

fn count(report: &LogReport, kind: FindingKind) -> usize {
    report.findings.iter().find(|f| f.kind == kind).map_or(0, |f| f.count)
}

/// Largest error against q = sin t [rad].
fn worst(log: &Log) -> f64 {
    let error = |(s, q): (usize, &f64)| {
        if log.usable[s] {
            (q - (log.start_s + s as f64 / log.rate_hz).sin()).abs()
        } else {
            0.0
        }
    };
    log.q[0].iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn prop_a_clean_log_is_read_as_it_stands_plain_or_gzip() {
    let text = file(&rows(200));
    let (log, report) = read(&text, &Columns::default(), 1).unwrap();
    assert_eq!(
        (log.rate_hz, log.samples(), report.rows_used, report.resampled),
        (100.0, 200, 200, false)
    );
    assert!(report.findings.is_empty());
    assert!(worst(&log) < 1e-9);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(text.as_bytes()).unwrap();
    let (zipped, _) = read(gzip.finish().unwrap(), &Columns::default(), 1).unwrap();
    assert_eq!(zipped, log);
}

#[test]
fn prop_irregular_rows_are_counted_named_and_dealt_with() {
    let mut rows = rows(1000);
    rows[500] = "5.0000,oops,1".to_string();
    rows[600] = "6.0000,1.0".to_string();
    rows[700] = "7.0000,NaN,1".to_string();
    rows.insert(800, rows[799].clone());
    rows.insert(300, "0.5000,0.1,0.2".to_string());
    let (log, report) = read(file(&rows), &Columns::default(), 1).unwrap();
    assert_eq!(count(&report, FindingKind::GarbageRow), 3);
    assert_eq!(count(&report, FindingKind::RepeatedRow), 1);
    assert_eq!(count(&report, FindingKind::TimeOutOfOrder), 1);
    assert_eq!(count(&report, FindingKind::MissingSample), 3);
    let garbage = report.findings.iter().find(|f| f.kind == FindingKind::GarbageRow).unwrap();
    // The header is line 1, and one row was put in before.
    assert_eq!(garbage.lines, [503, 603, 703]);
    assert_eq!((log.rate_hz, log.samples()), (100.0, 1000));
    // Cubic interpolation over two steps: h⁴ max|q''''| / 16.
    assert!(worst(&log) < 0.02f64.powi(4), "{}", worst(&log));
}

#[test]
fn prop_jitter_is_resampled_and_a_gap_is_marked() {
    let stamp = |i: usize| i as f64 / 100.0 + 0.003 * (i as f64 * 1.7).sin();
    let jittered: Vec<String> = (0..1000)
        .filter(|i| !(400..450).contains(i))
        .map(|i| (stamp(i), i))
        .map(|(t, _)| format!("{t:.7},{:.9},{:.9}", t.sin(), t.cos()))
        .collect();
    let (log, report) = read(file(&jittered), &Columns::default(), 1).unwrap();
    assert!(report.resampled);
    assert_eq!(count(&report, FindingKind::Gap), 1);
    assert!(count(&report, FindingKind::Jitter) > 0);
    assert!((log.rate_hz - 100.0).abs() < 0.1, "{}", log.rate_hz);
    let unusable = log.usable.iter().filter(|&&u| !u).count();
    assert!((48..=52).contains(&unusable), "{unusable}");
    assert!(worst(&log) < 2e-6, "{}", worst(&log));
}

#[test]
fn prop_columns_map_headers_units_signs_offsets_and_rate() {
    let mut text = "tick;motor;current;other\n".to_string();
    for i in 0..100 {
        writeln!(text, "{};{};{};x", 2 * i, 180.0 + i as f64, -2.0 * i as f64).unwrap();
    }
    let columns = Columns {
        time: Some("tick".to_string()),
        time_unit: Some(TimeUnit::Milliseconds),
        position: JointColumns {
            headers: vec!["motor".to_string()],
            transformation: Transformation {
                factor: vec![std::f64::consts::PI / 180.0],
                coupling: None,
                offset: vec![-1.0],
            },
            ..JointColumns::default()
        },
        torque: JointColumns {
            headers: vec!["current".to_string()],
            transformation: Transformation {
                factor: vec![-0.5],
                coupling: None,
                offset: vec![],
            },
            ..JointColumns::default()
        },
        ..Columns::default()
    };
    let (log, _) = read(&text, &columns, 1).unwrap();
    assert_eq!(log.rate_hz, 500.0);
    assert!((log.q[0][0] - (std::f64::consts::PI - 1.0)).abs() < 1e-15);
    assert_eq!(log.tau[0][10], 10.0);
}

#[test]
fn prop_a_coupling_matrix_mixes_the_columns() {
    let text = format!("q1,q2,tau1,tau2\n{}", "1,2,10,20\n3,5,30,50\n".repeat(20));
    let columns = Columns {
        sample_rate_hz: Some(50.0),
        position: JointColumns {
            transformation: Transformation {
                coupling: Some(DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 1.0, 2.0])),
                ..Default::default()
            },
            ..Default::default()
        },
        ..Columns::default()
    };
    let (log, report) = read(&text, &columns, 2).unwrap();
    assert_eq!((log.q[0][1], log.q[1][1]), (3.0, 13.0));
    assert_eq!((log.tau[1][1], report.rate_hz), (50.0, 50.0));
}

#[test]
fn prop_files_that_are_no_logs_are_refused_with_place_and_remedy() {
    let message = |text: &[u8], columns: &Columns| read(text, columns, 1).unwrap_err().to_string();
    let default = Columns::default();
    assert!(message(b"", &default).contains("is empty"));
    assert!(message(b"time,q1,tau1\n", &default).contains("is empty"));
    assert!(message(b"1,2,3\n4,5,6\n", &default).contains("no header"));
    let missing = message(file(&rows(100)).replace("tau1", "torque_of_axis").as_bytes(), &default);
    assert!(
        missing.contains("`tau1` (joint A1)") && missing.contains("`torque_of_axis`") && missing.contains("columns"),
        "{missing}"
    );
    assert!(message(file(&rows(100)).replace("time", "nothing").as_bytes(), &default).contains("sample_rate_hz"));
    assert!(message(file(&rows(100)).replace("tau1", "q1").as_bytes(), &default).contains("tau1"));
    let mut garbage = rows(100);
    (0..20).for_each(|i| garbage[3 * i] = "a,b,c".to_string());
    let text = message(file(&garbage).as_bytes(), &default);
    assert!(
        text.contains("20 of 100 rows") && text.contains("line 2") && text.contains("`b` in column 2"),
        "{text}"
    );
    let twice = [rows(100), rows(100)].concat();
    assert!(message(file(&twice).as_bytes(), &default).contains("time goes back"));
    assert!(message(file(&rows(5)).as_bytes(), &default).contains("5 usable rows"));
    // The number of a row is no time, though it could be milliseconds.
    let numbered: Vec<String> = rows(100)
        .iter()
        .enumerate()
        .map(|(i, r)| format!("{i}{}", &r[r.find(',').unwrap()..]))
        .collect();
    let text = message(file(&numbered).as_bytes(), &default);
    assert!(text.contains("1.0000e0 Hz") && text.contains("`time_unit`"), "{text}");
}

#[test]
fn prop_a_compressed_file_that_was_cut_off_is_named_as_such() {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(file(&rows(5000)).as_bytes()).unwrap();
    let whole = gzip.finish().unwrap();
    let error = read(&whole[..whole.len() / 2], &Columns::default(), 1).unwrap_err();
    assert!(matches!(error, LogError::CutOff { line, .. } if line > 1), "{error}");
}

#[test]
fn prop_columns_of_another_file_are_joined_row_by_row() {
    let folder = std::env::temp_dir().join(format!("dynident-joined-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: String| {
        std::fs::write(folder.join(name), text).unwrap();
        (name.to_string(), folder.join(name))
    };
    let positions: Vec<String> = rows(200).iter().map(|r| r.rsplit_once(',').unwrap().0.to_string()).collect();
    let mut torques: Vec<String> = rows(200).iter().map(|r| r.rsplit_once(',').unwrap().1.to_string()).collect();
    torques[50] = "none".to_string();
    let (_, log) = write("q.csv", format!("time,q1\n{}\n", positions.join("\n")));
    let other = write("tau.csv", format!("tau1\n{}\n", torques.join("\n")));
    let short = write("short.csv", format!("tau1\n{}\n", torques[..150].join("\n")));
    let columns = |file: &str| Columns {
        torque: JointColumns {
            file: Some(file.to_string()),
            ..JointColumns::default()
        },
        ..Columns::default()
    };
    let read = |file: &str| read_joined_log(&log, &[other.clone(), short.clone()], &columns(file), &joints(1));
    let (joined, report) = read("tau.csv").unwrap();
    assert_eq!((report.rows, report.rows_used, joined.samples()), (200, 199, 200));
    assert!((joined.tau[0][70] - 0.7f64.cos()).abs() < 1e-9 && worst(&joined) < 1e-7);
    let message = |file: &str| read(file).unwrap_err().to_string();
    assert!(
        message("short.csv").contains("q.csv has 200 rows and short.csv"),
        "{}",
        message("short.csv")
    );
    assert!(message("absent.csv").contains("`absent.csv`, which is not among the logs"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn prop_a_header_without_end_is_refused_before_it_fills_the_memory() {
    struct Endless(usize);
    impl std::io::Read for Endless {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            self.0 += out.len();
            assert!(self.0 < 10_000_000, "reads on and on");
            out.fill(b'x');
            Ok(out.len())
        }
    }
    let source = Source {
        name: "a.csv".to_string(),
        bytes: Endless(0),
    };
    let error = read_log(source, &Columns::default(), &joints(1)).unwrap_err();
    assert!(matches!(error, LogError::LongHeader { .. }), "{error}");
}

#[test]
fn prop_a_file_that_ends_within_a_row_loses_that_row_alone() {
    let text = file(&rows(100));
    let cut = &text[..text.len() - 12];
    let (log, report) = read(cut, &Columns::default(), 1).unwrap();
    assert_eq!(
        (report.rows, count(&report, FindingKind::GarbageRow), log.samples()),
        (100, 1, 99)
    );
}

fn stored(file: &str) -> Vec<u8> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/logs")
        .join(file);
    std::fs::read(path).unwrap()
}

/// Stamps of controllers and ROS: the unit is that of the steps.
#[test]
fn prop_stamps_in_any_unit_are_read_as_seconds_and_it_is_said() {
    for (unit, per_second, words) in [
        ("ms", 1e3, "milliseconds"),
        ("us", 1e6, "microseconds"),
        ("ns", 1e9, "nanoseconds"),
    ] {
        for rate in [25.0, 100.0, 500.0, 1000.0, 4000.0] {
            // From zero, and since 1970.
            for start in [0.0, 1_764_315_000.0] {
                let row = |i: usize| {
                    let t = i as f64 / rate;
                    format!("{:.0},{:.9},{:.9}", (start + t) * per_second, t.sin(), t.cos())
                };
                let rows: Vec<String> = (0..2000).map(row).collect();
                let result = read(file(&rows), &Columns::default(), 1);
                if unit == "ms" && rate > 500.0 {
                    // Stamps of whole milliseconds do not resolve such rates.
                    continue;
                }
                let (log, report) = result.unwrap_or_else(|e| panic!("{unit} {rate} {start}: {e}"));
                assert!((log.rate_hz / rate - 1.0).abs() < 1e-6, "{unit} {rate}: {}", log.rate_hz);
                let said = report
                    .findings
                    .iter()
                    .find(|f| f.kind == FindingKind::TimeUnit)
                    .expect("is said");
                assert!(said.detail.contains(words), "{}", said.detail);
                // Stated, it is not a finding.
                let stated = Columns {
                    time_unit: Some(TimeUnit::ALL.into_iter().find(|u| u.names().1 == unit).unwrap()),
                    ..Columns::default()
                };
                let (_, report) = read(file(&rows), &stated, 1).unwrap();
                assert_eq!(count(&report, FindingKind::TimeUnit), 0);
            }
        }
    }
    let (_, report) = read(file(&rows(500)), &Columns::default(), 1).unwrap();
    assert_eq!(count(&report, FindingKind::TimeUnit), 0, "seconds are not said");
}

#[test]
fn regress_stamps_that_are_no_times_of_one_recording_are_refused_without_their_memory() {
    let names = ["q", "p"].map(str::to_string);
    let read = |file: &str, columns: &Columns| {
        let bytes = stored(file);
        let source = Source {
            name: file.to_string(),
            bytes: &bytes[..],
        };
        read_log(source, columns, &names)
    };
    let error = read("last_stamp_1e12.csv.gz", &Columns::default()).unwrap_err().to_string();
    assert!(
        error.contains("after line 41") && error.contains("to 1000000000000 s"),
        "{error}"
    );
    let rate = |hz: f64| Columns {
        sample_rate_hz: Some(hz),
        ..Columns::default()
    };
    let (log, report) = read("ns_stamps.csv.gz", &rate(100.0)).unwrap();
    assert_eq!((log.rate_hz, count(&report, FindingKind::TimeUnit)), (100.0, log.q[0].len()));
    let (log, _) = read("ns_stamps.csv.gz", &Columns::default()).unwrap();
    assert!((log.rate_hz - 100.0).abs() < 1e-3, "{}", log.rate_hz);
    let error = read("ns_stamps.csv.gz", &rate(333.0)).unwrap_err().to_string();
    assert!(error.contains("states 333 Hz") && error.contains("`time_unit`"), "{error}");
    let as_seconds = Columns {
        time_unit: Some(TimeUnit::Seconds),
        ..rate(100.0)
    };
    let error = read("ns_stamps.csv.gz", &as_seconds).unwrap_err().to_string();
    assert!(error.contains("`time_unit`"), "{error}");
    let error = read("one_bad_row.csv.gz", &Columns::default()).unwrap_err();
    assert!(
        matches!(error, LogError::TooShort { .. } | LogError::TooMuchGarbage { .. }),
        "{error}"
    );
}

#[test]
fn prop_files_that_are_all_columns_or_all_lines_are_refused_with_the_limit() {
    let wide = (0..10_000).map(|i| format!("c{i}")).collect::<Vec<_>>().join(",");
    let error = read(format!("{wide}\n"), &Columns::default(), 1).unwrap_err().to_string();
    assert!(error.contains("has 10000 columns, the most accepted is 4096"), "{error}");
    let narrow = (0..3000).map(|i| format!("c{i}")).collect::<Vec<_>>().join(",");
    let error = read(format!("{narrow}\n"), &Columns::default(), 1).unwrap_err().to_string();
    assert!(error.contains("and 2940 more") && error.len() < 3000, "{error}");
    let garbage = format!("time,q1,tau1\n0,{},1\n", "x".repeat(1_000_000));
    let error = read(garbage, &Columns::default(), 1).unwrap_err().to_string();
    assert!(error.len() < 1000, "{}", error.len());
    // A hundred megabytes of zeros in a hundred kilobytes.
    let mut encoder = GzEncoder::new(b"".to_vec(), Compression::default());
    encoder.write_all(b"time,q1,tau1\n").unwrap();
    (0..100).for_each(|_| encoder.write_all(&b"0,0,0\n".repeat(1 << 18)).unwrap());
    let error = read(encoder.finish().unwrap(), &Columns::default(), 1)
        .unwrap_err()
        .to_string();
    assert!(error.contains("more than 100 times its size"), "{error}");
}

fn with_temperature(unit: &str) -> Columns {
    Columns {
        channels: vec![ChannelColumn {
            name: "temperature".into(),
            header: "T_gear".into(),
            unit: unit.into(),
        }],
        ..Columns::default()
    }
}

/// A temperature in every tenth row: the other rows count all the same, and straight lines join its values.
#[test]
fn prop_a_slow_channel_is_joined_by_straight_lines() {
    let rows: Vec<String> = rows(1000)
        .iter()
        .enumerate()
        .map(|(i, row)| match i % 10 {
            0 => format!("{row},{}", 20.0 + 0.01 * i as f64),
            5 => format!("{row},nan"),
            _ => format!("{row},"),
        })
        .collect();
    let text = format!("time,q1,tau1,T_gear\n{}\n", rows.join("\n"));
    let (log, report) = read(&text, &with_temperature("degC"), 1).unwrap();
    assert_eq!((log.samples(), report.rows_used), (1000, 1000));
    assert_eq!(count(&report, FindingKind::SlowChannel), 900);
    let [channel] = &log.channels[..] else {
        panic!("{:?}", log.channels.len())
    };
    assert_eq!((&*channel.name, &*channel.unit), ("temperature", "degC"));
    for (i, value) in channel.values.iter().enumerate() {
        let truth = 20.0 + 0.01 * i.min(990) as f64;
        assert!((value - truth).abs() < 1e-9, "{i}: {value}, not {truth}");
    }
    // Without the channel the column does not matter.
    let (plain, _) = read(&text, &Columns::default(), 1).unwrap();
    assert_eq!((plain.q, plain.tau), (log.q, log.tau));
}

#[test]
fn a_channel_without_column_or_numbers_is_refused_by_name() {
    let rows: Vec<String> = rows(100).iter().map(|row| format!("{row},-")).collect();
    let error = |header: &str| {
        let text = format!("time,q1,tau1,{header}\n{}\n", rows.join("\n"));
        read(text, &with_temperature("degC"), 1).unwrap_err().to_string()
    };
    let missing = error("T_motor");
    assert!(
        missing.contains("`T_gear` (channel temperature)") && missing.contains("`T_motor`"),
        "{missing}"
    );
    let empty = error("T_gear");
    assert!(
        empty.contains("`T_gear` has no numbers") && empty.contains("columns.channels"),
        "{empty}"
    );
}
