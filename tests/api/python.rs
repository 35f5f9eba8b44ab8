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
    let server = Server::start();
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
