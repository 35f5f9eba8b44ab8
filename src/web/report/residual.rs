//! The part of the report on the residual: findings, held-out errors, noise floor and detection limits.

use super::html::{Cell, Html, capital, listed, text, words};
use crate::documents::{
    ChangeCode, EffectFinding, EffectParameter, EvaluatedFigure, HeldOutCode, HeldOutDocument, HeldOutJoint, IdentifyDocument,
    LackOfFit, LawDocument, ResidualDocument, RivalDocument, UndetectedEffect,
};
use crate::web::figures::{before_after_figure, finding_figure, unit};

pub(super) fn diagnosis(page: &mut Html, result: &IdentifyDocument) {
    let Some(residual) = &result.residual else { return };
    page.heading(2, "Residual diagnosis");
    if residual.findings.is_empty() && residual.remainder.is_none() {
        page.paragraph("", &text(&residual.summary));
    }
    for finding in &residual.findings {
        describe(page, result, finding);
    }
    if let Some(rest) = &residual.remainder {
        page.heading(3, &format!("Unexplained on {}", listed(&rest.joints)));
        page.paragraph("finding", &text(&rest.sentence));
        page.paragraph("soft", &text(&rest.note));
    }
    held_out(page, &residual.held_out);
    if let Some(figure) = before_after_figure(result) {
        page.figure(
            &figure,
            "RMS error of single measurements per joint, of the declared model and of the model with the effects found, with the noise floor. Both models are estimated from the same rows with the same weights.",
        );
    }
    lack_of_fit(page, residual);
    undetected(page, &residual.undetected);
}

/// The residual of both models over that of noise alone.
fn lack_of_fit(page: &mut Html, residual: &ResidualDocument) {
    page.heading(3, "Noise floor and lack of fit");
    page.paragraph("", &format!("Noise floor from: {}.", text(&residual.noise_source)));
    let fits = residual.lack_of_fit.iter().zip(&residual.lack_of_fit_after);
    let fits = fits.zip(&residual.noise_floor);
    let row = |((before, after), floor): ((&LackOfFit, &LackOfFit), &Option<f64>)| {
        vec![
            text(&before.joint),
            text(floor),
            text(&before.statistic),
            chance(before.p_value),
            text(&after.statistic),
            chance(after.p_value),
        ]
    };
    page.table(
        "Lack of fit of the declared model and of the model with the effects found; 1: only noise remains",
        &["Joint", "#Noise floor", "#Declared model", "#p", "#With effects", "#p"],
        fits.map(row),
    );
}

/// The declared model and the final one on held-out data, joint by joint.
fn held_out(page: &mut Html, held_out: &HeldOutDocument) {
    if held_out.verdict == HeldOutCode::NotTested {
        return;
    }
    let row = |j: &HeldOutJoint| {
        vec![
            text(&j.joint),
            text(&j.before),
            text(&j.after),
            text(&j.floor),
            words(j.change.code()),
            chance(j.p_value),
        ]
    };
    page.heading(3, "Held-out errors");
    let caption = format!(
        "Held-out RMS error per joint (N·m, or N for prismatic joints): {}. Held-out data: {}",
        words(held_out.verdict.code()),
        text(&held_out.source)
    );
    page.table(
        &caption,
        &["Joint", "#Declared model", "#With effects", "#Noise floor", "Change", "#p"],
        held_out.joints.iter().map(row),
    );
}

/// What every robot may have and the logs do not show.
fn undetected(page: &mut Html, list: &[UndetectedEffect]) {
    let row = |one: &UndetectedEffect| {
        let parameter = &one.parameter;
        let largest = parameter
            .value
            .zip(parameter.std_dev)
            .map(|(value, deviation)| value.abs() + 3.0 * deviation);
        vec![
            capital(&words(&one.effect)),
            text(&one.joint),
            text(&parameter.value),
            text(&parameter.std_dev),
            text(&largest),
            unit(&parameter.unit),
            if one.in_model { "yes" } else { "no" }.into(),
        ]
    };
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    if !rows.is_empty() {
        page.heading(3, "Effects tested and not found");
        page.table(
            "Each estimated alone beside the final model; none is significant",
            &[
                "Effect",
                "Joint",
                "#Value",
                "#σ",
                "#Limit: |value| + 3σ",
                "Unit",
                "In the model",
            ],
            rows.into_iter(),
        );
    }
}

/// Below a millionth of a millionth a chance is none.
fn chance(p: Option<f64>) -> String {
    match p {
        Some(p) if p < 1e-12 => "< 10⁻¹²".into(),
        _ => text(&p),
    }
}

/// Every torque of a law, and its energy, set as formulas.
fn formula(page: &mut Html, law: &LawDocument) {
    let names = law.torques.iter().map(|t| format!("τ({})", text(&t.joint)));
    let energy = law.energy.iter().map(|_| "energy".to_string());
    let unset: Vec<String> = law
        .torques
        .iter()
        .map(|t| &t.expression)
        .chain(&law.energy)
        .map(text)
        .collect();
    let set = |(name, text): (String, (usize, String))| {
        let formula = law.mathml.get(text.0).filter(|_| law.mathml.len() == unset.len());
        vec![
            Cell::from(name),
            formula.map_or_else(|| Cell::from(text.1), |m| Cell(m.clone())),
        ]
    };
    page.table(
        "",
        &["Quantity", "Formula"],
        names.chain(energy).zip(unset.iter().cloned().enumerate()).map(set),
    );
}

fn describe(page: &mut Html, result: &IdentifyDocument, finding: &EffectFinding) {
    page.heading(
        3,
        &capital(&format!("{} on {}", words(&finding.effect), listed(&finding.joints))),
    );
    page.paragraph("finding", &text(&finding.sentence));
    if let Some(law) = &finding.law {
        formula(page, law);
    }
    if finding.parameters.is_empty() {
        return;
    }
    let deviation = |p: &EffectParameter| match p.std_dev {
        Some(0.0) => "given".to_string(),
        _ => text(&p.std_dev),
    };
    let row = |p: &EffectParameter| vec![words(&p.name), text(&p.value), deviation(p), unit(&p.unit)];
    page.table("", &["Parameter", "#Value", "#σ", "Unit"], finding.parameters.iter().map(row));
    let e = &finding.evidence;
    let mut evidence = format!(
        "Difference in BIC with the effect: {}; p of the gain: {}.",
        text(&e.log_evidence_ratio),
        chance(e.p_value)
    );
    let held_out = &finding.held_out;
    if held_out.change != ChangeCode::NotTested {
        evidence += &format!(
            " Held-out error without and with the effect: {} and {}, {} (p = {}).",
            text(&held_out.before),
            text(&held_out.after),
            words(held_out.change.code()),
            match held_out.p_value {
                EvaluatedFigure::Value(p) => chance(p),
                other => text(&other),
            }
        );
    }
    if !finding.in_model {
        evidence += " It is not in the model.";
    }
    if let Some(note) = &finding.note {
        evidence += &format!(" Note: {note}.");
    }
    page.paragraph("soft", &evidence);
    let rival = |r: &RivalDocument| {
        let what = r.law.as_ref().map_or_else(|| words(&r.effect), |law| text(&law.expression));
        vec![what, listed(&r.joints), text(&r.evidence)]
    };
    if !finding.rivals.is_empty() {
        page.table(
            "Rivals that the data do not exclude, with the difference in BIC in favour of the finding",
            &["Rival", "Joints", "#Difference in BIC"],
            finding.rivals.iter().map(rival),
        );
    }
    if let Some(figure) = finding_figure(result, finding) {
        page.figure(
            &figure,
            "Residual of the joint for the declared model and for the model with all effects found.",
        );
    }
}
