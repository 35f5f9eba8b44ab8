//! The part of the report on what the model leaves over, finding by finding.

use super::html::{Html, capital, items, listed, text, words};
use crate::web::figures::{before_after_figure, finding_figure, unit};
use serde_json::Value;

pub(super) fn loop_closed(page: &mut Html, result: &Value) {
    let residual = &result["residual"];
    if !residual.is_object() {
        return;
    }
    page.heading(2, "What the model leaves over");
    page.paragraph("", &format!("Noise floor from: {}.", text(&residual["noise_source"])));
    let fits = items(&residual["lack_of_fit"])
        .zip(items(&residual["lack_of_fit_after"]))
        .zip(items(&residual["noise_floor"]));
    let row = |((before, after), floor): ((&Value, &Value), &Value)| {
        vec![
            text(&before["joint"]),
            text(floor),
            text(&before["statistic"]),
            chance(&before["p_value"]),
            text(&after["statistic"]),
            chance(&after["p_value"]),
        ]
    };
    page.table(
        "Lack of fit: 1 where only noise is left",
        &["Joint", "#Noise floor", "#Before", "#p", "#After", "#p"],
        fits.map(row),
    );
    held_out(page, &residual["held_out"]);
    for finding in items(&residual["findings"]) {
        describe(page, result, finding);
    }
    let rest = &residual["remainder"];
    if rest.is_object() {
        page.heading(3, &format!("Unexplained, on {}", listed(&rest["joints"])));
        page.paragraph("finding", &text(&rest["sentence"]));
        page.paragraph("soft", &text(&rest["note"]));
    }
    undetected(page, &residual["undetected"]);
    if let Some(figure) = before_after_figure(result) {
        page.figure(
            &figure,
            "Error of single measurements per joint, of the declared model and of the model with the effects found, beside the noise floor. Both models are estimated from the same rows with the same weights.",
        );
    }
}

/// The declared model and the final one on held-out data, joint by joint.
fn held_out(page: &mut Html, held_out: &Value) {
    if held_out["verdict"] == "not_tested" {
        return;
    }
    let row = |j: &Value| {
        vec![
            text(&j["joint"]),
            text(&j["before"]),
            text(&j["after"]),
            text(&j["floor"]),
            words(&j["change"]),
            chance(&j["p_value"]),
        ]
    };
    let caption = format!(
        "Held-out error per joint (N m or N): {}. Data held out: {}",
        words(&held_out["verdict"]),
        text(&held_out["source"])
    );
    page.table(
        &caption,
        &["Joint", "#Declared model", "#With effects", "#Noise floor", "Change", "#p"],
        items(&held_out["joints"]).map(row),
    );
}

/// What every robot may have and the logs do not show.
fn undetected(page: &mut Html, list: &Value) {
    let row = |one: &Value| {
        let parameter = &one["parameter"];
        let [value, deviation] = ["value", "std_dev"].map(|key| parameter[key].as_f64().unwrap_or(f64::NAN));
        vec![
            capital(&words(&one["effect"])),
            text(&one["joint"]),
            text(&parameter["value"]),
            text(&parameter["std_dev"]),
            text(&(value.abs() + 3.0 * deviation).into()),
            unit(parameter["unit"].as_str().unwrap_or_default()),
            if one["in_model"] == true { "yes" } else { "no" }.into(),
        ]
    };
    let rows: Vec<Vec<String>> = items(list).map(row).collect();
    if !rows.is_empty() {
        page.table(
            "Looked for and not found: not beyond chance, each by itself beside the final model",
            &[
                "Effect",
                "Joint",
                "#Value",
                "#Deviation",
                "#No larger than",
                "Unit",
                "In the model",
            ],
            rows.into_iter(),
        );
    }
}

/// Below a millionth of a millionth a chance is none.
fn chance(p: &Value) -> String {
    match p.as_f64() {
        Some(p) if p < 1e-12 => "< 1e−12".into(),
        _ => text(p),
    }
}

fn describe(page: &mut Html, result: &Value, finding: &Value) {
    page.heading(
        3,
        &capital(&format!("{} on {}", words(&finding["effect"]), listed(&finding["joints"]))),
    );
    page.paragraph("finding", &text(&finding["sentence"]));
    if items(&finding["parameters"]).next().is_none() {
        return;
    }
    let row = |p: &Value| {
        vec![
            words(&p["name"]),
            text(&p["value"]),
            text(&p["std_dev"]),
            unit(&text(&p["unit"])),
        ]
    };
    page.table(
        "",
        &["Parameter", "#Value", "#σ", "Unit"],
        items(&finding["parameters"]).map(row),
    );
    let e = &finding["evidence"];
    let mut evidence = format!(
        "Twice the log of the evidence ratio against leaving it out: {}; chance of such a gain without it: {}.",
        text(&e["log_evidence_ratio"]),
        chance(&e["p_value"])
    );
    let held_out = &finding["held_out"];
    if held_out["change"] != "not_tested" {
        evidence += &format!(
            " Held-out error without and with it: {} and {}, {} (p = {}).",
            text(&held_out["before"]),
            text(&held_out["after"]),
            words(&held_out["change"]),
            chance(&held_out["p_value"])
        );
    }
    if finding["in_model"] == false {
        evidence += " It is not in the model.";
    }
    if let Some(note) = finding["note"].as_str() {
        evidence += &format!(" Note: {note}.");
    }
    page.paragraph("soft", &evidence);
    let rival = |r: &Value| vec![words(&r["effect"]), listed(&r["joints"]), text(&r["evidence"])];
    if items(&finding["rivals"]).next().is_some() {
        page.table(
            "Not excluded in its place; twice the log of the odds in favour of the finding",
            &["Effect", "Joints", "#Evidence"],
            items(&finding["rivals"]).map(rival),
        );
    }
    if let Some(figure) = finding_figure(result, finding) {
        page.figure(
            &figure,
            "What is left on the joint, of the declared model and of the model with all effects found.",
        );
    }
}
