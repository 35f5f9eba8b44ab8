//! Which parameters a formula is linear in.

use super::derivative::derivative;
use super::tree::{Operation, Tree, plain_sign};

/// Points at which a formula that did not simplify to zero is looked at.
const POINTS: usize = 12;

/// The largest set of `parameters` (symbols) that the formula is linear in together, and zero without; in their order. Of sets of
/// one size the first.
pub fn linear_set(tree: &Tree, parameters: &[usize], symbols: usize) -> Vec<usize> {
    let slopes: Vec<Tree> = parameters.iter().map(|&p| derivative(tree, p)).collect();
    let n = parameters.len();
    let bent: Vec<Vec<bool>> = slopes
        .iter()
        .map(|slope| parameters.iter().map(|&p| depends(slope, p, symbols)).collect())
        .collect();
    let is_in = |set: usize, i: usize| set >> i & 1 == 1;
    let fits = |set: &usize| {
        let straight = (0..n).all(|i| !is_in(*set, i) || (0..n).all(|k| !is_in(*set, k) || !bent[i][k]));
        let without = |symbol: usize| {
            let at = parameters.iter().position(|&p| p == symbol)?;
            is_in(*set, at).then_some(Tree::Number(0.0))
        };
        straight && is_zero(&tree.with(&without), tree, symbols)
    };
    // The first parameters have the highest rank among sets of one size.
    let rank = |set: &usize| {
        (
            set.count_ones(),
            std::cmp::Reverse((0..n).filter(|&i| is_in(*set, i)).collect::<Vec<_>>()),
        )
    };
    let best = (1..1usize << n).filter(fits).max_by_key(rank).unwrap_or(0);
    (0..n).filter(|&i| is_in(best, i)).map(|i| parameters[i]).collect()
}

/// Whether a tree changes with a symbol: at another value of it, and at the opposite one, where absolute values and signs change.
fn depends(tree: &Tree, symbol: usize, symbols: usize) -> bool {
    let at = |factor: f64| {
        tree.with(&|s| (s == symbol).then(|| Tree::pair(Operation::Multiply, Tree::Number(factor), Tree::Symbol(s))))
    };
    let differs = |factor: f64| !is_zero(&Tree::pair(Operation::Subtract, at(factor), tree.clone()), tree, symbols);
    tree.has(&|s| s == symbol) && (differs(1.7) || differs(-1.0))
}

/// Whether a tree is zero, by its form or at many points, beside values of `size`.
pub fn is_zero(tree: &Tree, size: &Tree, symbols: usize) -> bool {
    if *tree == Tree::Number(0.0) {
        return true;
    }
    let at = |tree: &Tree, point: usize| tree.value(&|s| coordinate(point, s, symbols), &|v, _| plain_sign(v));
    let pairs = (0..POINTS).map(|p| (at(tree, p), at(size, p)));
    let usable: Vec<(f64, f64)> = pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    // Differences of equal values are off by rounding, some 1e-16 of either.
    !usable.is_empty() && usable.iter().all(|(value, size)| value.abs() <= 1e-11 * (1.0 + size.abs()))
}

/// Coordinates between 0.3 and 1.7 that no formula has in mind: multiples of the golden ratio.
fn coordinate(point: usize, symbol: usize, symbols: usize) -> f64 {
    let k = (point * symbols + symbol + 1) as f64;
    0.3 + 1.4 * (k * 0.618_033_988_749_894_9).fract()
}

/// Whether a turn more of a symbol is the same.
pub fn is_periodic(tree: &Tree, symbol: usize, symbols: usize) -> bool {
    let turned = tree.with(&|s| {
        let turn = Tree::Number(std::f64::consts::TAU);
        (s == symbol).then(|| Tree::pair(Operation::Add, Tree::Symbol(s), turn))
    });
    let difference = Tree::pair(Operation::Subtract, turned, tree.clone());
    is_zero(&difference, tree, symbols)
}
