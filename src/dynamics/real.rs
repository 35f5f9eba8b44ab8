//! Numbers the equations of motion are written over: one sample, or eight at a time.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};
use wide::{f64x2, f64x8};

/// A real number, or several that go through the same operations side by side.
///
/// No fused multiply-add: results are the same on every processor, with or without vector units.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Send
    + Sync
    + 'static
{
    /// The same number in every lane.
    fn splat(v: f64) -> Self;
    /// Sine and cosine [argument in rad].
    fn sin_cos(self) -> (Self, Self);

    /// Zero in every lane.
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

impl Real for f64 {
    fn splat(v: f64) -> Self {
        v
    }

    fn sin_cos(self) -> (Self, Self) {
        // As in a pack, to the last bit.
        let (s, c) = f64x2::splat(self).sin_cos();
        (s.to_array()[0], c.to_array()[0])
    }
}

/// Samples per [`Pack`]: one AVX-512 register, two of AVX2, four of SSE2.
pub const LANES: usize = 8;

/// Eight samples side by side. Plain arrays: the compiler turns the loops into vector instructions of whatever width the
/// enclosing function is compiled for.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Pack(pub [f64; LANES]);

impl Pack {
    /// The first eight values of `from`.
    #[inline(always)]
    pub fn load(from: &[f64]) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&from[..LANES]);
        Self(lanes)
    }

    /// Writes the lanes to the beginning of a slice.
    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        to[..LANES].copy_from_slice(&self.0);
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = [0.0; LANES];
        for ((o, a), b) in out.iter_mut().zip(self.0).zip(other.0) {
            *o = f(a, b);
        }
        Self(out)
    }
}

impl Real for Pack {
    #[inline(always)]
    fn splat(v: f64) -> Self {
        Self([v; LANES])
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = f64x8::from(self.0).sin_cos();
        (Self(s.to_array()), Self(c.to_array()))
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Pack {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    )*};
}
lanewise!(Add add +, Sub sub -, Mul mul *);

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|v| -v))
    }
}

impl AddAssign for Pack {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Pack {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Sines and cosines of many angles [rad], eight at a time.
pub(crate) fn sines_and_cosines(angles: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut sines, mut cosines) = (vec![0.0; angles.len()], vec![0.0; angles.len()]);
    for ((s, c), some) in sines
        .chunks_mut(LANES)
        .zip(cosines.chunks_mut(LANES))
        .zip(angles.chunks(LANES))
    {
        let pack = Pack(std::array::from_fn(|lane| some.get(lane).copied().unwrap_or(0.0)));
        let (sine, cosine) = pack.sin_cos();
        s.copy_from_slice(&sine.0[..some.len()]);
        c.copy_from_slice(&cosine.0[..some.len()]);
    }
    (sines, cosines)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the C library's, whose error is below one unit in the last place. Joints turn by a few turns, spatial waves by
    /// some thousand.
    #[test]
    fn val_sines_and_cosines_are_those_of_the_c_library() {
        let angles: Vec<f64> = (-50_003..50_000).map(|i| f64::from(i) * 0.0731).collect();
        let (sines, cosines) = sines_and_cosines(&angles);
        for ((angle, s), c) in angles.iter().zip(&sines).zip(&cosines) {
            let (sine, cosine) = angle.sin_cos();
            assert!((s - sine).abs() <= 2.0 * f64::EPSILON, "sin {angle}: {s} {sine}");
            assert!((c - cosine).abs() <= 2.0 * f64::EPSILON, "cos {angle}: {c} {cosine}");
            assert_eq!(Real::sin_cos(*angle), (*s, *c));
        }
    }

    #[test]
    fn prop_sine_and_cosine_of_zero_are_exact() {
        assert_eq!(Pack::splat(0.0).sin_cos(), (Pack::splat(0.0), Pack::splat(1.0)));
    }
}
