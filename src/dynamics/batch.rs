//! A motion sampled in time, laid out so that eight samples are read at once.

use super::{Channel, LANES};

/// How the sign in the Coulomb column is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coulomb {
    /// `sign(qd)`, with `sign(0) = 0`.
    Sign,
    /// `qd / sqrt(qd² + eps²)`, eps in rad/s or m/s: differentiable, for use inside a search.
    Smooth(f64),
}

impl Coulomb {
    /// The sign of friction at velocity `qd` [rad/s or m/s]: −1 to 1.
    #[inline(always)]
    pub fn value(self, qd: f64) -> f64 {
        match self {
            Coulomb::Sign if qd == 0.0 => 0.0,
            Coulomb::Sign => qd.signum(),
            Coulomb::Smooth(eps) => qd / (qd * qd + eps * eps).sqrt(),
        }
    }

    /// Derivative by `qd`; zero for the true sign.
    #[inline(always)]
    pub fn slope(self, qd: f64) -> f64 {
        match self {
            Coulomb::Sign => 0.0,
            Coulomb::Smooth(eps) => {
                let square = qd * qd + eps * eps;
                eps * eps / (square * square.sqrt())
            }
        }
    }
}

/// `q, qd, qdd` of n joints at N samples. Joint-major, each joint's samples contiguous and padded with zeros to a multiple of
/// [`LANES`]: value of joint j at sample s is `q[j * stride + s]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    joints: usize,
    samples: usize,
    stride: usize,
    pub(crate) q: Vec<f64>,
    pub(crate) qd: Vec<f64>,
    pub(crate) qdd: Vec<f64>,
    /// What else is known along the motion.
    channels: Vec<Channel>,
}

impl Motion {
    /// A motion at rest at zero.
    pub fn zeros(joints: usize, samples: usize) -> Self {
        let stride = samples.div_ceil(LANES) * LANES;
        let zeros = vec![0.0; joints * stride];
        Self {
            joints,
            samples,
            stride,
            q: zeros.clone(),
            qd: zeros.clone(),
            qdd: zeros,
            channels: Vec::new(),
        }
    }

    /// The same motion with these further quantities along it, N values each.
    #[must_use]
    pub fn with_channels(mut self, channels: Vec<Channel>) -> Self {
        debug_assert!(channels.iter().all(|c| c.values.len() == self.samples));
        self.channels = channels;
        self
    }

    /// The further quantities.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Values of the quantity of this name; `None` where it was not measured.
    pub fn channel(&self, name: &str) -> Option<&[f64]> {
        self.channels.iter().find(|c| &*c.name == name).map(|c| &*c.values)
    }

    /// From functions of (joint, sample).
    pub fn from_fn(joints: usize, samples: usize, mut state: impl FnMut(usize, usize) -> [f64; 3]) -> Self {
        let mut motion = Self::zeros(joints, samples);
        for j in 0..joints {
            for s in 0..samples {
                motion.set(j, s, state(j, s));
            }
        }
        motion
    }

    /// Number of joints n.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Becomes the `samples` samples of `from` that begin with `first`, at most as many as there is room for.
    pub(crate) fn copy_part(&mut self, from: &Motion, first: usize, samples: usize) {
        debug_assert!(samples <= self.stride && self.joints == from.joints && first + samples <= from.samples);
        self.samples = samples;
        for (to, part) in [(&mut self.q, &from.q), (&mut self.qd, &from.qd), (&mut self.qdd, &from.qdd)] {
            for (to, part) in to.chunks_exact_mut(self.stride).zip(part.chunks_exact(from.stride)) {
                to[..samples].copy_from_slice(&part[first..first + samples]);
                to[samples..].fill(0.0);
            }
        }
    }

    /// Distance between two joints' values; a multiple of [`LANES`], at least [`Self::samples`].
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Sets position, velocity and acceleration of one joint at one sample [rad, rad/s, rad/s² or m, m/s, m/s²].
    pub fn set(&mut self, joint: usize, sample: usize, [q, qd, qdd]: [f64; 3]) {
        let at = joint * self.stride + sample;
        self.q[at] = q;
        self.qd[at] = qd;
        self.qdd[at] = qdd;
    }

    /// `[q, qd, qdd]` of a joint at a sample.
    pub fn get(&self, joint: usize, sample: usize) -> [f64; 3] {
        let at = joint * self.stride + sample;
        [self.q[at], self.qd[at], self.qdd[at]]
    }

    /// Positions of `joint` over time.
    pub fn positions(&self, joint: usize) -> &[f64] {
        &self.q[joint * self.stride..joint * self.stride + self.samples]
    }

    /// Velocities of `joint` over time.
    pub fn velocities(&self, joint: usize) -> &[f64] {
        &self.qd[joint * self.stride..joint * self.stride + self.samples]
    }

    /// Accelerations of `joint` over time.
    pub fn accelerations(&self, joint: usize) -> &[f64] {
        &self.qdd[joint * self.stride..joint * self.stride + self.samples]
    }
}
