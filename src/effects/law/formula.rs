//! Laws as text: the formula of every joint it acts on, its energy where it has one, and statements for source code.

use super::form::LawForm;
use super::functions::{OfPosition, OfSpeed};
use crate::effects::Formula;

/// How powers and absolute values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Syntax {
    /// `q^2`, `abs(v)`.
    Text,
    /// `pow(q, 2.0)`, `fabs(v)`: C, and Python with functions of these names.
    Source,
}

/// What a formula is written with.
struct Writer<'a> {
    syntax: Syntax,
    q: &'a dyn Fn(usize) -> String,
    v: &'a dyn Fn(usize) -> String,
    constants: &'a [String],
}

impl LawForm {
    /// Names of the constants, in the order in which they are reported.
    pub(super) fn constants(self) -> &'static [&'static str] {
        match self {
            Self::Position(OfPosition::Wave(_))
            | Self::Product {
                f: OfPosition::Wave(_), ..
            }
            | Self::CrossProduct {
                f: OfPosition::Wave(_), ..
            }
            | Self::Combination {
                f: OfPosition::Wave(_), ..
            }
            | Self::HalfCombination {
                f: OfPosition::Wave(_), ..
            } => &["a", "phi"],
            Self::PinSpring => &["a", "b", "phi", "rho"],
            Self::Spring { rest: false } => &["k", "r"],
            Self::Spring { rest: true } => &["k", "r", "c"],
            Self::Bilinear | Self::CrossPosition => &["k"],
            Self::Damper => &["c", "r"],
            Self::CrossSpeed(_) | Self::SpeedProduct(_) => &["c"],
            Self::SoftStop { .. } => &["a", "c", "s"],
            Self::Saturating => &["a", "r", "c"],
            _ => &["a"],
        }
    }
}

/// The formula of a form on its place.
pub fn formula(form: LawForm, joints: &[usize]) -> Formula {
    let constants: Vec<String> = form.constants().iter().map(ToString::to_string).collect();
    let writer = Writer {
        syntax: Syntax::Text,
        q: &|j| format!("q{}", j + 1),
        v: &|j| format!("qd{}", j + 1),
        constants: &constants,
    };
    let (torques, energy) = (writer.torques(form, joints), writer.energy(form, joints));
    let mut variables = Vec::new();
    let mut places = joints.to_vec();
    places.sort_unstable();
    for name in places.iter().flat_map(|&j| [(writer.q)(j), (writer.v)(j)]) {
        if torques.iter().any(|(_, text)| mentions(text, &name)) && !variables.contains(&name) {
            variables.push(name);
        }
    }
    Formula {
        torques,
        energy,
        variables,
    }
}

/// Whether a name stands in a text as a whole word: `q1` is not in `q12`, nor in `qd1`.
fn mentions(text: &str, name: &str) -> bool {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.split(|c: char| !word(c)).any(|w| w == name)
}

/// `(joint, value)` to be added to the torques, with numbers for the constants (as
/// [`Effect::reported`](crate::effects::Effect::reported) has them).
pub fn statements(
    form: LawForm,
    joints: &[usize],
    constants: &[String],
    q: &dyn Fn(usize) -> String,
    v: &dyn Fn(usize) -> String,
) -> Vec<(usize, String)> {
    let writer = Writer {
        syntax: Syntax::Source,
        q,
        v,
        constants,
    };
    writer.torques(form, joints)
}

impl Writer<'_> {
    fn power(&self, x: &str, n: u8) -> String {
        match (n, self.syntax) {
            (1, _) => x.to_string(),
            (_, Syntax::Text) => format!("{x}^{n}"),
            (_, Syntax::Source) => format!("pow({x}, {n}.0)"),
        }
    }

    fn absolute(&self, x: &str) -> String {
        match self.syntax {
            Syntax::Text => format!("abs({x})"),
            Syntax::Source => format!("fabs({x})"),
        }
    }

    fn root(&self, x: &str) -> String {
        match self.syntax {
            Syntax::Text => format!("sqrt({x})"),
            Syntax::Source => format!("pow({x}, 0.5)"),
        }
    }

    /// Small whole numbers: in source with a point, so that they are no integers there.
    fn number(&self, n: i64) -> String {
        match self.syntax {
            Syntax::Text => n.to_string(),
            Syntax::Source => format!("{n}.0"),
        }
    }

    /// `n x`.
    fn times(&self, n: u8, x: &str) -> String {
        match n {
            1 => x.to_string(),
            _ => format!("{}*{x}", self.number(i64::from(n))),
        }
    }

    /// `a q_i + b q_k`.
    fn combination(&self, [a, b]: [i8; 2], joints: &[usize]) -> String {
        let first = self.times(a.unsigned_abs(), &(self.q)(joints[0]));
        let second = self.times(b.unsigned_abs(), &(self.q)(joints[1]));
        format!("{first} {} {second}", if b < 0 { "-" } else { "+" })
    }

    /// A function of `x` with its constants, the first of which is the factor before it.
    fn of_position(&self, f: OfPosition, x: &str) -> String {
        let c = self.constants;
        match f {
            OfPosition::Power(n) => format!("{}*{}", c[0], self.power(x, n)),
            OfPosition::Sine(n) => format!("{}*sin({})", c[0], self.times(n, x)),
            OfPosition::Cosine(n) => format!("{}*cos({})", c[0], self.times(n, x)),
            OfPosition::Wave(n) => format!("{}*sin({} + {})", c[0], self.times(n, x), c[1]),
        }
    }

    fn of_speed(&self, g: OfSpeed, v: &str) -> String {
        match g {
            OfSpeed::Linear => v.to_string(),
            OfSpeed::Sign => format!("sign({v})"),
            OfSpeed::Absolute => self.absolute(v),
            OfSpeed::Quadratic => format!("{v}*{}", self.absolute(v)),
        }
    }

    fn torques(&self, form: LawForm, joints: &[usize]) -> Vec<(usize, String)> {
        let (first, last) = (joints[0], joints[joints.len() - 1]);
        let (q, v, c) = (&self.q, &self.v, self.constants);
        let own = |text: String| vec![(first, text)];
        let gradient = |force: String, ratio: &str| vec![(first, force.clone()), (last, format!("{ratio}*{force}"))];
        match form {
            LawForm::Position(f) => own(self.of_position(f, &q(first))),
            LawForm::PinSpring => {
                let u = format!("{} + {}", q(first), c[2]);
                let inside = format!("{} - {}*cos({u})", self.number(1), c[3]);
                own(format!("{}*sin({u}) + {}*sin({u})/{}", c[0], c[1], self.root(&inside)))
            }
            LawForm::Spring { rest } => {
                let rest = if rest { format!(" - {}", c[2]) } else { String::new() };
                let sum = format!("({} + {}*{}{rest})", q(first), c[1], q(last));
                gradient(format!("{}*{sum}", c[0]), &c[1])
            }
            LawForm::Bilinear => vec![
                (first, format!("{}*{}", c[0], q(last))),
                (last, format!("{}*{}", c[0], q(first))),
            ],
            LawForm::Combination { a, b, f } => {
                let text = self.of_position(f, &self.combination([a, b], joints));
                let scaled = |k: i8| match k {
                    1 => text.clone(),
                    -1 => format!("-{text}"),
                    k => format!("{}*{text}", self.number(i64::from(k))),
                };
                vec![(first, scaled(a)), (last, scaled(b))]
            }
            LawForm::HalfCombination { a, b, f } => own(self.of_position(f, &self.combination([a, b], joints))),
            LawForm::CrossPosition => own(format!("{}*{}", c[0], q(last))),
            LawForm::Product { f, g } | LawForm::CrossProduct { f, g } => {
                own(format!("{}*{}", self.of_position(f, &q(last)), self.of_speed(g, &v(first))))
            }
            LawForm::CrossSpeed(g) => own(format!("{}*{}", c[0], self.of_speed(g, &v(last)))),
            LawForm::SpeedProduct(g) => own(format!(
                "{}*{}*{}",
                c[0],
                self.absolute(&v(last)),
                self.of_speed(g, &v(first))
            )),
            LawForm::SoftStop { upper } => {
                let sign = if upper { "" } else { "-" };
                own(format!("{}*exp({sign}({} - {})/{})", c[0], q(first), c[2], c[1]))
            }
            LawForm::Saturating => {
                let sum = format!("({} + {}*{})", q(first), c[1], q(last));
                gradient(format!("{}*tanh({sum}/{})", c[0], c[2]), &c[1])
            }
            LawForm::Damper => gradient(format!("{}*({} + {}*{})", c[0], v(first), c[1], v(last)), &c[1]),
        }
    }

    /// The energy of what is conservative.
    fn energy(&self, form: LawForm, joints: &[usize]) -> Option<String> {
        let (first, last) = (joints[0], joints[joints.len() - 1]);
        let (q, c) = (&self.q, self.constants);
        // The integral of a wave of n cycles is one with n in its denominator.
        let wave = |f: OfPosition, x: &str| {
            let over = |n: u8| if n == 1 { c[0].clone() } else { format!("{}/{n}", c[0]) };
            match f {
                OfPosition::Power(n) => format!("{}/{}*{}", c[0], n + 1, self.power(x, n + 1)),
                OfPosition::Sine(n) => format!("-{}*cos({})", over(n), self.times(n, x)),
                OfPosition::Cosine(n) => format!("{}*sin({})", over(n), self.times(n, x)),
                OfPosition::Wave(n) => format!("-{}*cos({} + {})", over(n), self.times(n, x), c[1]),
            }
        };
        match form {
            LawForm::Position(f) => Some(wave(f, &q(first))),
            LawForm::PinSpring => {
                let u = format!("{} + {}", q(first), c[2]);
                Some(format!(
                    "-{}*cos({u}) + 2*{}/{rho}*sqrt(1 - {rho}*cos({u}))",
                    c[0],
                    c[1],
                    rho = c[3]
                ))
            }
            LawForm::Spring { rest } => {
                let rest = if rest { format!(" - {}", c[2]) } else { String::new() };
                Some(format!("0.5*{}*({} + {}*{}{rest})^2", c[0], q(first), c[1], q(last)))
            }
            LawForm::Bilinear => Some(format!("{}*{}*{}", c[0], q(first), q(last))),
            LawForm::Combination { a, b, f } => Some(wave(f, &self.combination([a, b], joints))),
            LawForm::SoftStop { upper } => {
                let sign = if upper { "" } else { "-" };
                Some(format!(
                    "{sign}{}*{c}*exp({sign}({} - {})/{c})",
                    c[0],
                    q(first),
                    c[2],
                    c = c[1]
                ))
            }
            LawForm::Saturating => Some(format!(
                "{}*{c}*log(cosh(({} + {}*{})/{c}))",
                c[0],
                q(first),
                c[1],
                q(last),
                c = c[2]
            )),
            _ => None,
        }
    }
}
