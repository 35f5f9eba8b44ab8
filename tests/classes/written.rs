//! Logs as text, and what of a text nobody can read.

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::{Chain, Coulomb, inverse_dynamics_batch};
use dynident::parameters::Layout;
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Time, two positions, two torques.
pub type Row = [f64; 5];

/// Rows of a period.
pub const PERIOD: usize = 500;

/// Three periods of five seconds of the planar arm at 100 Hz, with ordinary noise.
pub fn good_rows() -> Vec<Row> {
    rows_of(0.05)
}

/// The same with torque noise of so many N m.
pub fn rows_of(noise: f64) -> Vec<Row> {
    let robot = Shipped.named("planar_two_link").unwrap().robot;
    let layout = Layout::standard(&robot);
    let coefficient = |j: usize, l: usize, p: f64| 0.4 * (p + 1.3 * j as f64 + 2.1 * l as f64).sin();
    let series = FourierSeries {
        fundamental_hz: 0.2,
        a: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, 0.4)),
        b: DMatrix::from_fn(2, 3, |j, l| coefficient(j, l, 1.4)),
        offset: vec![0.1, -0.2],
    };
    let motion = series.sample(100.0);
    let truth = [
        [3.0, 0.6, 0.03, 0.0, 0.02, 0.0, 0.0, 0.2, 0.0, 0.2, 0.3, 0.5],
        [1.0, 0.2, -0.01, 0.0, 0.01, 0.0, 0.0, 0.06, 0.0, 0.06, 0.1, 0.2],
    ];
    let parameters: Vec<f64> = truth
        .iter()
        .flat_map(|link| link[..layout.per_link()].iter().copied())
        .collect();
    let tau = inverse_dynamics_batch(&Chain::new(&robot), &layout, &parameters, &motion, Coulomb::Sign);
    let mut random = rng(11);
    let mut row = |s: usize| {
        let at = s % PERIOD;
        let mut torque = |j: usize| tau[j * motion.stride() + at] + noise * normal(&mut random);
        [
            s as f64 / 100.0,
            motion.positions(0)[at],
            motion.positions(1)[at],
            torque(0),
            torque(1),
        ]
    };
    (0..3 * PERIOD).map(&mut row).collect()
}

pub fn log(rows: impl IntoIterator<Item = Row>) -> String {
    lines(rows.into_iter().map(|r| r.map(|v| format!("{v:?}")).join(",")))
}

pub fn lines(rows: impl IntoIterator<Item = String>) -> String {
    let rows: Vec<String> = rows.into_iter().collect();
    format!("time,q1,q2,tau1,tau2\n{}\n", rows.join("\n"))
}

pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Box and Muller.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(1e-12..1.0), rng.random_range(0.0..1.0));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Digits in a row beyond those of a double and of a name.
const MOST_DIGITS: usize = 30;

/// The first `NaN`, infinity or endless number in a text.
pub fn unreadable(text: &str) -> Option<String> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let is_odd = |w: &&str| {
        matches!(*w, "NaN" | "inf" | "Infinity" | "Inf") || w.len() > MOST_DIGITS && w.bytes().all(|b| b.is_ascii_digit())
    };
    words.into_iter().find(is_odd).map(String::from)
}
