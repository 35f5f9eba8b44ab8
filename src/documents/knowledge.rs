//! What an excitation request knows beside the robot: a model with its effects, two rivals to tell apart, data and trajectories
//! there are already.

use super::augmented::{ReadModel, read_model_with_effects};
use super::cursor::{Cursor, Fields, Findings};
use super::requests;
use super::robot::{NamedRobots, read_robot_or_name};
use super::warm_start::read_trajectory;
use crate::diagnosis::{EffectColumns, RivalTerm, information_over};
use crate::excitation::{Added, Given, Hypothesis, Knowledge, Rivals};
use crate::model::{INPUT_LIMITS, Robot};
use crate::parameters::BaseParameters;
use crate::regression::{AugmentedModel, Term};
use nalgebra::DMatrix;
use serde_json::Value;
use std::sync::Arc;

/// Most entries of `given`. Each costs an information matrix over a period of its motion, or the reading of a model, before the
/// search begins; whoever has recorded more than this has them in fewer identifications.
pub const MOST_GIVEN: usize = 100;

/// An identified model with its robot.
#[derive(Debug, Clone)]
pub struct DesignModel {
    /// The robot of the model.
    pub robot: Robot,
    /// The model with its effects, and the covariance of its base parameters.
    pub read: ReadModel,
}

/// What the columns beside the regressor's are of.
#[derive(Debug, Clone, Default)]
pub struct DesignTerms {
    /// In the order of the columns.
    pub terms: Vec<Term>,
    /// Places of finding and rival among them.
    pub rivals: Option<[usize; 2]>,
    /// The model that the design is made for: its base values, and those of its effects that are no question.
    pub known: Option<AugmentedModel>,
}

/// Reads `model`: inline, or by the id of the identification that it is of.
pub(super) fn read_design_model(fields: &Fields, known: &dyn NamedRobots) -> Option<DesignModel> {
    let cursor = fields.nullable("model")?;
    read_model_of(&cursor, known)
}

fn read_model_of(cursor: &Cursor, known: &dyn NamedRobots) -> Option<DesignModel> {
    if cursor.value().get("identification").is_none() {
        return read_inline(cursor, known);
    }
    let id = cursor
        .fields_of::<requests::IdentificationReference>()?
        .required("identification")?;
    let Some(document) = known.model(id.string()?) else {
        id.complain_with(
            "is no identification with a model that is known here",
            "give the id of a finished identification, or its JSON model itself",
        );
        return None;
    };
    // It was written here: what is wrong with it is not the client's.
    let own = Findings::new(Vec::new());
    let read = read_inline(&Cursor::root(&document, &own), known);
    if read.is_none() || !own.is_empty() {
        id.complain_with(
            "has a model without its `augmented` part",
            "identify again with this version, with tracing on",
        );
    }
    read
}

fn read_inline(cursor: &Cursor, known: &dyn NamedRobots) -> Option<DesignModel> {
    let fields = cursor.fields_of::<requests::Model>()?;
    let robot = fields.required("robot").and_then(|c| read_robot_or_name(&c, known))?.robot;
    let read = fields
        .required("augmented")
        .and_then(|c| read_model_with_effects(&c, &robot))?;
    Some(DesignModel { robot, read })
}

/// Places of the two among the model's effects and that effect's rivals.
fn read_rivals(fields: &Fields, model: Option<&DesignModel>) -> Option<(usize, RivalTerm)> {
    let cursor = fields.nullable("rivals")?;
    let two = cursor.fields_of::<requests::Rivals>()?;
    let (finding, rival) = (two.required("finding")?, two.required("rival")?);
    if fields
        .nullable("criterion")
        .is_none_or(|c| c.value().as_str() != Some("rival_evidence"))
    {
        cursor.complain_with(
            "is for the criterion `rival_evidence`",
            "set `criterion`, or leave `rivals` out",
        );
        return None;
    }
    let Some(model) = model else {
        cursor.complain_with("needs the model that has them", "give `model`");
        return None;
    };
    let terms = &model.read.model.terms;
    let robot = &model.robot;
    let at = place(&finding, robot, terms.iter())?;
    let list = &model.read.rivals[at];
    let which = place(&rival, robot, list.iter().map(|r| &r.term))?;
    Some((at, list[which].clone()))
}

/// A place in a list of terms: its number, or effect and joints.
fn place<'t>(cursor: &Cursor, robot: &Robot, terms: impl Iterator<Item = &'t Term>) -> Option<usize> {
    let terms: Vec<&Term> = terms.collect();
    let names = |term: &Term| -> Vec<&str> { term.acts_on().iter().map(|&j| robot.joints()[j].name.as_str()).collect() };
    if terms.is_empty() {
        cursor.complain_with(
            "is asked for, and the model holds none",
            "a model has the effects that held-out data do not reject, and of each the rivals that the data do not exclude: there is nothing to decide \
             between here",
        );
        return None;
    }
    if cursor.value().is_number() {
        return cursor.whole(0, terms.len() as u64 - 1).map(|n| n as usize);
    }
    let fields = cursor.fields_of::<requests::EffectPlace>()?;
    let effect = fields.required("effect")?.string()?;
    let joints: Vec<&str> = match fields.nullable("joints") {
        Some(list) => {
            let items = list.items_up_to(INPUT_LIMITS.joints, "joints")?;
            items.iter().filter_map(|c| c.string()).collect()
        }
        None => Vec::new(),
    };
    // A finding of the whole robot names all joints, its term none.
    let fits = |t: &&Term| t.effect.code() == effect && (t.joints.is_empty() || joints.is_empty() || names(t) == joints);
    let found = terms.iter().position(fits);
    if found.is_none() {
        let offered: Vec<String> = terms
            .iter()
            .map(|t| format!("{} on {:?}", t.effect.code(), names(t)))
            .collect();
        cursor.complain_with(
            format!("is `{effect}` on {joints:?}, which the model does not hold there"),
            format!("it holds {}", offered.join(", ")),
        );
    }
    found
}

/// Everything of the request that the information matrix holds beside one period of `Y_b`.
pub(super) fn read_knowledge(
    fields: &Fields,
    known: &dyn NamedRobots,
    robot: &Robot,
    model: Option<&DesignModel>,
) -> (Knowledge, DesignTerms) {
    let rivals = read_rivals(fields, model);
    let base = BaseParameters::exact(robot);
    let mut terms = DesignTerms::default();
    let mut knowledge = Knowledge::default();
    if let Some(model) = model {
        if !same_parameters(&model.robot, robot) {
            let pointer = fields.pointer_to("model");
            fields.complain_at(
                &pointer,
                "is of an arm with other joints or other declared friction than `robot`",
            );
            return (knowledge, terms);
        }
        let own = &model.read.model;
        let open = rivals.as_ref().map(|(at, _)| *at);
        let settled = own.terms.iter().enumerate().filter(|(at, _)| Some(*at) != open);
        terms.known = Some(AugmentedModel {
            terms: settled.map(|(_, term)| term.clone()).collect(),
            ..own.clone()
        });
        let bare = AugmentedModel {
            terms: Vec::new(),
            ..own.clone()
        };
        let mut sources: Vec<(Term, AugmentedModel)> = own.terms.iter().map(|t| (t.clone(), bare.clone())).collect();
        if let Some((_, rival)) = &rivals {
            let beside = AugmentedModel {
                values: rival.base_values.clone(),
                ..bare
            };
            sources.push((rival.term.clone(), beside));
        }
        terms.terms = sources.iter().map(|s| s.0.clone()).collect();
        let borrowed: Vec<(Term, &AugmentedModel)> = sources.iter().map(|(t, m)| (t.clone(), m)).collect();
        if !borrowed.is_empty() {
            knowledge.added = Some(Added(Arc::new(EffectColumns::new(robot, &borrowed))));
        }
        if let Some((at, _)) = &rivals {
            let last = terms.terms.len() - 1;
            terms.rivals = Some([*at, last]);
            knowledge.rivals = Some(Rivals {
                finding: hypothesis(&terms.terms, *at, last),
                rival: hypothesis(&terms.terms, last, *at),
                recorded: Some(known_of(model, &base, &terms.terms)),
                nested: [false; 2],
            });
        }
    }
    let given = fields.nullable("given").and_then(|c| given_items(&c)).unwrap_or_default();
    let read = given.iter().filter_map(|c| read_given(c, known, robot, &base, &terms.terms));
    knowledge.given = read.collect();
    let most = 1_000_000;
    knowledge.periods = fields.nullable("periods").and_then(|c| c.whole(1, most)).unwrap_or(1) as f64;
    (knowledge, terms)
}

/// Whether standard parameters of one are those of the other, in the same places.
fn same_parameters(one: &Robot, other: &Robot) -> bool {
    names_of(one) == names_of(other) && one.friction() == other.friction()
}

fn names_of(robot: &Robot) -> Vec<&str> {
    robot.joints().iter().map(|j| j.name.as_str()).collect()
}

/// Columns of a term, and what stands on them, where it competes with another. As in tracing, one that comes to the other where
/// its parameters go to a limit competes as a real thing only.
fn hypothesis(terms: &[Term], at: usize, other: usize) -> Hypothesis {
    let first = terms[..at].iter().map(Term::parameters).sum::<usize>();
    let (term, other) = (&terms[at], &terms[other]);
    let contains = term.effect.contains().contains(&other.effect.code()) && term.joints == other.joints;
    let coefficients = match contains {
        true => term.effect.brought_within_reach(&term.coefficients),
        false => term.coefficients.clone(),
    };
    let values = match coefficients.is_empty() {
        // A distortion: its parameters themselves.
        true => term.shape[..term.free_shapes].to_vec(),
        false => coefficients.into_iter().chain(vec![0.0; term.free_shapes]).collect(),
    };
    Hypothesis {
        columns: first..first + term.parameters(),
        values,
        borders: if contains { term.effect.borders() } else { Vec::new() },
    }
}

/// What the data of an identification say of the columns of a design.
fn known_of(model: &DesignModel, base: &BaseParameters, wanted: &[Term]) -> DMatrix<f64> {
    let read = &model.read;
    let mut terms = read.model.terms.clone();
    let mut information = read.prior.information.clone();
    let is_new = |r: &&RivalTerm| {
        let same = |t: &Term| t.effect.code() == r.term.effect.code() && t.joints == r.term.joints && t.form == r.term.form;
        wanted.iter().any(same) && !read.model.terms.iter().any(same)
    };
    // What one rival does beside another was not kept; a design has one.
    if let Some(rival) = read.rivals.iter().flatten().find(is_new) {
        let (p, k) = (information.nrows(), rival.own.nrows());
        information = information.resize(p + k, p + k, 0.0);
        information.view_mut((0, p), (p, k)).copy_from(&rival.cross);
        information.view_mut((p, 0), (k, p)).copy_from(&rival.cross.transpose());
        information.view_mut((p, p), (k, k)).copy_from(&rival.own);
        terms.push(rival.term.clone());
    }
    information_over(&read.model.base, &terms, &information, base, wanted)
}

/// The entries of `given`, none of them read where there are too many.
fn given_items<'a>(cursor: &Cursor<'a>) -> Option<Vec<Cursor<'a>>> {
    let items = cursor.items()?;
    if items.len() > MOST_GIVEN {
        cursor.complain_with(
            format!("has {} entries, at most {MOST_GIVEN} are taken", items.len()),
            "identify several logs together and give that identification, which holds what all of them say; \
             or give one entry with its `periods` where the same motion was recorded again",
        );
        return None;
    }
    Some(items)
}

fn read_given(cursor: &Cursor, known: &dyn NamedRobots, robot: &Robot, base: &BaseParameters, wanted: &[Term]) -> Option<Given> {
    let value = cursor.value();
    if value.get("identification").is_some() || value.get("robot").is_some() {
        let model = read_model_of(cursor, known)?;
        if !same_parameters(&model.robot, robot) {
            cursor.complain("is of an arm with other joints or other declared friction than `robot`");
            return None;
        }
        return Some(Given::Information(known_of(&model, base, wanted)));
    }
    let (series, periods) = match value.get("excitation").is_some() {
        true => read_given_design(cursor, known, robot)?,
        false => {
            let fields = cursor.fields_of::<requests::GivenTrajectory>()?;
            let series = read_trajectory(cursor, &fields, Some(robot.joint_count()));
            (series?, read_periods(&fields))
        }
    };
    Some(Given::Motion { series, periods })
}

fn read_periods(fields: &Fields) -> f64 {
    fields.nullable("periods").and_then(|c| c.whole(1, 1_000_000)).unwrap_or(1) as f64
}

fn read_given_design(cursor: &Cursor, known: &dyn NamedRobots, robot: &Robot) -> Option<(crate::trajectory::FourierSeries, f64)> {
    let fields = cursor.fields_of::<requests::GivenDesign>()?;
    let id = fields.required("excitation")?;
    let periods = read_periods(&fields);
    let Some(document) = known.design(id.string()?) else {
        id.complain_with(
            "is no design with a trajectory that is known here",
            "give the id of a finished POST /excitation, or coefficients, offset and fundamental_hz themselves",
        );
        return None;
    };
    let part = |name: &str| (name.to_string(), document[name].clone());
    let trajectory = Value::Object(["coefficients", "offset", "fundamental_hz"].map(part).into_iter().collect());
    let own = Findings::new(Vec::new());
    let root = Cursor::root(&trajectory, &own);
    let read = root
        .fields_of::<requests::GivenTrajectory>()
        .and_then(|f| read_trajectory(&root, &f, Some(robot.joint_count())));
    if read.is_none() {
        id.complain("is a design for another robot, or one that ended without a trajectory");
    }
    read.map(|series| (series, periods))
}

#[cfg(test)]
mod tests {
    use super::MOST_GIVEN;
    use crate::documents::read_excitation_request;
    use crate::documents::shipped::Shipped;
    use crate::formats::parse;
    use serde_json::json;

    fn findings(entries: usize) -> Vec<String> {
        let request = json!({"robot": "planar_two_link", "fourier": {"order": 3, "fundamental_hz": 0.2}, "sample_rate_hz": 50,
            "given": vec![json!({"excitation": "nothing"}); entries]});
        let parsed = parse(request.to_string().as_bytes()).unwrap();
        let errors = read_excitation_request(&parsed, &Shipped).unwrap_err();
        errors.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn regress_what_is_given_is_bounded() {
        // Every entry is looked at up to the bound, and none beyond it.
        assert!(
            findings(MOST_GIVEN)
                .iter()
                .all(|f| f.contains("is no design with a trajectory"))
        );
        assert_eq!(findings(MOST_GIVEN).len(), MOST_GIVEN);
        let beyond = findings(MOST_GIVEN + 1);
        assert_eq!(beyond.len(), 1, "{beyond:?}");
        let expected = "/given: has 101 entries, at most 100 are taken (identify several logs together";
        assert!(beyond[0].starts_with(expected), "{beyond:?}");
    }
}
