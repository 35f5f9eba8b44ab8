//! Functions of one position and of one speed that laws are composed of.

/// A function of a position, or of a combination of two. Waves with a phase have two columns, the others one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfPosition {
    /// `xⁿ`.
    Power(u8),
    /// `sin(n x)`.
    Sine(u8),
    /// `cos(n x)`.
    Cosine(u8),
    /// `sin(n x + φ)`: sine and cosine.
    Wave(u8),
}

impl OfPosition {
    /// Values of its columns at `x`.
    pub(super) fn at(self, x: f64) -> [f64; 2] {
        match self {
            Self::Power(n) => [x.powi(i32::from(n)), 0.0],
            Self::Sine(n) => [(f64::from(n) * x).sin(), 0.0],
            Self::Cosine(n) => [(f64::from(n) * x).cos(), 0.0],
            Self::Wave(n) => [(f64::from(n) * x).sin(), (f64::from(n) * x).cos()],
        }
    }

    pub(super) fn columns(self) -> usize {
        if matches!(self, Self::Wave(_)) { 2 } else { 1 }
    }

    /// Whether a whole turn of `x` brings the same value.
    pub(super) fn is_periodic(self) -> bool {
        !matches!(self, Self::Power(_))
    }
}

/// A function of a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OfSpeed {
    /// `v`.
    Linear,
    /// `sign v`.
    Sign,
    /// `|v|`.
    Absolute,
    /// `v |v|`.
    Quadratic,
}

impl OfSpeed {
    pub(super) const ALL: [Self; 4] = [Self::Linear, Self::Sign, Self::Absolute, Self::Quadratic];

    /// Value at `v`, whose sign is taken as `sign`.
    pub(super) fn at(self, v: f64, sign: f64) -> f64 {
        match self {
            Self::Linear => v,
            Self::Sign => sign,
            Self::Absolute => v.abs(),
            Self::Quadratic => v * v.abs(),
        }
    }

    /// Power of the speed's unit that it has.
    pub(super) fn power(self) -> usize {
        match self {
            Self::Sign => 0,
            Self::Linear | Self::Absolute => 1,
            Self::Quadratic => 2,
        }
    }
}
