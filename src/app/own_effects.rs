//! Whether own effects have values on the logs that they are to explain.

use super::{Code, Error};
use crate::dynamics::Coulomb;
use crate::effects::own::NotFinite;
use crate::effects::{OwnEffect, Scene};
use crate::model::Robot;
use crate::regression::Stretch;

/// Checks an effect at every sample of the logs, for each of `shapes`.
///
/// # Errors
/// `invalid_log` with effect, log, time, and the values that the formula has none for.
pub(super) fn has_values(robot: &Robot, effect: &OwnEffect, shapes: &[Vec<f64>], logs: &[Stretch]) -> Result<(), Error> {
    for log in logs {
        let scene = Scene {
            robot,
            motion: &log.motion,
            rigid: &[],
            declared: &[],
            interval: log.interval,
            periodic: log.periodic,
            coulomb: Coulomb::Sign,
        };
        if let Some(fault) = shapes.iter().find_map(|shape| effect.not_finite(&scene, shape)) {
            return Err(without_value(effect, log, &fault));
        }
    }
    Ok(())
}

fn without_value(effect: &OwnEffect, log: &Stretch, fault: &NotFinite) -> Error {
    let name = &effect.definition().name;
    let value = match fault.value {
        v if v.is_nan() => "no value".to_string(),
        v => format!("the value {v:e}"),
    };
    let detail = format!(
        "the own effect `{name}` has {value} on log `{}` at {:.3} s, where {}",
        log.name,
        fault.sample as f64 * log.interval,
        fault.at
    );
    let hint = format!(
        "change `{}` so that it has a value below 1e12 wherever the robot moves, or the ranges of its parameters: no division by zero, no root or logarithm of \
         negative numbers",
        effect.definition().expression
    );
    Error::new(Code::InvalidLog, detail).with_hint(hint)
}
