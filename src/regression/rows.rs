//! Which rows of a joint count: not those at reversals, and not those at which it rests.

use crate::regression::settings::SETTINGS;

/// Samples that are neither at a reversal nor so slow that the sign is a matter of the derivative's own ripple: a thousandth of
/// the top speed.
pub(crate) fn clear_of_reversals(v: &[f64], periodic: bool) -> Vec<bool> {
    let n = v.len();
    let slowest = 1e-3 * v.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    let mut clear: Vec<bool> = v.iter().map(|v| v.abs() >= slowest).collect();
    let next = |s: usize| if s + 1 < n { Some(s + 1) } else { periodic.then_some(0) };
    for s in 0..n {
        let Some(t) = next(s) else { continue };
        if v[s] * v[t] <= 0.0 {
            let before = if s > 0 { Some(s - 1) } else { periodic.then_some(n - 1) };
            [before, Some(s), Some(t), next(t)]
                .into_iter()
                .flatten()
                .for_each(|at| clear[at] = false);
        }
    }
    clear
}

/// Samples at which a joint rests: locked-in friction holds it then, any torque between the two levels of Coulomb friction, which
/// is no function of the state. A joint that never moves does not rest, it is not there.
pub(crate) fn at_rest(speeds: &[f64], interval: f64) -> Vec<bool> {
    let mut sorted: Vec<f64> = speeds.iter().map(|v| v.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    let top = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    let mut rests = vec![false; speeds.len()];
    let fewest = (SETTINGS.rest_s / interval).ceil() as usize;
    let mut from = 0;
    for s in 0..=speeds.len() {
        if s < speeds.len() && speeds[s].abs() < SETTINGS.slow_share * top {
            continue;
        }
        if s - from >= fewest.max(1) {
            rests[from..s].fill(true);
        }
        from = s + 1;
    }
    rests
}
