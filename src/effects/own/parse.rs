//! From text to a tree, by the crate exmex: it computes with trees in the place of numbers.

use super::tokens::prepared;
use super::tree::{Function, Operation, Tree};
use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator, literal_matcher_from_pattern};
use std::num::ParseFloatError;
use std::str::FromStr;

literal_matcher_from_pattern!(Literal, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Operators of formulas, which build trees.
#[derive(Debug, Clone)]
struct Operators;

type Expression = FlatEx<Tree, Operators, Literal>;

impl FromStr for Tree {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(Self::Number)
    }
}

impl MakeOperators<Tree> for Operators {
    /// Operators of equal rank go from left to right.
    fn make<'a>() -> Vec<Operator<'a, Tree>> {
        let binary = |apply: fn(Tree, Tree) -> Tree, prio: i64| BinOp {
            apply,
            prio,
            is_commutative: false,
        };
        vec![
            Operator::make_bin_unary("+", binary(|a, b| Tree::pair(Operation::Add, a, b), 0), |a| a),
            Operator::make_bin_unary("-", binary(|a, b| Tree::pair(Operation::Subtract, a, b), 0), |a| {
                Tree::of(Function::Minus, a)
            }),
            Operator::make_bin("*", binary(|a, b| Tree::pair(Operation::Multiply, a, b), 1)),
            Operator::make_bin("/", binary(|a, b| Tree::pair(Operation::Divide, a, b), 1)),
            Operator::make_bin("^", binary(|a, b| Tree::pair(Operation::Power, a, b), 2)),
            Operator::make_unary("sin", |a| Tree::of(Function::Sin, a)),
            Operator::make_unary("cos", |a| Tree::of(Function::Cos, a)),
            Operator::make_unary("tan", |a| Tree::of(Function::Tan, a)),
            Operator::make_unary("tanh", |a| Tree::of(Function::Tanh, a)),
            Operator::make_unary("exp", |a| Tree::of(Function::Exp, a)),
            Operator::make_unary("ln", |a| Tree::of(Function::Ln, a)),
            Operator::make_unary("log", |a| Tree::of(Function::Ln, a)),
            Operator::make_unary("sqrt", |a| Tree::of(Function::Sqrt, a)),
            Operator::make_unary("abs", |a| Tree::of(Function::Abs, a)),
            Operator::make_unary("sign", |a| Tree::of(Function::Sign, a)),
            Operator::make_constant("pi", Tree::Number(std::f64::consts::PI)),
        ]
    }
}

/// A formula, and the names in it in the order of their symbols.
///
/// # Errors
/// What is wrong with the text, and the remedy.
pub fn parsed(text: &str) -> Result<(Tree, Vec<String>), (String, String)> {
    let plain = prepared(text)?;
    let wrong = |e: exmex::ExError| {
        (
            format!("is no formula: {e}"),
            "see the section on own effects in the documentation".to_string(),
        )
    };
    let expression = Expression::parse(&plain).map_err(wrong)?;
    let names = expression.var_names().to_vec();
    let symbols: Vec<Tree> = (0..names.len()).map(Tree::Symbol).collect();
    Ok((expression.eval(&symbols).map_err(wrong)?, names))
}
