//! Motion of links behind elastic joints whose motors follow the trajectory.

use crate::dynamics::inverse_dynamics;
use crate::model::Robot;
use crate::parameters::Layout;
use nalgebra::{DMatrix, DVector};

/// Elastic joints between motors that follow a trajectory and links that have to be carried.
pub(super) struct ElasticArm<'a> {
    pub robot: &'a Robot,
    pub layout: &'a Layout,
    /// Standard parameters without friction.
    pub phi: &'a [f64],
    /// 1/K per joint [rad/(N·m) or m/N], zero for stiff ones.
    pub compliance: &'a [f64],
}

/// Share of critical damping: harmonic drives are quoted at some per cent up to a tenth. Ringing is over within a few swings.
const DAMPING: f64 = 0.1;

/// `[q, qd, qdd]` of all motors at one time.
pub(super) type Motors = Vec<[f64; 3]>;

/// Positions and velocities of the elastic joints.
type State = (DVector<f64>, DVector<f64>);

impl ElasticArm<'_> {
    /// Elastic joints and their states over time, `steps` steps of `interval` after the first:
    /// `tau(q, qd, qdd) = K (θ − q) + D (θ̇ − q̇)` on the elastic joints (Spong 1987), integrated by the classical Runge-Kutta
    /// method. `motor` says what all motors do after so many half steps. Starts in equilibrium.
    pub fn links(&self, motor: &dyn Fn(usize) -> Motors, steps: usize, interval: f64) -> Vec<(usize, Vec<[f64; 3]>)> {
        let elastic: Vec<usize> = (0..self.compliance.len()).filter(|&j| self.compliance[j] != 0.0).collect();
        let mut here = motor(0);
        let mut state = self.equilibrium(&here, &elastic);
        let damping = self.damping(&here, &state, &elastic);
        let mut links: Vec<(usize, Vec<[f64; 3]>)> = elastic.iter().map(|&j| (j, Vec::with_capacity(steps + 1))).collect();
        for step in 0..=steps {
            let slope = |motor: &Motors, (q, v): &State| (v.clone(), self.acceleration(motor, q, v, &elastic, &damping));
            let a = slope(&here, &state);
            for (i, (_, states)) in links.iter_mut().enumerate() {
                states.push([state.0[i], state.1[i], a.1[i]]);
            }
            if step == steps {
                break;
            }
            let (half, next) = (motor(2 * step + 1), motor(2 * step + 2));
            let moved = |k: &State, h: f64| (&state.0 + &k.0 * h, &state.1 + &k.1 * h);
            let b = slope(&half, &moved(&a, 0.5 * interval));
            let c = slope(&half, &moved(&b, 0.5 * interval));
            let d = slope(&next, &moved(&c, interval));
            let sum = |a: &DVector<f64>, b: &DVector<f64>, c: &DVector<f64>, d: &DVector<f64>| {
                (a + b * 2.0 + c * 2.0 + d) * (interval / 6.0)
            };
            state = (&state.0 + sum(&a.0, &b.0, &c.0, &d.0), &state.1 + sum(&a.1, &b.1, &c.1, &d.1));
            here = next;
        }
        links
    }

    /// Torque of the elastic joints for links at `q, v, a` and all else as the motors have it.
    fn load(&self, motor: &Motors, q: &DVector<f64>, v: &DVector<f64>, a: &DVector<f64>, elastic: &[usize]) -> DVector<f64> {
        let mut state: [Vec<f64>; 3] = std::array::from_fn(|i| motor.iter().map(|state| state[i]).collect());
        for (i, &j) in elastic.iter().enumerate() {
            (state[0][j], state[1][j], state[2][j]) = (q[i], v[i], a[i]);
        }
        let tau = inverse_dynamics(self.robot, self.layout, self.phi, &state[0], &state[1], &state[2]);
        DVector::from_iterator(elastic.len(), elastic.iter().map(|&j| tau[j]))
    }

    /// `q = θ − tau/K` with everything as it moves there; gravity's stiffness over K is a few per cent, so that twenty rounds
    /// leave rounding.
    fn equilibrium(&self, motor: &Motors, elastic: &[usize]) -> State {
        let of = |i: usize| DVector::from_iterator(elastic.len(), elastic.iter().map(|&j| motor[j][i]));
        let (theta, v, a) = (of(0), of(1), of(2));
        let compliance = DVector::from_iterator(elastic.len(), elastic.iter().map(|&j| self.compliance[j]));
        let mut q = theta.clone();
        for _ in 0..20 {
            q = &theta - self.load(motor, &q, &v, &a, elastic).component_mul(&compliance);
        }
        (q, v)
    }

    /// Rows and columns of the mass matrix that belong to the elastic joints, and their torque without acceleration of their own.
    fn masses(&self, motor: &Motors, q: &DVector<f64>, v: &DVector<f64>, elastic: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
        let m = elastic.len();
        let rest = self.load(motor, q, v, &DVector::zeros(m), elastic);
        let mut masses = DMatrix::zeros(m, m);
        for i in 0..m {
            let mut unit = DVector::zeros(m);
            unit[i] = 1.0;
            masses.set_column(i, &(self.load(motor, q, v, &unit, elastic) - &rest));
        }
        (masses, rest)
    }

    /// `D = 2 ζ sqrt(K m)` with the mass at the start.
    fn damping(&self, motor: &Motors, (q, v): &State, elastic: &[usize]) -> DVector<f64> {
        let (masses, _) = self.masses(motor, q, v, elastic);
        let of = |(i, &j): (usize, &usize)| 2.0 * DAMPING * (masses[(i, i)].max(0.0) / self.compliance[j]).sqrt();
        DVector::from_iterator(elastic.len(), elastic.iter().enumerate().map(of))
    }

    fn acceleration(
        &self,
        motor: &Motors,
        q: &DVector<f64>,
        v: &DVector<f64>,
        elastic: &[usize],
        damping: &DVector<f64>,
    ) -> DVector<f64> {
        let (masses, rest) = self.masses(motor, q, v, elastic);
        let spring = DVector::from_fn(elastic.len(), |i, _| {
            let [theta, speed, _] = motor[elastic[i]];
            (theta - q[i]) / self.compliance[elastic[i]] + damping[i] * (speed - v[i])
        });
        // Positive for bodies; what parameters of no body or numbers beyond those of a double make of them is not finite.
        let none = || DVector::from_element(elastic.len(), f64::NAN);
        masses.lu().solve(&(spring - rest)).unwrap_or_else(none)
    }
}
