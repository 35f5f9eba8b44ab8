//! From a definition to an effect, with everything that is wrong with it.

use super::arm::Arm;
use super::linear::{is_periodic, linear_set};
use super::names::{MOST_NAME, Said, name_fault, said};
use super::parse::parsed;
use super::tree::Tree;
use super::units::{Checked, Dimension, dimension};
use super::{Definition, OwnEffect, OwnShape, ParameterDefinition, Symbol, state_name};
use crate::effects::{Shape, is_reserved};
use crate::model::{FieldProblem, Robot};
use std::f64::consts::{PI, TAU};

/// Parameters of an effect; their sets are tried for linearity, two to this power.
pub const MOST_PARAMETERS: usize = 8;
/// Shape parameters: their grid is searched as a whole.
const MOST_SHAPES: usize = 3;
/// Points of the grid of each, by their number: the product is 144 at most.
const GRID: [usize; MOST_SHAPES] = [16, 12, 5];

impl OwnEffect {
    /// The effect on a robot.
    ///
    /// # Errors
    /// All that is wrong, with pointers into the definition (`/expression`, `/parameters/0/unit`, …) and remedies.
    pub fn new(definition: Definition, robot: &Robot) -> Result<Self, Vec<FieldProblem>> {
        Self::on(definition, &Arm::of(robot))
    }

    /// The effect on the joints of `arm`.
    pub(super) fn on(definition: Definition, arm: &Arm) -> Result<Self, Vec<FieldProblem>> {
        let mut found = Vec::new();
        check_name(&definition.name, &mut found);
        let joint = arm.place(&definition.joint);
        if joint.is_none() {
            let problem = FieldProblem::new("/joint", format!("the robot has no joint `{}`", definition.joint));
            found.push(problem.with_hint(format!("one of: {}", arm.names().join(", "))));
        }
        let dimensions = check_parameters(&definition.parameters, &mut found);
        check_channels(&definition, &mut found);
        // Their sets are tried one by one.
        if definition.parameters.len() > MOST_PARAMETERS {
            return Err(found);
        }
        let read = match parsed(&definition.expression) {
            Ok((tree, names)) => resolved(&definition, arm, &names, &mut found).map(|symbols| (tree, symbols)),
            Err((detail, hint)) => {
                found.push(FieldProblem::new("/expression", detail).with_hint(hint));
                None
            }
        };
        let (Some((tree, symbols)), Some(joint)) = (read, joint) else {
            return Err(found);
        };
        check_used(&definition, &tree, &symbols, &mut found);
        let raw = Raw {
            definition,
            joint,
            symbols,
            tree,
        };
        raw.check_units(arm, dimensions.as_deref(), &mut found);
        let effect = raw.effect(&mut found);
        match (found.is_empty(), effect) {
            (true, Some(effect)) => Ok(effect),
            _ => Err(found),
        }
    }
}

impl OwnEffect {
    /// Whether a unit can stand in a definition.
    pub(crate) fn knows_unit(unit: &str) -> bool {
        dimension(unit).is_ok()
    }
}

fn check_name(name: &str, found: &mut Vec<FieldProblem>) {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let first = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if !first || !name.chars().all(fits) || name.len() > MOST_NAME {
        let problem = FieldProblem::new("/name", "is no name of an effect");
        let hint = format!("a letter, then letters, digits, _ and -, {MOST_NAME} at most");
        found.push(problem.with_hint(hint));
    } else if is_reserved(name) {
        let problem = FieldProblem::new("/name", format!("`{name}` is an effect of the program"));
        found.push(problem.with_hint("give it another name"));
    }
}

fn check_channels(definition: &Definition, found: &mut Vec<FieldProblem>) {
    for (i, channel) in definition.channels.iter().enumerate() {
        let at = format!("/channels/{i}/name");
        let taken = definition.parameters.iter().any(|p| p.name == channel.name)
            || definition.channels[..i].iter().any(|c| c.name == channel.name);
        if let Some(detail) = name_fault(&channel.name) {
            found.push(FieldProblem::new(at, detail).with_hint("letters, digits and _, as in `columns.channels`"));
        } else if taken {
            let problem = FieldProblem::new(
                at,
                format!("`{}` is the name of a parameter or an earlier channel", channel.name),
            );
            found.push(problem.with_hint("give it another name"));
        }
    }
}

fn dimension_of(unit: &str) -> Dimension {
    dimension(unit).unwrap_or_default()
}

/// Checks names, units and ranges; the dimensions, where all units are known.
fn check_parameters(parameters: &[ParameterDefinition], found: &mut Vec<FieldProblem>) -> Option<Vec<Dimension>> {
    if parameters.len() > MOST_PARAMETERS {
        let detail = format!("has {} parameters, the most accepted is {MOST_PARAMETERS}", parameters.len());
        found.push(FieldProblem::new("/parameters", detail).with_hint("split the effect"));
        return None;
    }
    let mut dimensions = Vec::new();
    for (i, parameter) in parameters.iter().enumerate() {
        let at = |field: &str| format!("/parameters/{i}/{field}");
        let name = &parameter.name;
        if let Some(detail) = name_fault(name) {
            let hint = "a letter or _, then letters, digits and _; not q1, qd1, qdd1, pi or a function";
            found.push(FieldProblem::new(at("name"), detail).with_hint(hint));
        } else if parameters[..i].iter().any(|p| p.name == *name) {
            let problem = FieldProblem::new(at("name"), format!("`{name}` is the name of an earlier parameter"));
            found.push(problem.with_hint("give it another name"));
        }
        match dimension(&parameter.unit) {
            Ok(dimension) => dimensions.push(dimension),
            Err((detail, hint)) => found.push(FieldProblem::new(at("unit"), detail).with_hint(hint)),
        }
        if let (Some(low), Some(high)) = (parameter.low, parameter.high)
            && low >= high
        {
            let problem = FieldProblem::new(at("high"), format!("is {high}, not above `low` = {low}"));
            found.push(problem.with_hint("give low < high"));
        }
    }
    (dimensions.len() == parameters.len()).then_some(dimensions)
}

/// Order and place of the joint that a name speaks of.
fn state(name: &str, arm: &Arm, own: Option<usize>) -> Option<(usize, usize)> {
    match said(name)? {
        Said::Numbered { order, number } => {
            let joint = number.parse::<usize>().ok().filter(|k| (1..=arm.numbered()).contains(k))?;
            Some((order, joint - 1))
        }
        Said::Named { order, joint } => Some((order, arm.place(joint)?)),
        // Where the joint is wrong that is said of the joint.
        Said::Own { order } => Some((order, own.unwrap_or(0))),
    }
}

/// What every name stands for; `None` where one is unknown.
fn resolved(definition: &Definition, arm: &Arm, names: &[String], found: &mut Vec<FieldProblem>) -> Option<Vec<Symbol>> {
    let (n, own) = (arm.numbered(), arm.place(&definition.joint));
    let symbol = |name: &String| {
        if let Some(p) = definition.parameters.iter().position(|p| p.name == *name) {
            return Some(Symbol::Parameter(p));
        }
        if let Some(c) = definition.channels.iter().position(|c| c.name == *name) {
            return Some(Symbol::Channel(c));
        }
        let (order, joint) = state(name, arm, own)?;
        Some(Symbol::State { joint, order })
    };
    let symbols: Vec<Option<Symbol>> = names.iter().map(symbol).collect();
    for (name, _) in names.iter().zip(&symbols).filter(|(_, s)| s.is_none()) {
        let problem = FieldProblem::new("/expression", format!("`{name}` is neither a variable nor a parameter"));
        let hint = format!(
            "variables are q1 to q{n}, qd1 to qd{n}, qdd1 to qdd{n}, and q, qd, qdd of its own joint; list every other name in `parameters`"
        );
        found.push(problem.with_hint(hint));
    }
    symbols.into_iter().collect()
}

fn check_used(definition: &Definition, tree: &Tree, symbols: &[Symbol], found: &mut Vec<FieldProblem>) {
    let is_used = |p: usize| tree.has(&|s| symbols[s] == Symbol::Parameter(p));
    for (c, channel) in definition.channels.iter().enumerate() {
        if !tree.has(&|s| symbols[s] == Symbol::Channel(c)) {
            let detail = format!("`{}` changes nothing in the expression", channel.name);
            found.push(FieldProblem::new(format!("/channels/{c}/name"), detail).with_hint("use it, or take it away"));
        }
    }
    for (p, parameter) in definition.parameters.iter().enumerate().filter(|(p, _)| !is_used(*p)) {
        let detail = format!("`{}` changes nothing in the expression", parameter.name);
        found.push(FieldProblem::new(format!("/parameters/{p}/name"), detail).with_hint("use it, or take it away"));
    }
}

/// A formula with its symbols.
struct Raw {
    definition: Definition,
    joint: usize,
    symbols: Vec<Symbol>,
    tree: Tree,
}

impl Raw {
    fn symbol_of(&self, parameter: usize) -> Option<usize> {
        self.symbols.iter().position(|s| *s == Symbol::Parameter(parameter))
    }

    fn name(&self, symbol: usize) -> String {
        match self.symbols[symbol] {
            Symbol::Parameter(p) => self.definition.parameters[p].name.clone(),
            Symbol::Channel(c) => self.definition.channels[c].name.clone(),
            Symbol::State { joint, order } => state_name(joint, order),
        }
    }

    /// Complains at the first parameter whose unit would put it right, otherwise at the expression.
    fn check_units(&self, arm: &Arm, parameters: Option<&[Dimension]>, found: &mut Vec<FieldProblem>) {
        let Some(parameters) = parameters.filter(|_| arm.kinds_known) else {
            return;
        };
        let turns = |joint: usize| arm.turns(joint);
        let dimension = |s: &Symbol| match s {
            Symbol::Parameter(p) => parameters[*p],
            // A unit that is none of those known counts as a number.
            Symbol::Channel(c) => dimension_of(&self.definition.channels[*c].unit),
            Symbol::State { joint, order } => Dimension::of_state(turns(*joint), *order),
        };
        let symbols: Vec<Dimension> = self.symbols.iter().map(dimension).collect();
        let checked = Checked {
            tree: &self.tree,
            symbols: &symbols,
            channel: &|s| matches!(self.symbols[s], Symbol::Channel(_)),
            effort: Dimension::of_effort(turns(self.joint)),
            name: &|s| self.name(s),
        };
        let Some(fault) = checked.fault() else { return };
        let fitting = |p: usize| checked.solved(self.symbol_of(p)?).map(|unit| (p, unit));
        match (0..parameters.len()).find_map(fitting) {
            Some((p, unit)) => {
                let detail = format!("is `{}`: the expression {fault}", self.definition.parameters[p].unit);
                let hint = format!("{unit} would fit; angles count as 1");
                found.push(FieldProblem::new(format!("/parameters/{p}/unit"), detail).with_hint(hint));
            }
            None => {
                let hint = "no unit of one parameter alone would put it right";
                found.push(FieldProblem::new("/expression", fault).with_hint(hint));
            }
        }
    }

    /// The effect, unless it has no coefficient, or a shape has no range.
    fn effect(self, found: &mut Vec<FieldProblem>) -> Option<OwnEffect> {
        let count = self.definition.parameters.len();
        let symbols: Vec<usize> = (0..count).filter_map(|p| self.symbol_of(p)).collect();
        let linear = linear_set(&self.tree, &symbols, self.symbols.len());
        if linear.is_empty() {
            let problem = FieldProblem::new("/expression", "has no parameter that it is linear in, and zero without");
            found.push(problem.with_hint("multiply it with a factor: k*(…), with k among the parameters"));
            return None;
        }
        let parameter = |s: usize| match self.symbols[s] {
            Symbol::Parameter(p) => p,
            Symbol::State { .. } | Symbol::Channel(_) => unreachable!("only parameters were asked for"),
        };
        let bent: Vec<usize> = symbols.iter().copied().filter(|s| !linear.contains(s)).collect();
        if bent.len() > MOST_SHAPES {
            let names: Vec<String> = bent.iter().map(|&s| self.name(s)).collect();
            let detail = format!("is not linear in {}; the most accepted is {MOST_SHAPES}", names.join(", "));
            found.push(FieldProblem::new("/expression", detail).with_hint("give some of them as numbers"));
            return None;
        }
        let shapes: Vec<Option<OwnShape>> = bent.iter().map(|&s| self.shape(s, parameter(s), bent.len(), found)).collect();
        let shapes = shapes.into_iter().collect::<Option<Vec<_>>>()?;
        let one = |s: usize| move |t: usize| (t == s).then_some(Tree::Number(1.0));
        let column = |&s: &usize| {
            let others = |t: usize| one(s)(t).or_else(|| linear.contains(&t).then_some(Tree::Number(0.0)));
            self.tree.with(&others)
        };
        let columns = linear.iter().map(column).collect();
        let linear: Vec<usize> = linear.iter().map(|&s| parameter(s)).collect();
        let all = linear.iter().copied().chain(shapes.iter().map(|s| s.parameter));
        let not_negative = |p: usize| self.definition.parameters[p].low.is_some_and(|low| low >= 0.0);
        let positive = all.enumerate().filter(|(_, p)| not_negative(*p)).map(|(at, _)| at).collect();
        Some(OwnEffect {
            joint: self.joint,
            symbols: self.symbols,
            tree: self.tree,
            definition: self.definition,
            linear,
            columns,
            shapes,
            positive,
        })
    }

    /// Where a parameter that the formula is not linear in is searched. One of an angle goes round.
    fn shape(&self, symbol: usize, parameter: usize, shapes: usize, found: &mut Vec<FieldProblem>) -> Option<OwnShape> {
        let given = &self.definition.parameters[parameter];
        let count = GRID[shapes - 1];
        let own = |shape: Shape, turns: bool| Some(OwnShape { parameter, shape, turns });
        match (given.low, given.high) {
            (Some(low), Some(high)) if low > 0.0 && low < high => own(Shape::geometric(low, high, count), false),
            (Some(low), Some(high)) => own(even(low, high, count), false),
            (None, None) if given.unit.trim() == "rad" => {
                let turns = is_periodic(&self.tree, symbol, self.symbols.len());
                let mut shape = even(-PI, PI, count);
                if turns {
                    shape.grid.pop();
                    (shape.low, shape.high) = (-TAU, TAU);
                }
                own(shape, turns)
            }
            _ => {
                let missing = if given.low.is_none() { "low" } else { "high" };
                let detail = format!("is missing: the expression is not linear in `{}`", given.name);
                let problem = FieldProblem::new(format!("/parameters/{parameter}/{missing}"), detail);
                found.push(problem.with_hint("give the range that it is searched in, low and high"));
                None
            }
        }
    }
}

fn even(low: f64, high: f64, count: usize) -> Shape {
    let step = (high - low) / (count - 1) as f64;
    Shape {
        low,
        high,
        grid: (0..count).map(|i| low + i as f64 * step).collect(),
    }
}
