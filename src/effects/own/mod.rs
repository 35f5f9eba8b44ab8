//! Effects that a user defines by a formula.
//!
//! `tau_j += f(q, qd, qdd; p)`, read by `parse`, held against its units by `units`. Parameters that f is linear in, all of them
//! together, are coefficients with columns `∂f/∂p`; the others are shape parameters with the range that the definition gives.

mod any_robot;
mod arm;
mod define;
mod derivative;
mod linear;
mod names;
mod parse;
#[cfg(test)]
mod tests;
mod tokens;
mod tree;
mod units;

pub use define::MOST_PARAMETERS;
pub use names::name_fault;
pub use tokens::{MOST_CHARACTERS, MOST_NESTED};

use self::derivative::derivative;
use self::tree::{Syntax, Tree, plain_sign};
use super::{About, Column, Effect, Formula, ParameterInfo, PlotVariable, Reads, Scene, Shape, Span, Travel};
use crate::model::Robot;
use nalgebra::DMatrix;
use std::f64::consts::{PI, TAU};

/// What the names of laws that the program found begin with: they are reported as laws.
pub const FOUND_LAW: &str = "law_";

/// What is said of every own effect.
pub const ABOUT: About = About {
    name: "Own effect",
    phrase: "an own effect",
    meaning: "A torque that a formula of yours adds to one joint. As a candidate it is tested like every effect; declared, it belongs to the model \
              from the start.",
    over: PlotVariable::Position,
    identifiable: "where its columns are no combination of those of the base parameters over the motion",
    rivals: &[],
    source: "the definition",
};

/// An own effect as a request or a robot has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// What findings call it.
    pub name: String,
    /// Name of the joint whose torque it adds to.
    pub joint: String,
    /// The torque that it adds [N·m or N], in `q1`, `qd1`, `qdd1`, … and the parameters.
    pub expression: String,
    /// Its parameters.
    pub parameters: Vec<ParameterDefinition>,
    /// Further measured quantities in the expression.
    pub channels: Vec<ChannelVariable>,
    /// Whether it is a part of the model from the start; otherwise the data decide.
    pub declared: bool,
}

/// A further measured quantity in an own effect, such as a temperature.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelVariable {
    /// Name of the channel, in the expression and in the log.
    pub name: String,
    /// Unit of its values.
    pub unit: String,
    /// Value that is taken along a motion that it was not measured on: a design, a log without it, an export.
    pub reference: f64,
}

/// A parameter of an own effect.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterDefinition {
    /// Name in the expression.
    pub name: String,
    /// SI unit in words; `1` for none.
    pub unit: String,
    /// Smallest value.
    pub low: Option<f64>,
    /// Largest value.
    pub high: Option<f64>,
}

/// What a symbol of a formula stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Symbol {
    /// A parameter of the definition.
    Parameter(usize),
    /// A further measured quantity.
    Channel(usize),
    /// Position (order 0), speed (1) or acceleration (2) of a joint.
    State { joint: usize, order: usize },
}

/// A shape parameter and where it is searched.
#[derive(Debug, Clone, PartialEq)]
struct OwnShape {
    parameter: usize,
    shape: Shape,
    /// Whether a turn more or less is the same: then it is reported between −π and π.
    turns: bool,
}

/// An effect with a formula of its own, checked against a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnEffect {
    definition: Definition,
    joint: usize,
    symbols: Vec<Symbol>,
    tree: Tree,
    /// Parameters that the formula is linear in.
    linear: Vec<usize>,
    /// One formula per coefficient.
    columns: Vec<Tree>,
    shapes: Vec<OwnShape>,
    /// Places of what is positive by its range, among coefficients, then shapes.
    positive: Vec<usize>,
}

/// Largest torque per unit of a coefficient that is computed with: squares of it stay far from the range of doubles.
const LARGEST: f64 = 1e12;

/// What stands for the symbols of a formula in source code.
pub struct SourceNames<'a> {
    /// Parameters, in the order in which they are reported.
    pub constants: &'a [String],
    /// Position (order 0), speed (1) or acceleration (2) of a joint.
    pub state: &'a dyn Fn(usize, usize) -> String,
    /// A further measured quantity.
    pub channel: &'a dyn Fn(&ChannelVariable) -> String,
}

/// A sample on which an own effect has no usable value.
#[derive(Debug, Clone, PartialEq)]
pub struct NotFinite {
    /// From 0.
    pub sample: usize,
    /// What the formula gives there.
    pub value: f64,
    /// Values of its variables and shape parameters there, in words.
    pub at: String,
}

impl OwnEffect {
    /// As it was defined.
    pub fn definition(&self) -> &Definition {
        &self.definition
    }

    /// Whether it is a part of the model from the start.
    pub fn is_declared(&self) -> bool {
        self.definition.declared
    }

    /// Joint whose torque it adds to, from 0.
    pub fn joint(&self) -> usize {
        self.joint
    }

    /// Number of parameters that it is linear in.
    pub fn coefficients(&self) -> usize {
        self.linear.len()
    }

    /// Whether it has parameters that it is not linear in.
    pub fn has_shapes(&self) -> bool {
        !self.shapes.is_empty()
    }

    /// Joints that it adds to or that its formula speaks of, from 0, in order.
    fn joints(&self) -> Vec<usize> {
        let spoken_of = self.symbols.iter().filter_map(|s| match s {
            Symbol::State { joint, .. } => Some(*joint),
            Symbol::Parameter(_) | Symbol::Channel(_) => None,
        });
        let all: std::collections::BTreeSet<usize> = spoken_of.chain([self.joint]).collect();
        all.into_iter().collect()
    }

    /// Parameters as they are reported: coefficients, then shapes.
    fn order(&self) -> impl Iterator<Item = usize> + '_ {
        self.linear.iter().copied().chain(self.shapes.iter().map(|s| s.parameter))
    }

    /// Values of a tree over the samples, with these shapes; coefficients are not in it.
    fn values(&self, tree: &Tree, scene: &Scene, shape: &[f64]) -> Vec<f64> {
        let sign = |v: f64, of: &Tree| match of.has(&|s| matches!(self.symbols[s], Symbol::State { order: 1, .. })) {
            true => scene.sign(v),
            false => plain_sign(v),
        };
        let at = |sample: usize| tree.value(&|s| self.symbol(s, scene, sample, shape), &sign);
        (0..scene.samples()).map(at).collect()
    }

    fn symbol(&self, symbol: usize, scene: &Scene, sample: usize, shape: &[f64]) -> f64 {
        match self.symbols[symbol] {
            Symbol::State { joint, order } => scene.motion.get(joint, sample)[order],
            Symbol::Channel(c) => {
                let channel = &self.definition.channels[c];
                let measured = scene.motion.channel(&channel.name);
                measured.map_or(channel.reference, |values| values[sample])
            }
            Symbol::Parameter(p) => self.shapes.iter().position(|s| s.parameter == p).map_or(0.0, |at| shape[at]),
        }
    }

    /// The first sample on which a column is no number, or beyond all bounds.
    pub fn not_finite(&self, scene: &Scene, shape: &[f64]) -> Option<NotFinite> {
        self.columns.iter().find_map(|tree| {
            let values = self.values(tree, scene, shape);
            let sample = values.iter().position(|v| !is_usable(*v))?;
            let used = |s: &usize| self.tree.has(&|t| t == *s) && !self.is_coefficient(*s);
            let named = |s: usize| format!("{} = {:.6}", self.name(s), self.symbol(s, scene, sample, shape));
            Some(NotFinite {
                sample,
                value: values[sample],
                at: (0..self.symbols.len()).filter(used).map(named).collect::<Vec<_>>().join(", "),
            })
        })
    }

    fn is_coefficient(&self, symbol: usize) -> bool {
        matches!(self.symbols[symbol], Symbol::Parameter(p) if self.linear.contains(&p))
    }

    /// All combinations of shapes that a search begins from.
    pub fn grid(&self) -> Vec<Vec<f64>> {
        self.shapes.iter().fold(vec![Vec::new()], |points, own| {
            let longer = |point: &Vec<f64>| {
                let point = point.clone();
                own.shape
                    .grid
                    .iter()
                    .map(move |v| [&point[..], &[*v]].concat())
                    .collect::<Vec<_>>()
            };
            points.iter().flat_map(longer).collect()
        })
    }

    fn name(&self, symbol: usize) -> String {
        match self.symbols[symbol] {
            Symbol::Parameter(p) => self.definition.parameters[p].name.clone(),
            Symbol::Channel(c) => self.definition.channels[c].name.clone(),
            Symbol::State { joint, order } => state_name(joint, order),
        }
    }

    /// The statement `f` for source code.
    pub fn source(&self, names: &SourceNames) -> String {
        self.written(&self.tree, names)
    }

    /// The same of `∂f/∂qdd_k`; `None` where it is zero, or depends on accelerations: then it is no entry of a mass matrix.
    pub fn inertia_source(&self, k: usize, names: &SourceNames) -> Option<String> {
        let of_acceleration = |s: usize| matches!(self.symbols[s], Symbol::State { order: 2, .. });
        let symbol = self.symbols.iter().position(|s| *s == Symbol::State { joint: k, order: 2 })?;
        let slope = derivative(&self.tree, symbol);
        (!slope.has(&of_acceleration)).then(|| self.written(&slope, names))
    }

    fn written(&self, tree: &Tree, names: &SourceNames) -> String {
        let name = |s: usize| match self.symbols[s] {
            Symbol::State { joint, order } => (names.state)(joint, order),
            Symbol::Channel(c) => (names.channel)(&self.definition.channels[c]),
            Symbol::Parameter(p) => self
                .order()
                .position(|o| o == p)
                .map_or_else(String::new, |at| names.constants[at].clone()),
        };
        tree.written(Syntax::Source, &name)
    }
}

fn is_usable(value: f64) -> bool {
    value.abs() < LARGEST
}

/// `q1`, `qd1`, `qdd1`.
fn state_name(joint: usize, order: usize) -> String {
    format!("q{}{}", "d".repeat(order), joint + 1)
}

impl Effect for OwnEffect {
    fn code(&self) -> &str {
        &self.definition.name
    }

    fn about(&self) -> About {
        ABOUT
    }

    fn reads(&self) -> Reads {
        let own = |s: &Symbol| {
            matches!(s, Symbol::Parameter(_) | Symbol::Channel(_))
                || matches!(s, Symbol::State { joint, .. } if *joint == self.joint)
        };
        if self.symbols.iter().all(own) {
            Reads::OwnJoints
        } else {
            Reads::Arm
        }
    }

    fn places(&self, _robot: &Robot) -> Vec<Vec<usize>> {
        vec![vec![self.joint]]
    }

    fn formula(&self, _form: usize, _joints: &[usize]) -> Option<Formula> {
        let mut variables: Vec<(usize, usize)> = self
            .symbols
            .iter()
            .filter_map(|s| match s {
                Symbol::State { joint, order } => Some((*joint, *order)),
                Symbol::Parameter(_) | Symbol::Channel(_) => None,
            })
            .collect();
        variables.sort_unstable();
        Some(Formula {
            torques: vec![(self.joint, self.tree.written(Syntax::Text, &|s| self.name(s)))],
            energy: None,
            variables: variables
                .into_iter()
                .map(|(joint, order)| state_name(joint, order))
                .chain(self.definition.channels.iter().map(|c| c.name.clone()))
                .collect(),
        })
    }

    fn shapes(&self, _form: usize, _joints: &[usize], _spans: &[Span]) -> Vec<Shape> {
        self.shapes.iter().map(|s| s.shape.clone()).collect()
    }

    /// A column that is no number somewhere is zero: it explains nothing, and a fit steps back from there.
    fn columns(&self, _form: usize, scene: &Scene, _joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let column = |tree: &Tree| {
            let values = self.values(tree, scene, shape);
            let usable = values.iter().all(|v| is_usable(*v));
            Column::on(self.joint, if usable { values } else { vec![0.0; scene.samples()] })
        };
        self.columns.iter().map(column).collect()
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        let info = |p: usize| {
            let parameter = &self.definition.parameters[p];
            ParameterInfo::new(&parameter.name, &parameter.unit)
        };
        self.order().map(info).collect()
    }

    fn positive(&self, _form: usize) -> &[usize] {
        &self.positive
    }

    /// Coefficients within their range, by three standard deviations.
    fn is_plausible(&self, coefficients: &[f64], covariance: &DMatrix<f64>, _travel: Travel) -> bool {
        let inside = |(at, (&p, &value)): (usize, (&usize, &f64))| {
            let parameter = &self.definition.parameters[p];
            let doubt = 3.0 * covariance[(at, at)].max(0.0).sqrt();
            parameter.low.is_none_or(|low| value + doubt >= low) && parameter.high.is_none_or(|high| value - doubt <= high)
        };
        self.linear.iter().zip(coefficients).enumerate().all(inside)
    }

    fn reported(&self, _form: usize, coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        let turned = |(own, value): (&OwnShape, &f64)| match own.turns {
            true => (value + PI).rem_euclid(TAU) - PI,
            false => *value,
        };
        let shapes = self.shapes.iter().zip(shape).map(turned);
        coefficients.iter().copied().chain(shapes).collect()
    }
}
