//! One version: that of the newest dated release in the change log.

use std::path::Path;

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// `(version, date)` of every release, newest first; the heading of what is not released has no date.
fn releases() -> Vec<(String, String)> {
    let log = text("CHANGELOG.md");
    let headings = log.lines().filter_map(|line| line.strip_prefix("## "));
    headings
        .filter_map(|heading| heading.split_once(" – "))
        .map(|(version, date)| (version.to_string(), date.to_string()))
        .collect()
}

#[test]
fn program_client_and_interface_have_the_version_of_the_newest_release() {
    let (version, _) = releases().first().cloned().expect("there is a release");
    assert_eq!(env!("CARGO_PKG_VERSION"), version);
    assert!(text("python/pyproject.toml").contains(&format!("\nversion = \"{version}\"\n")));
    let openapi: serde_json::Value = serde_json::from_str(&text("openapi/openapi.json")).unwrap();
    assert_eq!(openapi["info"]["version"], version.as_str());
}

#[test]
fn releases_are_dated_and_the_newest_is_first() {
    let releases = releases();
    let is_date = |d: &str| d.len() == 10 && d.split('-').all(|part| part.parse::<u32>().is_ok());
    assert!(releases.iter().all(|(_, date)| is_date(date)), "{releases:?}");
    assert!(releases.windows(2).all(|w| w[0].1 >= w[1].1), "{releases:?}");
    let allowed = ["Added", "Changed", "Fixed", "Known limits", "Numerical"];
    let log = text("CHANGELOG.md");
    let wrong = log
        .lines()
        .filter_map(|l| l.strip_prefix("### "))
        .find(|part| !allowed.contains(part));
    assert_eq!(wrong, None);
}
