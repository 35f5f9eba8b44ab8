//! Thinning series for the eye.

/// Indices of about `most` samples, ascending, among them the lowest and the highest value of every series in every one of as
/// many equal stretches as that allows: what is drawn from them has every peak.
///
/// # Panics
/// When the series differ in length.
pub fn keep_peaks(series: &[&[f64]], most: usize) -> Vec<usize> {
    let n = series.first().map_or(0, |s| s.len());
    assert!(series.iter().all(|s| s.len() == n), "series of equal length");
    if n <= most {
        return (0..n).collect();
    }
    let stretches = (most / (2 * series.len())).max(1);
    let mut kept = Vec::with_capacity(most);
    for b in 0..stretches {
        let range = b * n / stretches..(b + 1) * n / stretches;
        for values in series {
            let by_value = |&a: &usize, &b: &usize| values[a].total_cmp(&values[b]);
            kept.extend(range.clone().min_by(by_value));
            kept.extend(range.clone().max_by(by_value));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_samples_that_stand_out_are_kept() {
        let mut flat = vec![0.0; 100_000];
        let slope: Vec<f64> = (0..100_000).map(f64::from).collect();
        for (at, value) in [(17, 1.0), (50_123, -2.0), (99_998, 3.0)] {
            flat[at] = value;
        }
        let kept = keep_peaks(&[&flat, &slope], 1000);
        assert!(kept.len() <= 1000 && kept.is_sorted());
        for at in [0, 17, 50_123, 99_998, 99_999] {
            assert!(kept.contains(&at), "{at}");
        }
        assert_eq!(keep_peaks(&[&flat[..5]], 1000), [0, 1, 2, 3, 4]);
    }
}
