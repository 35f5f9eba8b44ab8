//! Base parameters by ordinary, weighted and robust least squares: the paper's (9) and (15).

use super::noise::{NoiseSpectrum, passed};
use super::normal::{JointNormal, normal_equations};
use super::robust::{median_sigma, robust_normals};
use super::{Observation, PreparedLog, Solution};
use nalgebra::{DMatrix, DVector};

/// How rows weigh against each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// Every row the same, the paper's (9).
    Ordinary,
    /// Rows of joint j by `1/σⱼ²`, σⱼ from the residual, iterated.
    #[default]
    Weighted,
    /// Weighted with σⱼ from the median residual, and rows whose residual is beyond 1.345 σⱼ by `1.345 σⱼ/|e|` more (Huber): 95 % as good as least squares on normal
    /// noise, and a few gross errors do no harm.
    Robust,
}

/// What least squares says.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// p values, base parameters first; what is not [determined](Self::is_determined) has a value of least norm that only
    /// predictions of the same data may use.
    pub values: DVector<f64>,
    /// Covariance of the values, p × p, for noise that is correlated in time.
    pub covariance: DMatrix<f64>,
    /// Standard deviations by the paper's (15): `σ² (WᵀW)⁻¹`, every row counted as independent.
    pub textbook_std_dev: DVector<f64>,
    pub joints: Vec<JointFit>,
    pub solution: Solution,
    pub iterations: usize,
}

/// The fit of one joint's rows.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    pub rows: usize,
    /// Root mean square residual [N m or N].
    pub rms: f64,
    /// Rows less the parameters spent on them.
    pub degrees_of_freedom: f64,
    /// Independent values that the rows are worth, given the noise's correlation.
    pub effective_rows: f64,
    /// Standard deviation of a row's noise as measured by the scatter of the periods; `None` without periods.
    pub noise_std: Option<f64>,
    /// Residual mean square over what noise alone would leave; `None` without periods. Well above 1: the model lacks something.
    pub misfit: Option<f64>,
    /// Standard deviation that the rows were weighted with.
    pub sigma: f64,
    /// Standard deviation that recording has added to a torque: no error is known to be less [N m or N].
    pub resolution: f64,
}

impl Estimate {
    /// Infinite for a parameter that the data do not determine.
    pub fn std_dev(&self, c: usize) -> f64 {
        if self.is_determined(c) {
            self.covariance[(c, c)].max(0.0).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// The paper's σ: `100 std_dev/|value|`.
    pub fn relative_std_dev_percent(&self, c: usize) -> f64 {
        100.0 * self.std_dev(c) / self.values[c].abs()
    }

    pub fn is_determined(&self, c: usize) -> bool {
        self.solution.is_determined(c)
    }
}

/// Weights settle in a handful of rounds; this ends a cycle of rounding.
const MOST_ITERATIONS: usize = 50;
/// Relative change of every σ at which the weights have settled: far below the 1/√(2N) that σ itself is known to.
const SETTLED: f64 = 1e-6;

/// Fits one set of parameters to the rows of one or more logs (`logs[i]` is what `observations[i]` was made from).
///
/// # Panics
/// When there is no observation, or their columns differ.
pub fn estimate(observations: &[Observation], logs: &[&PreparedLog], estimator: Estimator) -> Estimate {
    estimate_from(&normal_equations(observations), observations, logs, estimator)
}

/// The same from the normal equations `plain` of the observations, for who needs them besides.
pub(crate) fn estimate_from(
    plain: &[JointNormal],
    observations: &[Observation],
    logs: &[&PreparedLog],
    estimator: Estimator,
) -> Estimate {
    assert_eq!(observations.len(), logs.len(), "one observation per log");
    let columns = observations[0].columns;
    let mut normals = plain.to_vec();
    let mut sigma = vec![1.0; normals.len()];
    let mut solution = Solution::new(&normals, &vec![1.0; normals.len()], columns);
    let mut iterations = 1;
    while estimator != Estimator::Ordinary && iterations < MOST_ITERATIONS {
        let mut next = sigmas(&normals, &solution, &sigma);
        if estimator == Estimator::Robust {
            // Gross errors are in the mean square with their squares; the scale that tells them must not be made of them.
            let residuals: Vec<_> = observations.iter().map(|o| o.residuals(&solution.values)).collect();
            for (j, (s, normal)) in next.iter_mut().zip(plain).enumerate() {
                let freedom = 1.0 - spent(normal, &solution, sigma[j]) / normal.rows.max(1) as f64;
                *s = median_sigma(observations, &residuals, j, freedom.max(0.1)).max(least_sigma(normal));
            }
        }
        let change = next.iter().zip(&sigma).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        sigma = next;
        if estimator == Estimator::Robust {
            normals = robust_normals(observations, &solution.values, &sigma);
        }
        solution = Solution::new(&normals, &weights(&sigma), columns);
        iterations += 1;
        if change < SETTLED {
            break;
        }
    }
    if estimator == Estimator::Ordinary {
        let spent = total_freedom(&normals, &solution);
        let square: f64 = normals.iter().map(|n| n.residual_square(&solution.values)).sum();
        let used = normals.iter().filter(|n| n.rows > 0);
        let least = used.map(least_sigma).reduce(f64::min).unwrap_or(1.0);
        sigma = vec![(square / spent).sqrt().max(least); normals.len()];
        solution = Solution::new(&normals, &weights(&sigma), columns);
    }
    assemble(observations, logs, plain, solution, sigma, iterations)
}

fn weights(sigma: &[f64]) -> Vec<f64> {
    sigma.iter().map(|s| 1.0 / (s * s)).collect()
}

/// Parameters spent on joint j's rows, `tr(A⁻¹ wⱼ WⱼᵀWⱼ)`; over all joints they sum up to the rank.
fn spent(normal: &JointNormal, solution: &Solution, sigma: f64) -> f64 {
    let mut trace = 0.0;
    for (b, &cb) in normal.columns.iter().enumerate() {
        for (a, &ca) in normal.columns.iter().enumerate() {
            trace += solution.inverse[(ca, cb)] * normal.gram[(a, b)];
        }
    }
    trace / (sigma * sigma)
}

fn total_freedom(normals: &[JointNormal], solution: &Solution) -> f64 {
    let rows: usize = normals.iter().map(|n| n.rows).sum();
    (rows as f64 - solution.rank as f64).max(1.0)
}

/// What the recording of the torque leaves; 1 where no row asks for a weight.
fn least_sigma(normal: &JointNormal) -> f64 {
    if normal.rows == 0 || normal.resolution <= 0.0 {
        return 1.0;
    }
    normal.resolution
}

/// σⱼ from the residuals, no less than the recording of the torque leaves.
fn sigmas(normals: &[JointNormal], solution: &Solution, sigma: &[f64]) -> Vec<f64> {
    let estimate = |(normal, &s): (&JointNormal, &f64)| {
        let freedom = (normal.rows as f64 - spent(normal, solution, s)).max(1.0);
        (normal.residual_square(&solution.values) / freedom)
            .sqrt()
            .max(least_sigma(normal))
    };
    normals.iter().zip(sigma).map(estimate).collect()
}

/// A misfit is one when the residual exceeds what noise leaves by more than four of its own standard deviations.
const MISFIT_SIGMAS: f64 = 4.0;

fn assemble(
    observations: &[Observation],
    logs: &[&PreparedLog],
    normals: &[JointNormal],
    solution: Solution,
    sigma: Vec<f64>,
    iterations: usize,
) -> Estimate {
    let values = solution.values.clone();
    let measured: Vec<Vec<Option<NoiseSpectrum>>> = logs
        .iter()
        .map(|log| (0..normals.len()).map(|j| NoiseSpectrum::from_scatter(log, j)).collect())
        .collect();
    let joints: Vec<JointFit> = normals
        .iter()
        .enumerate()
        .map(|(j, normal)| {
            let degrees_of_freedom = (normal.rows as f64 - spent(normal, &solution, sigma[j])).max(1.0);
            let square = normal.residual_square(&values);
            let spectra: Option<Vec<&NoiseSpectrum>> = measured.iter().map(|log| log[j].as_ref()).collect();
            let part = |o: &Observation| o.joints[j].used_rows();
            let noise = spectra.as_ref().map(|spectra| {
                let sum: f64 = spectra
                    .iter()
                    .zip(observations)
                    .map(|(s, o)| s.variance() * part(o) as f64)
                    .sum();
                (sum / normal.rows.max(1) as f64).max(normal.resolution * normal.resolution)
            });
            let effective_rows = match &spectra {
                Some(spectra) => spectra.iter().zip(observations).map(|(s, o)| s.effective_rows(part(o))).sum(),
                None => normal.rows as f64,
            };
            JointFit {
                rows: normal.rows,
                rms: (square / normal.rows.max(1) as f64).sqrt(),
                degrees_of_freedom,
                effective_rows,
                noise_std: noise.map(f64::sqrt),
                misfit: noise.filter(|&v| v > 0.0).map(|v| square / (degrees_of_freedom * v)),
                sigma: sigma[j],
                resolution: normal.resolution,
            }
        })
        .collect();
    let mut estimate = Estimate {
        covariance: DMatrix::zeros(values.len(), values.len()),
        textbook_std_dev: textbook(normals, &solution, &sigma),
        values,
        joints,
        solution,
        iterations,
    };
    estimate.take_covariance(observations, measured, normals);
    estimate
}

/// The paper's (15) with weighted rows: `σ² = Σ (eⱼ/σⱼ)² / (rows − p)` times `(WᵀΣ⁻¹W)⁻¹`.
fn textbook(normals: &[JointNormal], solution: &Solution, sigma: &[f64]) -> DVector<f64> {
    let square: f64 = normals
        .iter()
        .zip(sigma)
        .map(|(n, s)| n.residual_square(&solution.values) / (s * s))
        .sum();
    let variance = square / total_freedom(normals, solution);
    solution.inverse.diagonal().map(|v| (v.max(0.0) * variance).sqrt())
}

impl Estimate {
    /// `A⁻¹ (Σ wⱼ² WⱼᵀRⱼWⱼ) A⁻¹`, with R from the scatter of the periods where that explains the residual, and from the residual's own
    /// correlation where it does not, or where there are no periods.
    fn take_covariance(
        &mut self,
        observations: &[Observation],
        measured: Vec<Vec<Option<NoiseSpectrum>>>,
        normals: &[JointNormal],
    ) {
        let spectra: Vec<Vec<NoiseSpectrum>> = measured
            .into_iter()
            .zip(observations)
            .map(|(log, o)| self.spectra(o, log))
            .collect();
        if measured_nowhere(&self.joints) {
            for (j, fit) in self.joints.iter_mut().enumerate() {
                fit.effective_rows = spectra
                    .iter()
                    .zip(observations)
                    .map(|(s, o)| s[j].effective_rows(o.joints[j].used_rows()))
                    .sum();
            }
        }
        let p = self.values.len();
        let mut middle = DMatrix::zeros(p, p);
        for ((normal, fit), passed) in normals.iter().zip(&self.joints).zip(passed(observations, &spectra)) {
            let weight = fit.sigma.powi(-4);
            for (b, &cb) in normal.columns.iter().enumerate() {
                for (a, &ca) in normal.columns.iter().enumerate() {
                    middle[(ca, cb)] += weight * passed[(a, b)];
                }
            }
        }
        self.covariance = &self.solution.inverse * middle * &self.solution.inverse;
    }

    /// Of every joint in one log.
    fn spectra(&self, observation: &Observation, measured: Vec<Option<NoiseSpectrum>>) -> Vec<NoiseSpectrum> {
        let explained = |fit: &JointFit| {
            let most = 1.0 + MISFIT_SIGMAS * (2.0 / fit.effective_rows.max(1.0)).sqrt();
            fit.misfit.is_some_and(|m| m < most)
        };
        let believed: Vec<Option<NoiseSpectrum>> = measured
            .into_iter()
            .zip(&self.joints)
            .map(|(spectrum, fit)| spectrum.filter(|_| explained(fit)))
            .collect();
        let residuals = match believed.iter().all(Option::is_some) {
            true => Vec::new(),
            false => observation.residuals(&self.values),
        };
        let from_residual = |j: usize| {
            let fit = &self.joints[j];
            // The joint's freedom, shared among logs in proportion to their rows.
            let part = observation.joints[j].used_rows() as f64 / fit.rows.max(1) as f64;
            NoiseSpectrum::from_residual(&residuals[j], fit.degrees_of_freedom * part)
        };
        believed
            .into_iter()
            .enumerate()
            .map(|(j, spectrum)| spectrum.unwrap_or_else(|| from_residual(j)))
            .collect()
    }
}

fn measured_nowhere(joints: &[JointFit]) -> bool {
    joints.iter().all(|f| f.noise_std.is_none())
}
