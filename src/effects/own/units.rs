//! Units of an own effect: words as dimensions, and whether a formula is a torque.

use super::tree::{Function, Operation, Tree};
use exmex::{BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator, literal_matcher_from_pattern};
use std::num::ParseFloatError;
use std::ops::{Add, Mul, Sub};
use std::str::FromStr;

/// Exponents of kg, m, s, A, K. Angles have none: `N m/rad` is the dimension of `N m`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dimension([f64; 5]);

const BASES: [&str; 5] = ["kg", "m", "s", "A", "K"];

/// Units that may be named, all of factor one, with their exponents.
const UNITS: [(&str, [f64; 5]); 13] = [
    ("kg", [1.0, 0.0, 0.0, 0.0, 0.0]),
    ("m", [0.0, 1.0, 0.0, 0.0, 0.0]),
    ("s", [0.0, 0.0, 1.0, 0.0, 0.0]),
    ("A", [0.0, 0.0, 0.0, 1.0, 0.0]),
    ("K", [0.0, 0.0, 0.0, 0.0, 1.0]),
    ("rad", [0.0; 5]),
    ("N", [1.0, 1.0, -2.0, 0.0, 0.0]),
    ("J", [1.0, 2.0, -2.0, 0.0, 0.0]),
    ("W", [1.0, 2.0, -3.0, 0.0, 0.0]),
    ("Pa", [1.0, -1.0, -2.0, 0.0, 0.0]),
    ("V", [1.0, 2.0, -3.0, -1.0, 0.0]),
    ("Hz", [0.0, 0.0, -1.0, 0.0, 0.0]),
    ("degC", [0.0, 0.0, 0.0, 0.0, 1.0]),
];

impl Dimension {
    /// Of a position of order 0, a speed of order 1, an acceleration of order 2; of an angle, or of a length.
    pub fn of_state(revolute: bool, order: usize) -> Self {
        Self([0.0, f64::from(u8::from(!revolute)), -(order as f64), 0.0, 0.0])
    }

    /// Of the effort of a joint: a torque, or a force.
    pub fn of_effort(revolute: bool) -> Self {
        Self([1.0, 1.0 + f64::from(u8::from(revolute)), -2.0, 0.0, 0.0])
    }

    fn is_none(self) -> bool {
        self.0.iter().all(|e| e.abs() < 1e-9)
    }
}

impl Add for Dimension {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Dimension {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f64> for Dimension {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self(self.0.map(|e| e * by))
    }
}

/// With forces as N: `N m`, `N s/m`, `1`.
impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let forces = self.0[0];
        let rest = *self - Self([1.0, 1.0, -2.0, 0.0, 0.0]) * forces;
        let all = std::iter::once(("N", forces)).chain(BASES.into_iter().zip(rest.0).skip(1));
        let all: Vec<(&str, f64)> = all.filter(|(_, e)| e.abs() > 1e-9).collect();
        let raised = |(unit, e): &(&str, f64)| match e.abs() {
            1.0 => (*unit).to_string(),
            e => format!("{unit}^{e}"),
        };
        let [above, below] = [1.0, -1.0].map(|sign| {
            let own = all.iter().filter(|(_, e)| e * sign > 0.0);
            own.map(raised).collect::<Vec<_>>()
        });
        let above = if above.is_empty() { "1".to_string() } else { above.join(" ") };
        match &below[..] {
            [] => f.write_str(&above),
            [one] => write!(f, "{above}/{one}"),
            more => write!(f, "{above}/({})", more.join(" ")),
        }
    }
}

/// A number with a dimension, which units are computed with.
#[derive(Debug, Clone, Default)]
struct Quantity {
    dimension: Dimension,
    number: f64,
}

impl FromStr for Quantity {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let dimension = Dimension::default();
        text.parse().map(|number| Self { dimension, number })
    }
}

#[derive(Debug, Clone)]
struct UnitOperators;

literal_matcher_from_pattern!(Exponent, r"^[0-9]+(\.[0-9]+)?");

impl MakeOperators<Quantity> for UnitOperators {
    fn make<'a>() -> Vec<Operator<'a, Quantity>> {
        let binary = |apply: fn(Quantity, Quantity) -> Quantity, prio: i64| BinOp {
            apply,
            prio,
            is_commutative: false,
        };
        vec![
            Operator::make_bin("*", binary(|a, b| product(&a, &b, 1.0), 0)),
            Operator::make_bin("/", binary(|a, b| product(&a, &b, -1.0), 0)),
            Operator::make_bin(
                "^",
                binary(
                    |a, b| Quantity {
                        dimension: a.dimension * b.number,
                        number: a.number.powf(b.number),
                    },
                    1,
                ),
            ),
            Operator::make_unary("-", |a| Quantity { number: -a.number, ..a }),
        ]
    }
}

fn product(a: &Quantity, b: &Quantity, power: f64) -> Quantity {
    Quantity {
        dimension: a.dimension + b.dimension * power,
        number: a.number * b.number.powf(power),
    }
}

/// Characters of a unit.
const MOST_CHARACTERS: usize = 40;

/// The dimension of a unit in words: `N m/rad`, `N m s^2/(rad^2)`, `1`.
///
/// # Errors
/// What is wrong with it, and the remedy.
pub fn dimension(unit: &str) -> Result<Dimension, (String, String)> {
    let hint = || "write SI units without prefixes, factors side by side: N m/rad, N m s/rad, N, rad, 1".to_string();
    let fits = |c: char| c.is_ascii_alphanumeric() || " ^/()-.·*".contains(c);
    if unit.trim().is_empty() || unit.chars().count() > MOST_CHARACTERS || !unit.chars().all(fits) {
        return Err((format!("is `{}`, no unit", shortened(unit)), hint()));
    }
    let parsed = FlatEx::<Quantity, UnitOperators, Exponent>::parse(&side_by_side(unit))
        .map_err(|_| (format!("is `{unit}`, no unit"), hint()))?;
    let mut values = Vec::new();
    for name in parsed.var_names() {
        let Some((_, exponents)) = UNITS.iter().find(|(known, _)| known == name) else {
            return Err((
                format!("is `{unit}`: `{name}` is not known"),
                remedy(name).unwrap_or_else(hint),
            ));
        };
        values.push(Quantity {
            dimension: Dimension(*exponents),
            number: 1.0,
        });
    }
    let quantity = parsed.eval(&values).map_err(|_| (format!("is `{unit}`, no unit"), hint()))?;
    match quantity.number == 1.0 && quantity.dimension.0.iter().all(|e| e.is_finite()) {
        true => Ok(quantity.dimension),
        false => Err((format!("is `{unit}`: it has a factor"), hint())),
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(MOST_CHARACTERS).collect()
}

fn remedy(name: &str) -> Option<String> {
    let instead = [
        ("Nm", "N m"),
        ("nm", "N m"),
        ("deg", "rad"),
        ("mm", "m"),
        ("cm", "m"),
        ("ms", "s"),
        ("kN", "N"),
        ("mNm", "N m"),
        ("g", "kg"),
        ("rpm", "rad/s"),
        ("bar", "Pa"),
        ("radians", "rad"),
    ];
    let known = instead.iter().find(|(wrong, _)| *wrong == name);
    known.map(|(_, right)| format!("write {right}"))
}

/// Products that are written side by side, with `*` between them.
fn side_by_side(unit: &str) -> String {
    let plain = unit.replace(['·', '*'], " ");
    let mut text = String::new();
    for word in plain
        .replace('(', " ( ")
        .replace(')', " ) ")
        .replace('/', " / ")
        .replace('^', " ^ ")
        .split_whitespace()
    {
        let operator = |c: char| "/^(".contains(c);
        if !text.is_empty() && !text.ends_with(operator) && !"/^)".contains(word) {
            text.push('*');
        }
        text.push_str(word);
    }
    text
}

/// What a part of a formula has: a dimension, and how often the unknown one.
#[derive(Debug, Clone, Copy)]
struct Found {
    known: Dimension,
    unknown: f64,
}

/// Something that has no dimension if the formula is a torque.
struct Condition {
    found: Found,
    why: String,
}

/// A formula whose units are looked at.
pub struct Checked<'a> {
    /// The formula.
    pub tree: &'a Tree,
    /// Dimension of every symbol.
    pub symbols: &'a [Dimension],
    /// Whether a symbol is a further measured quantity: a number that is added to one is in its unit, as the 22 in
    /// `temperature - 22`.
    pub channel: &'a dyn Fn(usize) -> bool,
    /// What it is to have.
    pub effort: Dimension,
    /// Names of symbols.
    pub name: &'a dyn Fn(usize) -> String,
}

impl Checked<'_> {
    /// What is wrong with the units; `None` where they fit.
    pub fn fault(&self) -> Option<String> {
        let wrong = |c: &Condition| c.found.unknown != 0.0 || !c.found.known.is_none();
        self.conditions(None).into_iter().find(wrong).map(|c| c.why)
    }

    /// The dimension of a symbol with which all units fit.
    pub fn solved(&self, symbol: usize) -> Option<Dimension> {
        let conditions = self.conditions(Some(symbol));
        let first = conditions.iter().find(|c| c.found.unknown != 0.0)?;
        let dimension = first.found.known * (-1.0 / first.found.unknown);
        let fits = |c: &Condition| (c.found.known + dimension * c.found.unknown).is_none();
        conditions.iter().all(fits).then_some(dimension)
    }

    fn conditions(&self, unknown: Option<usize>) -> Vec<Condition> {
        let mut list = Vec::new();
        let all = self.found(self.tree, unknown, &mut list);
        list.push(Condition {
            why: format!("has the unit {}, expected {}", all.known, self.effort),
            found: Found {
                known: all.known - self.effort,
                ..all
            },
        });
        list
    }

    fn found(&self, tree: &Tree, unknown: Option<usize>, list: &mut Vec<Condition>) -> Found {
        let none = Found {
            known: Dimension::default(),
            unknown: 0.0,
        };
        let text = |t: &Tree| t.written(super::tree::Syntax::Text, self.name);
        match tree {
            Tree::Number(_) => none,
            Tree::Symbol(s) if Some(*s) == unknown => Found { unknown: 1.0, ..none },
            Tree::Symbol(s) => Found {
                known: self.symbols[*s],
                ..none
            },
            Tree::Of(f, x) => {
                let inner = self.found(x, unknown, list);
                match f {
                    Function::Minus | Function::Abs => inner,
                    Function::Sqrt => scaled(inner, 0.5),
                    Function::Sign => none,
                    _ => {
                        list.push(Condition {
                            found: inner,
                            why: format!(
                                "`{}`: the argument has the unit {}, expected 1 or rad",
                                text(tree),
                                inner.known
                            ),
                        });
                        none
                    }
                }
            }
            Tree::Pair(o, a, b) => {
                let (left, right) = (self.found(a, unknown, list), self.found(b, unknown, list));
                let channel = |t: &Tree| matches!(t, Tree::Symbol(s) if (self.channel)(*s));
                let number = |t: &Tree| matches!(t, Tree::Number(_));
                match (o, &**b) {
                    (Operation::Add | Operation::Subtract, _) if channel(a) && number(b) => left,
                    (Operation::Add | Operation::Subtract, _) if number(a) && channel(b) => right,
                    (Operation::Multiply, _) => together(left, right, 1.0),
                    (Operation::Divide, _) => together(left, right, -1.0),
                    (Operation::Power, Tree::Number(exponent)) => scaled(left, *exponent),
                    (Operation::Power, _) => {
                        for (found, part) in [(left, a), (right, b)] {
                            list.push(Condition {
                                found,
                                why: format!("`{}` in a power has the unit {}, expected 1 or rad", text(part), found.known),
                            });
                        }
                        none
                    }
                    _ => {
                        list.push(Condition {
                            found: together(left, right, -1.0),
                            why: format!("adds `{}` ({}) and `{}` ({})", text(a), left.known, text(b), right.known),
                        });
                        left
                    }
                }
            }
        }
    }
}

fn scaled(found: Found, by: f64) -> Found {
    Found {
        known: found.known * by,
        unknown: found.unknown * by,
    }
}

fn together(a: Found, b: Found, sign: f64) -> Found {
    Found {
        known: a.known + b.known * sign,
        unknown: a.unknown + b.unknown * sign,
    }
}
