//! A smooth function of one or two variables: what is left when no effect explains it. Never in the list of effects: it names
//! variables, not causes.

use super::{About, Column, Effect, EffectKind, ParameterInfo, PlotVariable, Scene};
use crate::model::Robot;

/// `tau_j += Σ c f(u) g(v)` with f and g from a small dictionary: waves of a position, powers of anything.
///
/// `joints` is `[row, variable (, variable (, second row))]`, variables coded as of [`variable_name`]; the shape holds centre and
/// half range per variable, then the numbers of the products taken (all of them where none is named), and is not estimated.
pub(crate) struct Unexplained;

/// `q3`, `qd3` or `load3` for variable 2, n + 2, 2 n + 2.
pub(crate) fn variable_name(code: usize, joints: usize) -> String {
    format!("{}{}", ["q", "qd", "load"][code / joints], code % joints + 1)
}

/// Values of a variable over the samples.
pub(crate) fn variable(scene: &Scene, code: usize) -> Vec<f64> {
    let n = scene.robot.joint_count();
    let joint = code % n;
    match code / n {
        0 => scene.motion.positions(joint).to_vec(),
        1 => scene.motion.velocities(joint).to_vec(),
        _ => scene.rigid[joint].clone(),
    }
}

/// Functions of one variable: 1, then sine and cosine of one to three times a position, then powers of the scaled variable.
const WAVES: usize = 7;
const POWERS: usize = 4;

fn functions(position: bool) -> usize {
    if position { WAVES + POWERS } else { 1 + 2 + POWERS }
}

fn function(position: bool, number: usize, raw: f64, scaled: f64) -> f64 {
    match (position, number) {
        (_, 0) => 1.0,
        (true, k) if k < WAVES => {
            let angle = k.div_ceil(2) as f64 * raw;
            if k % 2 == 1 { angle.sin() } else { angle.cos() }
        }
        (true, k) => scaled.powi((k - WAVES + 1) as i32),
        (false, 1) => scaled.abs(),
        (false, 2) => raw.signum(),
        (false, k) => scaled.powi((k - 2) as i32),
    }
}

/// Number of products of functions for these variables.
pub(crate) fn products(codes: &[usize], joints: usize) -> usize {
    codes.iter().map(|&c| functions(c < joints)).product()
}

impl Effect for Unexplained {
    fn code(&self) -> &'static str {
        "unexplained"
    }

    fn about(&self) -> About {
        About {
            name: "Unexplained residual",
            phrase: "a dependence without a listed cause",
            meaning: "A smooth dependence that no effect accounts for.",
            over: PlotVariable::Position,
            identifiable: "where the motion covers the variables",
            rivals: &[],
            source: "Mallat & Zhang 1993 (matching pursuit)",
        }
    }

    fn kind(&self) -> EffectKind {
        EffectKind::Additive
    }

    fn reads_torques(&self) -> bool {
        true
    }

    fn columns(&self, _form: usize, scene: &Scene, joints: &[usize], shape: &[f64]) -> Vec<Column> {
        let n = scene.robot.joint_count();
        let codes = &joints[1..joints.len().min(3)];
        let count = |i: usize| functions(codes[i] < n);
        let values: Vec<Vec<f64>> = codes.iter().map(|&c| variable(scene, c)).collect();
        let table: Vec<Vec<Vec<f64>>> = (0..codes.len())
            .map(|i| {
                let at = |k: usize, x: f64| function(codes[i] < n, k, x, (x - shape[2 * i]) / shape[2 * i + 1]);
                (0..count(i)).map(|k| values[i].iter().map(|&x| at(k, x)).collect()).collect()
            })
            .collect();
        let named = &shape[2 * codes.len()..];
        let per_row = products(codes, n);
        let all = per_row * if joints.len() > 3 { 2 } else { 1 };
        let wanted: Vec<usize> = if named.is_empty() {
            (0..all).collect()
        } else {
            named.iter().map(|&k| k as usize).collect()
        };
        let product = |k: usize| {
            let row = if k < per_row { joints[0] } else { joints[3] };
            let (a, b) = (k % per_row % count(0), k % per_row / count(0));
            let second = |s: usize| if codes.len() > 1 { table[1][b][s] } else { 1.0 };
            Column::on(row, (0..scene.samples()).map(|s| table[0][a][s] * second(s)).collect())
        };
        wanted.into_iter().map(product).collect()
    }

    fn parameters(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<ParameterInfo> {
        Vec::new()
    }
}
