//! The part of the report on what the model leaves over, finding by finding.

use super::html::{Cell, Html, capital, listed, text, words};
use crate::io::{
    ChangeCode, EffectFinding, EffectParameter, EvaluatedFigure, HeldOutCode, HeldOutDocument, HeldOutJoint, IdentifyDocument,
    LackOfFit, LawDocument, RivalDocument, UndetectedEffect,
};
use crate::web::figures::{before_after_figure, finding_figure, unit};

pub(super) fn loop_closed(page: &mut Html, result: &IdentifyDocument) {
    let Some(residual) = &result.residual else { return };
    page.heading(2, "What the model leaves over");
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
        "Lack of fit: 1 where only noise is left",
        &["Joint", "#Noise floor", "#Before", "#p", "#After", "#p"],
        fits.map(row),
    );
    held_out(page, &residual.held_out);
    for finding in &residual.findings {
        describe(page, result, finding);
    }
    if let Some(rest) = &residual.remainder {
        page.heading(3, &format!("Unexplained, on {}", listed(&rest.joints)));
        page.paragraph("finding", &text(&rest.sentence));
        page.paragraph("soft", &text(&rest.note));
    }
    undetected(page, &residual.undetected);
    if let Some(figure) = before_after_figure(result) {
        page.figure(
            &figure,
            "Error of single measurements per joint, of the declared model and of the model with the effects found, beside the noise floor. Both models are estimated from the same rows with the same weights.",
        );
    }
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
    let caption = format!(
        "Held-out error per joint (N m or N): {}. Data held out: {}",
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
fn chance(p: Option<f64>) -> String {
    match p {
        Some(p) if p < 1e-12 => "< 1e−12".into(),
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
        &["", "Formula"],
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
    let row = |p: &EffectParameter| vec![words(&p.name), text(&p.value), text(&p.std_dev), unit(&p.unit)];
    page.table("", &["Parameter", "#Value", "#σ", "Unit"], finding.parameters.iter().map(row));
    let e = &finding.evidence;
    let mut evidence = format!(
        "Twice the log of the evidence ratio against leaving it out: {}; chance of such a gain without it: {}.",
        text(&e.log_evidence_ratio),
        chance(e.p_value)
    );
    let held_out = &finding.held_out;
    if held_out.change != ChangeCode::NotTested {
        evidence += &format!(
            " Held-out error without and with it: {} and {}, {} (p = {}).",
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
            "Not excluded in its place; twice the log of the odds in favour of the finding",
            &["Effect", "Joints", "#Evidence"],
            finding.rivals.iter().map(rival),
        );
    }
    if let Some(figure) = finding_figure(result, finding) {
        page.figure(
            &figure,
            "What is left on the joint, of the declared model and of the model with all effects found.",
        );
    }
}
