//! Numbers the equations of motion are written over: one sample, or eight at a time.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

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
        f64::sin_cos(self)
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
        let (mut s, mut c) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            (s[i], c[i]) = self.0[i].sin_cos();
        }
        (Self(s), Self(c))
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
