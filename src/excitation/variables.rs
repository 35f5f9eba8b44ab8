//! From free variables to coefficients that satisfy every constraint.
//!
//! The equalities (14c) and all limits act on each joint alone, and each joint's admissible coefficients are a convex set around
//! rest. So nothing needs to be left to the optimiser: variables live in the null space of the equalities, and a joint whose
//! variables x leave its set is pulled back along the ray to rest, `x / g(x)` with the gauge `g` of the set. At the optimum
//! the limits bind, and the search runs on the surface `g = 1` without constraints.
//!
//! Where limits along the path ([`super::path`]) may ask for less than full motion, the inside of the set has to be reached too:
//! then the motion is `x / (1 + g^4)^(1/4)`, which approaches the surface as x grows.

use super::extremes::SampledBases;
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
    /// Of every joint: coefficients `[a_1…a_L, b_1…b_L, offset − rest]` from its variables; orthonormal columns, and columns of
    /// zeros for a joint with fewer harmonics than another.
    null_spaces: Vec<DMatrix<f64>>,
    /// The two lowest harmonics of every joint: (14c) binds them to the others.
    lowest: Vec<[usize; 2]>,
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
        let harmonics: Vec<Vec<usize>> = (0..problem.robot().joint_count()).map(|j| problem.harmonics_of(j)).collect();
        let spaces: Vec<DMatrix<f64>> = harmonics.iter().map(|h| null_space(order, h, spec.start)).collect();
        let per_joint = spaces.iter().map(DMatrix::ncols).max().unwrap_or(0);
        let limits = problem.robot().joints().iter().map(|j| j.limits);
        let rest: Vec<f64> = (0..problem.robot().joint_count()).map(|j| problem.rest_position(j)).collect();
        let bases = SampledBases::of(spec);
        let sets = limits.zip(&rest).map(|(l, &q)| JointSet::new(&l, q, spec, &bases)).collect();
        Self {
            joints: rest.len(),
            order,
            per_joint,
            null_spaces: spaces.into_iter().map(|b| b.resize_horizontally(per_joint, 0.0)).collect(),
            lowest: harmonics.iter().map(|h| [h[0], h[1]]).collect(),
            rest,
            sets,
            radial: if problem.has_path_limits() {
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
        let mut coefficients = self.raw(x);
        let mut gauge_gradients = DMatrix::zeros(coefficients.nrows(), self.joints);
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
        gradient.copy_from_slice(&self.from_coefficients(&to_raw));
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
        let mut raw = self.raw(x);
        let mut unused = vec![0.0; raw.nrows()];
        for (set, mut column) in self.sets.iter().zip(raw.column_iter_mut()) {
            let gauge = set.gauge(column.as_slice(), &mut unused).max(f64::MIN_POSITIVE);
            column.scale_mut(to(gauge) / gauge);
        }
        self.from_coefficients(&raw)
    }

    /// The whole motion drawn towards rest: variables of `share` times the coefficients of `x`.
    pub fn drawn_in(&self, x: &[f64], share: f64) -> Vec<f64> {
        let mut at = self.project(x);
        for (j, mut column) in at.coefficients.column_iter_mut().enumerate() {
            // Coefficients are u r(g), on the set at gauge g r(g); the variables that project to a share of them are further in
            // on u's ray.
            let gauge = share * at.gauges[j] * self.radial.factor(at.gauges[j]);
            column.scale_mut(share / self.radial.factor(self.radial.gauge_of(gauge)));
        }
        self.from_coefficients(&at.coefficients)
    }

    /// The same motion run backwards: `a` changes sign, `b` and the offset do not.
    pub fn reversed(&self, x: &[f64]) -> Vec<f64> {
        let mut turned = self.raw(x);
        turned.rows_mut(0, self.order).neg_mut();
        self.from_coefficients(&turned)
    }

    /// Coefficients of every joint before they are brought onto its set, (2L + 1) × n.
    fn raw(&self, x: &[f64]) -> DMatrix<f64> {
        let mut raw = DMatrix::zeros(2 * self.order + 1, self.joints);
        for (j, (basis, part)) in self.null_spaces.iter().zip(x.chunks_exact(self.per_joint)).enumerate() {
            raw.set_column(j, &(basis * DVector::from_column_slice(part)));
        }
        raw
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
        let joints = self.null_spaces.iter().zip(coefficients.column_iter());
        joints
            .flat_map(|(basis, column)| basis.tr_mul(&column).as_slice().to_vec())
            .collect()
    }

    /// The series, with equalities met to the last bit where floating point allows and every limit met with room for rounding.
    pub fn series(&self, x: &[f64]) -> FourierSeries {
        let coefficients = self.project(x).coefficients;
        let mut series = FourierSeries::at_rest(self.rest.clone(), self.order, self.fundamental_hz);
        for j in 0..self.joints {
            let mut column = coefficients.column(j).into_owned();
            // Rounding to the grid moves coefficients by less than 1e-10 of the largest; a second pull-back with that to spare
            // leaves every limit met by whoever evaluates it, in whatever order they sum.
            column *= 1.0 - ROOM;
            self.to_grid(column.as_mut_slice(), self.lowest[j]);
            for l in 0..self.order {
                series.a[(j, l)] = column[l];
                series.b[(j, l)] = column[self.order + l];
            }
            series.offset[j] += column[2 * self.order];
        }
        series
    }

    /// Rounds to multiples of a power of two such that `Σ a = 0`, `Σ l b = 0` (and `Σ b/l = 0`) hold exactly in floating point,
    /// whatever the order of summation: the joint then stands still at t = 0 by everybody's arithmetic, and `sign(qd)` there is
    /// 0.
    ///
    /// The two lowest harmonics, m < n, follow from the others. Of a multiple of `l (n² − m²)` grid for b_l both `Σ b_l/l` and
    /// `Σ l b_l` over the others are such multiples that `b_n/n = (m² Σ b/l − Σ l b)/(n² − m²)` and `b_m/m = −Σ b/l − b_n/n` are
    /// whole grids.
    fn to_grid(&self, c: &mut [f64], [m, n]: [usize; 2]) {
        let order = self.order;
        let largest = c[..2 * order].iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if largest == 0.0 {
            return;
        }
        let grid = 2f64.powi(largest.log2().ceil() as i32 - 40);
        let round = |v: f64, step: f64| (v / step).round() * step;
        let (a, b) = c[..2 * order].split_at_mut(order);
        a.iter_mut().for_each(|v| *v = round(*v, grid));
        a[m - 1] = 0.0;
        a[m - 1] = -a.iter().sum::<f64>();
        match self.start {
            Start::Zero => {
                let (mut over, mut times) = (0.0, 0.0);
                let apart = (n * n - m * m) as f64;
                for l in (1..=order).filter(|l| *l != m && *l != n) {
                    let unit = apart * grid * l as f64;
                    let k = (b[l - 1] / unit).round();
                    b[l - 1] = k * unit;
                    over += k * apart * grid;
                    times += b[l - 1] * l as f64;
                }
                let of_n = ((m * m) as f64 * over - times) / apart;
                b[n - 1] = of_n * n as f64;
                b[m - 1] = (-over - of_n) * m as f64;
            }
            Start::Free => {
                b.iter_mut().for_each(|v| *v = round(*v, grid * m as f64));
                b[m - 1] = 0.0;
                b[m - 1] = -b.iter().enumerate().map(|(i, v)| v * (i + 1) as f64).sum::<f64>() / m as f64;
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

    /// Gauge of variables for the same motion; inside, what lies far out is brought back to where its motion is within 0.3 % the
    /// same and can still shrink.
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
/// `Σ l b = 0` (acceleration), for a fixed start `Σ b/l = 0` (position) without offset, and that have no other harmonics than
/// these.
fn null_space(order: usize, harmonics: &[usize], start: Start) -> DMatrix<f64> {
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
    for l in (1..=order).filter(|l| !harmonics.contains(l)) {
        rows.push(row(&|i| if i == l - 1 { 1.0 } else { 0.0 }));
        rows.push(row(&|i| if i == order + l - 1 { 1.0 } else { 0.0 }));
    }
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
