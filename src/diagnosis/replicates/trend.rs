//! Logs that do not repeat: does what a joint keeps drift with the time of the log?
//!
//! Without replicates the noise is what the model leaves, and that is slow itself: a misfit of the motion wanders as the motion
//! does. So slow cosines over the log are not held against white noise, but against the next faster cosines of the same residual,
//! beside the model and beside functions of all positions: a drift is slower than what the motion can bring about. With the power
//! of the slow ones and of their neighbours equal but for chance, their ratio is F-distributed, whatever the noise is at higher
//! frequencies.
//!
//! Friction that changes as a gear warms up has no level, but a size: the same cosines times the joint's speed and its sign are
//! held against the next faster ones times the same.

use super::instability::Unsteady;
use super::level::Along;
use crate::diagnosis::settings::SETTINGS;
use crate::dynamics::Coulomb;
use crate::regression::{Data, System, Whitened, f_tail, reduce};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use std::ops::Range;

/// Joints whose residual drifts; nothing where the noise was measured, since the periods tell more.
///
/// `limit` is the largest chance of a false drift in all logs together.
pub(crate) fn trends(data: &Data, system: &System, limit: f64) -> Vec<Unsteady> {
    if system.noise_is_measured {
        return Vec::new();
    }
    let joints = system.model.robot.joint_count();
    let kinds = [Along::Time, Along::FrictionOverTime];
    let tries = (data.stretches.len() * joints * kinds.len()) as f64;
    // Sums over a few cosines are normal only nearly, and less so far out: a tenth of the chance, as for effects without measured
    // noise.
    let beyond_chance = |t: &Trend| t.p_value * tries < 0.1 * limit;
    let of_joint = |log: usize, joint: usize| {
        kinds
            .into_iter()
            .filter_map(move |along| Trend::of(data, system, log, joint, along))
    };
    let of_log = |log: usize| (0..joints).flat_map(move |j| of_joint(log, j));
    let all = (0..data.stretches.len()).flat_map(of_log).filter(beyond_chance);
    let mut found: Vec<(f64, Unsteady)> = all.filter_map(|t| Some((t.gain, t.reported(data, system)?))).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|f| f.1).collect()
}

struct Trend {
    log: usize,
    joint: usize,
    along: Along,
    /// Decrease of the sum of squares by the slow cosines.
    gain: f64,
    p_value: f64,
}

impl Trend {
    /// `None` where the log has no rows for so many columns.
    fn of(data: &Data, system: &System, log: usize, joint: usize, along: Along) -> Option<Self> {
        let beside = 2 * data.stretches[log].joints();
        let columns = columns_of(data, system, log, joint, along);
        let each = columns_per_cosine(along);
        let (own, rest, right) = system.projected(&columns);
        let to = |count: usize| {
            reduce(
                &part(&own, 0..count),
                &part(&rest, 0..count),
                &right.rows(0, count).into_owned(),
            )
        };
        let [bare, slow, all] = [
            beside,
            beside + each * SETTINGS.replicates.slow_cosines,
            beside + each * (SETTINGS.replicates.slow_cosines + SETTINGS.replicates.neighbour_cosines),
        ]
        .map(to);
        let (k, others) = (slow.rank.checked_sub(bare.rank)?, all.rank.checked_sub(slow.rank)?);
        if k == 0 || others < each * SETTINGS.replicates.neighbour_cosines / 2 {
            return None;
        }
        let gain = slow.gain - bare.gain;
        let wandering = ((all.gain - slow.gain) / others as f64).max(f64::MIN_POSITIVE);
        Some(Self {
            log,
            joint,
            along,
            gain,
            p_value: f_tail(gain / k as f64 / wandering, [k as f64, others as f64]),
        })
    }

    /// `None` where the drift is a sliver of what the joint keeps.
    fn reported(&self, data: &Data, system: &System) -> Option<Unsteady> {
        let block = &system.blocks[self.log][self.joint];
        let (kept, rows) = (block.residual.norm_squared(), block.rows.iter().filter(|r| **r).count());
        (self.gain > SETTINGS.selection.least_share * kept).then(|| Unsteady {
            joint: self.joint,
            along: vec![self.along],
            rms: data.noise[self.joint].slow_std_dev() * (self.gain / rows.max(1) as f64).sqrt(),
            left: [kept, kept - self.gain],
        })
    }
}

fn part(m: &DMatrix<f64>, range: Range<usize>) -> DMatrix<f64> {
    m.view((range.start, range.start), (range.len(), range.len())).into_owned()
}

fn columns_per_cosine(along: Along) -> usize {
    match along {
        Along::FrictionOverTime => 2,
        _ => 1,
    }
}

/// Positions of all joints and their squares, then the cosines or friction times those, on the rows of one joint in one log.
fn columns_of(data: &Data, system: &System, log: usize, joint: usize, along: Along) -> Whitened {
    let stretch = data.stretches[log].coarse_form();
    let motion = &system.thinned(data)[log].motion;
    let position = |j: usize| {
        let q = motion.positions(j).to_vec();
        let squared = q.iter().map(|v| v * v).collect();
        [q, squared]
    };
    let cosine = |k: usize, count: usize| (0..count).map(move |s| (PI * k as f64 * (s as f64 + 0.5) / count as f64).cos());
    let faded = |k: usize| {
        let speed = motion.velocities(joint);
        let times = |f: fn(f64) -> f64| {
            cosine(k, speed.len())
                .zip(speed)
                .map(|(c, v)| c * f(*v))
                .collect::<Vec<f64>>()
        };
        [times(|v| v), times(|v| Coulomb::Sign.value(v))]
    };
    let all = 1..=SETTINGS.replicates.slow_cosines + SETTINGS.replicates.neighbour_cosines;
    let mut values = stretch.shaped((0..stretch.joints()).flat_map(position).collect());
    match along {
        Along::FrictionOverTime => values.extend(stretch.shaped(all.flat_map(faded).collect())),
        // So slow that the filter leaves them as they are.
        _ => values.extend(all.map(|k| cosine(k, stretch.rows()).collect())),
    }
    let block = &system.blocks[log][joint];
    let white = |v: Vec<f64>| DVector::from_vec(data.noise[joint].whiten(&v, &block.rows, stretch.repetitions()));
    let columns: Vec<DVector<f64>> = values.into_iter().map(white).collect();
    let mut all: Whitened = vec![Vec::new(); data.stretches.len()];
    all[log].push((joint, DMatrix::from_columns(&columns)));
    all
}
