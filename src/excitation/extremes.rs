//! True extremes over time of what is limited, from samples, with a certificate for what lies between them.

use super::problem::ProblemSpec;
use crate::model::Limits;
use crate::trajectory::harmonic;
use multiversion::multiversion;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

/// Values of every coefficient's basis function at the points of one period: coefficient after coefficient, `points` each.
type Basis = Arc<Vec<f64>>;

/// The bases of position, velocity, acceleration and jerk, made when a limit first asks for one. They are the same for every
/// joint, and an evaluation that reads one of them seven times from a near cache takes a fraction of the time that seven of them
/// take from memory.
#[derive(Debug)]
pub(super) struct SampledBases {
    order: usize,
    fundamental_hz: f64,
    of: [OnceLock<Basis>; 4],
}

impl SampledBases {
    pub fn of(spec: &ProblemSpec) -> Self {
        Self {
            order: spec.order,
            fundamental_hz: spec.fundamental_hz,
            of: Default::default(),
        }
    }

    /// 1/cos(x) − 1 ≈ x²/2 < 1e-4 for x = πL/N < 0.0141.
    fn points(&self) -> usize {
        224 * self.order
    }

    fn derivative(&self, derivative: usize) -> Basis {
        let made = self.of[derivative].get_or_init(|| Arc::new(self.sampled(derivative)));
        Arc::clone(made)
    }

    fn sampled(&self, derivative: usize) -> Vec<f64> {
        let (order, points, omega) = (self.order, self.points(), TAU * self.fundamental_hz);
        let mut values = vec![if derivative == 0 { 1.0 } else { 0.0 }; points * (2 * order + 1)];
        for k in 0..points {
            let t = k as f64 / (points as f64 * self.fundamental_hz);
            for l in 1..=order {
                for (which, pair) in harmonic(omega, l, t).iter().enumerate() {
                    // The jerk is minus the frequency squared times the velocity.
                    let value = match derivative {
                        3 => -(omega * l as f64).powi(2) * pair[1],
                        d => pair[d],
                    };
                    values[(which * order + l - 1) * points + k] = value;
                }
            }
        }
        values
    }
}

/// True extremes over time, from samples, with a certificate for what lies between them.
///
/// A trigonometric polynomial of degree L that is at most m at N equispaced points of its period is at most `m / cos(π L / N)`
/// everywhere (Ehlich & Zeller 1964). N is chosen so that this adds less than 0.01 %.
#[derive(Debug, Clone)]
pub(super) struct CertifiedExtremes {
    points: usize,
    quantities: Vec<Quantity>,
    inverse_cosine: f64,
}

/// One limited quantity, `lower ≤ Σ c_i basis_i(t) ≤ upper` with lower < 0 < upper.
#[derive(Debug, Clone)]
struct Quantity {
    basis: Basis,
    lower: f64,
    upper: f64,
}

impl CertifiedExtremes {
    pub fn new(limits: &Limits, rest: f64, bases: &SampledBases) -> Self {
        let quantity = |derivative: usize, lower: f64, upper: f64| Quantity {
            basis: bases.derivative(derivative),
            lower,
            upper,
        };
        let position = limits.position.map(|[low, high]| quantity(0, low - rest, high - rest));
        let rates = [(1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)];
        let rates = rates.into_iter().filter_map(|(d, limit)| limit.map(|l| quantity(d, -l, l)));
        Self {
            points: bases.points(),
            quantities: position.into_iter().chain(rates).collect(),
            inverse_cosine: 1.0 / (PI * bases.order as f64 / bases.points() as f64).cos(),
        }
    }

    pub fn gauge(&self, c: &[f64], gradient: &mut [f64]) -> f64 {
        let mut largest = 0.0;
        gradient.fill(0.0);
        for quantity in &self.quantities {
            let [low, high] = extremes(&quantity.basis, self.points, c);
            // Between the samples it reaches at most middle ± half / cos(πL/N).
            let (middle, half) = (0.5 * (high.0 + low.0), 0.5 * (high.0 - low.0) * self.inverse_cosine);
            let (of_high, of_low) = (0.5 * (1.0 + self.inverse_cosine), 0.5 * (1.0 - self.inverse_cosine));
            for (value, limit, w_high, w_low) in [
                (middle + half, quantity.upper, of_high, of_low),
                (middle - half, quantity.lower, of_low, of_high),
            ] {
                if value / limit > largest {
                    largest = value / limit;
                    for (of_one, basis) in gradient.iter_mut().zip(quantity.basis.chunks_exact(self.points)) {
                        *of_one = (w_high * basis[high.1] + w_low * basis[low.1]) / limit;
                    }
                }
            }
        }
        largest
    }
}

/// Points that are summed at a time: 1 kB of sums, which stay in registers and the nearest cache while the coefficients pass.
const TOGETHER: usize = 128;

/// Least and greatest value of `Σ c_i basis_i` over the points, with the point where it is taken first. Every sum is taken in the
/// order of the coefficients, so that vectors of any width give the same bits.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn extremes(basis: &[f64], points: usize, c: &[f64]) -> [(f64, usize); 2] {
    let mut sums = [0.0; TOGETHER];
    let (mut low, mut high) = ((f64::INFINITY, 0), (f64::NEG_INFINITY, 0));
    for first in (0..points).step_by(TOGETHER) {
        let count = TOGETHER.min(points - first);
        sums.fill(0.0);
        for (i, &c) in c.iter().enumerate() {
            let values = &basis[i * points + first..][..count];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * c);
        }
        for (k, &value) in sums[..count].iter().enumerate() {
            if value < low.0 {
                low = (value, first + k);
            }
            if value > high.0 {
                high = (value, first + k);
            }
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With points that fill no whole block, and the first of equal extremes.
    #[test]
    fn prop_extremes_are_those_of_sums_point_by_point() {
        for points in [1, 7, 127, 128, 129, 1000] {
            let basis: Vec<f64> = (0..3 * points).map(|i| ((i * i % 97) as f64).sin()).collect();
            let c = [0.3, -1.2, 0.7];
            let at = |k: usize| (0..3).fold(0.0, |sum, i| sum + basis[i * points + k] * c[i]);
            let [low, high] = extremes(&basis, points, &c);
            let first =
                |better: fn(f64, f64) -> bool| (1..points).fold(0, |best, k| if better(at(k), at(best)) { k } else { best });
            let (least, greatest) = (first(|a, b| a < b), first(|a, b| a > b));
            assert_eq!(low, (at(least), least), "{points}");
            assert_eq!(high, (at(greatest), greatest), "{points}");
        }
    }
}
