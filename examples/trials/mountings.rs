//! Arms on walls and ceilings that are declared upright, and arms with a rotor inertia on every joint.

use crate::bench::*;
use crate::grid::found;
use dynident::model::Robot;
use dynident::simulate::HiddenEffect;

pub fn mountings(seeds: u64, first: u64) {
    let (mut right, mut all) = (0, 0);
    for robot in robots() {
        for (m, direction) in directions().into_iter().enumerate() {
            for seed in first..first + seeds {
                let (gravity, list) = mounted(&robot, direction, 4000 + 100 * m as u64 + seed);
                let off = gravity
                    .map_or(direction.angle(&robot.gravity()), |g| g.angle(&direction))
                    .to_degrees();
                let is_right = off < 0.2 && list.is_empty();
                right += usize::from(is_right);
                all += 1;
                if !is_right {
                    println!(
                        "{} {:?} seed {seed}: off by {off:.3}°, {gravity:?}, {list:?}",
                        robot.name(),
                        direction.as_slice()
                    );
                }
            }
        }
    }
    println!("{right} of {all} mountings within 0.2° and nothing else");
}

/// Gravity as found and what else, for an arm whose gravity points elsewhere than declared.
fn mounted(robot: &Robot, direction: nalgebra::Vector3<f64>, seed: u64) -> (Option<nalgebra::Vector3<f64>>, Vec<String>) {
    let (gravity, outcome) = traced_mounted(robot, direction, &[], seed);
    (gravity, found(&outcome))
}

const INERTIAS: [f64; 3] = [0.3, 1.0, 3.0];

pub fn rotors(seeds: u64, first: u64) {
    let (mut right, mut all) = (0, 0);
    for robot in robots() {
        for size in INERTIAS {
            for seed in first..first + seeds {
                let n = robot.joint_count();
                let inertia = |joint: usize| size * 0.3 * noise_levels(n)[joint] / 0.2;
                let effects: Vec<HiddenEffect> = (0..n)
                    .map(|joint| HiddenEffect::RotorInertia {
                        joint,
                        inertia: inertia(joint),
                    })
                    .collect();
                let outcome = traced(&robot, &effects, &sensor_noise(n), 7000 + seed);
                let list = found(&outcome);
                // What base parameters hold is not listed among what could have been found.
                let missed = outcome.report.undetected.iter().filter(|u| u.effect == "rotor_inertia");
                let open: Vec<String> = missed.map(|u| u.joint.clone()).collect();
                let is_right = !list.is_empty() && list.iter().all(|f| f.starts_with("rotor_inertia:"));
                right += usize::from(is_right);
                all += 1;
                println!("{} size {size} seed {seed}: {list:?}, not found {open:?}", robot.name());
            }
        }
    }
    println!("{right} of {all} with rotor inertias and nothing else");
}
