//! Comments are no wider than code.

use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What the formatter keeps code to.
fn limit() -> usize {
    let settings = std::fs::read_to_string(Path::new(ROOT).join("rustfmt.toml")).unwrap();
    let width = settings.lines().find_map(|l| l.strip_prefix("max_width = "));
    width.expect("a width").trim().parse().expect("a number")
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => rust_files(&path, found),
            false if path.extension().is_some_and(|e| e == "rs") => found.push(path),
            false => {}
        }
    }
}

/// Tables have one line for a row.
fn is_too_wide(line: &str, limit: usize) -> bool {
    let text = line.trim_start();
    let comment = text
        .strip_prefix("//")
        .map(|rest| rest.trim_start_matches(['/', '!']).trim_start());
    comment.is_some_and(|words| !words.starts_with('|') && words.contains(' ') && line.chars().count() > limit)
}

#[test]
fn no_comment_is_wider_than_code() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "benches", "examples"] {
        rust_files(&Path::new(ROOT).join(folder), &mut files);
    }
    let limit = limit();
    let mut wide = Vec::new();
    for file in &files {
        let text = std::fs::read_to_string(file).unwrap();
        let lines = text.lines().enumerate().filter(|(_, line)| is_too_wide(line, limit));
        wide.extend(lines.map(|(at, _)| format!("{}:{}", file.display(), at + 1)));
    }
    assert!(files.len() > 100 && wide.is_empty(), "wider than {limit}: {wide:#?}");
}

#[test]
fn wide_comments_are_seen() {
    assert!(is_too_wide("    /// one two three", 20));
    assert!(!is_too_wide("    /// one two three", 21));
    assert!(!is_too_wide("    /// | one | two |", 10) && !is_too_wide("    let one = two_and_three;", 10));
}
