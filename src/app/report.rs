//! From the numbers of an identification to its document.

use super::identify::{ReadLogs, reason};
use crate::diagnosis::{ResidualReport, reported_parameters};
use crate::documents::{
    BaseValue, DeclaredDocument, Direction, EffectValue, Feasibility, FitStart, IdentifyDocument, IdentifyRequest,
    InertiaDocument, JointErrors, LawDocument, LogDocument, LogRms, MarginValue, NoiseDocument, PaperProblem, PhysicalValue,
    QualityDocument, RmsDocument,
};
use crate::effects::OwnEffect;
use crate::identification::Quality;
use crate::identification::physical::{
    ConstraintMargin, FeasibleFit, FeasibleMethod, FitEnding, PaperFit, PhysicalFit, PhysicalLink,
};
use crate::model::Robot;
use crate::parameters::Layout;
use crate::regression::{AugmentedModel, Estimate, Estimator, Fitted, PredictionErrors, Stretch, Term};
use crate::spatial::PhysicalInertia;
use nalgebra::DVector;

/// All that the document of an identification is made of.
pub(super) struct Answer<'a> {
    pub request: &'a IdentifyRequest,
    /// With gravity where the data have it.
    pub robot: &'a Robot,
    pub found: &'a Fitted,
    pub declared: &'a Fitted,
    pub judged: &'a Quality,
    pub feasible: Option<&'a FeasibleFit>,
    /// The model found with bodies in the place of its base parameters.
    pub bodies: Option<&'a AugmentedModel>,
    pub read: &'a ReadLogs,
    /// How many of the logs were identified from; the others validate.
    pub identification: usize,
}

impl Answer<'_> {
    pub fn document(&self) -> IdentifyDocument {
        let robot = self.robot;
        let found = self.found;
        let physical = self.feasible.map(FeasibleFit::model);
        IdentifyDocument {
            robot: robot.name().to_string(),
            joints: robot.joints().iter().map(|j| j.name.clone()).collect(),
            estimator: match self.request.estimator {
                Estimator::Ordinary => "ols".into(),
                Estimator::Weighted => "wls".into(),
                Estimator::Robust => "robust".into(),
            },
            quality: quality_document(self.judged, found, robot),
            base_parameters: base_values(found),
            effects: Vec::new(),
            declared: DeclaredDocument {
                base_parameters: base_values(self.declared),
                rms: self.rms(&self.declared.model, None),
            },
            undetermined: found
                .estimate
                .solution
                .null_directions
                .iter()
                .map(|v| direction(found, v))
                .collect(),
            offsets: self
                .request
                .offset
                .then(|| (0..robot.joint_count()).map(|j| offset_value(robot, found, j)).collect()),
            physical_parameters: physical.and_then(|fit| physical_values(robot, fit)),
            feasibility: self.feasible.map(|fit| feasibility(robot, fit)),
            rms: self.rms(&found.model, self.bodies),
            noise: noise(robot, &found.estimate),
            log_report: self.log_report(),
            residual: None,
            predictions: Vec::new(),
            predictions_error: None,
            notes: self.request.notes.clone(),
            provenance: None,
        }
    }

    fn rms(&self, base: &AugmentedModel, physical: Option<&AugmentedModel>) -> RmsDocument {
        let of = |(log, stretch): (&super::identify::UsedLog, &Stretch)| LogRms {
            name: log.report.file.clone(),
            base: errors(base.errors(stretch)),
            physical: physical.map(|model| errors(model.errors(stretch))),
        };
        let mut all: Vec<LogRms> = self.read.used.iter().zip(&self.read.stretches).map(of).collect();
        let validation = all.split_off(self.identification);
        RmsDocument {
            identification: all,
            validation,
        }
    }

    fn log_report(&self) -> Vec<LogDocument> {
        let role = |i: usize| {
            if i < self.identification {
                "identification"
            } else {
                "validation"
            }
        };
        let logs = self.read.used.iter().enumerate();
        logs.map(|(i, log)| LogDocument::new(&log.report, role(i), &log.prepared.choices))
            .collect()
    }
}

/// The own effects that belong to the model from the start.
pub(super) fn declared_effects(found: &Fitted) -> Vec<EffectValue> {
    let terms = found.model.terms.iter().enumerate();
    let declared = terms.filter(|(_, t)| t.effect.own().is_some_and(OwnEffect::is_declared));
    let robot = &found.model.robot;
    let of = |(at, term): (usize, &Term)| {
        let joints: Vec<String> = term.acts_on().iter().map(|&j| robot.joints()[j].name.clone()).collect();
        let parameters = reported_parameters(robot, term, &found.term_covariance(at));
        let formula = term.effect.formula(term.form, &term.joints);
        EffectValue {
            effect: term.effect.code().into(),
            parameters: parameters.iter().map(Into::into).collect(),
            in_model: true,
            finding: false,
            declared: true,
            law: formula.map(|formula| LawDocument::new(&formula, &joints)),
            joints,
        }
    };
    declared.map(of).collect()
}

/// The findings as effects of the model, then what else the model has.
pub(super) fn effects(report: &ResidualReport) -> Vec<EffectValue> {
    let findings = report.findings.iter();
    findings
        .map(|f| EffectValue {
            effect: f.effect.clone(),
            joints: f.joints.clone(),
            parameters: f.parameters.iter().map(Into::into).collect(),
            in_model: f.in_model,
            finding: true,
            declared: false,
            law: f.formula.as_ref().map(|formula| LawDocument::new(formula, &f.joints)),
        })
        .chain(report.undetected.iter().filter(|u| u.in_model).map(|u| EffectValue {
            effect: u.effect.clone(),
            joints: vec![u.joint.clone()],
            parameters: vec![(&u.parameter).into()],
            in_model: true,
            finding: false,
            declared: false,
            law: None,
        }))
        .collect()
}

fn finite(v: f64) -> Option<f64> {
    v.is_finite().then_some(v)
}

fn quality_document(judged: &Quality, found: &Fitted, robot: &Robot) -> QualityDocument {
    let solution = &found.estimate.solution;
    QualityDocument {
        verdict: judged.verdict.code().into(),
        reason: reason(judged, &found.base, &found.estimate, robot),
        condition_number: finite(solution.condition_number()),
        rank: solution.rank,
        columns: found.estimate.values.len(),
        prediction_std: judged.prediction_std.iter().map(|&v| finite(v)).collect(),
        extrapolation: judged.extrapolation.iter().map(|&v| finite(v)).collect(),
        explained: judged.explained.joints.clone(),
    }
}

fn value(found: &Estimate, c: usize, name: String, expression: String, unit: &str) -> BaseValue {
    let identifiable = found.is_determined(c);
    let given = |v: f64| if identifiable { finite(v) } else { None };
    BaseValue {
        name,
        expression,
        value: given(found.values[c]),
        std_dev: given(found.std_dev(c)),
        relative_std_dev_percent: given(found.relative_std_dev_percent(c)),
        textbook_relative_std_dev_percent: given(100.0 * found.textbook_std_dev[c] / found.values[c].abs()),
        unit: unit.to_string(),
        identifiable,
    }
}

fn base_values(found: &Fitted) -> Vec<BaseValue> {
    let base = &found.base;
    let of = |c: usize| {
        value(
            &found.estimate,
            c,
            base.names[c].clone(),
            base.expressions[c].to_string(),
            base.units[c],
        )
    };
    (0..base.len()).map(of).collect()
}

fn offset_value(robot: &Robot, found: &Fitted, j: usize) -> BaseValue {
    let joint = &robot.joints()[j];
    value(
        &found.estimate,
        found.term_range(j).start,
        format!("offset {}", joint.name),
        "constant torque".to_string(),
        joint.effort_unit(),
    )
}

/// An open direction in the parameters' own units, its parts above a hundredth of the largest.
fn direction(found: &Fitted, scaled: &DVector<f64>) -> Direction {
    let scale = &found.estimate.solution.column_scale;
    let divisor = |c: usize| if scale[c] > 0.0 { scale[c] } else { 1.0 };
    let parts = DVector::from_fn(scaled.len(), |c, _| scaled[c] / divisor(c));
    let largest = parts.amax();
    let mut order: Vec<usize> = (0..parts.len()).filter(|&c| parts[c].abs() > 0.01 * largest).collect();
    order.sort_by(|&a, &b| parts[b].abs().total_cmp(&parts[a].abs()));
    let name = |c: usize| found.base.names.get(c).cloned().unwrap_or_else(|| effect_name(found, c));
    let text: Vec<String> = order
        .iter()
        .map(|&c| format!("{:.3} {}", parts[c] / largest, name(c)))
        .collect();
    Direction {
        text: text.join(" + ").replace("+ -", "- "),
        parameters: order.iter().map(|&c| name(c)).collect(),
    }
}

/// The effect that value `c` of an estimate belongs to.
fn effect_name(found: &Fitted, c: usize) -> String {
    let terms = &found.model.terms;
    let Some(at) = (0..terms.len()).find(|&t| found.term_range(t).contains(&c)) else {
        return format!("parameter {}", c + 1);
    };
    let acts_on = terms[at].acts_on();
    let joints = acts_on.iter().map(|&j| found.model.robot.joints()[j].name.as_str());
    format!("{} {}", terms[at].effect.code(), joints.collect::<Vec<_>>().join(" "))
}

fn physical_values(robot: &Robot, fit: &PhysicalFit) -> Option<Vec<PhysicalValue>> {
    let links = fit.links(&Layout::standard(robot))?;
    let in_description = |(joint, link): (&crate::model::Joint, PhysicalLink)| {
        let turn = joint.description_frame;
        PhysicalLink {
            inertia: PhysicalInertia {
                mass: link.inertia.mass,
                center_of_mass: turn * link.inertia.center_of_mass,
                inertia: turn * link.inertia.inertia * turn.transpose(),
            },
            ..link
        }
    };
    let links: Vec<PhysicalLink> = robot.joints().iter().zip(links).map(in_description).collect();
    Some(link_values(robot, &links))
}

/// Links in the frames of the description, as the answer has them.
fn link_values(robot: &Robot, links: &[PhysicalLink]) -> Vec<PhysicalValue> {
    let describe = |(k, (joint, link)): (usize, (&crate::model::Joint, &PhysicalLink))| {
        let i = link.inertia.inertia;
        PhysicalValue {
            link: k + 1,
            name: joint.link_name.clone(),
            mass: link.inertia.mass,
            center_of_mass: link.inertia.center_of_mass.into(),
            inertia: InertiaDocument {
                xx: i[(0, 0)],
                xy: i[(0, 1)],
                xz: i[(0, 2)],
                yy: i[(1, 1)],
                yz: i[(1, 2)],
                zz: i[(2, 2)],
            },
            viscous: link.viscous,
            coulomb: link.coulomb,
        }
    };
    robot.joints().iter().zip(links).enumerate().map(describe).collect()
}

fn status(ending: FitEnding) -> &'static str {
    match ending {
        FitEnding::Converged => "Converged",
        FitEnding::Stalled => "Stalled",
        FitEnding::BudgetExhausted => "BudgetExhausted",
        FitEnding::Infeasible => "Infeasible",
        FitEnding::Cancelled => "Cancelled",
    }
}

fn margin_values(fit: &PhysicalFit) -> Vec<MarginValue> {
    let cost = |m: &ConstraintMargin| {
        let active = fit.active.iter().find(|a| (a.link, a.constraint) == (m.link, m.constraint));
        active.map(|a| a.cost_percent)
    };
    let one = |m: &ConstraintMargin| MarginValue {
        link: m.link + 1,
        constraint: m.constraint.code().into(),
        margin: m.margin,
        active: cost(m).is_some(),
        cost_percent: cost(m),
    };
    fit.margins.iter().map(one).collect()
}

fn feasibility(robot: &Robot, feasible: &FeasibleFit) -> Feasibility {
    let model = feasible.model();
    Feasibility {
        method: match feasible.method() {
            FeasibleMethod::Paper => "paper".into(),
            _ => "consistent".into(),
        },
        status: status(model.ending).into(),
        rms_ratio: model.fit.ratio,
        margins: margin_values(model),
        paper: feasible.paper.as_ref().map(|paper| paper_problem(robot, paper)),
    }
}

fn paper_problem(robot: &Robot, paper: &PaperFit) -> PaperProblem {
    PaperProblem {
        status: status(paper.fit.ending).into(),
        objective: paper.fit.fit.cost,
        lower_bound: finite(paper.lower_bound),
        gap_percent: finite(100.0 * paper.gap),
        rms_ratio: paper.fit.fit.ratio,
        evaluations: paper.fit.iterations,
        starts: paper
            .starts
            .iter()
            .map(|s| FitStart {
                from: s.from.into(),
                status: status(s.ending).into(),
                feasible: s.feasible,
                objective: finite(s.cost),
                evaluations: s.evaluations,
            })
            .collect(),
        margins: margin_values(&paper.fit),
        physical_parameters: link_values(robot, &paper.links),
    }
}

pub(super) fn errors(e: PredictionErrors) -> JointErrors {
    JointErrors {
        sum: e.rms.iter().filter(|r| r.is_finite()).sum(),
        rms: e.rms.into_iter().map(finite).collect(),
        percent: e.percent.into_iter().map(finite).collect(),
    }
}

fn noise(robot: &Robot, found: &Estimate) -> Vec<NoiseDocument> {
    let one = |(joint, fit): (&crate::model::Joint, &crate::regression::JointFit)| NoiseDocument {
        joint: joint.name.clone(),
        residual_rms: fit.rms,
        noise_std: fit.noise_std,
        misfit: fit.misfit,
        rows: fit.rows,
        effective_rows: fit.effective_rows,
    };
    robot.joints().iter().zip(&found.joints).map(one).collect()
}
