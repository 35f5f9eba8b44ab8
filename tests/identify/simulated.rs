//! Logs of a robot whose parameters are known.

use crate::support::{iiwa14, rng, uniform};
use dynident::dynamics::{Chain, Coulomb, Motion, inverse_dynamics_batch};
use dynident::model::Robot;
use dynident::parameters::{BaseParameters, Layout};
use dynident::preparation::Log;
use dynident::trajectory::{FourierSeries, QuinticWayPoints, Trajectory};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Torque noise of the seven joints [N m], the size of that in the paper's Table 4.
pub const TORQUE_NOISE: [f64; 7] = [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06];
/// Encoder noise [rad].
pub const POSITION_NOISE: f64 = 3e-5;

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Table 3 of the paper as standard parameters.
pub fn table3() -> Vec<f64> {
    let path = format!("{}/tests/data/ref_regressor.json", env!("CARGO_MANIFEST_DIR"));
    let reference: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    reference["table3_pi"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

/// A robot with true parameters.
pub struct Virtual {
    pub robot: Robot,
    pub base: BaseParameters,
    pub phi: Vec<f64>,
}

impl Virtual {
    pub fn iiwa14() -> Self {
        let robot = iiwa14();
        Self {
            base: BaseParameters::exact(&robot),
            phi: table3(),
            robot,
        }
    }

    pub fn truth(&self) -> DVector<f64> {
        self.base.project(&self.phi)
    }

    /// Noise-free log of `repeats` runs of a trajectory, one after the other.
    pub fn clean(&self, trajectory: &dyn Trajectory, rate_hz: f64, repeats: usize) -> Log {
        let n = self.robot.joint_count();
        let samples = (trajectory.duration() * repeats as f64 * rate_hz).round() as usize;
        let motion = Motion::from_fn(n, samples, |j, s| {
            trajectory.state(j, (s as f64 / rate_hz) % trajectory.duration())
        });
        let tau = inverse_dynamics_batch(
            &Chain::new(&self.robot),
            &Layout::standard(&self.robot),
            &self.phi,
            &motion,
            Coulomb::Sign,
        );
        let torque = |j: usize| tau[j * motion.stride()..j * motion.stride() + samples].to_vec();
        Log {
            name: "simulated".to_string(),
            rate_hz,
            start_s: 0.0,
            q: (0..n).map(|j| motion.positions(j).to_vec()).collect(),
            qd: None,
            tau: (0..n).map(torque).collect(),
            usable: vec![true; samples],
            channels: Vec::new(),
        }
    }
}

/// Adds white noise to positions and torques.
pub fn noisy(log: &Log, position: f64, torque: &[f64], seed: u64) -> Log {
    let mut rng = rng(seed);
    let mut log = log.clone();
    for (j, (q, tau)) in log.q.iter_mut().zip(&mut log.tau).enumerate() {
        q.iter_mut().for_each(|v| *v += position * normal(&mut rng));
        tau.iter_mut().for_each(|v| *v += torque[j] * normal(&mut rng));
    }
    log
}

/// A random series of order 5, at rest at its start up to scaling, amplitudes as in measured experiments.
pub fn excitation(seed: u64, period_s: f64) -> FourierSeries {
    let mut rng = rng(seed);
    let mut draw = |scale: f64| DMatrix::from_fn(7, 5, |_, l| uniform(&mut rng, scale * (l + 1) as f64 / 5.0));
    let (a, b) = (draw(0.6), draw(0.6));
    FourierSeries {
        fundamental_hz: 1.0 / period_s,
        a,
        b,
        offset: vec![0.0, 0.2, -0.1, 0.4, 0.0, -0.3, 0.1],
    }
}

/// Ten quintic segments of a second each through random way-points, back to the start.
pub fn way_points(seed: u64) -> QuinticWayPoints {
    let mut rng = rng(seed);
    let mut points: Vec<Vec<f64>> = (0..10).map(|_| (0..7).map(|_| uniform(&mut rng, 0.6)).collect()).collect();
    points.push(points[0].clone());
    QuinticWayPoints::new(points, &[1.0; 10])
}
