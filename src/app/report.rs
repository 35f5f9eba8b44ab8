//! From the numbers of an identification to its document.

use super::identify::{UsedLog, reason};
use crate::identification::physical::{
    ConstraintMargin, FeasibleFit, FeasibleMethod, FitEnding, PaperFit, PhysicalFit, PhysicalLink,
};
use crate::identification::{Estimate, Estimator, Quality, Validation, validate};
use crate::io::{
    BaseValue, Direction, Feasibility, FitStart, IdentifyDocument, IdentifyRequest, InertiaDocument, JointErrors, LogDocument,
    LogRms, MarginValue, NoiseDocument, PaperProblem, PhysicalValue, QualityDocument, RmsDocument,
};
use crate::model::Robot;
use crate::parameters::{BaseParameters, Layout};
use crate::spatial::PhysicalInertia;
use nalgebra::DVector;

pub(super) fn document(
    request: &IdentifyRequest,
    base: &BaseParameters,
    found: &Estimate,
    judged: &Quality,
    feasible: Option<&FeasibleFit>,
    identification: &[UsedLog],
    validation: &[UsedLog],
) -> IdentifyDocument {
    let robot = &request.robot;
    let physical = feasible.map(FeasibleFit::model);
    let columns = physical.map(|fit| physical_columns(base, fit));
    let rms = |logs: &[UsedLog]| logs.iter().map(|log| log_rms(log, &found.values, columns.as_ref())).collect();
    let all = || {
        identification
            .iter()
            .map(|l| (l, "identification"))
            .chain(validation.iter().map(|l| (l, "validation")))
    };
    IdentifyDocument {
        robot: robot.name().to_string(),
        joints: robot.joints().iter().map(|j| j.name.clone()).collect(),
        estimator: match request.estimator {
            Estimator::Ordinary => "ols",
            Estimator::Weighted => "wls",
            Estimator::Robust => "robust",
        },
        quality: quality_document(judged, base, found, robot),
        base_parameters: (0..base.len()).map(|c| base_value(base, found, c)).collect(),
        undetermined: found
            .solution
            .null_directions
            .iter()
            .map(|v| direction(base, found, v))
            .collect(),
        offsets: request.offset.then(|| {
            (0..robot.joint_count())
                .map(|j| offset_value(robot, base, found, j))
                .collect()
        }),
        physical_parameters: physical.and_then(|fit| physical_values(robot, fit)),
        feasibility: feasible.map(|fit| feasibility(robot, fit)),
        rms: RmsDocument {
            identification: rms(identification),
            validation: rms(validation),
        },
        noise: noise(robot, found),
        log_report: all()
            .map(|(log, role)| LogDocument::new(&log.report, role, &log.prepared.choices))
            .collect(),
        residual: None,
        predictions: Vec::new(),
        predictions_error: None,
        notes: request.notes.clone(),
        provenance: None,
    }
}

fn finite(v: f64) -> Option<f64> {
    v.is_finite().then_some(v)
}

/// Model columns (base parameters, then what was added) of physical parameters.
pub(super) fn physical_columns(base: &BaseParameters, fit: &PhysicalFit) -> DVector<f64> {
    let standard = base.map.ncols();
    let projected = base.project(&fit.values[..standard]);
    DVector::from_iterator(
        base.len() + fit.values.len() - standard,
        projected.iter().copied().chain(fit.values[standard..].iter().copied()),
    )
}

fn quality_document(judged: &Quality, base: &BaseParameters, found: &Estimate, robot: &Robot) -> QualityDocument {
    QualityDocument {
        verdict: judged.verdict.code(),
        reason: reason(judged, base, found, robot),
        condition_number: finite(found.solution.condition_number()),
        rank: found.solution.rank,
        columns: found.values.len(),
        prediction_std: judged.prediction_std.iter().map(|&v| finite(v)).collect(),
        extrapolation: judged.extrapolation.iter().map(|&v| finite(v)).collect(),
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

fn base_value(base: &BaseParameters, found: &Estimate, c: usize) -> BaseValue {
    value(
        found,
        c,
        base.names[c].clone(),
        base.expressions[c].to_string(),
        base.units[c],
    )
}

fn offset_value(robot: &Robot, base: &BaseParameters, found: &Estimate, j: usize) -> BaseValue {
    let joint = &robot.joints()[j];
    value(
        found,
        base.len() + j,
        format!("offset {}", joint.name),
        "constant torque".to_string(),
        joint.effort_unit(),
    )
}

/// An open direction in the parameters' own units, its parts above a hundredth of the largest.
fn direction(base: &BaseParameters, found: &Estimate, scaled: &DVector<f64>) -> Direction {
    let divisor = |c: usize| {
        if found.solution.column_scale[c] > 0.0 {
            found.solution.column_scale[c]
        } else {
            1.0
        }
    };
    let parts = DVector::from_fn(scaled.len(), |c, _| scaled[c] / divisor(c));
    let largest = parts.amax();
    let mut order: Vec<usize> = (0..parts.len()).filter(|&c| parts[c].abs() > 0.01 * largest).collect();
    order.sort_by(|&a, &b| parts[b].abs().total_cmp(&parts[a].abs()));
    let name = |c: usize| {
        base.names
            .get(c)
            .cloned()
            .unwrap_or_else(|| format!("offset {}", c - base.len() + 1))
    };
    let text: Vec<String> = order
        .iter()
        .map(|&c| format!("{:.3} {}", parts[c] / largest, name(c)))
        .collect();
    Direction {
        text: text.join(" + ").replace("+ -", "- "),
        parameters: order.iter().map(|&c| name(c)).collect(),
    }
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

fn margin_values(margins: &[ConstraintMargin]) -> Vec<MarginValue> {
    let one = |m: &ConstraintMargin| MarginValue {
        link: m.link + 1,
        constraint: m.constraint.code(),
        margin: m.margin,
    };
    margins.iter().map(one).collect()
}

fn feasibility(robot: &Robot, feasible: &FeasibleFit) -> Feasibility {
    let model = feasible.model();
    Feasibility {
        method: match feasible.method() {
            FeasibleMethod::Paper => "paper",
            _ => "consistent",
        },
        status: status(model.ending),
        rms_ratio: model.fit.ratio,
        margins: margin_values(&model.margins),
        paper: feasible.paper.as_ref().map(|paper| paper_problem(robot, paper)),
    }
}

fn paper_problem(robot: &Robot, paper: &PaperFit) -> PaperProblem {
    PaperProblem {
        status: status(paper.fit.ending),
        objective: paper.fit.fit.cost,
        lower_bound: finite(paper.lower_bound),
        gap_percent: finite(100.0 * paper.gap),
        rms_ratio: paper.fit.fit.ratio,
        evaluations: paper.fit.iterations,
        starts: paper
            .starts
            .iter()
            .map(|s| FitStart {
                from: s.from,
                status: status(s.ending),
                feasible: s.feasible,
                objective: finite(s.cost),
                evaluations: s.evaluations,
            })
            .collect(),
        margins: margin_values(&paper.fit.margins),
        physical_parameters: link_values(robot, &paper.links),
    }
}

pub(super) fn errors(v: Validation) -> JointErrors {
    JointErrors {
        sum: v.rms.iter().sum(),
        rms: v.rms,
        percent: v.percent,
    }
}

fn log_rms(log: &UsedLog, base: &DVector<f64>, physical: Option<&DVector<f64>>) -> LogRms {
    LogRms {
        name: log.report.file.clone(),
        base: errors(validate(&log.observation, base)),
        physical: physical.map(|p| errors(validate(&log.observation, p))),
    }
}

fn noise(robot: &Robot, found: &Estimate) -> Vec<NoiseDocument> {
    let one = |(joint, fit): (&crate::model::Joint, &crate::identification::JointFit)| NoiseDocument {
        joint: joint.name.clone(),
        residual_rms: fit.rms,
        noise_std: fit.noise_std,
        misfit: fit.misfit,
        rows: fit.rows,
        effective_rows: fit.effective_rows,
    };
    robot.joints().iter().zip(&found.joints).map(one).collect()
}
