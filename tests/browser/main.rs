//! A newcomer's whole path through the pages, in Debian's Chromium, at the width of a laptop and of a phone.
//!
//! `newcomer.py` does what a person would do; this starts the server and hands it the addresses. Playwright is installed by
//! `scripts/setup` into `target/browser`, and drives the system's Chromium: no browser is downloaded.

#[path = "../support/server.rs"]
mod server;

use server::Server;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{PoisonError, RwLock};

/// As many browsers at a time as the test harness has threads; those that measure how long drawing takes run alone.
static ALONE: RwLock<()> = RwLock::new(());

fn python() -> PathBuf {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/browser/bin/python");
    assert!(python.exists(), "{} is missing: run scripts/setup", python.display());
    python
}

fn run(script: &str, arguments: &[&str]) {
    let _beside = ALONE.read().unwrap_or_else(PoisonError::into_inner);
    drive(script, arguments);
}

fn run_alone(script: &str) {
    let _alone = ALONE.write().unwrap_or_else(PoisonError::into_inner);
    drive(script, &[]);
}

/// `watch.py` ends a script that waits too long for one thing; this ends whatever goes on all the same. The slowest takes a
/// minute and a half.
const LONGEST_S: &str = "600";

fn drive(script: &str, arguments: &[&str]) {
    let server = Server::start();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser");
    let output = Command::new("timeout")
        .args(["--signal=ABRT", "--kill-after=10", LONGEST_S])
        .arg(python())
        .args(["-X", "faulthandler"])
        .arg(folder.join(script))
        .args(["--server", &server.url(""), "--program", env!("CARGO_BIN_EXE_dynident")])
        .args(arguments)
        .output()
        .expect("timeout and python start");
    assert!(
        output.status.success(),
        "{script}: {}\n{}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_newcomer_gets_from_the_lab_to_the_report_on_a_laptop() {
    run("newcomer.py", &["--width", "1366", "--height", "768"]);
}

#[test]
fn a_newcomer_gets_from_the_lab_to_the_report_on_a_phone() {
    run("newcomer.py", &["--width", "390", "--height", "844"]);
}

/// Tests start in the order of their names: those that run alone are among the first, so that others wait for them once.
#[test]
fn a_first_visit_is_light_and_shows_its_first_content_soon() {
    run_alone("weight.py");
}

#[test]
fn a_log_of_160_000_rows_is_drawn_in_under_a_second_and_zooms_smoothly() {
    run_alone("long_log.py");
}

#[test]
fn a_foreign_page_neither_reads_nor_changes_anything() {
    run("security.py", &[]);
}

#[test]
fn periodic_logs_of_500_hz_and_1_khz_are_identified_reported_and_drawn() {
    run("rates.py", &[]);
}

#[test]
fn a_robot_and_a_log_of_ones_own_lead_to_a_validated_model_on_a_laptop() {
    run("own_robot.py", &["--width", "1440", "--height", "900"]);
}

#[test]
fn a_robot_and_a_log_of_ones_own_lead_to_a_validated_model_on_a_phone() {
    run("own_robot.py", &["--width", "390", "--height", "844"]);
}

#[test]
fn a_robot_comes_with_its_meshes_in_an_archive_on_a_laptop() {
    run("packed_robot.py", &["--width", "1440", "--height", "900"]);
}

#[test]
fn a_robot_comes_with_its_meshes_in_an_archive_on_a_phone() {
    run("packed_robot.py", &["--width", "390", "--height", "844"]);
}

#[test]
fn one_click_leads_from_an_empty_server_to_a_closed_loop_on_a_laptop() {
    run("tour.py", &["--width", "1440", "--height", "900"]);
}

#[test]
fn one_click_leads_from_an_empty_server_to_a_closed_loop_on_a_phone() {
    run("tour.py", &["--width", "390", "--height", "844"]);
}

#[test]
fn own_effects_are_written_kept_in_the_lab_and_used_on_a_laptop() {
    run("own_effects.py", &["--width", "1440", "--height", "900"]);
}

#[test]
fn own_effects_are_written_kept_in_the_lab_and_used_on_a_phone() {
    run("own_effects.py", &["--width", "390", "--height", "844"]);
}

#[test]
fn every_field_has_a_place_and_names_what_is_wrong_on_a_laptop() {
    run("every_field.py", &["--width", "1440", "--height", "900"]);
}

#[test]
fn every_field_has_a_place_and_names_what_is_wrong_on_a_phone() {
    run("every_field.py", &["--width", "390", "--height", "844"]);
}
