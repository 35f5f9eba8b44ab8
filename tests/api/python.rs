//! The Python client: installed by pip, and its notebook run against a server.

use crate::server::Server;
use std::path::{Path, PathBuf};
use std::process::Command;

fn copied(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copied(&path, &target);
        } else {
            std::fs::copy(&path, target).unwrap();
        }
    }
}

/// The installed client by mypy, as its users have it: every type is stated, and none is wrong.
fn checked(python: &Path, folder: &Path) {
    let run = Command::new(python)
        .args(["-m", "mypy", "--strict", "--cache-dir"])
        .arg(folder.join("mypy"))
        .arg("site/dynident")
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stdout));
}

/// Robots by their documents, by files of every kind, and by an archive.
const ROBOTS: &str = r#"
import gzip, json, os, pathlib, zipfile
from dynident import Client, DynidentError
client = Client(os.environ["DYNIDENT_URL"])
urdf = '<robot name="two"><link name="a"/><link name="b"/><link name="c"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>' \
    '<joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint></robot>'
pathlib.Path("two.urdf").write_text(urdf)
pathlib.Path("two.json").write_text("\n " + json.dumps({"urdf": urdf}))
pathlib.Path("two.urdf.gz").write_bytes(gzip.compress(urdf.encode()))
with zipfile.ZipFile("two.zip", "w") as archive:
    archive.write("two.urdf", "two/urdf/two.urdf")
for n, robot in enumerate(["two.urdf", pathlib.Path("two.json"), "two.urdf.gz", "two.zip", {"urdf": urdf}]):
    kept = client.add_robot(robot, id=f"two-{n}", tip="b")
    assert (kept.id, kept.joints) == (f"two-{n}", ["j"]), kept
    assert kept.id in client.robots()
try:
    client.add_robot({"joints": []})
    raise SystemExit("an empty robot was kept")
except DynidentError as error:
    assert error.code == "invalid_document", error
print("robots kept")
"#;

fn keeps_robots(python: &Path, folder: &Path, server: &Server) {
    let run = Command::new(python)
        .args(["-c", ROBOTS])
        .current_dir(folder)
        .env("PYTHONPATH", folder.join("site"))
        .env("DYNIDENT_URL", server.url(""))
        .output()
        .unwrap();
    let (said, wrong) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success() && said.contains("robots kept"), "{said}{wrong}");
}

#[test]
fn the_notebook_leads_from_a_robot_to_a_validated_model() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join("target/simulators/bin/python");
    assert!(python.exists(), "NumPy and pandas are missing: run scripts/setup test");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("python-{}", std::process::id()));
    // A build leaves files beside its source.
    copied(&root.join("python"), &folder.join("source"));
    let install = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--no-deps",
        "--no-build-isolation",
        "--target",
    ];
    let installed = Command::new(&python)
        .args(install)
        .arg(folder.join("site"))
        .arg(folder.join("source"))
        .output()
        .unwrap();
    assert!(installed.status.success(), "{}", String::from_utf8_lossy(&installed.stderr));
    checked(&python, &folder);
    let server = Server::start();
    keeps_robots(&python, &folder, &server);
    let run = Command::new(&python)
        .arg(folder.join("source/run_notebook.py"))
        .arg(folder.join("source/notebooks/robot_to_model.ipynb"))
        .current_dir(&folder)
        .env("PYTHONPATH", folder.join("site"))
        .env("DYNIDENT_URL", server.url(""))
        .env("DYNIDENT", env!("CARGO_BIN_EXE_dynident"))
        .output()
        .unwrap();
    let (said, wrong) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success() && said.contains("notebook done"), "{said}{wrong}");
    std::fs::remove_dir_all(&folder).unwrap();
}
