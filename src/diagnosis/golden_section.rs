//! Golden-section search.

/// Where `f` is largest between two places, if it has one maximum there. Every step costs one value and leaves 0.62 of the
/// distance.
pub(crate) fn golden_section(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], steps: usize) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..steps {
        if fa > fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    if fa > fb { a } else { b }
}
