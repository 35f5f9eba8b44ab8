//! Formulas as trees, simplified as they are built.

use std::f64::consts::PI;
use std::sync::Arc;

/// A function of one argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// `−x`.
    Minus,
    /// `sin x`.
    Sin,
    /// `cos x`.
    Cos,
    /// `tan x`.
    Tan,
    /// `tanh x`.
    Tanh,
    /// `eˣ`.
    Exp,
    /// The natural logarithm.
    Ln,
    /// `√x`.
    Sqrt,
    /// `|x|`.
    Abs,
    /// −1, 0 or 1.
    Sign,
}

/// An operation on two values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// `a + b`.
    Add,
    /// `a − b`.
    Subtract,
    /// `a b`.
    Multiply,
    /// `a / b`.
    Divide,
    /// `aᵇ`.
    Power,
}

/// A formula. Symbols are numbers that whoever evaluates it gives a meaning.
#[derive(Debug, Clone, PartialEq)]
pub enum Tree {
    /// A constant.
    Number(f64),
    /// A variable or parameter.
    Symbol(usize),
    /// A function of one value.
    Of(Function, Arc<Tree>),
    /// An operation on two values.
    Pair(Operation, Arc<Tree>, Arc<Tree>),
}

impl Default for Tree {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl Function {
    /// Every function with the name that it is called by.
    pub const NAMED: [(&'static str, Self); 10] = [
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("tanh", Self::Tanh),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("log", Self::Ln),
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("sign", Self::Sign),
    ];

    /// The value of the function; a sign by `sign`, which may be smooth.
    pub fn at(self, x: f64, sign: &dyn Fn(f64) -> f64) -> f64 {
        match self {
            Self::Minus => -x,
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Sqrt => x.sqrt(),
            Self::Abs => x.abs(),
            Self::Sign => sign(x),
        }
    }
}

impl Operation {
    /// The value of the operation. A whole exponent multiplies, so that a negative base is no obstacle.
    pub fn at(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power if b.fract() == 0.0 && b.abs() <= 64.0 => a.powi(b as i32),
            Self::Power => a.powf(b),
        }
    }
}

/// −1, 0 or 1.
pub fn plain_sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

impl Tree {
    /// A function of a tree: its value where that is a number.
    pub fn of(function: Function, argument: Self) -> Self {
        match (function, argument) {
            (Function::Minus, Self::Of(Function::Minus, inner)) => Arc::unwrap_or_clone(inner),
            (f, Self::Number(x)) if f.at(x, &plain_sign).is_finite() => Self::Number(f.at(x, &plain_sign)),
            (f, argument) => Self::Of(f, Arc::new(argument)),
        }
    }

    /// An operation on two trees, without what changes nothing.
    pub fn pair(operation: Operation, a: Self, b: Self) -> Self {
        use Operation::{Add, Divide, Multiply, Power, Subtract};
        let is = |t: &Self, value: f64| *t == Self::Number(value);
        match operation {
            _ if let (Self::Number(x), Self::Number(y)) = (&a, &b)
                && operation.at(*x, *y).is_finite() =>
            {
                Self::Number(operation.at(*x, *y))
            }
            Add if is(&a, 0.0) => b,
            Add | Subtract if is(&b, 0.0) => a,
            Subtract if is(&a, 0.0) => Self::of(Function::Minus, b),
            Multiply if is(&a, 0.0) || is(&b, 0.0) => Self::Number(0.0),
            Divide if is(&a, 0.0) => Self::Number(0.0),
            Multiply if is(&a, 1.0) => b,
            Multiply | Divide | Power if is(&b, 1.0) => a,
            Power if is(&b, 0.0) => Self::Number(1.0),
            _ => Self::Pair(operation, Arc::new(a), Arc::new(b)),
        }
    }

    /// Whether a symbol is in it that `is` says yes to.
    pub fn has(&self, is: &dyn Fn(usize) -> bool) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Symbol(s) => is(*s),
            Self::Of(_, x) => x.has(is),
            Self::Pair(_, a, b) => a.has(is) || b.has(is),
        }
    }

    /// With trees in the place of symbols, simplified; a symbol without one stays.
    pub fn with(&self, put: &dyn Fn(usize) -> Option<Self>) -> Self {
        match self {
            Self::Number(_) => self.clone(),
            Self::Symbol(s) => put(*s).unwrap_or_else(|| self.clone()),
            Self::Of(f, x) => Self::of(*f, x.with(put)),
            Self::Pair(o, a, b) => Self::pair(*o, a.with(put), b.with(put)),
        }
    }

    /// Its value; a sign by `sign`, called with the argument and the tree that made it.
    pub fn value(&self, symbol: &dyn Fn(usize) -> f64, sign: &dyn Fn(f64, &Self) -> f64) -> f64 {
        match self {
            Self::Number(v) => *v,
            Self::Symbol(s) => symbol(*s),
            Self::Of(f, x) => f.at(x.value(symbol, sign), &|v| sign(v, x)),
            Self::Pair(o, a, b) => o.at(a.value(symbol, sign), b.value(symbol, sign)),
        }
    }
}

/// How powers, functions and constants are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Syntax {
    /// `q^2`, `abs(v)`: what is read again.
    Text,
    /// `pow(q, 2.0)`, `fabs(v)`, `log(x)`: C, and Python with functions of these names.
    Source,
}

/// What binds how strongly: sums and signs, products, powers, and what needs no parentheses.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const POWER: u8 = 3;
const WHOLE: u8 = 4;

impl Tree {
    /// As text, with `name` for symbols.
    pub fn written(&self, syntax: Syntax, name: &dyn Fn(usize) -> String) -> String {
        self.bound(syntax, name, SUM)
    }

    /// In parentheses where it binds less than `least`.
    fn bound(&self, syntax: Syntax, name: &dyn Fn(usize) -> String, least: u8) -> String {
        let (text, binds) = self.parts(syntax, name);
        if binds < least { format!("({text})") } else { text }
    }

    fn parts(&self, syntax: Syntax, name: &dyn Fn(usize) -> String) -> (String, u8) {
        use Operation::{Add, Divide, Multiply, Power, Subtract};
        let side = |t: &Self, least: u8| t.bound(syntax, name, least);
        match self {
            Self::Number(v) => (number(*v, syntax), if v.is_sign_negative() { SUM } else { WHOLE }),
            Self::Symbol(s) => (name(*s), WHOLE),
            Self::Of(Function::Minus, x) => (format!("-{}", side(x, PRODUCT)), SUM),
            Self::Of(f, x) => (format!("{}({})", function_name(*f, syntax), side(x, SUM)), WHOLE),
            Self::Pair(Add, a, b) => (format!("{} + {}", side(a, SUM), side(b, PRODUCT)), SUM),
            Self::Pair(Subtract, a, b) => (format!("{} - {}", side(a, SUM), side(b, PRODUCT)), SUM),
            Self::Pair(Multiply, a, b) => (format!("{}*{}", side(a, PRODUCT), side(b, POWER)), PRODUCT),
            Self::Pair(Divide, a, b) => (format!("{}/{}", side(a, PRODUCT), side(b, POWER)), PRODUCT),
            Self::Pair(Power, a, b) if syntax == Syntax::Source => (format!("pow({}, {})", side(a, SUM), side(b, SUM)), WHOLE),
            Self::Pair(Power, a, b) => (format!("{}^{}", side(a, WHOLE), side(b, WHOLE)), POWER),
        }
    }
}

fn number(value: f64, syntax: Syntax) -> String {
    match syntax {
        Syntax::Text if value == PI => "pi".into(),
        Syntax::Text => format!("{value}"),
        Syntax::Source => format!("{value:?}"),
    }
}

fn function_name(function: Function, syntax: Syntax) -> &'static str {
    match (function, syntax) {
        (Function::Abs, Syntax::Source) => "fabs",
        (Function::Ln, Syntax::Source) => "log",
        _ => Function::NAMED.iter().find(|n| n.1 == function).map_or("", |n| n.0),
    }
}
