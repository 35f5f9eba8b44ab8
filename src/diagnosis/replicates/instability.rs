//! Joints whose torque is not the same all through a log, as a remainder: all that was found of them, reported together.

use super::level::{Along, Level};
use crate::diagnosis::report::Remainder;
use crate::diagnosis::settings::SETTINGS;
use crate::model::Robot;
use crate::regression::{NoiseModel, Stretch, deviation};

/// What of one joint goes with the time of the log, or with its periods.
#[derive(Debug, Clone)]
pub(crate) struct Unsteady {
    pub joint: usize,
    /// The stronger first.
    pub along: Vec<Along>,
    /// RMS of it over the log [N·m or N].
    pub rms: f64,
    /// Sum of squares of what is left and could be of this kind, with and without it; above the noise where that is known.
    pub left: [f64; 2],
}

/// Levels taken out of the periods of one stretch, one after the other.
#[derive(Debug, Default)]
pub(crate) struct TakenOut {
    levels: Vec<Level>,
    /// Joint, and its slow changes before the first level was taken out.
    before: Vec<(usize, f64)>,
}

impl TakenOut {
    pub fn count(&self) -> usize {
        self.levels.len()
    }

    /// Takes a level out of a stretch, whose mean is left to its caller.
    pub fn take(&mut self, level: Level, stretch: &mut Stretch) {
        if self.before.iter().all(|(joint, _)| *joint != level.joint) {
            self.before.push((level.joint, slow_changes(stretch, level.joint)));
        }
        level.take_out(&mut stretch.periods);
        self.levels.push(level);
    }

    /// The stretch with the levels back in it: what errors are reported for, since nothing explains them.
    pub fn put_back(&self, stretch: &Stretch) -> Stretch {
        let mut periods = stretch.periods.clone();
        self.levels.iter().for_each(|level| level.put_back(&mut periods));
        let mut whole = Stretch {
            periods,
            ..stretch.clone()
        };
        whole.torque = whole.mean_over(&(0..whole.periods.len()).collect::<Vec<_>>());
        whole
    }

    /// What there is to tell of every joint, by the noise of what is left.
    pub fn reported(&self, stretch: &Stretch, noise: &[NoiseModel]) -> Vec<Unsteady> {
        let of = |&(joint, before): &(usize, f64)| {
            let own: Vec<&Level> = self.levels.iter().filter(|l| l.joint == joint).collect();
            let mut along: Vec<Along> = Vec::new();
            for level in &own {
                if !along.contains(&level.along) {
                    along.push(level.along);
                }
            }
            let by_noise = slow_noise(stretch, &noise[joint]);
            Unsteady {
                joint,
                along,
                rms: own.iter().map(|l| l.rms().powi(2)).sum::<f64>().sqrt(),
                left: [before, slow_changes(stretch, joint)].map(|sum| (sum - by_noise).max(0.0)),
            }
        };
        self.before.iter().map(of).collect()
    }
}

/// Sum of squares of the means over tenths of a period of what every period deviates from the mean of all.
fn slow_changes(stretch: &Stretch, joint: usize) -> f64 {
    let part = (stretch.rows() / SETTINGS.replicates.parts).max(1);
    let of_period = |period: &Vec<Vec<f64>>| {
        let deviation = deviation(stretch, period, joint);
        let means = deviation.chunks(part).map(|c| c.iter().sum::<f64>() / c.len() as f64);
        means.map(|m| m * m).sum::<f64>()
    };
    stretch.periods.iter().map(of_period).sum()
}

/// What noise alone makes of [`slow_changes`].
fn slow_noise(stretch: &Stretch, noise: &NoiseModel) -> f64 {
    let part = (stretch.rows() / SETTINGS.replicates.parts).max(1);
    let parts = stretch.rows().div_ceil(part) * (stretch.periods.len() - 1);
    parts as f64 * noise.slow_std_dev().powi(2) / part as f64
}

/// The remainder that unsteady joints make.
pub(crate) fn remainder_of(robot: &Robot, list: &[Unsteady]) -> Option<Remainder> {
    let (of_friction, of_levels): (Vec<Unsteady>, Vec<Unsteady>) =
        list.iter().cloned().partition(|u| u.along == [Along::FrictionOverTime]);
    joined(levels_of(robot, &of_levels), frictions_of(robot, &of_friction))
}

/// Friction that changes over logs that do not repeat: how, only periods tell.
fn frictions_of(robot: &Robot, list: &[Unsteady]) -> Option<Remainder> {
    let mut whole = levels_of(robot, list)?;
    for speed in list.iter().map(|u| format!("qd{}", u.joint + 1)) {
        // A joint is in the list once for every log.
        if !whole.depends_on.contains(&speed) {
            whole.depends_on.push(speed);
        }
    }
    whole.note = format!(
        "the friction of {} changes over the log; that predicts {:.0} % of what is left there; record a motion that repeats, whose periods tell how fast",
        whole.joints.join(", "),
        100.0 * whole.predicted_share
    );
    Some(whole)
}

/// Torques whose level goes with the time of the log or with its periods.
fn levels_of(robot: &Robot, list: &[Unsteady]) -> Option<Remainder> {
    if list.is_empty() {
        return None;
    }
    let (mut joints, mut rms, mut depends_on) = (Vec::new(), Vec::<f64>::new(), Vec::new());
    for one in list {
        let name = robot.joints()[one.joint].name.clone();
        match joints.iter().position(|j| *j == name) {
            Some(at) => rms[at] = rms[at].max(one.rms),
            None => {
                joints.push(name);
                rms.push(one.rms);
            }
        }
        for along in one.along.iter().map(|a| a.name().to_string()) {
            if !depends_on.contains(&along) {
                depends_on.push(along);
            }
        }
    }
    let [with, without] = [0, 1].map(|i| list.iter().map(|u| u.left[i]).sum::<f64>());
    let predicted_share = if with > 0.0 {
        (1.0 - without / with).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let note = format!(
        "the torque of {} goes with {}, whatever the motion is, as of no effect known here; that predicts {:.0} % of what changes slowly there",
        joints.join(", "),
        depends_on.iter().map(|name| in_words(name)).collect::<Vec<_>>().join(" and "),
        100.0 * predicted_share
    );
    Some(Remainder {
        joints,
        depends_on,
        predicted_share,
        rms,
        note,
    })
}

fn in_words(name: &str) -> &'static str {
    match name {
        "time" => "the time of the log",
        _ => "the period of the log",
    }
}

/// Two remainders in one, the larger first.
pub(crate) fn joined(one: Option<Remainder>, other: Option<Remainder>) -> Option<Remainder> {
    let (Some(a), Some(b)) = (&one, &other) else {
        return one.or(other);
    };
    let square = |r: &Remainder| r.rms.iter().map(|v| v * v).sum::<f64>();
    let (first, second) = if square(a) >= square(b) { (a, b) } else { (b, a) };
    let mut whole = first.clone();
    for (joint, rms) in second.joints.iter().zip(&second.rms) {
        match whole.joints.iter().position(|j| j == joint) {
            Some(at) => whole.rms[at] = whole.rms[at].hypot(*rms),
            None => {
                whole.joints.push(joint.clone());
                whole.rms.push(*rms);
            }
        }
    }
    let further = second.depends_on.iter().filter(|v| !first.depends_on.contains(v));
    whole.depends_on.extend(further.cloned());
    let (of_first, of_second) = (square(first), square(second));
    let sum = (of_first + of_second).max(f64::MIN_POSITIVE);
    whole.predicted_share = (first.predicted_share * of_first + second.predicted_share * of_second) / sum;
    whole.note = format!("{}; {}", first.note, second.note);
    Some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::motion_error::tests::two_links;

    fn remainder(joints: &[&str], depends_on: &[&str], rms: &[f64], share: f64) -> Remainder {
        let owned = |list: &[&str]| list.iter().map(|s| s.to_string()).collect();
        Remainder {
            joints: owned(joints),
            depends_on: owned(depends_on),
            predicted_share: share,
            rms: rms.to_vec(),
            note: depends_on.join(" "),
        }
    }

    /// A joint whose friction changes in several logs is named once, in whatever order the logs come.
    #[test]
    fn prop_friction_of_several_logs_names_each_joint_once() {
        let of = |joint: usize, along: Along| Unsteady {
            joint,
            along: vec![along],
            rms: 1.0,
            left: [2.0, 1.0],
        };
        let friction = [1, 0, 1, 0].map(|j| of(j, Along::FrictionOverTime));
        let whole = remainder_of(&two_links(), &friction).unwrap();
        assert_eq!(whole.depends_on, ["time", "qd2", "qd1"]);
        assert_eq!(whole.joints, ["q2", "q1"]);
    }

    #[test]
    fn prop_two_remainders_are_told_in_one_the_larger_first() {
        let motion = remainder(&["J1", "J2"], &["q1", "q2"], &[0.3, 0.4], 0.5);
        let time = remainder(&["J2", "J3"], &["time"], &[3.0, 4.0], 1.0);
        let both = joined(Some(motion.clone()), Some(time.clone())).unwrap();
        assert_eq!(both.joints, ["J2", "J3", "J1"]);
        assert_eq!(both.depends_on, ["time", "q1", "q2"]);
        assert!((both.rms[0] - 3f64.hypot(0.4)).abs() < 1e-15 && both.rms[2] == 0.3);
        // Shares weigh by what they are shares of: 25 and 0.25.
        assert!((both.predicted_share - (25.0 + 0.125) / 25.25).abs() < 1e-12);
        assert_eq!(joined(None, Some(time.clone())), Some(time));
        assert_eq!(joined(Some(motion.clone()), None), Some(motion));
    }
}
