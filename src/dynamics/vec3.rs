//! Three-vectors over [`Real`]: what the recursions need and no more.

use super::Real;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vec3<R> {
    pub x: R,
    pub y: R,
    pub z: R,
}

impl<R: Real> Vec3<R> {
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(R::zero(), R::zero(), R::zero())
    }

    #[inline(always)]
    pub fn splat(v: [f64; 3]) -> Self {
        Self::new(R::splat(v[0]), R::splat(v[1]), R::splat(v[2]))
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> R {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self::new(
            self.y * o.z - self.z * o.y,
            self.z * o.x - self.x * o.z,
            self.x * o.y - self.y * o.x,
        )
    }

    /// `m x` for a constant matrix, rows first.
    #[inline(always)]
    pub fn rotated(self, m: &[[f64; 3]; 3]) -> Self {
        let row = |r: &[f64; 3]| R::splat(r[0]) * self.x + R::splat(r[1]) * self.y + R::splat(r[2]) * self.z;
        Self::new(row(&m[0]), row(&m[1]), row(&m[2]))
    }

    /// `mᵀ x` for a constant matrix, rows first.
    #[inline(always)]
    pub fn rotated_back(self, m: &[[f64; 3]; 3]) -> Self {
        let column = |i: usize| R::splat(m[0][i]) * self.x + R::splat(m[1][i]) * self.y + R::splat(m[2][i]) * self.z;
        Self::new(column(0), column(1), column(2))
    }
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<R: Real> Sub for Vec3<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<R: Real> Neg for Vec3<R> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> Mul<R> for Vec3<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, s: R) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}

impl<R: Real> AddAssign for Vec3<R> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
