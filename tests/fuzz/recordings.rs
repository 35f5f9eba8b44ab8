//! Recordings that are no text: files of every format with bits turned, sizes replaced, parts cut out, repeated and taken from
//! another file.

use super::bases::{LOG, REQUEST};
use super::dice::Dice;
use super::runner::{Order, Runner};
use super::target::Target;
use libtest_mimic::{Failed, Trial};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Files to begin with: every format, and of each the variant whose inside is not hidden by compression where there is one.
const BASES: [&str; 27] = [
    "savez.npz",
    "transposed.npz",
    "stamps.npz",
    "pandas.parquet",
    "lists.parquet",
    "version5.mat",
    "version7.mat",
    "joint_states.db3",
    "packed_messages.db3",
    "joint_states.mcap",
    "apart.mcap",
    "json.mcap",
    "packed.csv.zst",
    "packed.parquet.gz",
    "savetxt.txt",
    "kuka_fri.csv",
    "kuka_sunrise.log",
    "ur_rtde.csv",
    "ur_rtde_lists.csv",
    "ur_rtde_arrays.csv",
    "kuka_fri.csv in UTF-16",
    "milliseconds.mat",
    "packed.db3.zstd",
    "generic.mcap",
    "generic.db3",
    "db3_folder.zip",
    "split.zip",
];
/// Inputs of each: some seconds.
const INPUTS: u64 = 60;

pub fn trials() -> Vec<Trial> {
    let trial = |name: &'static str| Trial::test(format!("recordings::{name}"), move || mutated(name));
    BASES.into_iter().map(trial).collect()
}

fn file(name: &str) -> Vec<u8> {
    if let Some(plain) = name.strip_suffix(" in UTF-16") {
        let text = String::from_utf8(file(plain)).expect("it is text");
        return format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/logs/formats")
        .join(name);
    std::fs::read(path).expect("the recording is there")
}

/// The planar arm, with joints as the recordings call them, and the columns of recordings that have none known by name.
fn request(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robots/planar_two_link.json");
    let mut robot: Value =
        serde_json::from_str(&std::fs::read_to_string(path).expect("the shipped robot is there")).expect("it is JSON");
    for (j, name) in ["shoulder", "elbow"].into_iter().enumerate() {
        robot["joints"][j]["name"] = json!(name);
    }
    let mut request = json!({"robot": robot});
    if ["generic.mcap", "generic.db3", "db3_folder.zip"].contains(&name) {
        let of = |pattern: &str| [0, 1].map(|j| pattern.replace('N', &j.to_string()));
        request["columns"] = json!({
            "position": {"headers": of("/arm/state/positions[N]")},
            "torque": {"headers": of("/arm/state/motors[N]/torque")},
        });
    }
    request
}

/// Numbers that sizes and counts are replaced by: none, the ends of the types, and just beyond what there is.
fn count(dice: &mut Dice, length: usize) -> u64 {
    let ends = [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0xffff_ffff, i64::MAX as u64, u64::MAX];
    match dice.below(3) {
        0 => length as u64 + 1,
        1 => dice.bits() >> dice.below(64),
        _ => ends[dice.below(ends.len())],
    }
}

fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice, other: &[u8]) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    // What says where everything is stands at the ends.
    let near = 400.min(length);
    let at = match dice.below(3) {
        0 => dice.below(near),
        1 => length - 1 - dice.below(near),
        _ => dice.below(length),
    };
    match dice.below(8) {
        0 => bytes.truncate(at),
        1 | 2 => bytes[at] ^= 1 << dice.below(8),
        3 => bytes[at] = dice.bits() as u8,
        4 | 5 => {
            let value = count(dice, length).to_le_bytes();
            let size = [1, 2, 4, 8][dice.below(4)].min(length - at);
            bytes[at..at + size].copy_from_slice(&value[..size]);
        }
        6 => {
            let run = dice.run(length, 4096);
            match dice.below(2) {
                0 => drop(bytes.drain(run)),
                _ => bytes.extend_from_within(run),
            }
        }
        _ => {
            let run = dice.run(other.len(), 4096);
            bytes.splice(at..at, other[run].iter().copied());
        }
    }
}

fn mutated(name: &str) -> Result<(), Failed> {
    let (whole, request) = (file(name), request(name).to_string());
    let folder = std::env::temp_dir().join(format!("dynident-recordings-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let mut runner = Runner::new();
    let mut failed = Vec::new();
    for seed in 0..=INPUTS {
        let mut bytes = whole.clone();
        let mut dice = Dice::new(seed);
        // The first is the file itself.
        for _ in 0..if seed == 0 { 0 } else { 1 + dice.below(3) } {
            let other = file(BASES[dice.below(BASES.len())]);
            mutate(&mut bytes, &mut dice, &other);
        }
        std::fs::write(folder.join(LOG), &bytes)?;
        std::fs::write(folder.join(REQUEST), &request)?;
        let verdict = runner.run(&Order::Folder(Target::Inspect, &folder));
        if seed == 0 && !verdict.accepted {
            return Err(format!("{name} is refused: {} {:?}", verdict.refused, verdict.failure).into());
        }
        if let Some(failure) = verdict.failure {
            failed.push(format!("seed {seed}: {failure} ({})", kept(name, seed, &folder).display()));
        }
    }
    std::fs::remove_dir_all(&folder)?;
    if failed.is_empty() {
        Ok(())
    } else {
        Err(failed.join("\n").into())
    }
}

/// Keeps the files of an input that failed: one for the corpus.
fn kept(name: &str, seed: u64, folder: &Path) -> PathBuf {
    let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz/inspect/{name}-{seed}"));
    let _ = std::fs::create_dir_all(&to);
    for part in [LOG, REQUEST] {
        let _ = std::fs::copy(folder.join(part), to.join(part));
    }
    to
}
