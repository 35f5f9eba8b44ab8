//! Sizes that a planned recording is said to reveal, held against logs that have them.

use crate::bench::*;
use dynident::diagnosis::{
    Detectable, DiagnosisOptions, Hidden, Inseparable, Plan, ResidualReport, Visible, detectable, diagnose,
};
use dynident::model::Robot;
use dynident::regression::AugmentedModel;
use dynident::simulate::{Experiment, HiddenEffect, ListedEffect, simulate};
use dynident::trajectory::FourierSeries;
use rayon::prelude::*;

const PERIODS: f64 = 6.0;

/// An arm, its bodies and its motion.
struct Bench {
    robot: Robot,
    phi: Vec<f64>,
    series: FourierSeries,
}

impl Bench {
    fn new(robot: Robot, seed: u64) -> Self {
        Self {
            phi: bodies(&robot, seed),
            series: excitation(robot.joint_count(), seed),
            robot,
        }
    }

    fn planned(&self) -> Detectable {
        self.planned_with(PERIODS, 1.0)
    }

    /// With so many periods, and the noise `factor` times the usual.
    fn planned_with(&self, periods: f64, factor: f64) -> Detectable {
        let declared = AugmentedModel::declared(&self.robot);
        let model = AugmentedModel {
            values: declared.base.project(&self.phi),
            ..declared
        };
        let noise: Vec<f64> = noise_levels(self.robot.joint_count()).iter().map(|n| n * factor).collect();
        detectable(&Plan {
            model: &model,
            series: &[&self.series],
            rate_hz: RATE,
            periods,
            torque_noise: &noise,
            own: &[],
            chance: DiagnosisOptions::default().chance,
        })
    }

    /// What a diagnosis finds on a log with these effects.
    fn found(&self, effects: &[HiddenEffect], seed: u64) -> Vec<String> {
        let name = |f: &dynident::diagnosis::Finding| format!("{} {}", f.effect, f.joints.join(" "));
        self.report(effects, seed).findings.iter().map(name).collect()
    }

    fn report(&self, effects: &[HiddenEffect], seed: u64) -> ResidualReport {
        let log = simulate(&Experiment {
            robot: &self.robot,
            parameters: &self.phi,
            trajectory: &self.series,
            periods: PERIODS,
            rate_hz: RATE,
            effects,
            noise: &sensor_noise(self.robot.joint_count()),
            seed,
        });
        diagnose(&self.robot, &[stretch(&log, "planned")], &[], &DiagnosisOptions::default()).report
    }

    /// Share of logs with the effect at this size in which a pair is separated: the effect is found, and the rival neither found
    /// nor named beside it.
    fn apart(&self, visible: &Visible, pair: &Inseparable, size: f64, seeds: std::ops::Range<u64>) -> f64 {
        let hidden = [hidden(visible, size, self.robot.joint_count())];
        let names = |joints: &[usize]| -> Vec<String> { joints.iter().map(|&j| self.robot.joints()[j].name.clone()).collect() };
        let is =
            |effect: &str, joints: &[String], code: &str, on: &[usize]| effect == code && (on.is_empty() || joints == names(on));
        let apart = |seed: &u64| {
            let findings = self.report(&hidden, *seed).findings;
            let found = findings.iter().any(|f| is(&f.effect, &f.joints, &pair.effect, &pair.joints));
            let named = findings.iter().any(|f| {
                let beside = f
                    .rivals
                    .iter()
                    .any(|r| is(&r.effect, &r.joints, &pair.rival, &pair.rival_joints));
                beside || is(&f.effect, &f.joints, &pair.rival, &pair.rival_joints)
            });
            found && !named
        };
        let count = seeds.end - seeds.start;
        seeds.into_par_iter().filter(apart).count() as f64 / count as f64
    }

    /// Share of logs with the effect at `factor` times its size in which anything is found, and what.
    fn rate(&self, visible: &Visible, factor: f64, seeds: std::ops::Range<u64>) -> (f64, Vec<(String, usize)>) {
        let hidden = [hidden(visible, factor * visible.size.unwrap(), self.robot.joint_count())];
        let count = seeds.end - seeds.start;
        let found: Vec<Vec<String>> = seeds.into_par_iter().map(|seed| self.found(&hidden, seed)).collect();
        let hits = found.iter().filter(|f| !f.is_empty()).count();
        let mut names: Vec<(String, usize)> = Vec::new();
        for name in found.into_iter().flatten() {
            match names.iter_mut().find(|n| n.0 == name) {
                Some(known) => known.1 += 1,
                None => names.push((name, 1)),
            }
        }
        names.sort_by_key(|n| std::cmp::Reverse(n.1));
        (hits as f64 / count as f64, names)
    }
}

/// The effect at this size.
fn hidden(visible: &Visible, size: f64, joints: usize) -> HiddenEffect {
    use HiddenEffect::*;
    let size = visible.sign * size;
    let joint = visible.joints.first().copied().unwrap_or(0);
    let other = visible.joints.get(1).copied().unwrap_or(0);
    let assumed = |name: &str| visible.assumed.iter().find(|(p, _)| p.name == name).expect("is assumed").1;
    let of = |name: &str| if visible.parameter.name == name { size } else { 0.0 };
    match visible.effect.as_str() {
        "torque_offset" => TorqueOffset { joint, offset: size },
        "stribeck_friction" => StribeckFriction {
            joint,
            amplitude: size,
            velocity: assumed("velocity"),
            exponent: 2.0,
        },
        "nonlinear_viscous_friction" => NonlinearViscousFriction {
            joint,
            coefficient: size,
            exponent: 2.0,
        },
        "asymmetric_viscous_friction" => AsymmetricViscousFriction {
            joint,
            coefficient: size,
        },
        "load_dependent_friction" => LoadDependentFriction {
            joint,
            coefficient: size,
        },
        "presliding_hysteresis" => PreslidingHysteresis {
            joint,
            amplitude: size,
            width: assumed("width"),
        },
        "smooth_coulomb_friction" => SmoothCoulombFriction {
            joint,
            amplitude: size,
            velocity: assumed("velocity"),
        },
        "rotor_inertia" => RotorInertia { joint, inertia: size },
        "transmission_coupling" => TransmissionCoupling {
            joints: [joint, other],
            ratio: 1.0,
            viscous: of("viscous"),
            coulomb: of("coulomb"),
            inertia: of("inertia"),
        },
        "joint_spring" => JointSpring {
            joint,
            stiffness: size,
            rest: assumed("rest_position"),
        },
        "position_ripple" => PositionRipple {
            joint,
            amplitude: size,
            cycles: assumed("cycles"),
            phase: 0.0,
        },
        "joint_elasticity" => JointElasticity {
            joint,
            stiffness: 1.0 / size,
        },
        "encoder_offset" => EncoderOffset { joint, offset: size },
        "base_tilt" => BaseTilt {
            roll: of("roll"),
            pitch: of("pitch"),
        },
        "torque_delay" => TorqueDelay { seconds: size },
        "torque_gain" => TorqueGain { joint, gain: 1.0 + size },
        "torque_crosstalk" => TorqueCrosstalk {
            joint,
            from: other,
            coefficient: size,
        },
        "friction_drift" => {
            let constant = assumed("time_constant");
            // The size is the change over the log, the effect what fades from its start.
            let length = PERIODS / 0.1;
            let start = 1.0 / (1.0 - (-length / constant).exp());
            FrictionDrift {
                joint,
                viscous: of("viscous_change") * start,
                coulomb: of("coulomb_change") * start,
                time_constant: constant,
            }
        }
        "external_contact" => {
            // In the middle of the fourth period.
            let start = 35.0;
            ExternalContact {
                start,
                end: start + assumed("duration"),
                torque: (0..joints).map(|j| if j == joint { size } else { 0.0 }).collect(),
            }
        }
        "torque_saturation" => Listed(ListedEffect {
            code: visible.effect.clone(),
            form: 0,
            joints: vec![joint],
            coefficients: vec![size],
            shape: Vec::new(),
        }),
        code => panic!("no such effect: {code}"),
    }
}

/// The whole table:
/// `DYNIDENT_DETECTABLE=seeds[,code[,factor]] cargo test --release --test effects -- --ignored --nocapture detectable::table`.
#[test]
#[ignore = "minutes to hours: the whole table of sizes against logs"]
fn table() {
    let asked = std::env::var("DYNIDENT_DETECTABLE").unwrap_or_default();
    let mut parts = asked.split(',');
    let seeds: u64 = parts.next().and_then(|n| n.parse().ok()).unwrap_or(40);
    let code = parts.next().unwrap_or("").to_string();
    let factor: f64 = parts.next().and_then(|n| n.parse().ok()).unwrap_or(1.0);
    let arm = parts.next().unwrap_or("four");
    let robot = match arm {
        "seven" => seven_axes(),
        "six" => six_axes(),
        _ => four_axes(),
    };
    let every: usize = parts.next().and_then(|n| n.parse().ok()).unwrap_or(1);
    let bench = Bench::new(robot, 7);
    let started = std::time::Instant::now();
    let planned = bench.planned();
    println!(
        "{} effects, {} pairs in {:.3} s",
        planned.effects.len(),
        planned.pairs.len(),
        started.elapsed().as_secs_f64()
    );
    for (at, visible) in planned
        .effects
        .iter()
        .enumerate()
        .filter(|(_, v)| v.effect.contains(code.as_str()))
    {
        let place: Vec<String> = visible.joints.iter().map(|j| format!("J{}", j + 1)).collect();
        let head = format!("{:28} {:6} {:10}", visible.effect, place.join(" "), visible.parameter.name);
        let Ok(size) = visible.size else {
            println!("{head} {:?}", visible.size);
            continue;
        };
        if at % every != 0 {
            continue;
        }
        let (rate, names) = match seeds {
            0 => (f64::NAN, Vec::new()),
            _ => bench.rate(visible, factor, 0..seeds),
        };
        let pairs = planned
            .pairs
            .iter()
            .filter(|p| p.effect == visible.effect && p.joints == visible.joints && p.parameter == visible.parameter.name);
        let pairs: Vec<String> = pairs
            .map(|p| {
                format!(
                    "{} {:?} {:.3} {:.2}",
                    p.rival,
                    p.rival_joints,
                    p.correlation,
                    p.told_apart_from.map_or(f64::NAN, |t| t / size)
                )
            })
            .collect();
        println!(
            "{head} {:10.4} {:6} {:.3} {names:?} | {pairs:?}",
            visible.sign * size,
            visible.parameter.unit,
            rate
        );
    }
}

/// Pairs at the size from which they are separated, as `table`.
#[test]
#[ignore = "minutes to hours: pairs of effects against logs"]
fn pairs() {
    let seeds: u64 = std::env::var("DYNIDENT_DETECTABLE")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(40);
    let bench = Bench::new(four_axes(), 7);
    let planned = bench.planned();
    for pair in &planned.pairs {
        let is_own = |v: &&Visible| v.effect == pair.effect && v.joints == pair.joints && v.parameter.name == pair.parameter;
        let visible = planned.effects.iter().find(is_own).expect("a pair is of an effect");
        let Some(size) = pair.told_apart_from else { continue };
        let rates = [1.0, size / visible.size.unwrap()].map(|f| bench.apart(visible, pair, f * visible.size.unwrap(), 0..seeds));
        println!(
            "{} {:?} {} / {} {:?}: correlation {:.3}, apart in {:.3} at the smallest size, {:.3} at {:.2} times it",
            pair.effect,
            pair.joints,
            pair.parameter,
            pair.rival,
            pair.rival_joints,
            pair.correlation,
            rates[0],
            rates[1],
            size / visible.size.unwrap()
        );
    }
}

/// Logs of the short test.
const SEEDS: u64 = 60;

/// Ninety in a hundred. Of sixty logs 47 to 58 are within three and two standard deviations; were the size 1.3 times too large,
/// all of them would show the effect, and were it as much too small, half of them.
#[test]
fn val_effects_of_the_size_given_are_found_as_often_as_said() {
    let bench = Bench::new(four_axes(), 7);
    let planned = bench.planned();
    for (effect, joint) in [("torque_offset", 2), ("presliding_hysteresis", 0), ("external_contact", 3)] {
        let visible = planned
            .effects
            .iter()
            .find(|v| v.effect == effect && v.joints == [joint])
            .unwrap();
        let (rate, names) = bench.rate(visible, 1.0, 0..SEEDS);
        let hits = (rate * SEEDS as f64).round() as u64;
        assert!((47..=58).contains(&hits), "{visible:?}: {hits} of {SEEDS}, {names:?}");
    }
}

/// Twice the size has four times the gain: no log misses it. Friction acts on the motors; along the bent motion its sign would be
/// wrong beside every reversal, and the fit worse than without elasticity.
#[test]
fn prop_elasticity_of_a_soft_joint_is_found_beside_its_friction() {
    let bench = Bench::new(four_axes(), 7);
    let planned = bench.planned();
    let is_third = |v: &&Visible| v.effect == "joint_elasticity" && v.joints == [2];
    let visible = planned.effects.iter().find(is_third).unwrap();
    let hidden = [hidden(visible, 2.0 * visible.size.unwrap(), 4)];
    for seed in 0..4 {
        assert_eq!(bench.found(&hidden, seed), ["joint_elasticity J3"], "seed {seed}");
    }
}

#[test]
fn prop_sizes_go_with_the_noise_and_fall_with_the_root_of_the_periods() {
    let bench = Bench::new(four_axes(), 7);
    let sizes = |planned: Detectable| -> Vec<Option<f64>> {
        let searched = planned
            .effects
            .into_iter()
            .filter(|v| !["friction_drift", "external_contact"].contains(&v.effect.as_str()));
        searched.map(|v| v.size.ok()).collect()
    };
    let [plain, loud, long] = [(6.0, 1.0), (6.0, 2.0), (24.0, 1.0)].map(|(p, f)| sizes(bench.planned_with(p, f)));
    let mut compared = 0;
    for ((plain, loud), long) in plain.iter().zip(&loud).zip(&long) {
        // With twice the noise some leave their range.
        let (Some(plain), Some(loud), Some(long)) = (plain, loud, long) else {
            continue;
        };
        // Whether a rival that stands in for the effect would be physical depends on the size, in steps.
        compared += usize::from((loud / plain - 2.0).abs() < 1e-9 && (long / plain - 0.5).abs() < 1e-9);
    }
    assert!(
        compared * 10 > plain.iter().flatten().count() * 9,
        "{compared} of {}",
        plain.len()
    );
}

/// The first joint stands upright and the second one's axis keeps its direction to it: the base inertias of both hold their
/// rotors'. The encoder of the last joint turns with its link. A spring is an offset with a slope.
#[test]
fn what_base_parameters_hold_is_absorbed_and_what_is_alike_is_a_pair() {
    let planned = Bench::new(four_axes(), 7).planned();
    let of = |effect: &str, joint: usize| {
        planned
            .effects
            .iter()
            .find(|v| v.effect == effect && v.joints == [joint])
            .unwrap()
    };
    for (effect, joint) in [("rotor_inertia", 0), ("rotor_inertia", 1), ("encoder_offset", 3)] {
        assert_eq!(of(effect, joint).size, Err(Hidden::Absorbed), "{effect} {joint}");
    }
    assert!(of("rotor_inertia", 2).size.is_ok());
    // The second joint turns round within one fold of the motion. The last link is light: only a gear softer than any would show.
    assert_eq!(of("smooth_coulomb_friction", 1).size, Err(Hidden::ShownOnce));
    assert!(matches!(of("joint_elasticity", 3).size, Err(Hidden::BeyondRange(size)) if size > 1e-3));
    for joint in 0..4 {
        let pair = planned
            .pairs
            .iter()
            .find(|p| p.effect == "torque_offset" && p.joints == [joint] && p.rival == "joint_spring");
        let pair = pair.expect("an offset is the limit of a spring");
        assert!(pair.correlation > 1.0 - 1e-9 && pair.told_apart_from.is_none(), "{pair:?}");
    }
}
