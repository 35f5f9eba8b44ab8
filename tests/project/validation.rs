//! The table of `val_` tests in the documentation names every one of them, where it stands, and an external source.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PAGE: &str = "src/docs/validation.md";

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Names after `fn` that begin with `val_`.
fn names_of_tests(text: &str) -> impl Iterator<Item = String> {
    let names = text.lines().filter_map(|line| line.trim_start().strip_prefix("fn val_"));
    names.map(|rest| format!("val_{}", rest.split('(').next().unwrap_or_default()))
}

/// File of every `val_` test in `src` and `tests`.
fn in_sources() -> BTreeMap<String, String> {
    let root = Path::new(ROOT);
    let mut files = Vec::new();
    ["src", "tests"]
        .iter()
        .for_each(|top| rust_files(&root.join(top), &mut files));
    let mut tests = BTreeMap::new();
    for path in files {
        let file = path.strip_prefix(root).unwrap().to_str().unwrap().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        tests.extend(names_of_tests(&text).map(|name| (name, file.clone())));
    }
    tests
}

/// `(test, file, source)` of every row of the table.
fn in_table(page: &str) -> Vec<[String; 3]> {
    let rows = page.lines().filter(|line| line.starts_with("| `val_"));
    let cells = |line: &str| -> Vec<String> {
        let parts = line.trim_matches('|').split(" | ");
        parts.map(|c| c.trim().trim_matches('`').to_string()).collect()
    };
    rows.map(|line| cells(line).try_into().unwrap_or_else(|_| panic!("three cells in `{line}`")))
        .collect()
}

#[test]
fn the_table_of_val_tests_is_that_of_the_sources() {
    let page = std::fs::read_to_string(Path::new(ROOT).join(PAGE)).unwrap();
    let rows = in_table(&page);
    assert!(rows.iter().all(|[.., source]| source.len() > 3), "every row has a source");
    let listed: BTreeMap<String, String> = rows.iter().cloned().map(|[test, file, _]| (test, file)).collect();
    assert_eq!(rows.len(), listed.len(), "a test has two rows in {PAGE}");
    let sources = in_sources();
    let missing: Vec<_> = sources.iter().filter(|entry| listed.get(entry.0) != Some(entry.1)).collect();
    let gone: Vec<_> = listed.keys().filter(|test| !sources.contains_key(*test)).collect();
    assert!(
        missing.is_empty() && gone.is_empty(),
        "{PAGE}: missing or in another file: {missing:?}; no such test: {gone:?}"
    );
}
