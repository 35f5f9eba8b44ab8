//! The house rules: who may use whom, and that the map shows what is there.

mod cycles;
mod validation;
mod version;
mod width;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const GOLDEN: &str = "tests/project/module-graph.txt";

/// From left to right: each uses only what stands before it. Modules of one group do not use each other.
const LAYERS: &[&[&str]] = &[
    &["spatial", "solver", "cancel"],
    &["model"],
    &["parameters"],
    &["dynamics"],
    &["trajectory"],
    &["excitation", "preparation", "effects"],
    &["regression"],
    &["identification", "diagnosis", "simulate"],
    &["formats"],
    &["documents"],
    &["app"],
    &["web"],
    &["service"],
    &["cli"],
];

/// Files of the library; unit tests in a file of their own may use what their module may not.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
    found
}

/// Names after `crate::` in code, comments and tests left out.
fn used_modules(text: &str) -> BTreeSet<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|l| !l.trim_start().starts_with("//"));
    let mut used = BTreeSet::new();
    for line in lines {
        for part in line.split("crate::").skip(1) {
            let groups = part.strip_prefix('{').map(|g| g.split(',').collect()).unwrap_or(vec![part]);
            for name in groups {
                let name: String = name.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if name.chars().next().is_some_and(char::is_lowercase) {
                    used.insert(name);
                }
            }
        }
    }
    used
}

/// Which top-level module uses which.
fn module_graph() -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(ROOT).join("src");
    let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in sources(&root) {
        let relative = file.strip_prefix(&root).unwrap();
        let Some(module) = relative.components().next().filter(|_| relative.components().count() > 1) else {
            continue;
        };
        let module = module.as_os_str().to_str().unwrap().to_string();
        let mut used = used_modules(&std::fs::read_to_string(&file).unwrap());
        used.remove(&module);
        graph.entry(module).or_default().extend(used);
    }
    graph
}

#[test]
fn the_module_graph_is_the_one_checked_in() {
    let lines: Vec<String> = module_graph()
        .iter()
        .map(|(module, used)| {
            format!("{module}: {}", used.iter().cloned().collect::<Vec<_>>().join(" "))
                .trim_end()
                .to_string()
        })
        .collect();
    let found = lines.join("\n") + "\n";
    let path = Path::new(ROOT).join(GOLDEN);
    if std::env::var_os("DYNIDENT_UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    assert!(
        golden == found,
        "modules use each other differently than {GOLDEN} says. If that is meant, run\n    \
         DYNIDENT_UPDATE_GOLDEN=1 cargo test --release --test project\nfound:\n{found}"
    );
}

#[test]
fn every_layer_uses_only_what_stands_to_its_left() {
    let layer = |module: &str| {
        let at = LAYERS.iter().position(|group| group.contains(&module));
        at.unwrap_or_else(|| panic!("`{module}` has no layer in this test: say where it stands"))
    };
    for (module, used) in module_graph() {
        for other in used {
            assert!(
                layer(&other) < layer(&module),
                "`{module}` uses `{other}`, which does not stand to its left"
            );
        }
    }
}

/// The numerical core is pure: no clock, no environment, no files, no network, nothing asynchronous.
#[test]
fn the_core_is_pure() {
    let forbidden = [
        "std::time",
        "std::env",
        "std::fs",
        "std::net",
        "tokio",
        "axum",
        "async fn",
        "Instant::now",
        "SystemTime",
        "println!",
    ];
    let core: BTreeSet<&str> = LAYERS.iter().take(8).flat_map(|g| g.iter().copied()).collect();
    for module in core {
        let folder = Path::new(ROOT).join("src").join(module);
        for file in if folder.is_dir() { sources(&folder) } else { Vec::new() } {
            let text = std::fs::read_to_string(&file).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for word in forbidden {
                let line = code.lines().find(|l| !l.trim_start().starts_with("//") && l.contains(word));
                assert!(
                    line.is_none(),
                    "{}: `{}` in the core",
                    file.display(),
                    line.unwrap_or_default().trim()
                );
            }
        }
    }
}

#[test]
fn every_path_that_architecture_names_exists() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("ARCHITECTURE.md")).unwrap();
    let mut checked = 0;
    for quoted in text.split('`').skip(1).step_by(2) {
        let tops = [
            "src/",
            "tests/",
            "examples/",
            "openapi/",
            "docs/",
            "benches/",
            "scripts/",
            ".ci/",
        ];
        if tops.iter().any(|top| quoted.starts_with(top)) {
            assert!(
                Path::new(ROOT).join(quoted).exists(),
                "ARCHITECTURE.md names `{quoted}`, which is not there"
            );
            checked += 1;
        }
    }
    assert!(checked >= 10, "ARCHITECTURE.md names its paths in backquotes");
}
