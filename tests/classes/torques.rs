//! Torque columns that say nothing: dead, constant, of any scale, noise, in other units.

use super::written::{Row, good_rows, lines, log, normal, rng, rows_of};
use super::{Case, Expect, refused, try_all};
use serde_json::{Value, json};

fn with(change: impl Fn(usize, &mut Row)) -> String {
    let mut rows = good_rows();
    rows.iter_mut().enumerate().for_each(|(s, row)| change(s, row));
    log(rows)
}

/// The first thing said of the data is said of `joint` alone, and the other joint has its errors.
fn first_fault(document: &Value, joint: usize) -> Result<(), String> {
    if document["residual"].is_null() {
        let rms = &document["rms"]["identification"][0]["base"]["rms"];
        let alone = rms[joint].is_null() && rms[1 - joint].as_f64().is_some_and(|r| (0.04..0.06).contains(&r));
        return if alone { Ok(()) } else { Err(rms.to_string()) };
    }
    let names = ["J1", "J2"];
    let residual = &document["residual"];
    let rms = &document["rms"]["identification"][0]["base"]["rms"];
    let first = &residual["data_faults"][0]["joints"];
    let others = residual["findings"].as_array().map_or(0, Vec::len);
    match *first == json!([names[joint]]) && rms[joint].is_null() && rms[1 - joint].as_f64().is_some() && others == 0 {
        true => Ok(()),
        false => Err(format!("{first}, {rms}, {}", residual["findings"])),
    }
}

#[test]
fn a_dead_column_is_named_first_and_costs_only_its_joint() {
    let mut cases = Vec::new();
    for joint in 0..2 {
        let holds: fn(&Value) -> Result<(), String> = if joint == 0 {
            |d| first_fault(d, 0)
        } else {
            |d| first_fault(d, 1)
        };
        for value in [0.0, -0.0, 3.25, -1e-12, 1e12, 1e150] {
            for estimator in ["ols", "wls", "robust"] {
                let text = with(|_, row| row[3 + joint] = value);
                // The diagnosis is the same for all of them.
                let trace = estimator == "wls" || value == 3.25;
                let request = json!({"estimator": estimator, "feasible": {"method": "none"}, "trace": trace});
                cases.push(
                    Case::identify(format!("joint {joint} {value:e} {estimator}"), text, Expect::Result(holds)).asking(request),
                );
            }
        }
    }
    try_all(&cases);
}

#[test]
fn torques_that_are_all_the_same_are_refused() {
    let mut cases = Vec::new();
    for value in [0.0, 2.0, -7.5, 1e-300, 1e200] {
        let text = with(|_, row| (row[3], row[4]) = (value, value));
        cases.push(Case::identify(format!("all {value:e}"), text, refused(["no torque"])));
    }
    let alternating = with(|s, row| (row[3], row[4]) = if s % 2 == 0 { (1.0, 2.0) } else { (-1.0, -2.0) });
    cases.push(Case::identify(
        "alternating",
        alternating,
        Expect::Either(vec!["log.csv".into()], explains_nothing),
    ));
    let same = with(|_, row| row[4] = row[3]);
    cases.push(Case::identify("one column twice", same, Expect::Result(|_| Ok(()))));
    let position = with(|_, row| (row[3], row[4]) = (row[1], row[2]));
    cases.push(Case::identify("positions for torques", position, Expect::Result(|_| Ok(()))));
    try_all(&cases);
}

fn scaled_named(document: &Value) -> Result<(), String> {
    first_fault(document, 1)
}

#[test]
fn torques_of_any_scale_have_a_verdict() {
    let mut cases = Vec::new();
    for exponent in [-300, -150, -60, -15, 15, 60, 150, 290] {
        // Written as text, so that the sizes are those of a file.
        let at = |value: f64| format!("{value:.8}e{exponent}");
        let both = good_rows()
            .into_iter()
            .map(|[t, a, b, x, y]| format!("{t:?},{a:?},{b:?},{},{}", at(x), at(y)));
        cases.push(Case::identify(
            format!("both 1e{exponent}"),
            lines(both),
            refused(["no torque"]),
        ));
        let one = good_rows()
            .into_iter()
            .map(|[t, a, b, x, y]| format!("{t:?},{a:?},{b:?},{x:?},{}", at(y)));
        cases.push(Case::identify(format!("one 1e{exponent}"), lines(one), Expect::Result(scaled_named)).traced());
    }
    try_all(&cases);
}

fn explains_nothing(document: &Value) -> Result<(), String> {
    let residual = &document["residual"];
    let accused = residual["findings"].as_array().map_or(0, Vec::len);
    let signs = residual["data_faults"].to_string();
    match document["quality"]["verdict"] == "explains_nothing"
        && accused == 0
        && !signs.contains("sign")
        && !signs.contains("order")
    {
        true => Ok(()),
        false => Err(format!("{}: {signs}, {}", document["quality"], residual["findings"])),
    }
}

#[test]
fn noise_in_the_place_of_torque_accuses_nobody() {
    let mut cases = Vec::new();
    for seed in 0..6 {
        let mut random = rng(seed);
        let size = 10f64.powi(seed as i32 - 2);
        // White, or going together over some rows as a filtered signal does.
        let mut last = [0.0; 2];
        let rows = good_rows().into_iter().map(|[t, a, b, _, _]| {
            for value in &mut last {
                let keep = if seed % 2 == 0 { 0.0 } else { 0.6 };
                *value = keep * *value + normal(&mut random) * size;
            }
            [t, a, b, last[0], last[1]]
        });
        cases.push(
            Case::identify(
                format!("noise {seed} of {size:e}"),
                log(rows),
                Expect::Result(explains_nothing),
            )
            .traced(),
        );
    }
    try_all(&cases);
}

#[test]
fn amperes_need_torque_constants() {
    let text = || log(good_rows());
    let mut cases = Vec::new();
    for torque in [
        json!({"unit": "A"}),
        json!({"unit": ["A", "N m"]}),
        json!({"unit": ["N m", "A"]}),
        json!({"unit": "A", "scale": []}),
        json!({"unit": "A", "sign": [1, -1]}),
    ] {
        let request = json!({"columns": {"torque": torque}});
        cases.push(Case::identify(format!("{torque}"), text(), refused(["torque"])).asking(request));
    }
    let stated = json!({"columns": {"torque": {"unit": "A", "scale": [1.0, 1.0]}}});
    cases.push(Case::identify("with constants", text(), Expect::Result(|_| Ok(()))).asking(stated));
    for scale in [
        json!([1e308, 1.0]),
        json!([0.0, 1.0]),
        json!([1e-308, 1.0]),
        json!([-1e200, 1e200]),
    ] {
        let request = json!({"columns": {"torque": {"scale": scale}}, "feasible": {"method": "none"}});
        cases.push(Case::identify(format!("scale {scale}"), text(), Expect::Either(vec![], |_| Ok(()))).asking(request));
    }
    try_all(&cases);
}

fn no_finding(document: &Value) -> Result<(), String> {
    let residual = &document["residual"];
    match residual["findings"].as_array().map_or(0, Vec::len) + residual["data_faults"].as_array().map_or(0, Vec::len) {
        0 => Ok(()),
        _ => Err(format!("{}, {}", residual["findings"], residual["data_faults"])),
    }
}

/// The log as it would have been written with so many digits: torques alone, or positions as well.
#[test]
fn rounding_is_no_effect() {
    let mut cases = Vec::new();
    // With noise, and without.
    for (digits, noise) in [(1, 0.05), (2, 0.05), (3, 0.05), (2, 0.0), (3, 0.0), (4, 0.0), (6, 0.0)] {
        let short = |v: f64| format!("{v:.digits$}");
        let good_rows = || rows_of(noise);
        let torque = good_rows()
            .into_iter()
            .map(|[t, a, b, x, y]| format!("{t:?},{a:?},{b:?},{},{}", short(x), short(y)));
        cases.push(
            Case::identify(
                format!("torques of {digits} digits, noise {noise}"),
                lines(torque),
                Expect::Result(no_finding),
            )
            .traced(),
        );
        if digits > 2 {
            let all = good_rows().into_iter().map(|row| row.map(short).join(","));
            cases.push(
                Case::identify(
                    format!("all of {digits} digits, noise {noise}"),
                    lines(all),
                    Expect::Result(no_finding),
                )
                .traced(),
            );
        }
    }
    try_all(&cases);
}
