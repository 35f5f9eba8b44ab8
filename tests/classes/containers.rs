//! Recordings in containers: cut off, damaged, bombs, shapes that do not fit.

use super::written::{Row, good_rows, log};
use super::{Case, Expect, refused, try_all};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

fn sample(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/data/logs/formats/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn case(name: String, file: &str, content: Vec<u8>, expect: Expect) -> Case {
    let mut case = Case::identify(name, String::new(), expect);
    case.logs = vec![(file.into(), content)];
    case
}

fn any(_: &Value) -> Result<(), String> {
    Ok(())
}

const SAMPLES: [&str; 12] = [
    "arrays.mcap",
    "joint_states.mcap",
    "joint_states.db3",
    "lists.parquet",
    "pandas.parquet",
    "packed.parquet.gz",
    "packed.csv.zst",
    "packed.db3.zstd",
    "savez.npz",
    "transposed.npz",
    "version5.mat",
    "version7.mat",
];

/// Cut off anywhere, with bytes changed, or with others behind the end, they are refused by name or read as far as they go.
#[test]
fn damaged_recordings_are_refused_by_name() {
    let mut cases = Vec::new();
    for file in SAMPLES {
        let whole = sample(file);
        for part in [1, 5, 50, 95, 99] {
            let cut = whole[..(whole.len() * part / 100).max(1)].to_vec();
            cases.push(case(format!("{part} % of {file}"), file, cut, refused([file])));
        }
        for (at, value) in [(10, 0xff), (30, 0x00), (50, 0xff), (75, 0x7f), (97, 0x80)] {
            let mut damaged = whole.clone();
            let from = whole.len() * at / 100;
            damaged[from..(from + 16).min(whole.len())].fill(value);
            cases.push(case(
                format!("{file} damaged at {at} %"),
                file,
                damaged,
                Expect::Either(vec![file.into()], any),
            ));
        }
        let longer = [whole.clone(), b"more".repeat(100)].concat();
        cases.push(case(format!("more behind {file}"), file, longer, Expect::Either(vec![], any)));
        // The content says what it is, whatever the name.
        cases.push(case(format!("{file} as text"), "log.csv", whole, Expect::Either(vec![], any)));
    }
    try_all(&cases);
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(content).unwrap();
    packed.finish().unwrap()
}

/// An array of doubles as NumPy writes it.
fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let shape: Vec<String> = shape.iter().map(|n| format!("{n},")).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape.join(" "));
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    let data = values.iter().flat_map(|v| v.to_le_bytes());
    [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes()]
        .concat()
        .into_iter()
        .chain(data)
        .collect()
}

fn npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, content) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

fn columns(rows: &[Row]) -> [Vec<f64>; 5] {
    std::array::from_fn(|c| rows.iter().map(|r| r[c]).collect())
}

#[test]
fn archives_of_arrays_are_read_for_what_they_hold_and_no_further() {
    let rows = good_rows();
    let n = rows.len();
    let [t, a, b, x, y] = columns(&rows);
    let both = |one: &[f64], other: &[f64]| -> Vec<f64> { one.iter().zip(other).flat_map(|(p, q)| [*p, *q]).collect() };
    let (q, tau) = (npy(&[n, 2], &both(&a, &b)), npy(&[n, 2], &both(&x, &y)));
    let time = || npy(&[n], &t);
    let good = npz(&[("time", time()), ("q", q.clone()), ("tau", tau.clone())]);
    let claims = |shape: &[usize]| npy(shape, &[0.0; 4]);
    let mut cases = vec![case("whole".into(), "log.npz", good.clone(), Expect::Result(any))];
    for (name, arrays) in [
        (
            "one row",
            vec![
                ("time", npy(&[1], &[0.0])),
                ("q", npy(&[1, 2], &[0.0; 2])),
                ("tau", npy(&[1, 2], &[0.0; 2])),
            ],
        ),
        (
            "no rows",
            vec![("time", npy(&[0], &[])), ("q", npy(&[0, 2], &[])), ("tau", npy(&[0, 2], &[]))],
        ),
        (
            "a scalar",
            vec![("time", npy(&[], &[1.0])), ("q", q.clone()), ("tau", tau.clone())],
        ),
        (
            "five dimensions",
            vec![
                ("time", time()),
                ("q", npy(&[2, 2, 2, 2, 2], &[0.0; 32])),
                ("tau", tau.clone()),
            ],
        ),
        (
            "more than there is",
            vec![("time", claims(&[1 << 40])), ("q", q.clone()), ("tau", tau.clone())],
        ),
        (
            "a product beyond 64 bits",
            vec![("time", claims(&[1 << 33, 1 << 33])), ("q", q.clone()), ("tau", tau.clone())],
        ),
        (
            "one joint",
            vec![("time", time()), ("q", npy(&[n], &a)), ("tau", npy(&[n], &x))],
        ),
        ("no arrays", vec![]),
        (
            "words",
            vec![("time", b"words".to_vec()), ("q", q.clone()), ("tau", tau.clone())],
        ),
    ] {
        cases.push(case(name.into(), "log.npz", npz(&arrays), refused(["log.npz"])));
    }
    let shorter = npz(&[("time", npy(&[n / 2], &t[..n / 2])), ("q", q.clone()), ("tau", tau.clone())]);
    cases.push(case(
        "times of half".into(),
        "log.npz",
        shorter,
        Expect::Either(vec!["log.npz".into()], any),
    ));
    let odd = npz(&[("../time", time()), ("q", q.clone()), ("tau", tau)]);
    cases.push(case(
        "a path for a name".into(),
        "log.npz",
        odd,
        Expect::Either(vec!["log.npz".into()], any),
    ));
    // A hundred megabytes of zeros in a hundred kilobytes.
    let zeros = npy(&[12 << 20], &vec![0.0; 12 << 20]);
    let bomb = npz(&[("time", zeros.clone()), ("q", zeros), ("tau", q)]);
    cases.push(case("a bomb".into(), "log.npz", bomb, refused(["log.npz"])));
    try_all(&cases);
}

#[test]
fn compressed_logs_unpack_to_no_more_than_a_recording() {
    let text = log(good_rows());
    let packed = gzip(text.as_bytes());
    let mut cases = vec![case("packed".into(), "log.csv.gz", packed.clone(), Expect::Result(any))];
    let header = "time,q1,q2,tau1,tau2\n";
    for (name, line) in [
        ("blanks", " ".repeat(1 << 20)),
        ("rows", "0,0,0,0,0\n".repeat(100_000)),
        ("line ends", "\n".repeat(1 << 20)),
    ] {
        let bomb = gzip(format!("{header}{}", line.repeat(300 << 20 >> 20)).as_bytes());
        cases.push(case(format!("a bomb of {name}"), "log.csv.gz", bomb, refused(["log.csv.gz"])));
    }
    cases.push(case(
        "packed twice".into(),
        "log.csv.gz",
        gzip(&packed),
        Expect::Either(vec!["log.csv.gz".into()], any),
    ));
    cases.push(case(
        "cut off".into(),
        "log.csv.gz",
        packed[..packed.len() / 2].to_vec(),
        refused(["log.csv.gz"]),
    ));
    cases.push(case(
        "nothing, packed".into(),
        "log.csv.gz",
        gzip(b""),
        refused(["log.csv.gz"]),
    ));
    cases.push(case(
        "two in one".into(),
        "log.csv.gz",
        [packed.clone(), gzip(b"")].concat(),
        Expect::Result(any),
    ));
    for (name, content) in [
        ("a picture", b"\x89PNG\r\n\x1a\n0000".to_vec()),
        ("a page", b"<html><body>404</body></html>".to_vec()),
        ("a document", b"{\"time\": [1, 2, 3]}".to_vec()),
        ("a PDF", b"%PDF-1.7\n1 0 obj".to_vec()),
        ("HDF5", b"\x89HDF\r\n\x1a\n\x00\x00".to_vec()),
        ("pickle", b"\x80\x04\x95abc.".to_vec()),
        ("a program", b"\x7fELF\x02\x01\x01".to_vec()),
        ("an archive", b"PK\x03\x04 nothing".to_vec()),
        (
            "an empty archive",
            b"PK\x05\x06\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00".to_vec(),
        ),
    ] {
        cases.push(case(name.into(), "log.bin", content, refused(["log.bin"])));
    }
    try_all(&cases);
}
