//! The curl example of the README, run as it stands there.

use crate::server::Server;
use std::process::Command;

#[test]
fn the_curl_example_of_the_readme_works() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap();
    let example = readme
        .split("```")
        .find(|block| block.contains("curl "))
        .expect("the README has a curl example");
    let script = example.trim_start_matches("sh").replace("\r", "");
    assert!(script.contains("http://127.0.0.1:8080"), "{script}");
    if Command::new("curl").arg("--version").output().is_err() {
        println!("SKIPPED the_curl_example_of_the_readme_works: curl is not installed");
        return;
    }
    let server = Server::start();
    let script = script.replace("127.0.0.1:8080", &server.address.to_string());
    let output = Command::new("sh").args(["-ec", &script]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text} {}", String::from_utf8_lossy(&output.stderr));
    let result: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    assert!(result["condition_number"].as_f64().unwrap() > 1.0);
}
