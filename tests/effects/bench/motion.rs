//! Random motions.

use dynident::model::Robot;
use dynident::trajectory::{FourierSeries, QuinticWayPoints, Trajectory};
use nalgebra::{DMatrix, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A random Fourier series at rest at zero at its start, scaled to 1.2 rad/s and 1.4 rad.
pub fn excitation(joints: usize, seed: u64) -> FourierSeries {
    scaled_excitation(&vec![[1.4, 1.2]; joints], seed)
}

/// A random Fourier series at rest at zero at its start, every joint scaled to `[travel, speed]`.
fn scaled_excitation(limits: &[[f64; 2]], seed: u64) -> FourierSeries {
    let joints = limits.len();
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xe8c17e);
    let order = 5;
    let mut series = FourierSeries::at_rest(vec![0.0; joints], order, 0.1);
    series.a = DMatrix::from_fn(joints, order, |_, _| rng.random_range(-1.0..1.0));
    series.b = DMatrix::from_fn(joints, order, |_, _| rng.random_range(-1.0..1.0));
    for j in 0..joints {
        // Position, velocity and acceleration zero at t = 0: Σ b/l = 0, Σ a = 0, Σ l b = 0.
        let mean = series.a.row(j).sum() / order as f64;
        series.a.row_mut(j).iter_mut().for_each(|a| *a -= mean);
        let (b1, b2) = {
            let (s, t) = (2..order).fold((0.0, 0.0), |(s, t), l| {
                let b = series.b[(j, l)];
                (s + b / (l + 1) as f64, t + b * (l + 1) as f64)
            });
            // b1 + b2/2 = −s, b1 + 2 b2 = −t.
            let b2 = (s - t) / 1.5;
            (-s - 0.5 * b2, b2)
        };
        (series.b[(j, 0)], series.b[(j, 1)]) = (b1, b2);
        let (mut speed, mut travel) = (0.0f64, 0.0f64);
        for k in 0..400 {
            let [q, v, _] = series.state(j, k as f64 * 0.025);
            (speed, travel) = (speed.max(v.abs()), travel.max(q.abs()));
        }
        let scale = (limits[j][1] / speed).min(limits[j][0] / travel);
        series.a.row_mut(j).iter_mut().for_each(|v| *v *= scale);
        series.b.row_mut(j).iter_mut().for_each(|v| *v *= scale);
    }
    series
}

/// Random way-points, 10 s.
pub fn validation(joints: usize, seed: u64) -> QuinticWayPoints {
    cautious_validation(joints, 0, 1.0, seed)
}

/// The same way-points, with a share of them on one joint.
pub fn cautious_validation(joints: usize, joint: usize, share: f64, seed: u64) -> QuinticWayPoints {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9a11d);
    let mut points: Vec<Vec<f64>> = (0..6)
        .map(|_| (0..joints).map(|_| rng.random_range(-1.0..1.0)).collect())
        .collect();
    points.iter_mut().for_each(|p| p[joint] *= share);
    points[0] = vec![0.0; joints];
    points[5] = vec![0.0; joints];
    QuinticWayPoints::new(points, &[2.0; 5])
}

/// Four fifths of the limits of speed and travel, as is usual on a robot.
pub fn wide_excitation(robot: &Robot, seed: u64) -> FourierSeries {
    let limits: Vec<[f64; 2]> = limits(robot).iter().map(|l| l.map(|v| 0.8 * v)).collect();
    scaled_excitation(&limits, seed)
}

/// Random way-points within six tenths of the travel, 2 s apart, no faster than nine tenths of the speed.
pub fn wide_validation(robot: &Robot, seed: u64) -> QuinticWayPoints {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9a11d);
    let limits = limits(robot);
    let home = vec![0.0; limits.len()];
    let mut points = vec![home.clone()];
    for left in (1..5).rev() {
        let next = limits.iter().enumerate().map(|(j, &[travel, speed])| {
            // Fifteen eighths of the step over its time is the top speed of a quintic; the way home has `left` steps.
            let step = 0.9 * speed * 2.0 * 8.0 / 15.0;
            let wanted: f64 = rng.random_range(-0.6 * travel..0.6 * travel);
            let from = points.last().expect("begins at home")[j];
            let reach = left as f64 * step;
            wanted.clamp(from - step, from + step).clamp(-reach, reach)
        });
        let next = next.collect();
        points.push(next);
    }
    points.push(home);
    QuinticWayPoints::new(points, &[2.0; 5])
}

/// `[travel, speed]` to either side of zero, per joint.
fn limits(robot: &Robot) -> Vec<[f64; 2]> {
    let of = |j: &dynident::model::Joint| {
        let travel = j.limits.position.map_or(1.75, |[low, high]| high.min(-low));
        [travel, j.limits.velocity.unwrap_or(1.5)]
    };
    robot.joints().iter().map(of).collect()
}

/// Axes and space diagonals, both ways.
pub fn directions() -> Vec<Vector3<f64>> {
    let ends = [-1.0, 1.0];
    let axes = (0..3).flat_map(|i| ends.map(|s| Vector3::ith(i, s)));
    let diagonals = (0..8).map(|k| Vector3::from_fn(|i, _| ends[k >> i & 1]).normalize());
    axes.chain(diagonals).collect()
}
