//! Products of tall matrices of which many columns are zero: those of joints further out.

use matrixmultiply::dgemm;
use nalgebra::DMatrix;
use std::borrow::Cow;

/// `Aᵀ B`, by blocks that stay in the cache and without the columns that are zero.
pub(crate) fn transposed_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(a.nrows(), b.nrows(), "as many rows");
    let rows = a.nrows();
    let (left, right) = (occupied(a), occupied(b));
    let (packed_a, packed_b) = (packed(a, &left), packed(b, &right));
    let mut product = vec![0.0; left.len() * right.len()];
    if rows > 0 && !product.is_empty() {
        let (step, out) = (rows as isize, left.len() as isize);
        // SAFETY: the slices hold rows × left, rows × right and left × right values, column after column.
        unsafe {
            dgemm(
                left.len(),
                rows,
                right.len(),
                1.0,
                packed_a.as_ptr(),
                step,
                1,
                packed_b.as_ptr(),
                1,
                step,
                0.0,
                product.as_mut_ptr(),
                1,
                out,
            );
        }
    }
    let mut all = DMatrix::zeros(a.ncols(), b.ncols());
    for (c, &to) in right.iter().enumerate() {
        for (r, &at) in left.iter().enumerate() {
            all[(at, to)] = product[c * left.len() + r];
        }
    }
    all
}

fn occupied(m: &DMatrix<f64>) -> Vec<usize> {
    let column = |c: usize| &m.as_slice()[c * m.nrows()..(c + 1) * m.nrows()];
    // Whole runs at once: most columns that are looked through to their end are zero. The sign of a zero is no value.
    let is_zero = |run: &[f64]| run.iter().fold(0, |all, v| all | v.to_bits()) << 1 == 0;
    (0..m.ncols()).filter(|&c| !column(c).chunks(64).all(is_zero)).collect()
}

/// The columns `which`, one after the other.
fn packed<'a>(m: &'a DMatrix<f64>, which: &[usize]) -> Cow<'a, [f64]> {
    if which.len() == m.ncols() {
        return Cow::Borrowed(m.as_slice());
    }
    let rows = m.nrows();
    let mut values = Vec::with_capacity(rows * which.len());
    which
        .iter()
        .for_each(|&c| values.extend_from_slice(&m.as_slice()[c * rows..(c + 1) * rows]));
    Cow::Owned(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_is_the_product() {
        let value = |r: usize, c: usize| {
            if c % 3 == 1 {
                0.0
            } else {
                ((r * 7 + c * 3) % 11) as f64 - 5.0
            }
        };
        let (a, b) = (DMatrix::from_fn(40, 7, value), DMatrix::from_fn(40, 5, |r, c| value(c, r)));
        assert_eq!(transposed_product(&a, &b), a.transpose() * &b);
        assert_eq!(
            transposed_product(&DMatrix::zeros(4, 2), &DMatrix::zeros(4, 0)).shape(),
            (2, 0)
        );
    }
}
