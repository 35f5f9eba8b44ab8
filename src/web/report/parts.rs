//! The parts of the report, in their order; residual and physical parameters have files of their own.

use super::Circumstances;
use super::formula;
use super::html::{Cell, Html, capital, escaped, listed, text, words};
use crate::documents::{
    BaseValue, ChoiceDocument, DataFaultDocument, EffectParameter, EffectValue, IdentifyDocument, JointErrors, LogDocument,
    LogOrigin, LogRms, ResidualDocument,
};
use crate::web::figures::{error_figure, parameter_figures, torque_figure, unit};
use serde_json::Value;

pub(super) fn heading(page: &mut Html, result: &IdentifyDocument, circumstances: &Circumstances) {
    page.heading(1, &format!("Identification of {}", text(&result.robot)));
    let version = text(&result.provenance.as_ref().map(|p| p.version.clone()));
    let mut line = format!("dynident {version}");
    circumstances.ended.iter().for_each(|ended| line += &format!(", {ended}"));
    circumstances
        .id
        .iter()
        .for_each(|id| line += &format!(", identification {id}"));
    page.paragraph("soft", &line);
}

pub(super) fn summary(page: &mut Html, result: &IdentifyDocument) {
    if let Some(residual) = &result.residual {
        verdict(page, residual);
    }
    let q = &result.quality;
    let class = if q.verdict == "good" { "verdict" } else { "verdict bad" };
    page.paragraph(
        class,
        &format!(
            "Data: {}. {}.",
            words(&q.verdict),
            capital(text(&q.reason).trim_end_matches('.'))
        ),
    );
    let row = |name: &str, value: String| vec![name.to_string(), value];
    let [base, further] = determined(result);
    let mut rows = vec![row("Base parameters determined", base)];
    rows.extend(
        Some(further)
            .filter(|f| !f.is_empty())
            .map(|f| row("Parameters of effects and offsets determined", f)),
    );
    rows.extend([
        row("Condition number, columns scaled", text(&q.condition_number)),
        row("Estimator", estimator(&result.estimator).into()),
        row(
            "Physical fit: residual of the physical over that of the base parameters",
            text(&result.feasibility.as_ref().map(|f| f.rms_ratio)),
        ),
    ]);
    page.table("Key figures", &["Quantity", "#Value"], rows.into_iter());
    result.notes.iter().for_each(|note| page.paragraph("soft", note));
}

/// The method behind the code of an estimator.
fn estimator(code: &str) -> &str {
    match code {
        "wls" => "least squares weighted by each joint's noise",
        "ols" => "ordinary least squares",
        "robust" => "least squares robust against outliers",
        other => other,
    }
}

/// How many base parameters the logs determine, and how many parameters beside them, where the fit has some.
fn determined(result: &IdentifyDocument) -> [String; 2] {
    let base = &result.base_parameters;
    let known = base.iter().filter(|p| p.value.is_some()).count();
    let (rank, columns) = (result.quality.rank, result.quality.columns);
    let further = columns.saturating_sub(base.len());
    let of = |known: usize, all: usize| format!("{known} of {all}");
    [
        of(known, base.len()),
        if further > 0 {
            of(rank.saturating_sub(known), further)
        } else {
            String::new()
        },
    ]
}

/// What the diagnosis came to, faults of the data, and every finding in its sentence.
fn verdict(page: &mut Html, residual: &ResidualDocument) {
    let faulty = !residual.data_faults.iter().all(DataFaultDocument::is_allowed_for);
    page.paragraph(if faulty { "verdict bad" } else { "verdict" }, &text(&residual.summary));
    for fault in &residual.data_faults {
        let sentence = format!(
            "{}. {}",
            capital(text(&fault.detail).trim_end_matches('.')),
            text(&fault.remedy)
        );
        page.paragraph("finding", &sentence);
    }
    let findings = residual.findings.iter().map(|f| &f.sentence);
    let sentences = findings.chain(residual.remainder.iter().map(|r| &r.sentence));
    sentences.for_each(|s| page.paragraph("finding", s));
}

pub(super) fn logs(page: &mut Html, result: &IdentifyDocument) {
    page.heading(2, "Logs and their preparation");
    let row = |l: &LogDocument| {
        vec![
            l.file.clone(),
            l.role.clone(),
            text(&l.rows_used),
            text(&l.rows),
            text(&l.sample_rate_hz),
            text(&l.duration_s),
        ]
    };
    page.table(
        "",
        &["File", "Role", "#Rows used", "#Rows", "#Rate (Hz)", "#Length (s)"],
        result.log_report.iter().map(row),
    );
    for log in &result.log_report {
        for finding in &log.findings {
            page.paragraph(
                "",
                &format!(
                    "{}: {}, {} times: {}",
                    text(&log.file),
                    words(&finding.code),
                    text(&finding.count),
                    text(&finding.detail)
                ),
            );
        }
        let row = |c: &ChoiceDocument| [words(&c.what), text(&c.value), text(&c.why)].to_vec();
        page.table(
            &format!("Preparation of {}", text(&log.file)),
            &["Step", "Choice", "Reason"],
            log.choices.iter().map(row),
        );
    }
}

pub(super) fn parameters(page: &mut Html, result: &IdentifyDocument) {
    page.heading(2, "Base parameters");
    page.paragraph("soft", "Standard deviations σ allow for correlated noise. Names and expressions are those of the standard parameters of every link about its joint frame.");
    let row = |p: &BaseValue| {
        let value = p.value.map_or("not determined".into(), |v| text(&v));
        vec![
            formula::name(&text(&p.name)),
            Cell::from(value),
            Cell::from(text(&p.std_dev)),
            Cell::from(text(&p.relative_std_dev_percent)),
            Cell(format!("<span class=\"whole\">{}</span>", escaped(&unit(&p.unit)))),
            formula::expression(&text(&p.expression)),
        ]
    };
    let all = result.base_parameters.iter().chain(result.offsets.iter().flatten());
    page.table(
        "",
        &["Name", "#Value", "#σ", "#σ/|value| (%)", "Unit", "Expression"],
        all.map(row),
    );
    effects(page, &result.effects);
    result
        .undetermined
        .iter()
        .for_each(|d| page.paragraph("", &format!("Not determined: {}", text(&d.text))));
    for figure in parameter_figures(result) {
        let caption = format!(
            "Base parameters in {}, with two standard deviations to both sides.",
            figure.panels[0].y.trim_start_matches("value ± 2σ (").trim_end_matches(')')
        );
        page.figure(&figure, &caption);
    }
}

pub(super) fn errors(page: &mut Html, result: &IdentifyDocument) {
    page.heading(2, "Errors per joint");
    let names: Vec<String> = result.joints.iter().map(|j| format!("#{j}")).collect();
    let heads: Vec<&str> = ["Log", "Role", "Model"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .chain(["#Sum"])
        .collect();
    let mut rows = Vec::new();
    let mut add = |role: &str, log: &LogRms, model: &str, errors: &JointErrors| {
        let head = [log.name.clone(), role.into(), model.into()];
        let figures = errors.rms.iter().map(text).chain([text(&errors.sum)]);
        rows.push(head.into_iter().chain(figures).collect::<Vec<_>>());
    };
    for (role, logs) in [
        ("identification", &result.rms.identification),
        ("validation", &result.rms.validation),
    ] {
        for log in logs {
            add(role, log, "base", &log.base);
            log.physical.iter().for_each(|errors| add(role, log, "physical", errors));
        }
    }
    page.table(
        "RMS error: measured less predicted torque (N·m, or N for prismatic joints) of single measurements, for the model with the effects found",
        &heads,
        rows.into_iter(),
    );
    if !result.rms.identification.is_empty() {
        page.figure(
            &error_figure(result),
            "Root mean square error of the base parameters, per joint and log.",
        );
    }
}

/// What was found beside the declared model, and whether it is in the model.
fn effects(page: &mut Html, list: &[EffectValue]) {
    let of = |effect: &EffectValue| -> Vec<Vec<String>> {
        let row = |p: &EffectParameter| {
            vec![
                capital(&words(&effect.effect)),
                listed(&effect.joints),
                words(&p.name),
                text(&p.value),
                text(&p.std_dev),
                unit(&p.unit),
                match (effect.in_model, !effect.finding) {
                    (true, true) if effect.declared => "yes, declared",
                    (true, true) => "yes, not significant alone",
                    (true, false) => "yes",
                    (false, _) => "no",
                }
                .into(),
            ]
        };
        effect.parameters.iter().map(row).collect()
    };
    let rows: Vec<Vec<String>> = list.iter().flat_map(of).collect();
    if !rows.is_empty() {
        page.table(
            "Effects estimated together with the base parameters",
            &["Effect", "Joints", "Parameter", "#Value", "#σ", "Unit", "In the model"],
            rows.into_iter(),
        );
    }
}

pub(super) fn torques(page: &mut Html, result: &IdentifyDocument) {
    if result.predictions.is_empty() {
        return;
    }
    page.heading(2, "Measured and predicted torque");
    let effects = result.effects.iter().any(|e| e.in_model);
    for prediction in &result.predictions {
        let j = result.joints.iter().position(|j| *j == prediction.joint).unwrap_or(0);
        let sliding = result.is_sliding(j);
        let by = match effects {
            true => "the base parameters with the effects found",
            false => "the base parameters",
        };
        let figure = torque_figure(prediction, if sliding { "N" } else { "N m" });
        let gaps = if figure.has_gaps() {
            " Gaps are rows that the fit leaves out, where the joint hardly moves."
        } else {
            ""
        };
        let caption = format!(
            "Joint {}, {}: measured, and predicted by {by}; below, their difference.{gaps}",
            text(&prediction.joint),
            text(&prediction.log)
        );
        page.figure(&figure, &caption);
    }
}

pub(super) fn reproduction(page: &mut Html, result: &IdentifyDocument, circumstances: &Circumstances) {
    let Some(origin) = &result.provenance else { return };
    page.heading(2, "Reproduction");
    page.paragraph(
        "",
        &format!(
            "dynident {}. The identification draws no random numbers: the same logs and request give the same result.",
            text(&origin.version)
        ),
    );
    let row = |l: &LogOrigin| vec![l.file.clone(), l.role.clone(), text(&l.bytes), l.sha256.clone()];
    page.table(
        "Logs, by SHA-256 of the files as they were sent",
        &["File", "Role", "#Bytes", "SHA-256"],
        origin.logs.iter().map(row),
    );
    let of_role = |role: &str| {
        let files = origin.logs.iter().filter(|l| l.role == role);
        files.map(|l| l.file.as_str()).collect::<Vec<_>>().join(" ")
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
    page.document(&origin.request);
    page.heading(3, "robot.json");
    page.document(&serde_json::to_value(&origin.robot).expect("plain numbers and words"));
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
