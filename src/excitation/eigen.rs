//! Eigenvalues and eigenvectors of a symmetric matrix: a third of every evaluation, so compiled for the vector units of the
//! machine.
//!
//! Householder tridiagonalisation and implicit QL with shifts (Martin, Reinsch, Wilkinson 1968; Bowdler, Martin, Reinsch,
//! Wilkinson 1968: `tred2`, `tql2`), arranged so that every inner loop goes along a column. On matrices of this size general
//! libraries, ours and LAPACK, take longer.

use multiversion::multiversion;
use nalgebra::{DMatrix, DVector};

/// Eigenvalues, not sorted, and eigenvectors (columns, orthonormal) of the symmetric `m`. What is not finite gives eigenvalues
/// that are not.
pub(super) fn symmetric_eigen(mut m: DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let size = m.nrows();
    let mut vectors = DMatrix::identity(size, size);
    let (mut diagonal, mut beside) = (DVector::zeros(size), vec![0.0; size]);
    decompose(m.as_mut_slice(), diagonal.as_mut_slice(), &mut beside, vectors.as_mut_slice());
    (diagonal, vectors)
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn decompose(a: &mut [f64], d: &mut [f64], e: &mut [f64], v: &mut [f64]) {
    let n = d.len();
    let mut work = vec![0.0; n];
    // `H_k = 1 − scale_k h hᵀ`, h below the diagonal of column k.
    let scales: Vec<f64> = (0..n).map(|k| reflect(a, n, k, e, &mut work)).collect();
    for k in 0..n {
        d[k] = a[k * n + k];
    }
    for k in (0..n).rev().filter(|&k| scales[k] != 0.0) {
        apply(&a[k * n + k + 1..(k + 1) * n], scales[k], v, n, &mut work);
    }
    transpose(v, n);
    implicit_ql(d, e, v);
}

/// Clears column k below the entry beside the diagonal, which goes to `e[k]`, from both sides. Returns `2/hᵀh` of the h that it
/// leaves in the column.
#[inline(always)]
fn reflect(a: &mut [f64], n: usize, k: usize, e: &mut [f64], work: &mut [f64]) -> f64 {
    let (head, rest) = a.split_at_mut((k + 1) * n);
    let h = &mut head[k * n + k + 1..];
    let Some((&mut first, below)) = h.split_first_mut() else {
        return 0.0;
    };
    let below: f64 = below.iter().map(|x| x * x).sum();
    if below == 0.0 {
        e[k] = first;
        return 0.0;
    }
    // Away from zero: no digits are lost.
    e[k] = -(first * first + below).sqrt().copysign(first);
    h[0] -= e[k];
    let scale = 2.0 / (h[0] * h[0] + below);
    let (h, p) = (&*h, &mut work[..n - k - 1]);
    // p = scale A h, then w = p − (scale/2)(pᵀh) h, and A ← A − h wᵀ − w hᵀ.
    p.fill(0.0);
    for (column, &factor) in rest.chunks_exact(n).zip(h) {
        p.iter_mut().zip(&column[k + 1..]).for_each(|(p, a)| *p += factor * a);
    }
    p.iter_mut().for_each(|p| *p *= scale);
    let half = 0.5 * scale * p.iter().zip(h).map(|(p, h)| p * h).sum::<f64>();
    p.iter_mut().zip(h).for_each(|(p, h)| *p -= half * h);
    for (c, column) in rest.chunks_exact_mut(n).enumerate() {
        let (hc, wc) = (h[c], p[c]);
        let column = column[k + 1..].iter_mut().zip(h.iter().zip(&*p));
        column.for_each(|(a, (h, w))| *a -= h * wc + w * hc);
    }
    scale
}

/// `Qᵀ ← Qᵀ H` on the last rows and columns, as many as h has entries: the rest of Qᵀ is still that of the identity.
#[inline(always)]
fn apply(h: &[f64], scale: f64, v: &mut [f64], n: usize, work: &mut [f64]) {
    let first = n - h.len();
    let product = &mut work[..h.len()];
    product.fill(0.0);
    for (column, &factor) in v.chunks_exact(n).skip(first).zip(h) {
        product.iter_mut().zip(&column[first..]).for_each(|(p, q)| *p += factor * q);
    }
    for (column, &factor) in v.chunks_exact_mut(n).skip(first).zip(h) {
        let factor = scale * factor;
        column[first..].iter_mut().zip(&*product).for_each(|(q, p)| *q -= factor * p);
    }
}

fn transpose(v: &mut [f64], n: usize) {
    for c in 0..n {
        (0..c).for_each(|r| v.swap(c * n + r, r * n + c));
    }
}

/// Turns the tridiagonal matrix (`d` its diagonal, `e` beside it, the last one zero) into its eigenvalues in `d`, and `v` into
/// `v` times its eigenvectors.
#[inline(always)]
fn implicit_ql(d: &mut [f64], e: &mut [f64], v: &mut [f64]) {
    let n = d.len();
    let (mut shifted, mut scale) = (0.0, 0.0f64);
    for l in 0..n {
        scale = scale.max(d[l].abs() + e[l].abs());
        let negligible = f64::EPSILON * scale;
        let m = l + e[l..].iter().position(|e| e.abs() <= negligible).unwrap_or(n - 1 - l);
        // Not a number is not larger either: what is not finite ends here.
        while m > l && e[l].abs() > negligible {
            // The shift is an eigenvalue of the leading 2 × 2 block.
            let before = d[l];
            let p = (d[l + 1] - before) / (2.0 * e[l]);
            let r = p + (p * p + 1.0).sqrt().copysign(p);
            d[l] = e[l] / r;
            d[l + 1] = e[l] * r;
            let (next, beside) = (d[l + 1], e[l + 1]);
            let shift = before - d[l];
            d[l + 2..].iter_mut().for_each(|d| *d -= shift);
            shifted += shift;
            let mut p = d[m];
            let (mut c, mut c2, mut c3, mut s, mut s2) = (1.0, 1.0, 1.0, 0.0, 0.0);
            for i in (l..m).rev() {
                (c3, c2, s2) = (c2, c, s);
                let (g, h) = (c * e[i], c * p);
                let r = (p * p + e[i] * e[i]).sqrt();
                e[i + 1] = s * r;
                (s, c) = (e[i] / r, p / r);
                p = c * d[i] - s * g;
                d[i + 1] = h + s * (c * g + s * d[i]);
                let (left, right) = v[i * n..(i + 2) * n].split_at_mut(n);
                for (x, y) in left.iter_mut().zip(right) {
                    (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                }
            }
            p = -s * s2 * c3 * beside * e[l] / next;
            e[l] = s * p;
            d[l] = c * p;
        }
        d[l] += shifted;
        e[l] = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a size, its eigenvalues over `size · spread / 2` powers of ten and in pairs that are nearly alike.
    fn graded(size: usize, spread: f64) -> DMatrix<f64> {
        let w = DMatrix::from_fn(size + 3, size, |r, c| {
            ((3 * r * r + 5 * c * c + 7 * r * c + 1) as f64).sin() * 10f64.powf(-spread * (c / 2) as f64 / size as f64)
        });
        w.tr_mul(&w)
    }

    #[test]
    fn prop_eigenvectors_are_orthonormal_and_diagonalise() {
        for size in [1, 2, 3, 8, 57] {
            let block = DMatrix::from_diagonal(&DVector::from_fn(size, |i, _| (i % 3) as f64));
            let plain = [DMatrix::identity(size, size) * 2.0, DMatrix::zeros(size, size), block];
            for m in [0.0, 0.4, 6.0].map(|spread| graded(size, spread)).into_iter().chain(plain) {
                let (values, v) = symmetric_eigen(m.clone());
                // Every one of some 2n reflections and rotations of a column rounds once.
                let rounding = 10.0 * size as f64 * f64::EPSILON;
                assert!((v.tr_mul(&v) - DMatrix::identity(size, size)).amax() < rounding, "{m}");
                let back = &v * DMatrix::from_diagonal(&values) * v.transpose();
                assert!((back - &m).amax() <= rounding * m.norm(), "{m}");
            }
        }
    }

    #[test]
    fn prop_what_is_not_finite_ends() {
        let mut m = graded(6, 0.4);
        m[(3, 2)] = f64::NAN;
        m[(2, 3)] = f64::NAN;
        let (values, _) = symmetric_eigen(m);
        assert!(values.iter().any(|v| !v.is_finite()));
    }
}
