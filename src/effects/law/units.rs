//! Names and units of a law's constants.

use super::form::LawForm;
use super::functions::OfPosition;
use crate::effects::ParameterInfo;
use crate::model::Robot;

/// The constants of a form on its place, in the order in which they are reported.
pub(super) fn parameters(form: LawForm, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo> {
    let names = form.constants().iter();
    names
        .enumerate()
        .map(|(at, name)| ParameterInfo::new(*name, unit(form, at, robot, joints)))
        .collect()
}

fn unit(form: LawForm, at: usize, robot: &Robot, joints: &[usize]) -> String {
    let (first, last) = (joints[0], joints[joints.len() - 1]);
    let effort = robot.joints()[first].effort_unit();
    let per = |powers: &[(usize, usize)], seconds: usize| quotient(robot, effort, powers, seconds);
    let power = |f: OfPosition| if let OfPosition::Power(n) = f { usize::from(n) } else { 0 };
    match (form, at) {
        (LawForm::PinSpring, 1) => effort.into(),
        (LawForm::PinSpring, 3) | (LawForm::Spring { .. } | LawForm::Damper, 1) => "1".into(),
        (LawForm::Saturating, 1) => "1".into(),
        (LawForm::SoftStop { .. }, 1 | 2) | (LawForm::Saturating, 2) => robot.joints()[first].position_unit().into(),
        (LawForm::Spring { .. }, 2) => robot.joints()[first].position_unit().into(),
        // Of the remaining forms only the phase of a wave, and that of a pin spring, comes after the factor.
        (_, 1..) => "rad".into(),
        (LawForm::Position(f), _) => per(&[(first, power(f))], 0),
        (LawForm::Spring { .. } | LawForm::CrossPosition | LawForm::Bilinear, _) => per(&[(last, 1)], 0),
        (LawForm::Product { f, g } | LawForm::CrossProduct { f, g }, _) => {
            per(&[(last, power(f)), (first, g.power())], g.power())
        }
        (LawForm::CrossSpeed(g), _) => per(&[(last, g.power())], g.power()),
        (LawForm::SpeedProduct(g), _) => per(&[(last, 1), (first, g.power())], 1 + g.power()),
        (LawForm::Damper, _) => per(&[(last, 1)], 1),
        (
            LawForm::PinSpring
            | LawForm::Combination { .. }
            | LawForm::HalfCombination { .. }
            | LawForm::SoftStop { .. }
            | LawForm::Saturating,
            _,
        ) => effort.into(),
    }
}

/// `effort s^n/(rad^a m^b)`: powers of positions of joints below, seconds above.
fn quotient(robot: &Robot, effort: &str, powers: &[(usize, usize)], seconds: usize) -> String {
    let raised = |unit: &str, n: usize| match n {
        0 => String::new(),
        1 => unit.to_string(),
        n => format!("{unit}^{n}"),
    };
    let of = |unit: &str| {
        let own = powers.iter().filter(|(j, _)| robot.joints()[*j].position_unit() == unit);
        raised(unit, own.map(|p| p.1).sum())
    };
    let below: Vec<String> = ["rad", "m"].map(of).into_iter().filter(|u| !u.is_empty()).collect();
    let above = [effort.to_string(), raised("s", seconds)];
    let above = above.into_iter().filter(|u| !u.is_empty()).collect::<Vec<_>>().join(" ");
    match below.len() {
        0 => above,
        1 => format!("{above}/{}", below[0]),
        _ => format!("{above}/({})", below.join(" ")),
    }
}
