//! The paper's μ (2) and its way to the standard parameters (4).

use crate::identification::physical::{LinkScale, PhysicalLink, rod_prior};
use crate::model::{LinkPrior, Robot};
use crate::parameters::{Inertial, Layout, ParameterKind};
use crate::spatial::PhysicalInertia;
use nalgebra::{DVector, Matrix3, Vector3};

/// μ link by link: mass, centre of mass, inertia about it (xx, xy, xz, yy, yz, zz), friction as declared; then one constant per
/// extra column. Each stands where the layout has its counterpart: m at M, l_x at MX, I_xx at XX. In the link frames of the
/// description.
pub(super) struct Variables {
    pub layout: Layout,
    pub links: usize,
    /// From the dynamics' link frame to the description's.
    turns: Vec<Matrix3<f64>>,
    /// Natural size of every variable.
    pub scale: DVector<f64>,
}

/// Entries of a symmetric tensor in the order xx, xy, xz, yy, yz, zz.
pub(super) const ENTRIES: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

impl Variables {
    /// For `count` unknowns: the standard parameters and the extra columns.
    pub fn new(robot: &Robot, count: usize) -> Self {
        let layout = Layout::standard(robot);
        let size = |i: usize| match layout.parameters().get(i) {
            Some(p) => {
                let LinkScale { mass, length } = LinkScale::from_link(&rod_prior(robot, p.link));
                match p.kind {
                    ParameterKind::Inertial(Inertial::M) => mass,
                    ParameterKind::Inertial(Inertial::MX | Inertial::MY | Inertial::MZ) => length,
                    ParameterKind::Inertial(_) => mass * length * length,
                    // Friction is of the order of a newton metre, and determined by the log in any case.
                    _ => 1.0,
                }
            }
            None => 1.0,
        };
        Self {
            scale: DVector::from_fn(count, |i, _| size(i)),
            links: robot.joint_count(),
            turns: robot.joints().iter().map(|j| j.description_frame).collect(),
            layout,
        }
    }

    /// Index of the mass of `link`, which the other inertial variables follow.
    pub fn first(&self, link: usize) -> usize {
        self.layout.inertial(link, Inertial::M)
    }

    /// Index of the friction of `link`, where the model has it.
    pub fn friction(&self, link: usize, kind: ParameterKind) -> Option<usize> {
        self.layout.parameters().iter().position(|p| p.link == link && p.kind == kind)
    }

    pub fn body(&self, mu: &[f64], link: usize) -> PhysicalInertia {
        let v = &mu[self.first(link)..];
        PhysicalInertia {
            mass: v[0],
            center_of_mass: Vector3::new(v[1], v[2], v[3]),
            inertia: Matrix3::new(v[4], v[5], v[6], v[5], v[7], v[8], v[6], v[8], v[9]),
        }
    }

    /// Bodies and friction in the frames of the dynamics, as variables; friction and extra columns are those of `phi`.
    pub fn of_bodies(&self, bodies: &[PhysicalInertia], phi: &[f64]) -> Vec<f64> {
        let mut mu = phi.to_vec();
        for (link, (body, turn)) in bodies.iter().zip(&self.turns).enumerate() {
            let (center, inertia) = (turn * body.center_of_mass, turn * body.inertia * turn.transpose());
            let at = self.first(link);
            mu[at] = body.mass;
            mu[at + 1..at + 4].copy_from_slice(center.as_slice());
            ENTRIES
                .iter()
                .enumerate()
                .for_each(|(e, &entry)| mu[at + 4 + e] = inertia[entry]);
        }
        mu
    }

    /// The variables of standard parameters; `None` where a mass is zero.
    pub fn of_standard(&self, phi: &[f64]) -> Option<Vec<f64>> {
        let bodies: Option<Vec<_>> = (0..self.links)
            .map(|link| self.layout.link_inertia(phi, link).physical())
            .collect();
        Some(self.of_bodies(&bodies?, phi))
    }

    /// Prior bodies, with friction and extra columns of `phi`.
    pub fn of_priors(&self, priors: &[LinkPrior], phi: &[f64]) -> Vec<f64> {
        let bodies: Vec<_> = priors.iter().map(|p| p.inertia).collect();
        self.of_bodies(&bodies, phi)
    }

    /// π(μ) of (4), in the frames of the dynamics.
    pub fn standard(&self, mu: &[f64]) -> DVector<f64> {
        let mut phi = DVector::from_column_slice(mu);
        for (link, turn) in self.turns.iter().enumerate() {
            let body = self.body(mu, link);
            let turned = PhysicalInertia {
                mass: body.mass,
                center_of_mass: turn.transpose() * body.center_of_mass,
                inertia: turn.transpose() * body.inertia * turn,
            };
            let parameters = turned.about_origin().parameters();
            phi.rows_mut(self.first(link), 10).copy_from_slice(&parameters);
        }
        phi
    }

    /// `(∂π/∂μ)ᵀ g`. With G the symmetric matrix of derivatives by the entries of the tensor about the origin,
    /// `I_o = I + m (c·c E − c cᵀ)`: by I that is G itself, by m it is `g_h·c + tr(G) c·c − c·Gc` more, and by c it is
    /// `m (g_h + 2 tr(G) c − 2 G c)`.
    pub fn pull_back(&self, mu: &[f64], gradient: &DVector<f64>) -> DVector<f64> {
        let mut pulled = gradient.clone();
        for (link, turn) in self.turns.iter().enumerate() {
            let at = self.first(link);
            let g = &gradient.as_slice()[at..at + 10];
            let half = |r: usize, c: usize, v: f64| if r == c { v } else { 0.5 * v };
            let mut tensor = Matrix3::zeros();
            for (e, &(r, c)) in ENTRIES.iter().enumerate() {
                tensor[(r, c)] = half(r, c, g[4 + e]);
                tensor[(c, r)] = tensor[(r, c)];
            }
            let tensor = turn * tensor * turn.transpose();
            let moment = turn * Vector3::new(g[1], g[2], g[3]);
            let (m, c) = (mu[at], Vector3::new(mu[at + 1], mu[at + 2], mu[at + 3]));
            let (trace, turned) = (tensor.trace(), tensor * c);
            pulled[at] = g[0] + moment.dot(&c) + trace * c.dot(&c) - c.dot(&turned);
            let by_center = (moment + c * (2.0 * trace) - turned * 2.0) * m;
            pulled.rows_mut(at + 1, 3).copy_from(&by_center);
            for (e, &(r, c)) in ENTRIES.iter().enumerate() {
                pulled[at + 4 + e] = tensor[(r, c)] * if r == c { 1.0 } else { 2.0 };
            }
        }
        pulled
    }

    /// Links as simulators call them.
    pub fn physical(&self, mu: &[f64]) -> Vec<PhysicalLink> {
        let friction = |link, kind| self.friction(link, kind).map_or(0.0, |at| mu[at]);
        (0..self.links)
            .map(|link| PhysicalLink {
                inertia: self.body(mu, link),
                viscous: friction(link, ParameterKind::Viscous),
                coulomb: friction(link, ParameterKind::Coulomb),
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Friction, Joint, JointKind};
    use crate::spatial::Transform;

    fn variables() -> Variables {
        let turned = |k: usize| Joint {
            description_frame: Transform::from_xyz_rpy(Vector3::zeros(), Vector3::new(0.3, 0.8 * k as f64, -1.1)).rotation,
            ..Joint::from_placement(format!("j{k}"), JointKind::Revolute, Transform::trans(0.3, 0.1, 0.2))
        };
        let friction = Friction {
            viscous: true,
            coulomb: true,
        };
        let robot = Robot::new("two", Vector3::new(0.0, 0.0, -9.81), vec![turned(0), turned(1)], friction).unwrap();
        Variables::new(&robot, 25)
    }

    fn some(count: usize, seed: f64) -> Vec<f64> {
        (0..count).map(|i| (seed + 1.3 * i as f64).sin() + 1.5).collect()
    }

    #[test]
    fn prop_variables_and_standard_parameters_are_inverse_to_each_other() {
        let (v, mu) = (variables(), some(25, 0.2));
        let back = v.of_standard(v.standard(&mu).as_slice()).unwrap();
        assert!(mu.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn prop_the_pull_back_is_the_derivative() {
        let (v, mu) = (variables(), some(25, 0.2));
        let g = DVector::from_vec(some(25, 2.0));
        let exact = v.pull_back(&mu, &g);
        for i in 0..25 {
            // π is a polynomial of degree three: a central difference is off by h² and rounding of 1e-16/h.
            let h = 1e-5;
            let (mut up, mut down) = (mu.clone(), mu.clone());
            (up[i], down[i]) = (up[i] + h, down[i] - h);
            let difference = g.dot(&(v.standard(&up) - v.standard(&down))) / (2.0 * h);
            assert!(
                (difference - exact[i]).abs() < 1e-8 * (1.0 + exact[i].abs()),
                "{i}: {difference} {}",
                exact[i]
            );
        }
    }
}
