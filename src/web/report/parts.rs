//! The parts of the report, in their order.

use super::Circumstances;
use super::formula;
use super::html::{Cell, Html, capital, escaped, items, listed, text, words};
use crate::web::figures::{before_after_figure, error_figure, finding_figure, parameter_figures, torque_figure, unit};
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
        "Root mean square of measured less predicted torque (N m, or N for sliding joints), of the rows as they were fitted",
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
    for finding in items(&residual["findings"]) {
        describe(page, result, finding);
    }
    let rest = &residual["remainder"];
    if rest.is_object() {
        page.heading(3, &format!("Unexplained, on {}", listed(&rest["joints"])));
        page.paragraph("finding", &text(&rest["sentence"]));
        page.paragraph("soft", &text(&rest["note"]));
    }
    if let Some(figure) = before_after_figure(result) {
        page.figure(
            &figure,
            "Error per joint before and after the effects found, beside the noise floor: of single measurements with all their noise, and of models fitted anew. The errors above are of rows as they were prepared, in which a mean over periods has less noise.",
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
            "What is left on the joint, with the base parameters alone and with all effects found.",
        );
    }
}

pub(super) fn torques(page: &mut Html, result: &Value) {
    if items(&result["predictions"]).next().is_none() {
        return;
    }
    page.heading(2, "Measured and predicted torque");
    let joints: Vec<&Value> = items(&result["joints"]).collect();
    for prediction in items(&result["predictions"]) {
        let j = joints.iter().position(|j| **j == prediction["joint"]).unwrap_or(0);
        let sliding = result["provenance"]["robot"]["joints"][j]["kind"] == "prismatic";
        let by = if prediction["augmented"].is_array() {
            "the declared model with the effects found"
        } else {
            "the base parameters"
        };
        let caption = format!(
            "Joint {}, {}: measured, and predicted by {by}; below, their difference.",
            text(&prediction["joint"]),
            text(&prediction["log"])
        );
        page.figure(&torque_figure(prediction, if sliding { "N" } else { "N m" }), &caption);
    }
}

pub(super) fn physical(page: &mut Html, result: &Value) {
    if items(&result["physical_parameters"]).next().is_none() {
        return;
    }
    page.heading(2, "Physical parameters");
    let link = |l: &Value| format!("{} {}", text(&l["link"]), text(&l["name"]));
    // Two tables: all of it in one is wider than a page.
    let body = |l: &Value| {
        let c = &l["center_of_mass"];
        let numbers = [&l["mass"], &c[0], &c[1], &c[2], &l["viscous"], &l["coulomb"]];
        std::iter::once(link(l)).chain(numbers.map(text)).collect::<Vec<_>>()
    };
    page.table(
        "In the frames of the robot's description",
        &["Link", "#Mass (kg)", "#x (m)", "#y (m)", "#z (m)", "#Viscous", "#Coulomb"],
        items(&result["physical_parameters"]).map(body),
    );
    let inertia = |l: &Value| {
        let numbers = ["xx", "yy", "zz", "xy", "xz", "yz"].map(|k| text(&l["inertia"][k]));
        std::iter::once(link(l)).chain(numbers).collect::<Vec<_>>()
    };
    page.table(
        "Inertia about the centre of mass (kg m²)",
        &["Link", "#Ixx", "#Iyy", "#Izz", "#Ixy", "#Ixz", "#Iyz"],
        items(&result["physical_parameters"]).map(inertia),
    );
    margins(page, &result["feasibility"]["margins"]);
}

/// A row per link and a column per constraint.
fn margins(page: &mut Html, margins: &Value) {
    let (mut links, mut constraints): (Vec<&Value>, Vec<String>) = (Vec::new(), Vec::new());
    for m in items(margins) {
        if !links.contains(&&m["link"]) {
            links.push(&m["link"]);
        }
        if !constraints.contains(&words(&m["constraint"])) {
            constraints.push(words(&m["constraint"]));
        }
    }
    let of = |link: &Value, constraint: &String| {
        let found = items(margins).find(|m| m["link"] == *link && words(&m["constraint"]) == *constraint);
        found.map_or("–".into(), |m| text(&m["margin"]))
    };
    let heads: Vec<String> = constraints.iter().map(|c| format!("#{}", capital(c))).collect();
    let heads: Vec<&str> = std::iter::once("Link").chain(heads.iter().map(String::as_str)).collect();
    let row = |link: &&Value| {
        std::iter::once(text(link))
            .chain(constraints.iter().map(|c| of(link, c)))
            .collect::<Vec<_>>()
    };
    page.table(
        "Margins to what is physically possible: above zero where it is",
        &heads,
        links.iter().map(row),
    );
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
