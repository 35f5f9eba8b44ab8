//! Where the next local solve starts: at random, or from points found before.

use super::pool::{Point, distance};
use super::symmetry::Symmetries;
use super::variables::Variables;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Random numbers of one job: a stream of its own, whatever thread runs it.
pub(super) fn random_numbers(seed: u64, round: usize, job: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((round as u64) << 20) | job as u64);
    rng
}

/// Uniform in a cube, then scaled to the limits.
pub(super) fn random_start(variables: &Variables, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let raw: Vec<f64> = (0..variables.len()).map(|_| rng.random_range(-1.0..1.0)).collect();
    variables.on_the_limits(&raw)
}

/// A start in another basin, from good points (best first): one or two joints anew, joints exchanged between two points, or a
/// long step. Steps below a quarter mostly fall back into the basin they came from.
pub(super) fn hop(variables: &Variables, symmetries: &Symmetries, pool: &[Point], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let at = favour_the_first(pool.len(), rng);
    let kind: f64 = rng.random();
    if kind < 0.35 {
        let x = one_joint_anew(variables, &pool[at].x, rng);
        let another = rng.random::<f64>() < 0.3;
        if another { one_joint_anew(variables, &x, rng) } else { x }
    } else if kind < 0.7 && pool.len() > 1 {
        let other = (at + rng.random_range(1..pool.len())) % pool.len();
        let other = nearest_image(variables, symmetries, &pool[at].x, &pool[other].x);
        exchange(variables, &pool[at].x, &other, rng)
    } else {
        neighbour(variables, &pool[at].x, between(0.25, 0.7, rng), rng)
    }
}

/// A start within the basin of one of the three best points: basins have ridges where a local solve gets stuck.
pub(super) fn shake(variables: &Variables, pool: &[Point], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let at = favour_the_first(pool.len().min(3), rng);
    neighbour(variables, &pool[at].x, between(0.03, 0.15, rng), rng)
}

/// The square favours the better points without giving up the others.
fn favour_the_first(count: usize, rng: &mut ChaCha8Rng) -> usize {
    (rng.random::<f64>().powi(2) * count as f64) as usize
}

/// Evenly in the logarithm.
fn between(low: f64, high: f64, rng: &mut ChaCha8Rng) -> f64 {
    low * (high / low).powf(rng.random())
}

/// Every joint's coefficients moved by a normal step of relative length `size`.
fn neighbour(variables: &Variables, from: &[f64], size: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let per_joint = variables.per_joint();
    let mut x = variables.settled(from);
    for joint in x.chunks_exact_mut(per_joint) {
        let length = joint.iter().map(|v| v * v).sum::<f64>().sqrt();
        let step = size * length / (per_joint as f64).sqrt();
        joint.iter_mut().for_each(|v| *v += step * normal(rng));
    }
    x
}

fn one_joint_anew(variables: &Variables, from: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let per_joint = variables.per_joint();
    let fresh = random_start(variables, rng);
    let mut x = variables.settled(from);
    let start = rng.random_range(0..x.len() / per_joint) * per_joint;
    x[start..start + per_joint].copy_from_slice(&fresh[start..start + per_joint]);
    x
}

fn nearest_image(variables: &Variables, symmetries: &Symmetries, one: &[f64], other: &[f64]) -> Vec<f64> {
    let images = symmetries.images(variables, other).into_iter();
    let by_distance = |x: &Vec<f64>| distance(variables, one, x);
    let nearest = images.min_by(|a, b| by_distance(a).total_cmp(&by_distance(b)));
    nearest.expect("the identity is a symmetry")
}

/// Every joint from one of two points, by a coin.
fn exchange(variables: &Variables, one: &[f64], other: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let per_joint = variables.per_joint();
    let mut x = variables.settled(one);
    let other = variables.settled(other);
    for (mine, theirs) in x.chunks_exact_mut(per_joint).zip(other.chunks_exact(per_joint)) {
        if rng.random() {
            mine.copy_from_slice(theirs);
        }
    }
    x
}

/// Box and Muller; the first draw is kept from zero.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}
