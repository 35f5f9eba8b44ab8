//! Time stamps: sizes of allocations, units, order.

use super::written::{Row, good_rows, log, rng};
use super::{Case, Expect, refused, try_all};
use rand::RngExt;
use serde_json::json;

fn with(change: impl Fn(usize, &mut Row)) -> String {
    let mut rows = good_rows();
    rows.iter_mut().enumerate().for_each(|(s, row)| change(s, row));
    log(rows)
}

#[test]
fn the_last_stamp_never_decides_what_is_allocated() {
    let last = good_rows().len() - 1;
    let mut cases = Vec::new();
    for value in [1e6, 1e9, 1e12, 1e15, 1e18, 1e25, 1e100, 1e300, 1.7e308] {
        let text = with(|s, row| row[0] = if s == last { value } else { row[0] });
        cases.push(Case::identify(format!("last {value:e}"), text, refused(["time", "line"])));
        let text = with(|s, row| row[0] = if s == 0 { -value } else { row[0] });
        cases.push(Case::identify(format!("first {value:e}"), text, refused(["time", "line"])));
        let text = with(|s, row| row[0] += if 2 * s > last { value } else { 0.0 });
        cases.push(Case::identify(format!("jump {value:e}"), text, refused(["time"])));
        // A single stamp that fits nowhere is dropped.
        let text = with(|s, row| row[0] = if s == 700 { value } else { row[0] });
        cases.push(Case::identify(
            format!("middle {value:e}"),
            text,
            Expect::Result(|d| names_finding(d, "time_out_of_order")),
        ));
    }
    try_all(&cases);
}

fn names_finding(document: &serde_json::Value, code: &str) -> Result<(), String> {
    let report = &document["log_report"][0];
    let has = report["findings"]
        .as_array()
        .is_some_and(|all| all.iter().any(|f| f["code"] == code));
    if has { Ok(()) } else { Err(format!("no {code} in {report}")) }
}

fn hundred_hertz(document: &serde_json::Value) -> Result<(), String> {
    let report = &document["log_report"][0];
    let rate = report["sample_rate_hz"].as_f64().unwrap_or(0.0);
    if (rate - 100.0).abs() < 0.5 {
        Ok(())
    } else {
        Err(format!("{rate} Hz in {report}"))
    }
}

#[test]
fn stamps_in_any_unit_are_recognised_with_or_without_an_epoch() {
    let mut cases = Vec::new();
    for (factor, since) in [
        (1e3, 0.0),
        (1e6, 0.0),
        (1e9, 0.0),
        (1e3, 1.7e12),
        (1e6, 1.7e15),
        (1e9, 1.7e18),
    ] {
        for stated in [false, true] {
            let text = with(|_, row| row[0] = (row[0] * factor + since).round());
            let mut request = json!({"feasible": {"method": "none"}, "trace": false});
            if stated {
                request["columns"] = json!({"sample_rate_hz": 100});
            }
            let name = format!("factor {factor:e} since {since:e} stated {stated}");
            cases.push(Case::identify(name, text, Expect::Result(hundred_hertz)).asking(request));
        }
    }
    // A wrong statement is an error.
    let text = with(|_, row| row[0] *= 1e9);
    let wrong = json!({"columns": {"time_unit": "s"}});
    cases.push(Case::identify("nanoseconds stated as seconds", text, refused(["time_unit"])).asking(wrong));
    try_all(&cases);
}

#[test]
fn stamps_in_no_order_are_refused_or_put_right() {
    let mut rows = good_rows();
    let mut random = rng(3);
    for s in (1..rows.len()).rev() {
        rows.swap(s, random.random_range(0..=s));
    }
    let mut cases = vec![Case::identify("shuffled", log(rows), refused(["line", "time goes back"]))];
    let mut backwards = good_rows();
    backwards.reverse();
    cases.push(Case::identify(
        "backwards",
        log(backwards),
        refused(["line", "time goes back"]),
    ));
    cases.push(Case::identify("one stamp", with(|_, row| row[0] = 3.0), refused(["log.csv"])));
    let doubled = good_rows().into_iter().flat_map(|row| [row, row]);
    cases.push(Case::identify("every row twice", log(doubled), Expect::Result(hundred_hertz)));
    let repeated = with(|s, row| row[0] -= if s % 50 == 1 { 0.01 } else { 0.0 });
    cases.push(Case::identify("some stamps twice", repeated, Expect::Result(hundred_hertz)));
    let negative = with(|_, row| row[0] -= 1000.0);
    cases.push(Case::identify("before zero", negative, Expect::Result(hundred_hertz)));
    let none = with(|s, row| row[0] = if s % 3 == 0 { f64::NAN } else { row[0] });
    cases.push(Case::identify("a third without stamp", none, refused(["line 2"])));
    let two = [good_rows(), good_rows()].concat();
    cases.push(Case::identify(
        "two recordings",
        log(two),
        Expect::Either(vec!["line".into()], hundred_hertz),
    ));
    try_all(&cases);
}
