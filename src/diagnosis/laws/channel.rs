//! Laws in a further measured quantity, such as a temperature.
//!
//! They are tried where what the periods deviate from each other by follows the quantity
//! ([`replicates`](crate::diagnosis::replicates)): an offset or friction that changes with it in proportion, or exponentially, as
//! the viscosity of a lubricant does. Each is an effect with a formula of its own, and competes with all others on the periods in
//! groups.

use crate::diagnosis::replicates::Following;
use crate::dynamics::Channel;
use crate::effects::own::FOUND_LAW;
use crate::effects::{ChannelVariable, Definition, OwnEffect, ParameterDefinition};
use crate::model::{Robot, shortest};
use crate::regression::Stretch;
use std::sync::Arc;

/// A law in a channel: its name, the factor that depends on the channel, and the one that depends on the speed.
struct ChannelKind {
    name: &'static str,
    exponential: bool,
    speed: Speed,
}

#[derive(Clone, Copy, PartialEq)]
enum Speed {
    None,
    Linear,
    Sign,
}

const KINDS: [ChannelKind; 5] = [
    ChannelKind {
        name: "offset",
        exponential: false,
        speed: Speed::None,
    },
    ChannelKind {
        name: "viscous_friction",
        exponential: false,
        speed: Speed::Linear,
    },
    ChannelKind {
        name: "coulomb_friction",
        exponential: false,
        speed: Speed::Sign,
    },
    ChannelKind {
        name: "viscous_friction_exponential",
        exponential: true,
        speed: Speed::Linear,
    },
    ChannelKind {
        name: "coulomb_friction_exponential",
        exponential: true,
        speed: Speed::Sign,
    },
];

/// Constants of an exponential, in units of the range of the channel: below the first it is a step, beyond the last a straight
/// line.
const CONSTANTS: [f64; 2] = [0.1, 5.0];

/// The laws that are tried for these joints and channels.
pub(crate) fn channel_laws(robot: &Robot, following: &[Following], stretches: &[Stretch]) -> Vec<Arc<OwnEffect>> {
    let mut places: Vec<(usize, usize)> = following.iter().map(|f| (f.joint, f.channel)).collect();
    places.sort_unstable();
    places.dedup();
    let laws = places.iter().flat_map(|&(joint, channel)| {
        let seen = Seen::new(stretches, channel);
        KINDS.iter().filter_map(move |kind| seen.as_ref()?.law(robot, joint, kind))
    });
    laws.map(Arc::new).collect()
}

/// A channel as the logs have it.
struct Seen {
    channel: Channel,
    low: f64,
    range: f64,
}

impl Seen {
    fn new(stretches: &[Stretch], number: usize) -> Option<Self> {
        // Period by period where there are any: a mean over periods has neither the lowest nor the highest value.
        let means = || stretches.iter().filter_map(|s| s.motion.channels().get(number));
        let singles = stretches
            .iter()
            .flat_map(|s| &s.channel_periods)
            .filter_map(|p| p.get(number));
        let all = || singles.clone().chain(means());
        let values = || all().flat_map(|c| c.values.iter().copied());
        let low = values().fold(f64::INFINITY, f64::min);
        let range = values().fold(f64::NEG_INFINITY, f64::max) - low;
        let channel = all().next()?.clone();
        (range > 0.0 && range.is_finite()).then_some(Self { channel, low, range })
    }

    /// The lowest value, rounded to a tenth of the power of ten below the range: people say 22 °C.
    fn reference(&self) -> f64 {
        let step = 10f64.powf(self.range.log10().floor() - 1.0);
        (self.low / step).round() * step
    }

    fn law(&self, robot: &Robot, joint: usize, kind: &ChannelKind) -> Option<OwnEffect> {
        let (name, axis) = (&*self.channel.name, &robot.joints()[joint]);
        let reference = self.reference();
        let sign = if reference < 0.0 { '+' } else { '-' };
        let change = format!("({name} {sign} {})", shortest(reference.abs()));
        let factor = match kind.exponential {
            true => format!("k*exp(-{change}/c)"),
            false => format!("k*{change}"),
        };
        let speed = format!("qd{}", joint + 1);
        let expression = match kind.speed {
            Speed::None => factor,
            Speed::Linear => format!("{factor}*{speed}"),
            Speed::Sign => format!("{factor}*sign({speed})"),
        };
        let known = OwnEffect::knows_unit(&self.channel.unit) && &*self.channel.unit != "1";
        let unit = if known { &*self.channel.unit } else { "1" };
        let k = unit_of(axis.effort_unit(), axis.position_unit(), kind, known.then_some(unit));
        let free = |name: &str, unit: String| ParameterDefinition {
            name: name.into(),
            unit,
            low: None,
            high: None,
        };
        let mut parameters = vec![free("k", k)];
        if kind.exponential {
            parameters.push(ParameterDefinition {
                low: Some(CONSTANTS[0] * self.range),
                high: Some(CONSTANTS[1] * self.range),
                ..free("c", unit.into())
            });
        }
        let definition = Definition {
            name: format!("{FOUND_LAW}{name}_{}", kind.name),
            joint: axis.name.clone(),
            expression,
            parameters,
            channels: vec![ChannelVariable {
                name: name.into(),
                unit: unit.into(),
                reference,
            }],
            declared: false,
        };
        OwnEffect::new(definition, robot).ok()
    }
}

/// Of the factor k.
fn unit_of(effort: &str, position: &str, kind: &ChannelKind, channel: Option<&str>) -> String {
    let above = if kind.speed == Speed::Linear { " s" } else { "" };
    let below: Vec<&str> = [
        (kind.speed == Speed::Linear).then_some(position),
        channel.filter(|_| !kind.exponential),
    ]
    .into_iter()
    .flatten()
    .collect();
    match &below[..] {
        [] => format!("{effort}{above}"),
        [one] => format!("{effort}{above}/{one}"),
        more => format!("{effort}{above}/({})", more.join(" ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::Motion;
    use crate::model::{Joint, JointKind, Mdh};

    fn robot() -> Robot {
        let kinds = [JointKind::Revolute, JointKind::Prismatic];
        let mdh = Mdh {
            alpha: 0.3,
            d: 0.1,
            theta: 0.0,
            r: 0.2,
        };
        let joint = |(i, kind)| Joint::from_mdh(format!("A{i}"), kind, mdh);
        let friction = crate::model::Friction {
            viscous: true,
            coulomb: true,
        };
        let joints = kinds.into_iter().enumerate().map(joint).collect();
        Robot::new("two", nalgebra::Vector3::new(0.0, 0.0, -9.81), joints, friction).unwrap()
    }

    fn following(joint: usize) -> Following {
        Following {
            joint,
            channel: 0,
            evidence: 1.0,
            p_value: 0.0,
            torque: Vec::new(),
        }
    }

    /// All kinds are formulas that own effects take, with units that fit, whatever the channel's unit and sign.
    #[test]
    fn prop_every_kind_is_an_effect() {
        let robot = robot();
        for (unit, low) in [("degC", 21.96), ("bar", -3.2), ("A", 0.004)] {
            let values: Vec<f64> = (0..64).map(|s| low + 0.3 * f64::from(s)).collect();
            let motion = Motion::zeros(2, 64).with_channels(vec![Channel::new("heat", unit, values)]);
            let stretch = Stretch::of_motion(motion, 0.01, true);
            let laws = channel_laws(&robot, &[following(1), following(0), following(1)], &[stretch]);
            assert_eq!(laws.len(), 2 * KINDS.len(), "{unit}");
            let first = laws[3].definition();
            assert!(first.expression.starts_with("k*exp(-(heat "), "{}", first.expression);
        }
    }
}
