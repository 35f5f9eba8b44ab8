//! From free variables to coefficients that satisfy every constraint.
//!
//! The equalities (14c) and all limits act on each joint alone, and each joint's admissible coefficients are a convex set around
//! rest. So nothing needs to be left to the optimiser: variables live in the null space of the equalities, and a joint whose
//! variables x leave its set is pulled back along the ray to rest, `x / g(x)` with the gauge `g` of the set. At the optimum
//! the limits bind, and the search runs on the surface `g = 1` without constraints.
//!
//! Where limits along the path ([`super::path`]) may ask for less than full motion, the inside of the set has to be reached too: then the
//! motion is `x / (1 + g^4)^(1/4)`, which approaches the surface as x grows.

use super::gauge::JointSet;
use super::problem::{Problem, Start};
use crate::trajectory::FourierSeries;
use nalgebra::{DMatrix, DVector};

/// Variables of one problem, `per_joint` for each joint, joint after joint.
#[derive(Debug, Clone)]
pub(super) struct Variables {
    joints: usize,
    order: usize,
    per_joint: usize,
    /// Coefficients of one joint `[a_1…a_L, b_1…b_L, offset − rest]` from its variables; orthonormal columns.
    null_space: DMatrix<f64>,
    /// Rest position of every joint: where the ray starts.
    rest: Vec<f64>,
    sets: Vec<JointSet>,
    radial: Radial,
    fundamental_hz: f64,
    start: Start,
}

/// Coefficients of all joints, (2L + 1) × n, and what is needed to take a gradient back to the variables.
#[derive(Debug, Clone)]
pub(super) struct Projected {
    /// Column j: `[a, b, offset − rest]` of joint j.
    pub coefficients: DMatrix<f64>,
    gauges: Vec<f64>,
    /// Column j: gradient of the gauge by the coefficients.
    gauge_gradients: DMatrix<f64>,
}

impl Variables {
    pub fn new(problem: &Problem) -> Self {
        let spec = problem.spec();
        let order = spec.order;
        let null_space = null_space(order, spec.start);
        let limits = problem.robot().joints().iter().map(|j| j.limits);
        let rest: Vec<f64> = (0..problem.robot().joint_count()).map(|j| problem.rest_position(j)).collect();
        let sets = limits.zip(&rest).map(|(l, &q)| JointSet::new(&l, q, spec)).collect();
        Self {
            joints: rest.len(),
            order,
            per_joint: null_space.ncols(),
            null_space,
            rest,
            sets,
            radial: if problem.torque().is_some() {
                Radial::Inside
            } else {
                Radial::Surface
            },
            fundamental_hz: spec.fundamental_hz,
            start: spec.start,
        }
    }

    pub fn len(&self) -> usize {
        self.joints * self.per_joint
    }

    pub fn per_joint(&self) -> usize {
        self.per_joint
    }

    pub fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Coefficients on the surface of the admissible set, in the direction of `x`.
    pub fn project(&self, x: &[f64]) -> Projected {
        let raw = &self.null_space * DMatrix::from_column_slice(self.per_joint, self.joints, x);
        let mut gauge_gradients = DMatrix::zeros(raw.nrows(), self.joints);
        let mut coefficients = raw;
        let mut gauges = Vec::with_capacity(self.joints);
        for (j, set) in self.sets.iter().enumerate() {
            let gauge = set.gauge(
                coefficients.column(j).as_slice(),
                gauge_gradients.column_mut(j).as_mut_slice(),
            );
            coefficients.column_mut(j).scale_mut(self.radial.factor(gauge));
            gauges.push(gauge);
        }
        Projected {
            coefficients,
            gauges,
            gauge_gradients,
        }
    }

    /// `∂F/∂x` from `∂F/∂coefficients`: with `c = u r(g)`, `∂F/∂u = r ∂F/∂c + (∂F/∂c · c) r'/r ∇g`.
    pub fn pull_back(&self, at: &Projected, to_coefficients: &DMatrix<f64>, gradient: &mut [f64]) {
        let mut to_raw = to_coefficients.clone();
        for j in 0..self.joints {
            let along = to_coefficients.column(j).dot(&at.coefficients.column(j));
            let mut column = to_raw.column_mut(j);
            let (factor, slope) = (self.radial.factor(at.gauges[j]), self.radial.log_slope(at.gauges[j]));
            column.scale_mut(factor);
            column.axpy(along * slope, &at.gauge_gradients.column(j), 1.0);
        }
        gradient.copy_from_slice(self.null_space.tr_mul(&to_raw).as_slice());
    }

    /// The same direction with every joint at gauge 1, so that steps and distances mean the same for all joints.
    pub fn on_the_limits(&self, x: &[f64]) -> Vec<f64> {
        self.rescaled(x, &|_| 1.0)
    }

    /// The same motion in variables from which a step of relative length means the same for all joints.
    pub fn settled(&self, x: &[f64]) -> Vec<f64> {
        self.rescaled(x, &|gauge| self.radial.settled(gauge))
    }

    fn rescaled(&self, x: &[f64], to: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let mut raw = &self.null_space * DMatrix::from_column_slice(self.per_joint, self.joints, x);
        let mut unused = vec![0.0; self.null_space.nrows()];
        for (set, mut column) in self.sets.iter().zip(raw.column_iter_mut()) {
            let gauge = set.gauge(column.as_slice(), &mut unused).max(f64::MIN_POSITIVE);
            column.scale_mut(to(gauge) / gauge);
        }
        self.null_space.tr_mul(&raw).as_slice().to_vec()
    }

    /// The whole motion drawn towards rest: variables of `share` times the coefficients of `x`.
    pub fn drawn_in(&self, x: &[f64], share: f64) -> Vec<f64> {
        let mut at = self.project(x);
        for (j, mut column) in at.coefficients.column_iter_mut().enumerate() {
            // Coefficients are u r(g), on the set at gauge g r(g); the variables that project to a share of them are further in on u's ray.
            let gauge = share * at.gauges[j] * self.radial.factor(at.gauges[j]);
            column.scale_mut(share / self.radial.factor(self.radial.gauge_of(gauge)));
        }
        self.from_coefficients(&at.coefficients)
    }

    /// Maps one joint's variables to those of the same motion run backwards: `a` changes sign, `b` and the offset do not.
    pub fn reversal(&self) -> DMatrix<f64> {
        let mut turned = self.null_space.clone();
        turned.rows_mut(0, self.order).neg_mut();
        self.null_space.tr_mul(&turned)
    }

    /// Variables nearest to a series, of whatever order: harmonics that the problem has not are dropped.
    pub fn of_series(&self, series: &FourierSeries) -> Vec<f64> {
        assert_eq!(series.offset.len(), self.joints, "a series for this robot");
        let harmonic = |m: &DMatrix<f64>, j: usize, l: usize| if l < series.order() { m[(j, l)] } else { 0.0 };
        let coefficients = DMatrix::from_fn(2 * self.order + 1, self.joints, |i, j| match i {
            i if i < self.order => harmonic(&series.a, j, i),
            i if i < 2 * self.order => harmonic(&series.b, j, i - self.order),
            _ => series.offset[j] - self.rest[j],
        });
        self.from_coefficients(&coefficients)
    }

    /// Variables that stand for given coefficients (those of [`Self::project`], up to each joint's scale).
    pub fn from_coefficients(&self, coefficients: &DMatrix<f64>) -> Vec<f64> {
        self.null_space.tr_mul(coefficients).as_slice().to_vec()
    }

    /// The series, with equalities met to the last bit where floating point allows and every limit met with room for rounding.
    pub fn series(&self, x: &[f64]) -> FourierSeries {
        let coefficients = self.project(x).coefficients;
        let mut series = FourierSeries::at_rest(self.rest.clone(), self.order, self.fundamental_hz);
        for j in 0..self.joints {
            let mut column = coefficients.column(j).into_owned();
            // Rounding to the grid moves coefficients by less than 1e-10 of the largest; a second pull-back with that to spare leaves
            // every limit met by whoever evaluates it, in whatever order they sum.
            column *= 1.0 - ROOM;
            self.to_grid(column.as_mut_slice());
            for l in 0..self.order {
                series.a[(j, l)] = column[l];
                series.b[(j, l)] = column[self.order + l];
            }
            series.offset[j] += column[2 * self.order];
        }
        series
    }

    /// Rounds to multiples of a power of two such that `Σ a = 0`, `Σ l b = 0` (and `Σ b/l = 0`) hold exactly in floating point,
    /// whatever the order of summation: the joint then stands still at t = 0 by everybody's arithmetic, and `sign(qd)` there is 0.
    fn to_grid(&self, c: &mut [f64]) {
        let order = self.order;
        let largest = c[..2 * order].iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if largest == 0.0 {
            return;
        }
        let grid = 2f64.powi(largest.log2().ceil() as i32 - 40);
        let round = |v: f64, step: f64| (v / step).round() * step;
        let (a, b) = c[..2 * order].split_at_mut(order);
        for v in a.iter_mut().skip(1) {
            *v = round(*v, grid);
        }
        a[0] = -a[1..].iter().sum::<f64>();
        match self.start {
            Start::Zero => {
                // b_l a multiple of 3 l grid makes both sums over l ≥ 3 multiples of 3 grid, and b_2 = ⅔ (difference) exact.
                let (mut over, mut times) = (0.0, 0.0);
                for l in 3..=order {
                    let unit = 3.0 * grid * l as f64;
                    let k = (b[l - 1] / unit).round();
                    b[l - 1] = k * unit;
                    over += k * 3.0 * grid;
                    times += b[l - 1] * l as f64;
                }
                b[1] = (over - times) / 3.0 * 2.0;
                b[0] = -times - 2.0 * b[1];
            }
            Start::Free => {
                for v in b.iter_mut().skip(1) {
                    *v = round(*v, grid);
                }
                b[0] = -b.iter().enumerate().skip(1).map(|(i, v)| v * (i + 1) as f64).sum::<f64>();
            }
        }
    }
}

/// How far along its ray a joint's motion goes, for variables of gauge g.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Radial {
    /// To the surface: `1/g`.
    Surface,
    /// `1 / (1 + g^4)^(1/4)`: to 0.84 of the surface at g = 1, to 0.996 at g = 2.8; proportional to x far inside.
    Inside,
}

impl Radial {
    /// r: coefficients over variables.
    fn factor(self, gauge: f64) -> f64 {
        match self {
            Radial::Surface => 1.0 / gauge.max(f64::MIN_POSITIVE),
            Radial::Inside => (1.0 + gauge.powi(4)).powf(-0.25),
        }
    }

    /// `r'/r`
    fn log_slope(self, gauge: f64) -> f64 {
        match self {
            Radial::Surface => -1.0 / gauge.max(f64::MIN_POSITIVE),
            Radial::Inside => -gauge.powi(3) / (1.0 + gauge.powi(4)),
        }
    }

    /// Gauge of variables for the same motion; inside, what lies far out is brought back to where its motion is within 0.3 % the same and
    /// can still shrink.
    fn settled(self, gauge: f64) -> f64 {
        match self {
            Radial::Surface => 1.0,
            Radial::Inside => gauge.min(3.0),
        }
    }

    /// The g of variables whose coefficients have gauge `reached`, below 1; on the surface all have the same.
    fn gauge_of(self, reached: f64) -> f64 {
        match self {
            Radial::Surface => 1.0,
            Radial::Inside => (reached.powi(-4) - 1.0).powf(-0.25),
        }
    }
}

/// Room left for rounding to the grid (2⁻⁴⁰ of the largest coefficient, times L² in the dependent ones) and in sums.
const ROOM: f64 = 1e-8;

/// Orthonormal basis of the coefficients `[a, b, offset]` of one joint that satisfy (14c), corrected: `Σ a = 0` (velocity),
/// `Σ l b = 0` (acceleration), and for a fixed start `Σ b/l = 0` (position) without offset.
fn null_space(order: usize, start: Start) -> DMatrix<f64> {
    let size = 2 * order + 1;
    let fixed = start == Start::Zero;
    let row = |f: &dyn Fn(usize) -> f64| DVector::from_fn(size, |i, _| f(i));
    let mut rows = vec![
        row(&|i| if i < order { 1.0 } else { 0.0 }),
        row(&|i| {
            if (order..2 * order).contains(&i) {
                (i - order + 1) as f64
            } else {
                0.0
            }
        }),
    ];
    if fixed {
        rows.push(row(&|i| {
            if (order..2 * order).contains(&i) {
                1.0 / (i - order + 1) as f64
            } else {
                0.0
            }
        }));
        rows.push(row(&|i| if i == 2 * order { 1.0 } else { 0.0 }));
    }
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let add = |v: DVector<f64>, out: &mut Vec<DVector<f64>>| {
        let mut rest = v;
        for _ in 0..2 {
            for d in out.iter() {
                rest.axpy(-d.dot(&rest), d, 1.0);
            }
        }
        // The vectors tried are unit or short sums of units: own parts are 0 up to rounding or above 1/size.
        if rest.norm() > 1e-9 {
            out.push(rest.normalize());
        }
    };
    rows.into_iter().for_each(|r| add(r, &mut basis));
    let equalities = basis.len();
    (0..size).for_each(|i| add(row(&|k| if k == i { 1.0 } else { 0.0 }), &mut basis));
    DMatrix::from_columns(&basis[equalities..])
}
