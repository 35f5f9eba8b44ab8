//! Plain English: phrases that were replaced by the terms of the field stay out of every text of the project.

use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Phrases in lower case, each with what to write instead.
const INSTEAD: &[(&str, &str)] = &[
    ("told", "reported, distinguished, or notified"),
    ("nothing runs, nothing waits", "no jobs running or queued"),
    ("keep off", "avoid"),
    ("keeps off", "avoids"),
    ("make small", "optimality criterion, or minimise"),
    ("left over", "residual"),
    ("leave over", "residual"),
    ("leaves over", "residual"),
    ("log evidence ratio", "BIC difference"),
    ("log evidence ratios", "BIC difference"),
    ("expected evidence between", "expected BIC difference between"),
    ("goes on from a selection", "continues a stepwise selection"),
    ("looked for and not found", "tested and not found, with the detection limit"),
];

/// Files that may contain a phrase, each for a reason.
const EXCEPTIONS: &[(&str, &str)] = &[
    // This list itself.
    ("tests/project/words.rs", "*"),
    // A copy of a library.
    ("src/web/assets/three.js", "*"),
];

/// Folders and files at the root that hold text of the project; build products and data of tests are not among them.
const TOPS: &[&str] = &[
    "src",
    "tests",
    "examples",
    "benches",
    "python",
    "openapi",
    "scripts",
    "docs",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "README.md",
    "Cargo.toml",
    "Makefile",
    "deny.toml",
];

const ENDINGS: &[&str] = &[
    "rs", "md", "py", "ipynb", "js", "html", "css", "json", "toml", "sh", "conf", "service", "txt", "yml", "yaml", "sql",
];

fn is_text(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().into_owned());
    ending.is_none_or(|e| ENDINGS.contains(&e.as_str()))
}

/// Files made by builds and package managers are not texts of the project, and `tests/data` holds inputs of others.
fn is_skipped(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ["node_modules", "target", "__pycache__"].contains(&name.as_ref())
        || name.ends_with(".egg-info")
        || name.starts_with('.')
        || path.ends_with("tests/data")
}

fn texts(path: &Path, found: &mut Vec<PathBuf>) {
    if is_skipped(path) {
        return;
    }
    if path.is_dir() {
        let entries = std::fs::read_dir(path).unwrap();
        entries.for_each(|entry| texts(&entry.unwrap().path(), found));
    } else if is_text(path) {
        found.push(path.to_path_buf());
    }
}

/// Lower case, everything but letters, digits and `_` as one space, so that phrases are found across lines and comment signs.
fn words(text: &str) -> String {
    let lower = text.to_lowercase();
    let parts = lower.split(|c: char| !c.is_alphanumeric() && c != '_');
    let joined: Vec<&str> = parts.filter(|w| !w.is_empty()).collect();
    format!(" {} ", joined.join(" "))
}

fn is_excepted(file: &str, phrase: &str) -> bool {
    EXCEPTIONS.iter().any(|(f, p)| *f == file && (*p == "*" || *p == phrase))
}

/// `file: phrase` of every phrase in a text.
fn hits(file: &str, text: &str) -> Vec<String> {
    let text = words(text);
    let in_text = |phrase: &str| text.contains(&words(phrase)) && !is_excepted(file, phrase);
    let found = INSTEAD.iter().filter(|(phrase, _)| in_text(phrase));
    found
        .map(|(phrase, instead)| format!("{file}: `{phrase}`; write: {instead}"))
        .collect()
}

#[test]
fn replaced_phrases_stay_out_of_every_text() {
    let root = Path::new(ROOT);
    let mut files = Vec::new();
    TOPS.iter().for_each(|top| texts(&root.join(top), &mut files));
    assert!(files.len() > 500, "only {} texts: has a folder moved?", files.len());
    let mut all = Vec::new();
    for path in files {
        let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).unwrap();
        all.extend(hits(&name, &String::from_utf8_lossy(&bytes)));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn a_phrase_is_found_across_lines_and_only_as_whole_words() {
    assert_eq!(hits("a.rs", "/// What the fit leaves\n    /// over.").len(), 1);
    assert_eq!(hits("a.md", "It is Told.").len(), 1);
    assert!(hits("a.rs", "told_apart_from, untold").is_empty());
}
