//! The parts of the report, in their order; residual and physical parameters have files of their own.

use super::Circumstances;
use super::formula;
use super::html::{Cell, Html, capital, escaped, items, listed, text, words};
use crate::web::figures::{error_figure, parameter_figures, torque_figure, unit};
use serde_json::Value;

pub(super) fn heading(page: &mut Html, result: &Value, circumstances: &Circumstances) {
    page.heading(1, &format!("Identification of {}", text(&result["robot"])));
    let version = text(&result["provenance"]["version"]);
    let mut line = format!("dynident {version}");
    circumstances.ended.iter().for_each(|ended| line += &format!(", {ended}"));
    circumstances
        .id
        .iter()
        .for_each(|id| line += &format!(", identification {id}"));
    page.paragraph("soft", &line);
}

pub(super) fn summary(page: &mut Html, result: &Value) {
    let q = &result["quality"];
    let class = if q["verdict"] == "good" { "verdict" } else { "verdict bad" };
    page.paragraph(
        class,
        &format!(
            "Data: {}. {}.",
            words(&q["verdict"]),
            capital(text(&q["reason"]).trim_end_matches('.'))
        ),
    );
    let residual = &result["residual"];
    if residual.is_object() {
        page.paragraph("verdict", &text(&residual["summary"]));
        for fault in items(&residual["data_faults"]) {
            let sentence = format!(
                "{}. {}",
                capital(text(&fault["detail"]).trim_end_matches('.')),
                text(&fault["remedy"])
            );
            page.paragraph("finding", &sentence);
        }
        for told in items(&residual["findings"]).chain([&residual["remainder"]]) {
            told["sentence"].as_str().iter().for_each(|s| page.paragraph("finding", s));
        }
    }
    let row = |name: &str, value: String| vec![name.to_string(), value];
    let rows = [
        row(
            "Base parameters determined",
            format!("{} of {}", text(&q["rank"]), text(&q["columns"])),
        ),
        row("Condition number, columns scaled", text(&q["condition_number"])),
        row("Estimator", text(&result["estimator"])),
        row(
            "Fit of the physical parameters over that of the base parameters",
            text(&result["feasibility"]["rms_ratio"]),
        ),
    ];
    page.table("", &["What", "#Figure"], rows.into_iter());
    items(&result["notes"]).for_each(|note| page.paragraph("soft", &text(note)));
}

pub(super) fn logs(page: &mut Html, result: &Value) {
    page.heading(2, "Logs");
    let row = |l: &Value| {
        [
            &l["file"],
            &l["role"],
            &l["rows_used"],
            &l["rows"],
            &l["sample_rate_hz"],
            &l["duration_s"],
        ]
        .map(text)
        .to_vec()
    };
    page.table(
        "",
        &["File", "Role", "#Rows used", "#of", "#Rate (Hz)", "#Length (s)"],
        items(&result["log_report"]).map(row),
    );
    for log in items(&result["log_report"]) {
        for finding in items(&log["findings"]) {
            page.paragraph(
                "",
                &format!(
                    "{}: {}, {} times: {}",
                    text(&log["file"]),
                    words(&finding["code"]),
                    text(&finding["count"]),
                    text(&finding["detail"])
                ),
            );
        }
        let row = |c: &Value| [words(&c["what"]), text(&c["value"]), text(&c["why"])].to_vec();
        page.table(
            &format!("How {} was prepared", text(&log["file"])),
            &["What", "How", "Why"],
            items(&log["choices"]).map(row),
        );
    }
}

pub(super) fn parameters(page: &mut Html, result: &Value) {
    page.heading(2, "Base parameters");
    page.paragraph("soft", "Standard deviations σ allow for correlated noise. Names and expressions are those of the standard parameters of every link about its joint frame.");
    let row = |p: &Value| {
        let value = if p["value"].is_null() {
            "not determined".into()
        } else {
            text(&p["value"])
        };
        vec![
            formula::name(&text(&p["name"])),
            Cell::from(value),
            Cell::from(text(&p["std_dev"])),
            Cell::from(text(&p["relative_std_dev_percent"])),
            Cell(format!("<span class=\"whole\">{}</span>", escaped(&unit(&text(&p["unit"]))))),
            formula::expression(&text(&p["expression"])),
        ]
    };
    let all = items(&result["base_parameters"]).chain(items(&result["offsets"]));
    page.table(
        "",
        &["Name", "#Value", "#σ", "#σ/|value| (%)", "Unit", "Expression"],
        all.map(row),
    );
    effects(page, &result["effects"]);
    items(&result["undetermined"]).for_each(|d| page.paragraph("", &format!("Not determined: {}", text(&d["text"]))));
    for figure in parameter_figures(result) {
        let caption = format!(
            "Base parameters in {}, with two standard deviations to both sides.",
            figure.panels[0].y.trim_start_matches("value ± 2σ (").trim_end_matches(')')
        );
        page.figure(&figure, &caption);
    }
}

pub(super) fn errors(page: &mut Html, result: &Value) {
    page.heading(2, "Errors");
    let names: Vec<String> = items(&result["joints"]).map(|j| format!("#{}", text(j))).collect();
    let heads: Vec<&str> = ["Log", "Role", "Model"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .chain(["#Sum"])
        .collect();
    let mut rows = Vec::new();
    for (role, key) in [("identification", "identification"), ("held out", "validation")] {
        for log in items(&result["rms"][key]) {
            for model in ["base", "physical"].into_iter().filter(|m| log[*m].is_object()) {
                let errors = items(&log[model]["rms"]).map(text);
                rows.push(
                    [text(&log["name"]), role.to_string(), model.to_string()]
                        .into_iter()
                        .chain(errors)
                        .chain([text(&log[model]["sum"])])
                        .collect::<Vec<_>>(),
                );
            }
        }
    }
    page.table(
        "Root mean square of measured less predicted torque (N m, or N for sliding joints), of single measurements about the model with the effects found",
        &heads,
        rows.into_iter(),
    );
    if result["rms"].is_object() {
        page.figure(
            &error_figure(result),
            "Root mean square error of the base parameters, per joint and log.",
        );
    }
}

/// What was found beside the declared model, and whether it is in the model.
fn effects(page: &mut Html, list: &Value) {
    let of = |effect: &Value| -> Vec<Vec<String>> {
        let row = |p: &Value| {
            vec![
                capital(&words(&effect["effect"])),
                listed(&effect["joints"]),
                words(&p["name"]),
                text(&p["value"]),
                text(&p["std_dev"]),
                unit(&text(&p["unit"])),
                match (effect["in_model"] == true, effect["finding"] == false) {
                    (true, true) => "yes, not beyond chance by itself",
                    (true, false) => "yes",
                    (false, _) => "no",
                }
                .into(),
            ]
        };
        items(&effect["parameters"]).map(row).collect()
    };
    let rows: Vec<Vec<String>> = items(list).flat_map(of).collect();
    if !rows.is_empty() {
        page.table(
            "Effects estimated together with the base parameters",
            &["Effect", "Joints", "Parameter", "#Value", "#σ", "Unit", "In the model"],
            rows.into_iter(),
        );
    }
}

pub(super) fn torques(page: &mut Html, result: &Value) {
    if items(&result["predictions"]).next().is_none() {
        return;
    }
    page.heading(2, "Measured and predicted torque");
    let effects = items(&result["effects"]).any(|e| e["in_model"] == true);
    let joints: Vec<&Value> = items(&result["joints"]).collect();
    for prediction in items(&result["predictions"]) {
        let j = joints.iter().position(|j| **j == prediction["joint"]).unwrap_or(0);
        let sliding = result["provenance"]["robot"]["joints"][j]["kind"] == "prismatic";
        let by = match effects {
            true => "the base parameters with the effects found",
            false => "the base parameters",
        };
        let caption = format!(
            "Joint {}, {}: measured, and predicted by {by}; below, their difference.",
            text(&prediction["joint"]),
            text(&prediction["log"])
        );
        page.figure(&torque_figure(prediction, if sliding { "N" } else { "N m" }), &caption);
    }
}

pub(super) fn again(page: &mut Html, result: &Value, circumstances: &Circumstances) {
    let origin = &result["provenance"];
    page.heading(2, "To do it again");
    page.paragraph(
        "",
        &format!(
            "dynident {}. The identification draws no random numbers: the same logs and request give the same result.",
            text(&origin["version"])
        ),
    );
    let row = |l: &Value| ["file", "role", "bytes", "sha256"].map(|k| text(&l[k])).to_vec();
    page.table(
        "Logs, by SHA-256 of the files as they were sent",
        &["File", "Role", "#Bytes", "SHA-256"],
        items(&origin["logs"]).map(row),
    );
    let of_role = |role: &str| {
        items(&origin["logs"])
            .filter(|l| l["role"] == role)
            .map(|l| text(&l["file"]))
            .collect::<Vec<_>>()
            .join(" ")
    };
    let held_out = match of_role("validation") {
        files if files.is_empty() => String::new(),
        files => format!(" --validation {files}"),
    };
    page.paragraph(
        "mono",
        &format!(
            "dynident identify --robot robot.json --request request.json --log {}{held_out} --out result.json",
            of_role("identification")
        ),
    );
    page.heading(3, "request.json");
    page.document(&origin["request"]);
    page.heading(3, "robot.json");
    page.document(&origin["robot"]);
    if let Some(design) = &circumstances.design {
        page.heading(3, "The executed design");
        page.paragraph("soft", "Its request with the seed of the search, and the trajectory.");
        let kept: serde_json::Map<String, Value> = ["request", "version", "status", "fundamental_hz", "coefficients", "offset"]
            .iter()
            .filter_map(|k| Some((k.to_string(), design.get(*k)?.clone())))
            .collect();
        page.document(&Value::Object(kept));
    }
}
