//! Formulas against values computed by hand, units, linearity, and everything that is refused.

use super::derivative::derivative;
use super::linear::linear_set;
use super::parse::parsed;
use super::tokens::{MOST_CHARACTERS, MOST_NESTED};
use super::tree::{Syntax, Tree, plain_sign};
use super::*;
use crate::dynamics::{Coulomb, Motion};
use crate::model::{Friction, Joint, JointKind, Mdh};
use nalgebra::Vector3;

/// Two turning joints and a slide.
fn robot() -> Robot {
    let kinds = [JointKind::Revolute, JointKind::Revolute, JointKind::Prismatic];
    let joint = |(i, kind): (usize, JointKind)| {
        let mdh = Mdh {
            alpha: 0.3,
            d: 0.1,
            theta: 0.0,
            r: 0.2,
        };
        Joint::from_mdh(format!("A{}", i + 1), kind, mdh)
    };
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    let joints = kinds.into_iter().enumerate().map(joint).collect();
    Robot::new("bench", Vector3::new(0.0, 0.0, -9.81), joints, friction).unwrap()
}

fn parameter(name: &str, unit: &str, range: [Option<f64>; 2]) -> ParameterDefinition {
    ParameterDefinition {
        name: name.into(),
        unit: unit.into(),
        low: range[0],
        high: range[1],
    }
}

/// An effect on A2 with free parameters.
fn definition(expression: &str, parameters: &[(&str, &str)]) -> Definition {
    Definition {
        channels: Vec::new(),
        name: "mine".into(),
        joint: "A2".into(),
        expression: expression.into(),
        parameters: parameters.iter().map(|(n, u)| parameter(n, u, [None; 2])).collect(),
        declared: false,
    }
}

/// What is wrong with a definition: pointer, and the whole problem in words.
fn faults(definition: Definition) -> Vec<(String, String)> {
    match OwnEffect::new(definition, &robot()) {
        Ok(effect) => panic!("{effect:?}"),
        Err(all) => all.iter().map(|p| (p.pointer.clone(), p.to_string())).collect(),
    }
}

/// The value of a formula at values of its names.
fn at(text: &str, values: &[(&str, f64)]) -> f64 {
    let (tree, names) = parsed(text).unwrap_or_else(|e| panic!("{text}: {e:?}"));
    let value = |s: usize| {
        values
            .iter()
            .find(|v| v.0 == names[s])
            .unwrap_or_else(|| panic!("{}", names[s]))
            .1
    };
    tree.value(&value, &|v, _| plain_sign(v))
}

#[test]
fn prop_formulas_have_the_values_computed_by_hand() {
    let x = &[("x", 3.0), ("y", 0.5), ("z", -2.0)][..];
    let cases = [
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2 - -3", f64::NAN),
        ("-x + y", -2.5),
        ("-x*y", -1.5),
        ("+x", 3.0),
        ("x - y - z", 4.5),
        ("x - y + z", 0.5),
        ("x/y/z", -3.0),
        ("x/y*z", -12.0),
        ("x*y/z", -0.75),
        ("2*x^2/3", 6.0),
        ("x^-2", 1.0 / 9.0),
        ("x^(-y)", 1.0 / 3f64.sqrt()),
        ("z^3", -8.0),
        ("(x^2)^y", 3.0),
        ("1e-3*x + 2.5E2*y - .5", 124.503),
        ("exp(-(x/2)^2)", (-2.25f64).exp()),
        ("ln(x) - log(x)", 0.0),
        ("log(100)", 100f64.ln()),
        ("sign(z) + sign(x)*sign(y - 0.5)", -1.0),
        ("abs(z)^0.5", 2f64.sqrt()),
        ("sqrt(x + 1)", 2.0),
        (
            "tanh(x)/tan(y) - sin(x)*cos(z)",
            3f64.tanh() / 0.5f64.tan() - 3f64.sin() * 2f64.cos(),
        ),
        ("2*pi", std::f64::consts::TAU),
        ("((((x))))", 3.0),
        ("2 - 3 - 4", -5.0),
        ("2 - 3*4 + 5/2 - 1", -8.5),
    ];
    for (text, expected) in cases {
        if expected.is_nan() {
            assert!(parsed(text).is_err(), "{text}");
            continue;
        }
        let value = at(text, x);
        assert!((value - expected).abs() < 1e-12, "{text} = {value}, expected {expected}");
    }
}

/// A number below `n`.
fn draw(seed: &mut u64, n: u64) -> u64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) % n
}

/// A pseudo-random formula in x, y and z that has a value everywhere but at few points.
fn random_tree(seed: &mut u64, depth: usize) -> Tree {
    use super::tree::{Function, Operation};
    if depth == 0 || draw(seed, 5) == 0 {
        return match draw(seed, 4) {
            0 => Tree::Number(draw(seed, 50) as f64 / 8.0),
            s => Tree::Symbol(s as usize - 1),
        };
    }
    match draw(seed, 9) {
        0 => Tree::of(Function::Minus, random_tree(seed, depth - 1)),
        1 => Tree::of(Function::NAMED[draw(seed, 4) as usize].1, random_tree(seed, depth - 1)),
        2 => {
            let exponent = Tree::Number(draw(seed, 3) as f64 + 1.0);
            Tree::pair(Operation::Power, random_tree(seed, depth - 1), exponent)
        }
        k => {
            let operation = [Operation::Add, Operation::Subtract, Operation::Multiply, Operation::Divide][k as usize % 4];
            Tree::pair(operation, random_tree(seed, depth - 1), random_tree(seed, depth - 1))
        }
    }
}

#[test]
fn prop_what_is_written_reads_back_as_the_same_formula() {
    let names = ["x", "y", "z"];
    let point = [0.7, -1.3, 2.1];
    let mut compared = 0;
    for mut seed in 0..400 {
        let tree = random_tree(&mut seed, 5);
        let text = tree.written(Syntax::Text, &|s| names[s].into());
        if text.len() > MOST_CHARACTERS {
            continue;
        }
        let (read, found) = parsed(&text).unwrap_or_else(|e| panic!("{text}: {e:?}"));
        let truth = tree.value(&|s| point[s], &|v, _| plain_sign(v));
        let of = |s: usize| point[names.iter().position(|n| *n == found[s]).unwrap()];
        let value = read.value(&of, &|v, _| plain_sign(v));
        if truth.is_finite() && truth.abs() < 1e12 {
            compared += 1;
            assert!(
                (value - truth).abs() <= 1e-9 * truth.abs().max(1.0),
                "{text}: {value}, expected {truth}"
            );
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn prop_derivatives_are_differences_of_values() {
    let point = [0.7, -1.3, 2.1];
    let mut compared = 0;
    for mut seed in 1000..1200 {
        let tree = random_tree(&mut seed, 4);
        let slope = derivative(&tree, 0);
        let value = |tree: &Tree, x: f64| tree.value(&|s| if s == 0 { x } else { point[s] }, &|v, _| plain_sign(v));
        let h = 1e-5;
        let [up, down, slope] = [
            value(&tree, point[0] + h),
            value(&tree, point[0] - h),
            value(&slope, point[0]),
        ];
        // Central differences are off by h²/6 times a third derivative: formulas that bend more are left out.
        if up.is_finite() && down.is_finite() && slope.abs() < 1e3 && up.abs() < 1e3 {
            compared += 1;
            let difference = (up - down) / (2.0 * h);
            assert!(
                (difference - slope).abs() < 1e-4 * slope.abs().max(1.0),
                "{tree:?}: {difference}, {slope}"
            );
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn derivatives_go_through_absolute_values_and_signs() {
    let (tree, names) = parsed("k*abs(x)*sign(y) + k^2*z").unwrap();
    let symbol = |name: &str| names.iter().position(|n| n == name).unwrap();
    let slope = derivative(&tree, symbol("k"));
    let values = |s: usize| {
        [("k", 2.0), ("x", -3.0), ("y", -1.0), ("z", 0.5)]
            .iter()
            .find(|v| v.0 == names[s])
            .unwrap()
            .1
    };
    assert_eq!(slope.value(&values, &|v, _| plain_sign(v)), -3.0 + 2.0);
    let slope = derivative(&tree, symbol("x"));
    assert_eq!(slope.value(&values, &|v, _| plain_sign(v)), 2.0);
}

#[test]
fn parameters_are_coefficients_where_the_formula_is_linear_in_all_of_them() {
    let linear = |text: &str, parameters: &[&str]| {
        let (tree, names) = parsed(text).unwrap();
        let symbols: Vec<usize> = parameters
            .iter()
            .map(|p| names.iter().position(|n| n == p).unwrap())
            .collect();
        let set = linear_set(&tree, &symbols, names.len());
        set.into_iter().map(|s| names[s].clone()).collect::<Vec<_>>()
    };
    assert_eq!(linear("k*sin(q2 - q0)", &["k", "q0"]), ["k"]);
    assert_eq!(linear("k*(q2 - q0)", &["q0", "k"]), ["k"]);
    assert_eq!(linear("k*q2 + c", &["k", "c"]), ["k", "c"]);
    assert_eq!(linear("(a*q1 + b)*sin(s*q2)", &["a", "b", "s"]), ["a", "b"]);
    assert_eq!(linear("a*b*q1", &["a", "b"]), ["a"]);
    assert_eq!(linear("k*tanh(qd2/s)", &["k", "s"]), ["k"]);
    assert_eq!(linear("k*abs(q2 - q0)", &["k", "q0"]), ["k"]);
    assert_eq!(linear("(k*q1 + c*q2)/(1 + s*q1^2)", &["k", "c", "s"]), ["k", "c"]);
    assert_eq!(linear("k*q1 - k*q1 + c*q1", &["c"]), ["c"]);
    assert!(linear("sin(k*q1)", &["k"]).is_empty());
    assert!(linear("k*q1 + 3", &["k"]).is_empty());
    assert!(linear("abs(k)*q1", &["k"]).is_empty());
    assert!(linear("k^2*q1 + k*q1", &["k"]).is_empty());
}

/// The torque of an effect with values of its coefficients and shapes, one sample of `[q, qd, qdd]` per joint.
fn torque(effect: &OwnEffect, c: &[f64], shape: &[f64], state: &[[f64; 3]]) -> f64 {
    let robot = robot();
    let mut motion = Motion::zeros(3, 1);
    state.iter().enumerate().for_each(|(j, s)| motion.set(j, 0, *s));
    let scene = Scene {
        robot: &robot,
        motion: &motion,
        rigid: &[],
        declared: &[],
        interval: 0.01,
        periodic: false,
        coulomb: Coulomb::Sign,
    };
    let columns = effect.columns(0, &scene, &[1], shape);
    columns.iter().zip(c).map(|(column, c)| c * column.rows[0].1[0]).sum()
}

#[test]
fn columns_are_the_formula_and_follow_the_definition() {
    let mut given = definition(
        "k*sin(q2 - q0) + c*qd1*abs(qd_A2) + j*qdd2",
        &[("q0", "rad"), ("k", "N m"), ("c", "N m s^2/rad^2"), ("j", "kg m^2")],
    );
    given.parameters[1].low = Some(0.0);
    let effect = OwnEffect::new(given, &robot()).unwrap();
    let names: Vec<String> = effect.parameters(0, &robot(), &[1]).into_iter().map(|p| p.name).collect();
    assert_eq!(names, ["k", "c", "j", "q0"]);
    assert_eq!(effect.positive(0), [0]);
    let state = [[0.1, 0.4, 0.0], [0.7, -0.5, 1.5], [0.0; 3]];
    let value = torque(&effect, &[2.0, 3.0, 0.1], &[0.2], &state);
    assert!((value - (2.0 * 0.5f64.sin() + 3.0 * 0.4 * 0.5 + 0.15)).abs() < 1e-14);
    assert_eq!(effect.reads(), Reads::Arm);
    let formula = effect.formula(0, &[1]).unwrap();
    assert_eq!(formula.torques, [(1, "k*sin(q2 - q0) + c*qd1*abs(qd2) + j*qdd2".to_string())]);
    assert_eq!(formula.variables, ["qd1", "q2", "qd2", "qdd2"]);
    let constants = ["A", "B", "C", "D"].map(String::from);
    let state = |joint: usize, order: usize| format!("{}[{joint}]", ["q", "v", "a"][order]);
    let channel = |c: &ChannelVariable| c.name.clone();
    let names = SourceNames {
        constants: &constants,
        state: &state,
        channel: &channel,
    };
    assert_eq!(effect.source(&names), "A*sin(q[1] - D) + B*v[0]*fabs(v[1]) + C*a[1]");
    assert_eq!(effect.inertia_source(1, &names).as_deref(), Some("C"));
    assert_eq!(effect.inertia_source(0, &names), None);
}

#[test]
fn an_angle_without_a_range_goes_round_and_is_reported_within_half_a_turn() {
    let effect = OwnEffect::new(definition("k*sin(2*(q2 - q0))", &[("k", "N m"), ("q0", "rad")]), &robot()).unwrap();
    let shape = &effect.shapes(0, &[1], &[])[0];
    assert_eq!([shape.low, shape.high], [-TAU, TAU]);
    assert!(shape.grid.iter().all(|v| (-PI..PI).contains(v)));
    let reported = effect.reported(0, &[1.0], &[4.0]);
    assert!((reported[1] - (4.0 - TAU)).abs() < 1e-12);
    let spring = OwnEffect::new(definition("k*(q2 - q0)", &[("k", "N m/rad"), ("q0", "rad")]), &robot()).unwrap();
    let shape = &spring.shapes(0, &[1], &[])[0];
    assert_eq!([shape.low, shape.high], [-PI, PI]);
    assert_eq!(spring.reported(0, &[1.0], &[2.0])[1], 2.0);
}

#[test]
fn units_fit_with_and_without_radians() {
    let fits = |expression: &str, parameters: &[(&str, &str)]| {
        let given = definition(expression, parameters);
        let ranged = |p: ParameterDefinition| parameter(&p.name, &p.unit, [Some(0.1), Some(2.0)]);
        let parameters = given.parameters.clone().into_iter().map(ranged).collect();
        OwnEffect::new(Definition { parameters, ..given }, &robot()).map(|_| ())
    };
    for unit in [
        "N m/rad",
        "N m",
        "J",
        "kg m^2/s^2",
        "N·m/rad",
        "N*m",
        "W s",
        "Pa m^3",
        "N m rad^-1",
    ] {
        assert_eq!(fits("k*q2", &[("k", unit)]), Ok(()), "{unit}");
    }
    for unit in ["N m s/rad", "N m s", "kg m^2/(s rad)", "kg m^2/s"] {
        assert_eq!(fits("k*qd2", &[("k", unit)]), Ok(()), "{unit}");
    }
    assert_eq!(fits("k*sqrt(q3/d)*sign(qd3)", &[("k", "N m"), ("d", "m")]), Ok(()));
    assert_eq!(fits("k*abs(qd2/s)^p", &[("k", "N m"), ("s", "rad/s"), ("p", "1")]), Ok(()));
    assert_eq!(fits("k*abs(qd2)^0.5", &[("k", "N m s^0.5")]), Ok(()));
    assert_eq!(fits("k*q3", &[("k", "N")]), Ok(()));
}

#[test]
fn a_wrong_unit_is_named_with_the_one_that_fits() {
    let only = |given: Definition| {
        let all = faults(given);
        assert_eq!(all.len(), 1, "{all:?}");
        all[0].clone()
    };
    let (pointer, text) = only(definition("k*sin(q2)", &[("k", "N")]));
    assert_eq!(pointer, "/parameters/0/unit");
    assert!(text.contains("N m would fit"), "{text}");
    let mut length = definition("k*sin(q2 - q0)", &[("k", "N m"), ("q0", "m")]);
    (length.parameters[1].low, length.parameters[1].high) = (Some(-1.0), Some(1.0));
    let (pointer, text) = only(length);
    assert_eq!(pointer, "/parameters/1/unit", "{text}");
    assert!(text.contains("1 would fit"), "{text}");
    let mut two = definition("k*tanh(qd2/s)", &[("k", "N m"), ("s", "m/s")]);
    (two.parameters[1].low, two.parameters[1].high) = (Some(0.01), Some(1.0));
    let (pointer, text) = only(two);
    assert_eq!(pointer, "/parameters/1/unit", "{text}");
    assert!(text.contains("1/s would fit"), "{text}");
    let (pointer, text) = only(definition("k*q2 + k*qd2", &[("k", "N m")]));
    assert_eq!(pointer, "/expression");
    assert!(text.contains("adds `k*q2` (N m) and `k*qd2` (N m/s)"), "{text}");
    let (pointer, _) = only(definition("k*sin(qd2)", &[("k", "N m")]));
    assert_eq!(pointer, "/expression");
    for (unit, remedy) in [
        ("Nm", "write N m"),
        ("deg", "write rad"),
        ("parsec", "SI units"),
        ("", "SI units"),
        ("2 m", "SI units"),
    ] {
        let (pointer, text) = only(definition("k*q2", &[("k", unit)]));
        assert_eq!(pointer, "/parameters/0/unit");
        assert!(text.contains(remedy), "{text}");
    }
}

#[test]
fn every_fault_is_found_at_once_with_its_place_and_a_remedy() {
    let given = Definition {
        channels: Vec::new(),
        name: "torque_offset".into(),
        joint: "A9".into(),
        expression: "k*sin(q2 - q0) + z*q9".into(),
        parameters: vec![
            parameter("k", "Nm", [Some(2.0), Some(1.0)]),
            parameter("q0", "rad", [None; 2]),
            parameter("k", "N m", [None; 2]),
            parameter("qd1", "rad/s", [None; 2]),
            parameter("sin", "1", [None; 2]),
        ],
        declared: false,
    };
    let all = faults(given);
    let pointers: Vec<&str> = all.iter().map(|f| f.0.as_str()).collect();
    assert_eq!(
        pointers,
        [
            "/name",
            "/joint",
            "/parameters/0/unit",
            "/parameters/0/high",
            "/parameters/2/name",
            "/parameters/3/name",
            "/parameters/4/name",
            "/expression",
            "/expression",
        ]
    );
    assert!(all.iter().all(|f| f.1.ends_with(')')), "every problem has a remedy: {all:?}");
}

#[test]
fn expressions_that_say_nothing_clear_are_refused() {
    let deep = "(".repeat(100_000) + "q2" + &")".repeat(100_000);
    let nested = format!("k*{}q2{}", "(".repeat(MOST_NESTED + 1), ")".repeat(MOST_NESTED + 1));
    let long = format!("k*(q2{})", " + q2".repeat(80));
    let cases = [
        ("", "is empty"),
        ("k*", "ends with `*`"),
        ("k**2*q2", "`**`"),
        ("k q2", "no operator between"),
        ("2k*q2", "no operator between"),
        ("k(q2)", "is no function"),
        ("sin*q2", "without parentheses"),
        ("k*-q2", "where a value is expected"),
        ("k*/q2", "where a value is expected"),
        ("k*()", "where a value is expected"),
        ("k*(q2", "open parentheses"),
        ("k*q2)", "not open"),
        ("k*q2^2^3", "power of a power"),
        ("k*atan2(q1, q2)", "character `,`"),
        ("k*{q2}", "character `{`"),
        ("k = q2", "character `=`"),
        ("k·q2", "character `\\u{b7}`"),
        ("k*q2 # x", "character `#`"),
        ("1.2.3*k*q2", "no operator between"),
        ("k*q12", "neither a variable"),
        ("k*q0", "neither a variable"),
        ("k*e", "neither a variable"),
        ("k + PI", "neither a variable"),
        ("sin(q2)", "changes nothing"),
        ("k*q2 + 1", "no parameter that it is linear in"),
        ("sin(k*q2)", "no parameter that it is linear in"),
        ("0*k", "changes nothing"),
        ("k*q2^q2^-2", "power of a power"),
        (nested.as_str(), "parentheses within each other"),
        (long.as_str(), "characters"),
        (deep.as_str(), "characters"),
    ];
    for (expression, expected) in cases {
        let all = faults(definition(expression, &[("k", "N m")]));
        let shown: String = expression.chars().take(50).collect();
        assert!(all.iter().any(|f| f.1.contains(expected)), "{shown}: {all:?}");
        assert!(all.iter().all(|f| f.1.len() < 400), "{shown}: {all:?}");
    }
}

#[test]
fn ranges_are_asked_for_where_the_formula_is_not_linear() {
    let all = faults(definition("k*tanh(qd2/s)", &[("k", "N m"), ("s", "rad/s")]));
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(all[0].0, "/parameters/1/low");
    let mut half = definition("k*tanh(qd2/s)", &[("k", "N m"), ("s", "rad/s")]);
    half.parameters[1].low = Some(0.01);
    assert_eq!(faults(half)[0].0, "/parameters/1/high");
    let four = definition(
        "k*sin(a*q2 + sin(b*q2 + sin(c*q2 + sin(d*q2))))",
        &[("k", "N m"), ("a", "1"), ("b", "1"), ("c", "1"), ("d", "1")],
    );
    assert!(faults(four)[0].1.contains("is not linear in a, b, c, d"));
    let nine: Vec<(String, &str)> = (0..9).map(|i| (format!("k{i}"), "N m")).collect();
    let nine: Vec<(&str, &str)> = nine.iter().map(|(n, u)| (n.as_str(), *u)).collect();
    assert!(faults(definition("k0*q2", &nine))[0].1.contains("9 parameters"));
}

#[test]
fn values_that_are_none_are_found_and_never_computed_with() {
    let mut given = definition("k/(q2 - q0) + c*sqrt(q1)", &[("k", "N m"), ("q0", "rad"), ("c", "N m")]);
    (given.parameters[1].low, given.parameters[1].high) = (Some(-1.0), Some(1.0));
    let effect = OwnEffect::new(given, &robot()).unwrap();
    let robot = robot();
    let mut motion = Motion::zeros(3, 3);
    (0..3).for_each(|s| motion.set(0, s, [1.0 - s as f64, 0.0, 0.0]));
    (0..3).for_each(|s| motion.set(1, s, [0.5, 0.0, 0.0]));
    let scene = Scene {
        robot: &robot,
        motion: &motion,
        rigid: &[],
        declared: &[],
        interval: 0.01,
        periodic: false,
        coulomb: Coulomb::Sign,
    };
    let fault = effect.not_finite(&scene, &[0.5]).unwrap();
    assert_eq!(
        (fault.sample, fault.at.as_str()),
        (0, "q0 = 0.500000, q1 = 1.000000, q2 = 0.500000")
    );
    let fault = effect.not_finite(&scene, &[0.0]).unwrap();
    assert!(fault.sample == 2 && fault.value.is_nan(), "{fault:?}");
    for shape in [0.5, 0.0] {
        let columns = effect.columns(0, &scene, &[1], &[shape]);
        assert!(columns.iter().flat_map(|c| &c.rows[0].1).all(|v| v.is_finite()));
    }
}

/// As long and as deep as the limits allow: read within a thread's usual stack, in little time.
#[test]
fn prop_the_largest_expressions_are_read_in_little_time() {
    let mut worst: f64 = 0.0;
    let names: Vec<String> = (0..8).map(|i| format!("k{i}")).collect();
    let parameters: Vec<(&str, &str)> = names.iter().map(|n| (n.as_str(), "1")).collect();
    let product = names.iter().map(|n| format!("sin({n}*q1)^2*")).collect::<String>() + "k0";
    let quotient = names.iter().fold("q1".to_string(), |inner, n| format!("exp({inner}/{n})"));
    let sum = names
        .iter()
        .map(|n| format!("{n}*sin(q1*{n}^2)/(1+{n})+"))
        .collect::<String>()
        + "k0*k1*k2";
    let deep = (0..MOST_NESTED).fold("k0".to_string(), |inner, i| format!("sin({inner}/k{})", i % 8));
    let chain = format!("k0{}", "+k1".repeat((MOST_CHARACTERS - 2) / 3));
    let tower = (0..MOST_NESTED).fold("k0".to_string(), |inner, _| format!("(k1^{inner})"));
    for text in [&product, &quotient, &sum, &deep, &chain, &tower] {
        assert!(text.len() <= MOST_CHARACTERS, "{text}");
        let start = std::time::Instant::now();
        let _ = OwnEffect::new(definition(text, &parameters), &robot());
        worst = worst.max(start.elapsed().as_secs_f64());
    }
    // A request waits for this.
    assert!(worst < 1.0, "{worst} s");
}

/// `q`, `qd`, `qdd` are those of the joint that the effect acts on, unless a parameter has the name.
#[test]
fn own_variables_are_those_of_the_joint() {
    let text = |definition: Definition| {
        OwnEffect::new(definition, &robot()).unwrap().formula(0, &[]).unwrap().torques[0]
            .1
            .clone()
    };
    assert_eq!(
        text(definition(
            "k*q + d*qd + m*qdd",
            &[("k", "N m/rad"), ("d", "N m s/rad"), ("m", "kg m^2")]
        )),
        "k*q2 + d*qd2 + m*qdd2"
    );
    let on_first = |definition: Definition| Definition {
        joint: "A1".into(),
        ..definition
    };
    assert_eq!(text(on_first(definition("k*q", &[("k", "N m/rad")]))), "k*q1");
    assert_eq!(text(definition("q*q1", &[("q", "N m/rad")])), "q*q1");
    // Held against the kind of the joint: on the slide it is a force per length.
    let on_slide = |unit: &str| Definition {
        joint: "A3".into(),
        ..definition("k*q", &[("k", unit)])
    };
    assert_eq!(text(on_slide("N/m")), "k*q3");
    assert_eq!(faults(on_slide("N m/rad"))[0].0, "/parameters/0/unit");
}

/// Without a robot, only what no robot makes right is wrong.
#[test]
fn definitions_are_checked_without_a_robot() {
    let anywhere = |joint: &str, expression: &str, parameters: &[(&str, &str)]| -> Vec<String> {
        let definition = Definition {
            joint: joint.into(),
            ..definition(expression, parameters)
        };
        definition.faults().iter().map(ToString::to_string).collect()
    };
    let nothing: [String; 0] = [];
    for unit in ["N m/rad", "N/m", "N", "N m/m"] {
        // Of a turning joint or a slide, by a turning joint or a slide.
        assert_eq!(anywhere("", "k*q_elbow", &[("k", unit)]), nothing, "{unit}");
    }
    for unit in ["N m/rad", "N/m"] {
        assert_eq!(anywhere("elbow", "k*q_elbow", &[("k", unit)]), nothing, "{unit}");
    }
    // A force per angle is nothing on the same joint.
    assert!(anywhere("elbow", "k*q_elbow", &[("k", "N")])[0].starts_with("/parameters/0/unit: is `N`"));
    assert!(anywhere("", "k*q", &[("k", "N")])[0].starts_with("/parameters/0/unit: is `N`"));
    assert_eq!(anywhere("", "k*q30", &[("k", "N m")]), nothing);
    assert!(anywhere("", "k*q31", &[("k", "N m")])[0].starts_with("/expression: `q31` is neither"));
    assert!(anywhere("", "k*(q1 + qd1)", &[("k", "N m")])[0].starts_with("/expression: "));
    assert!(anywhere("", "k*q +", &[("k", "N m")])[0].starts_with("/expression: "));
    assert!(anywhere("", "sin(q)", &[])[0].starts_with("/expression: has no parameter that it is linear in"));
    assert!(anywhere("", "k*exp(s*q)", &[("k", "N m"), ("s", "1")])[0].starts_with("/parameters/1/low: is missing"));
    // More joints than kinds are tried of: their units are held against the robot alone.
    let many = "k*(q1*q2*q3*q4*q5*q6*q7*q8*q9)";
    assert_eq!(anywhere("", many, &[("k", "V")]), nothing);
}
