//! The forms that a law can have: where they sit, their columns and shape parameters.

use super::functions::{OfPosition, OfSpeed};
use crate::effects::{Column, Scene, Shape, Span};
use crate::model::Robot;
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

/// What kind of law a form is; every kind has the same prior.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// A function of the joint's own position, or position and speed.
    Own,
    /// A function of another joint's position or speed.
    Cross,
    /// On one joint alone, a function of its own position and another's, as the gradient of an energy would have it there.
    HalfEnergy,
    /// The gradient of an energy (or of a dissipation function) on both joints.
    Energy,
}

/// A form of a law. Places are `[j]` for functions of the joint's own state, `[j, m]` for a torque on j that depends on m as
/// well, and `[i, k]`, i < k, for gradients on both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LawForm {
    /// `tau_j = c f(q_j)`.
    Position(OfPosition),
    /// A spring between two pins, `tau_j = a sin u + b sin u / √(1 − ρ cos u)` with `u = q_j + φ`: stiffness k, free length l,
    /// radii r and s make `a = k r s`, `b = −k l r s / √(r² + s²)`, `ρ = 2 r s / (r² + s²)`. They cannot all be separated without
    /// one known length.
    PinSpring,
    /// The gradient of `½ k (q_i + a q_k)²`, with `rest` of `½ k (q_i + a q_k − c)²`.
    Spring {
        /// Whether it has a rest c.
        rest: bool,
    },
    /// The gradient of `k q_i q_k`.
    Bilinear,
    /// The gradient of the integral of `A f(a q_i + b q_k)`: `a A f` on joint i, `b A f` on joint k. `f` is a wave of one cycle.
    Combination {
        /// Factor of the first position.
        a: i8,
        /// Factor of the second position.
        b: i8,
        /// The wave.
        f: OfPosition,
    },
    /// `tau_j = A f(a q_j + b q_m)`, with nothing on joint m.
    HalfCombination {
        /// Factor of the first position.
        a: i8,
        /// Factor of the second position.
        b: i8,
        /// The wave.
        f: OfPosition,
    },
    /// `tau_j = k q_m`.
    CrossPosition,
    /// `tau_j = c f(q_m) g(qd_j)`; place `[j]` where m is j.
    Product {
        /// Of the position.
        f: OfPosition,
        /// Of the speed.
        g: OfSpeed,
    },
    /// The same on another joint's position.
    CrossProduct {
        /// Of the position.
        f: OfPosition,
        /// Of the speed.
        g: OfSpeed,
    },
    /// `tau_j = c g(qd_m)`.
    CrossSpeed(OfSpeed),
    /// `tau_j = c |qd_m| g(qd_j)`, g linear or the sign.
    SpeedProduct(OfSpeed),
    /// The gradient of the dissipation function `½ c (qd_i + a qd_k)²` by the speeds.
    Damper,
    /// A soft stop, `tau_j = a exp(± (q_j − s) / c)`: rising towards the upper end of the joint's travel, or towards the lower
    /// one. The end s, where the torque is a, is given: it is how far the log goes.
    SoftStop {
        /// Whether it stands at the upper end.
        upper: bool,
    },
    /// A hose that gives way, the gradient of `a c ln cosh((q_i + r q_k)/c)`: `a tanh((q_i + r q_k)/c)` on joint i, r times
    /// that on joint k.
    Saturating,
}

/// Ratios of two joints that a spring or damper acts on the combination of.
const RATIO: f64 = 5.0;
/// Between four fifths of the geometric mean of the radii and none of it: `ρ` of a pin spring beyond which the two pins meet, and
/// below which it is a sine.
const PIN: [f64; 2] = [0.05, 0.995];
/// Lengths of a soft stop or of a hose that gives way, as shares of the travel: below the first it is a step that a few rows
/// show, beyond the last a polynomial or a spring.
const LENGTH: [f64; 2] = [0.04, 0.8];

static ALL: LazyLock<Vec<LawForm>> = LazyLock::new(listed);

fn listed() -> Vec<LawForm> {
    use OfPosition::{Cosine, Power, Sine, Wave};
    let waves = |n: u8| [Sine(n), Cosine(n), Wave(n)];
    let mut all: Vec<LawForm> = [Power(2), Power(3)].map(LawForm::Position).to_vec();
    all.extend((1..=8).flat_map(waves).map(LawForm::Position));
    all.extend([
        LawForm::PinSpring,
        LawForm::Spring { rest: false },
        LawForm::Spring { rest: true },
        LawForm::Bilinear,
    ]);
    let ratios = [(1, 1), (1, -1), (1, 2), (1, -2), (2, 1), (2, -1)];
    for (a, b) in ratios {
        all.extend(waves(1).map(|f| LawForm::Combination { a, b, f }));
        all.extend(waves(1).map(|f| LawForm::HalfCombination { a, b, f }));
    }
    all.push(LawForm::CrossPosition);
    let factors = [Power(1), Power(2)].into_iter().chain((1..=3).flat_map(waves));
    for f in factors {
        all.extend(OfSpeed::ALL.map(|g| LawForm::Product { f, g }));
        let sharp = [OfSpeed::Linear, OfSpeed::Sign];
        all.extend(sharp.map(|g| LawForm::CrossProduct { f, g }));
    }
    all.extend(OfSpeed::ALL.map(LawForm::CrossSpeed));
    all.extend([OfSpeed::Linear, OfSpeed::Sign].map(LawForm::SpeedProduct));
    all.push(LawForm::Damper);
    // Models name a form by its number: new ones come last.
    all.extend([true, false].map(|upper| LawForm::SoftStop { upper }));
    all.push(LawForm::Saturating);
    all
}

impl LawForm {
    /// Every form; its number is its place in this list.
    pub fn all() -> &'static [Self] {
        &ALL
    }

    /// The form of this number.
    ///
    /// # Panics
    /// Where there is none.
    pub fn numbered(number: usize) -> Self {
        ALL[number]
    }

    /// Which class of the search it belongs to.
    pub fn class(self) -> Class {
        match self {
            Self::Position(_) | Self::PinSpring | Self::Product { .. } | Self::SoftStop { .. } => Class::Own,
            Self::HalfCombination { .. } => Class::HalfEnergy,
            Self::CrossPosition | Self::CrossProduct { .. } | Self::CrossSpeed(_) | Self::SpeedProduct(_) => Class::Cross,
            Self::Spring { .. } | Self::Bilinear | Self::Combination { .. } | Self::Damper | Self::Saturating => Class::Energy,
        }
    }

    /// Whether it acts on both joints of its place.
    pub fn is_gradient(self) -> bool {
        self.class() == Class::Energy
    }

    /// Whether it does no work over a closed path: its torque is the gradient of an energy, as far as the joints it acts on say
    /// so.
    pub fn is_conservative(self) -> bool {
        match self {
            Self::Position(_)
            | Self::PinSpring
            | Self::Spring { .. }
            | Self::Bilinear
            | Self::Combination { .. }
            | Self::SoftStop { .. }
            | Self::Saturating => true,
            Self::HalfCombination { .. } | Self::CrossPosition => false,
            Self::Product { .. } | Self::CrossProduct { .. } | Self::CrossSpeed(_) | Self::SpeedProduct(_) | Self::Damper => {
                false
            }
        }
    }

    /// Whether it depends on a speed: then it is friction, and may not drive the joints.
    pub fn is_friction(self) -> bool {
        !self.is_conservative() && !matches!(self, Self::HalfCombination { .. } | Self::CrossPosition)
    }

    /// Whether a whole turn of every revolute joint brings the same torque.
    pub fn is_periodic(self) -> bool {
        match self {
            Self::Position(f) | Self::Product { f, .. } | Self::CrossProduct { f, .. } => f.is_periodic(),
            Self::Spring { .. } | Self::Bilinear | Self::CrossPosition | Self::SoftStop { .. } | Self::Saturating => false,
            _ => true,
        }
    }

    /// Whether it is `other` with one more constant: a wave with a phase where the other has none, a spring with a rest.
    pub fn contains(self, other: Self) -> bool {
        use OfPosition::{Cosine, Sine, Wave};
        let wider = |f: OfPosition, g: OfPosition| match (f, g) {
            (Wave(n), Sine(m) | Cosine(m)) => n == m,
            _ => false,
        };
        match (self, other) {
            (Self::Position(f), Self::Position(g)) => wider(f, g),
            (Self::Product { f, g: speed }, Self::Product { f: g, g: same }) => speed == same && wider(f, g),
            (Self::CrossProduct { f, g: speed }, Self::CrossProduct { f: g, g: same }) => speed == same && wider(f, g),
            (Self::Combination { a, b, f }, Self::Combination { a: c, b: d, f: g }) => (a, b) == (c, d) && wider(f, g),
            (Self::HalfCombination { a, b, f }, Self::HalfCombination { a: c, b: d, f: g }) => (a, b) == (c, d) && wider(f, g),
            (Self::Spring { rest: true }, Self::Spring { rest: false }) => true,
            _ => false,
        }
    }

    fn needs_angles(self) -> bool {
        match self {
            Self::Position(f) | Self::Product { f, .. } | Self::CrossProduct { f, .. } => f.is_periodic(),
            Self::PinSpring | Self::Combination { .. } | Self::HalfCombination { .. } => true,
            _ => false,
        }
    }

    pub(super) fn places(self, robot: &Robot) -> Vec<Vec<usize>> {
        let n = robot.joint_count();
        let turns = |j: usize| robot.joints()[j].is_revolute();
        let alike = |i: usize, k: usize| robot.joints()[i].kind == robot.joints()[k].kind;
        let own = || (0..n).map(|j| vec![j]).collect::<Vec<_>>();
        let others = || (0..n).flat_map(|j| (0..n).filter(move |m| *m != j).map(move |m| vec![j, m]));
        let all: Vec<Vec<usize>> = match self.class() {
            Class::Own => own(),
            // A combination has a sum of its positions or speeds; a bilinear energy has none.
            Class::Energy => others()
                .filter(|p| p[0] < p[1] && (self == Self::Bilinear || alike(p[0], p[1])))
                .collect(),
            Class::HalfEnergy => others().filter(|p| alike(p[0], p[1])).collect(),
            Class::Cross => others().collect(),
        };
        let variable = |p: &Vec<usize>| match self {
            Self::Combination { .. } | Self::HalfCombination { .. } => p.iter().all(|&j| turns(j)),
            _ => turns(p[p.len() - 1]),
        };
        all.into_iter().filter(|p| !self.needs_angles() || variable(p)).collect()
    }

    /// Joints whose torque it changes.
    pub fn acts_on(self, joints: &[usize]) -> Vec<usize> {
        if self.is_gradient() {
            joints.to_vec()
        } else {
            vec![joints[0]]
        }
    }

    pub(super) fn shapes(self, joints: &[usize], spans: &[Span]) -> Vec<Shape> {
        match self {
            Self::PinSpring => vec![
                Shape {
                    low: -TAU,
                    high: TAU,
                    grid: (0..12).map(|i| -PI + f64::from(i) * PI / 6.0).collect(),
                },
                Shape {
                    low: PIN[0],
                    high: PIN[1],
                    grid: vec![0.3, 0.6, 0.8, 0.93],
                },
            ],
            Self::Spring { .. } | Self::Damper => vec![ratio(joints, spans)],
            Self::SoftStop { upper } => {
                let below = if upper { 0.0 } else { spans[joints[0]].range };
                let end = Shape::fixed(spans[joints[0]].highest - below);
                vec![length(travel(joints[0], spans)), end]
            }
            // The combination goes as far as both joints together at a ratio of one.
            Self::Saturating => vec![
                ratio(joints, spans),
                length(travel(joints[0], spans) + travel(joints[1], spans)),
            ],
            _ => Vec::new(),
        }
    }

    /// One column per coefficient.
    pub(super) fn columns(self, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let (first, last) = (joints[0], joints[joints.len() - 1]);
        let q = |j: usize, s: usize| scene.motion.positions(j)[s];
        let v = |j: usize, s: usize| scene.motion.velocities(j)[s];
        let speed = |g: OfSpeed, j: usize, s: usize| g.at(v(j, s), scene.sign(v(j, s)));
        let on = |value: &dyn Fn(usize) -> f64| Column::on(first, (0..scene.samples()).map(value).collect());
        let waves = |f: OfPosition, x: &dyn Fn(usize) -> f64, times: &dyn Fn(usize) -> f64| {
            let column = |i: usize| on(&|s| f.at(x(s))[i] * times(s));
            (0..f.columns()).map(column).collect::<Vec<_>>()
        };
        match self {
            Self::Position(f) => waves(f, &|s| q(first, s), &|_| 1.0),
            Self::PinSpring => {
                let angle = |s: usize| q(first, s) + shape[0];
                let chord = |s: usize| (1.0 - shape[1] * angle(s).cos()).sqrt();
                vec![on(&|s| angle(s).sin()), on(&|s| angle(s).sin() / chord(s))]
            }
            Self::Spring { rest } => {
                let a = shape[0];
                let sum = both(scene, joints, [1.0, a], |s| q(first, s) + a * q(last, s));
                let constant = rest.then(|| both(scene, joints, [1.0, a], |_| -1.0));
                std::iter::once(sum).chain(constant).collect()
            }
            Self::Bilinear => vec![Column {
                rows: vec![
                    (first, scene.motion.positions(last).to_vec()),
                    (last, scene.motion.positions(first).to_vec()),
                ],
            }],
            Self::Combination { a, b, f } => {
                let (a, b) = (f64::from(a), f64::from(b));
                let column = |i: usize| both(scene, joints, [a, b], |s| f.at(a * q(first, s) + b * q(last, s))[i]);
                (0..f.columns()).map(column).collect()
            }
            Self::HalfCombination { a, b, f } => waves(f, &|s| f64::from(a) * q(first, s) + f64::from(b) * q(last, s), &|_| 1.0),
            Self::CrossPosition => vec![on(&|s| q(last, s))],
            Self::Product { f, g } | Self::CrossProduct { f, g } => waves(f, &|s| q(last, s), &|s| speed(g, first, s)),
            Self::CrossSpeed(g) => vec![on(&|s| speed(g, last, s))],
            Self::SpeedProduct(g) => vec![on(&|s| v(last, s).abs() * speed(g, first, s))],
            Self::Damper => {
                let a = shape[0];
                vec![both(scene, joints, [1.0, a], |s| v(first, s) + a * v(last, s))]
            }
            Self::SoftStop { upper } => {
                let towards = if upper { 1.0 } else { -1.0 };
                vec![on(&|s| (towards * (q(first, s) - shape[1]) / shape[0]).exp())]
            }
            Self::Saturating => {
                let (a, c) = (shape[0], shape[1]);
                vec![both(scene, joints, [1.0, a], |s| ((q(first, s) + a * q(last, s)) / c).tanh())]
            }
        }
    }

    /// What is reported, in the order of the formula's constants: amplitude and phase of a wave in the place of the coefficients
    /// of sine and cosine, and the rest of a spring in the place of its torque.
    pub(super) fn reported(self, coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        let wave = |f: OfPosition| match f.columns() {
            2 => vec![coefficients[0].hypot(coefficients[1]), coefficients[1].atan2(coefficients[0])],
            _ => coefficients.to_vec(),
        };
        match self {
            Self::Position(f) | Self::Product { f, .. } | Self::CrossProduct { f, .. } => wave(f),
            Self::Combination { f, .. } | Self::HalfCombination { f, .. } => wave(f),
            Self::Spring { rest: true } => vec![coefficients[0], shape[0], coefficients[1] / coefficients[0]],
            _ => coefficients.iter().chain(shape).copied().collect(),
        }
    }
}

fn travel(joint: usize, spans: &[Span]) -> f64 {
    spans[joint].range.max(f64::MIN_POSITIVE)
}

/// Factor of the second joint. Near zero it takes no part: what it adds to the combination is a twentieth of what the first does,
/// or more.
fn ratio(joints: &[usize], spans: &[Span]) -> Shape {
    let least = (0.05 * travel(joints[0], spans) / travel(joints[1], spans)).min(0.2);
    let grid = [-3.0, -1.5, -0.75, -0.35, 0.35, 0.75, 1.5, 3.0].into_iter();
    Shape {
        low: -RATIO,
        high: RATIO,
        grid: grid.filter(|a: &f64| a.abs() > least).collect(),
    }
}

/// A length along `travel`.
fn length(travel: f64) -> Shape {
    Shape {
        low: LENGTH[0] * travel,
        high: LENGTH[1] * travel,
        grid: [0.08, 0.16, 0.32].map(|share| share * travel).to_vec(),
    }
}

/// A column on both joints, `factors` times the value.
fn both(scene: &Scene, joints: &[usize], factors: [f64; 2], value: impl Fn(usize) -> f64) -> Column {
    let values: Vec<f64> = (0..scene.samples()).map(value).collect();
    let row = |(&j, f): (&usize, f64)| (j, values.iter().map(|v| f * v).collect());
    Column {
        rows: joints.iter().zip(factors).map(row).collect(),
    }
}
