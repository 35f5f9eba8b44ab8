//! Rigid-body inertia in the forms the field uses: about the link-frame origin (linear in the dynamics), about the centre of
//! mass (what a simulator wants), and as the 4 × 4 pseudo-inertia (whose definiteness is physical consistency).

use super::Transform;
use nalgebra::{Matrix3, Matrix4, Vector3};

/// Mass, first moment and rotational inertia about the frame origin: the ten standard inertial parameters of a link,
/// in the paper's order `M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ` (3). Units kg, kg m, kg m². `XY = I_xy − m l_x l_y` is the
/// entry of the inertia tensor, not the positive integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkInertia {
    /// Mass (kg).
    pub mass: f64,
    /// `m · l_C` [kg m].
    pub first_moment: Vector3<f64>,
    /// Inertia tensor about the frame origin [kg m²].
    pub inertia: Matrix3<f64>,
}

/// Mass, centre of mass and inertia about it: the paper's `mu` (2) without friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalInertia {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass in the link frame (m).
    pub center_of_mass: Vector3<f64>,
    /// Inertia tensor about the centre of mass, axes of the link frame [kg m²].
    pub inertia: Matrix3<f64>,
}

impl LinkInertia {
    /// No mass.
    pub fn zero() -> Self {
        Self {
            mass: 0.0,
            first_moment: Vector3::zeros(),
            inertia: Matrix3::zeros(),
        }
    }

    /// From `[M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ]`.
    pub fn from_parameters(p: &[f64]) -> Self {
        Self {
            mass: p[0],
            first_moment: Vector3::new(p[1], p[2], p[3]),
            inertia: Matrix3::new(p[4], p[5], p[6], p[5], p[7], p[8], p[6], p[8], p[9]),
        }
    }

    /// `[M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ]`.
    pub fn parameters(&self) -> [f64; 10] {
        let (h, i) = (&self.first_moment, &self.inertia);
        [
            self.mass,
            h.x,
            h.y,
            h.z,
            i[(0, 0)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 1)],
            i[(1, 2)],
            i[(2, 2)],
        ]
    }

    /// The same body seen from frame A, where `pose` is the pose of the present frame B in A.
    ///
    /// With `h' = R h` and `t` the translation: first moment `h' + m t`, inertia
    /// `R I Rᵀ + 2 (h'·t) E − h' tᵀ − t h'ᵀ + m (t·t E − t tᵀ)` (parallel axes, Khalil & Dombre 2004).
    pub fn transformed(&self, pose: &Transform) -> Self {
        let t = pose.translation;
        let h = pose.rotation * self.first_moment;
        let inertia = pose.rotation * self.inertia * pose.rotation.transpose()
            + Matrix3::identity() * (2.0 * h.dot(&t) + self.mass * t.dot(&t))
            - h * t.transpose()
            - t * h.transpose()
            - t * t.transpose() * self.mass;
        Self {
            mass: self.mass,
            first_moment: h + t * self.mass,
            inertia,
        }
    }

    /// Pseudo-inertia `[[Σ, h], [hᵀ, m]]` with `Σ = ½ tr(I) E − I`; positive definite if and only if the body has a positive
    /// mass density somewhere: positive mass and the triangle inequality of the principal moments (Wensing et al. 2018).
    pub fn pseudo_inertia(&self) -> Matrix4<f64> {
        let sigma = Matrix3::identity() * (0.5 * self.inertia.trace()) - self.inertia;
        let mut j = Matrix4::zeros();
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&sigma);
        j.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.first_moment);
        j.fixed_view_mut::<1, 3>(3, 0).copy_from(&self.first_moment.transpose());
        j[(3, 3)] = self.mass;
        j
    }

    /// `None` when there is a first moment without mass, because then no centre of mass exists; that of nothing is the origin.
    pub fn physical(&self) -> Option<PhysicalInertia> {
        if self.mass == 0.0 {
            let nowhere = self.first_moment == Vector3::zeros();
            return nowhere.then_some(PhysicalInertia {
                mass: 0.0,
                center_of_mass: Vector3::zeros(),
                inertia: self.inertia,
            });
        }
        let c = self.first_moment / self.mass;
        let steiner = Matrix3::identity() * c.dot(&c) - c * c.transpose();
        Some(PhysicalInertia {
            mass: self.mass,
            center_of_mass: c,
            inertia: self.inertia - steiner * self.mass,
        })
    }
}

impl PhysicalInertia {
    /// The paper's (4): standard parameters from physical ones.
    pub fn about_origin(&self) -> LinkInertia {
        let c = self.center_of_mass;
        let steiner = Matrix3::identity() * c.dot(&c) - c * c.transpose();
        LinkInertia {
            mass: self.mass,
            first_moment: c * self.mass,
            inertia: self.inertia + steiner * self.mass,
        }
    }
}

impl std::ops::Add for LinkInertia {
    type Output = LinkInertia;

    fn add(self, other: LinkInertia) -> LinkInertia {
        LinkInertia {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            inertia: self.inertia + other.inertia,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> PhysicalInertia {
        PhysicalInertia {
            mass: 2.5,
            center_of_mass: Vector3::new(0.1, -0.2, 0.05),
            inertia: Matrix3::new(0.03, 0.002, -0.001, 0.002, 0.04, 0.003, -0.001, 0.003, 0.02),
        }
    }

    #[test]
    fn prop_physical_and_standard_parameters_are_inverse_to_each_other() {
        let back = body().about_origin().physical().unwrap();
        assert!((back.center_of_mass - body().center_of_mass).amax() < 1e-15);
        assert!((back.inertia - body().inertia).amax() < 1e-15);
    }

    #[test]
    fn prop_transforming_keeps_inertia_about_the_centre_of_mass() {
        let pose = Transform::from_xyz_rpy(Vector3::new(0.4, 0.1, -0.3), Vector3::new(0.2, 0.9, -2.0));
        let moved = body().about_origin().transformed(&pose).physical().unwrap();
        let expected = pose.rotation * body().inertia * pose.rotation.transpose();
        assert!((moved.inertia - expected).amax() < 1e-14);
        assert!((moved.center_of_mass - (pose.rotation * body().center_of_mass + pose.translation)).amax() < 1e-15);
    }

    #[test]
    fn prop_pseudo_inertia_is_definite_exactly_when_the_triangle_inequality_holds() {
        let smallest = |b: PhysicalInertia| b.about_origin().pseudo_inertia().symmetric_eigenvalues().min();
        assert!(smallest(body()) > 0.0);
        let needle = PhysicalInertia {
            inertia: Matrix3::from_diagonal(&Vector3::new(0.05, 0.02, 0.02)),
            ..body()
        };
        assert!(smallest(needle) < 0.0, "0.05 > 0.02 + 0.02 is no body");
    }
}
