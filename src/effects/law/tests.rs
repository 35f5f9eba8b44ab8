//! The formula that is printed is the one that is computed, and energies are energies.

use super::*;
use crate::dynamics::{Coulomb, Motion};
use crate::model::{Friction, Joint, JointKind, Mdh};
use nalgebra::Vector3;

/// Two turning joints and a slide, with names apart from their numbers.
fn robot() -> Robot {
    let kinds = [
        JointKind::Revolute,
        JointKind::Revolute,
        JointKind::Prismatic,
        JointKind::Prismatic,
    ];
    let joint = |(i, kind): (usize, JointKind)| {
        let mdh = Mdh {
            alpha: 0.3,
            d: 0.1,
            theta: 0.0,
            r: 0.2,
        };
        Joint::from_mdh(format!("axis {}", i + 1), kind, mdh)
    };
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    let joints = kinds.into_iter().enumerate().map(joint).collect();
    Robot::new("bench", Vector3::new(0.0, 0.0, -9.81), joints, friction).unwrap()
}

/// One sample of `[q, qd]` per joint.
fn motion(state: &[[f64; 2]]) -> Motion {
    let mut motion = Motion::zeros(state.len(), 1);
    for (j, [q, v]) in state.iter().enumerate() {
        motion.set(j, 0, [*q, *v, 0.0]);
    }
    motion
}

/// Torque of every joint and sample.
fn torques(number: usize, robot: &Robot, motion: &Motion, joints: &[usize], [c, shape]: [&[f64]; 2]) -> Vec<Vec<f64>> {
    let nothing = vec![vec![0.0; motion.samples()]; motion.joints()];
    let scene = Scene {
        robot,
        motion,
        rigid: &nothing,
        declared: &nothing,
        interval: 0.01,
        periodic: false,
        coulomb: Coulomb::Sign,
    };
    let mut sum = nothing.clone();
    for (column, c) in Law.columns(number, &scene, joints, shape).iter().zip(c) {
        for (j, values) in &column.rows {
            sum[*j].iter_mut().zip(values).for_each(|(t, v)| *t += c * v);
        }
    }
    sum
}

/// A recursive-descent reader of `+ - * / ^`, functions of one argument, numbers and names.
struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    value: &'a dyn Fn(&str) -> f64,
}

impl Reader<'_> {
    fn of(text: &str, value: &dyn Fn(&str) -> f64) -> f64 {
        let plain = text.replace(' ', "");
        let mut reader = Reader {
            text: plain.as_bytes(),
            at: 0,
            value,
        };
        let result = reader.sum();
        assert_eq!(reader.at, plain.len(), "{text}");
        result
    }

    fn next(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(0)
    }

    fn takes(&mut self, c: u8) -> bool {
        let yes = self.next() == c;
        self.at += usize::from(yes);
        yes
    }

    fn sum(&mut self) -> f64 {
        let mut sum = if self.takes(b'-') { -self.product() } else { self.product() };
        loop {
            if self.takes(b'+') {
                sum += self.product();
            } else if self.takes(b'-') {
                sum -= self.product();
            } else {
                return sum;
            }
        }
    }

    fn product(&mut self) -> f64 {
        let mut product = self.factor();
        loop {
            if self.takes(b'*') {
                product *= self.factor();
            } else if self.takes(b'/') {
                product /= self.factor();
            } else {
                return product;
            }
        }
    }

    fn factor(&mut self) -> f64 {
        if self.takes(b'-') {
            return -self.factor();
        }
        let base = if self.takes(b'(') { self.closed() } else { self.word() };
        if self.takes(b'^') { base.powf(self.word()) } else { base }
    }

    fn closed(&mut self) -> f64 {
        let value = self.sum();
        assert!(self.takes(b')'));
        value
    }

    fn word(&mut self) -> f64 {
        let from = self.at;
        while self.next().is_ascii_alphanumeric() || self.next() == b'.' || self.next() == b'_' {
            self.at += 1;
        }
        let name = std::str::from_utf8(&self.text[from..self.at]).unwrap().to_string();
        if let Ok(number) = name.parse() {
            return number;
        }
        if !self.takes(b'(') {
            return (self.value)(&name);
        }
        let x = self.sum();
        let second = self.takes(b',').then(|| self.sum());
        assert!(self.takes(b')'));
        match name.as_str() {
            "sin" => x.sin(),
            "cos" => x.cos(),
            "sqrt" => x.sqrt(),
            "abs" | "fabs" => x.abs(),
            "exp" => x.exp(),
            "log" => x.ln(),
            "cosh" => x.cosh(),
            "tanh" => x.tanh(),
            "sign" => x.signum(),
            "pow" => x.powf(second.unwrap()),
            other => panic!("no function {other}"),
        }
    }
}

/// Some numbers for the coefficients and shapes of a form.
fn constants(number: usize, robot: &Robot, joints: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let span = Span {
        range: 1.5,
        highest: 0.9,
        speed: 1.0,
        interval: 0.01,
        speed_error: 0.0,
    };
    let shapes = Law.shapes(number, joints, &vec![span; robot.joint_count()]);
    let count = Law.parameters(number, robot, joints).len() - shapes.len();
    let shape = shapes.iter().map(|s| s.grid[2 * s.grid.len() / 3] + 0.01).collect();
    ((0..count).map(|i| 1.3 - 0.6 * i as f64).collect(), shape)
}

#[test]
fn prop_the_formula_in_text_and_in_source_is_the_torque() {
    let robot = robot();
    let state = [[0.7, -0.4], [-1.1, 0.9], [0.3, 0.25], [-0.2, -0.6]];
    let mut seen = std::collections::BTreeSet::new();
    for (number, &form) in LawForm::all().iter().enumerate() {
        for joints in form.places(&robot) {
            let (c, shape) = constants(number, &robot, &joints);
            let truth = torques(number, &robot, &motion(&state), &joints, [&c, &shape]);
            let reported = Law.reported(number, &c, &shape);
            let infos = Law.parameters(number, &robot, &joints);
            assert_eq!(reported.len(), infos.len(), "{form:?}");
            let value = |name: &str| match infos.iter().position(|i| i.name == name) {
                Some(at) => reported[at],
                None => match name.strip_prefix("qd") {
                    Some(j) => state[j.parse::<usize>().unwrap() - 1][1],
                    None => state[name.strip_prefix('q').expect(name).parse::<usize>().unwrap() - 1][0],
                },
            };
            let literals: Vec<String> = reported.iter().map(|v| format!("({v:?})")).collect();
            let source = statements(form, &joints, &literals, &|j| format!("q{}", j + 1), &|j| {
                format!("qd{}", j + 1)
            });
            let text = formula(form, &joints).torques;
            for list in [&text, &source] {
                assert_eq!(list.iter().map(|t| t.0).collect::<Vec<_>>(), form.acts_on(&joints));
                for (j, text) in list {
                    let read = Reader::of(text, &value);
                    assert!(
                        (read - truth[*j][0]).abs() < 1e-12,
                        "{form:?} on {joints:?}: {text} = {read}, {}",
                        truth[*j][0]
                    );
                    seen.insert(number);
                }
            }
        }
    }
    assert_eq!(seen.len(), LawForm::all().len(), "every form has a place on this robot");
}

#[test]
fn prop_torques_are_the_gradient_of_the_energy_on_every_joint_in_it() {
    let robot = robot();
    let state = [[0.7, -0.4], [-1.1, 0.9], [0.3, 0.25], [-0.2, -0.6]];
    for (number, &form) in LawForm::all().iter().enumerate() {
        for joints in form.places(&robot) {
            let (c, shape) = constants(number, &robot, &joints);
            let Some(energy) = formula(form, &joints).energy else {
                assert!(!form.is_conservative());
                continue;
            };
            let reported = Law.reported(number, &c, &shape);
            let infos = Law.parameters(number, &robot, &joints);
            let at = |joint: usize, step: f64| {
                let value = |name: &str| match infos.iter().position(|i| i.name == name) {
                    Some(at) => reported[at],
                    None => {
                        let j = name.strip_prefix('q').expect(name).parse::<usize>().unwrap() - 1;
                        state[j][0] + if j == joint { step } else { 0.0 }
                    }
                };
                Reader::of(&energy, &value)
            };
            let truth = torques(number, &robot, &motion(&state), &joints, [&c, &shape]);
            for j in 0..robot.joint_count() {
                // Differences of second order over 1e-4 are off by 1e-8 times a third derivative of some hundreds.
                let slope = (at(j, 1e-4) - at(j, -1e-4)) / 2e-4;
                assert!(
                    (slope - truth[j][0]).abs() < 1e-5,
                    "{form:?} {energy}: {slope} {}",
                    truth[j][0]
                );
            }
        }
    }
}

#[test]
fn units_follow_the_kinds_of_the_joints() {
    let robot = robot();
    let unit = |form: LawForm, joints: &[usize]| {
        let number = LawForm::all().iter().position(|f| *f == form).unwrap();
        Law.parameters(number, &robot, joints)
            .into_iter()
            .map(|i| i.unit)
            .collect::<Vec<_>>()
    };
    assert_eq!(unit(LawForm::Spring { rest: true }, &[0, 1]), ["N m/rad", "1", "rad"]);
    assert_eq!(unit(LawForm::Spring { rest: false }, &[2, 3]), ["N/m", "1"]);
    assert_eq!(unit(LawForm::Bilinear, &[0, 2]), ["N m/m"]);
    let product = LawForm::CrossProduct {
        f: OfPosition::Power(2),
        g: OfSpeed::Linear,
    };
    assert_eq!(unit(product, &[2, 0]), ["N s/(rad^2 m)"]);
    assert_eq!(unit(LawForm::CrossSpeed(OfSpeed::Quadratic), &[0, 1]), ["N m s^2/rad^2"]);
    assert_eq!(unit(LawForm::PinSpring, &[0]), ["N m", "N m", "rad", "1"]);
}
