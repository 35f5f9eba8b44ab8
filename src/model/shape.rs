//! Shapes of links that nobody described: capsules along the kinematics.

use super::{Capsule, Robot};
use nalgebra::Vector3;

/// Radius of a link over the length of the arm: arms of one metre have links about 12 cm thick (UR5e, iiwa 7, Panda).
const SLENDERNESS: f64 = 0.06;
/// Radii of links of arms, from desktop arms to those of 300 kg (m).
const RADII: [f64; 2] = [0.02, 0.12];
/// Links shorter than so many radii are inside their neighbours.
const SHORTEST: f64 = 1.5;

impl Robot {
    /// The robot with shapes, where no link of it has one: a capsule from every joint to the next, as thick as links of arms of
    /// this length are. The last link reaches to twice its centre of mass, where that is known. Second, the joints whose links
    /// were given one.
    ///
    /// It is a guess: enough to keep an arm from folding into itself, and to be replaced by capsules of the real links where the
    /// arm comes close to anything.
    pub fn with_shape(&self) -> (Self, Vec<String>) {
        if self.joints().iter().any(|j| !j.geometry.is_empty()) {
            return (self.clone(), Vec::new());
        }
        let reaches = self.reaches();
        let whole: f64 = reaches.iter().map(|r| r.norm()).sum();
        let radius = (SLENDERNESS * whole).clamp(RADII[0], RADII[1]);
        let long = |reach: &Vector3<f64>| reach.norm() > SHORTEST * radius && reach.norm() < super::INPUT_LIMITS.length;
        let mut shaped = self.clone();
        let mut named = Vec::new();
        for (joint, reach) in shaped.joints_mut().iter_mut().zip(&reaches).filter(|(_, reach)| long(reach)) {
            joint.geometry = vec![Capsule {
                ends: [Vector3::zeros(), *reach],
                radius,
            }];
            named.push(joint.name.clone());
        }
        (shaped, named)
    }

    /// Where the next joint is, in the frame of every link (m).
    fn reaches(&self) -> Vec<Vector3<f64>> {
        let next = self.joints().iter().skip(1).map(|j| j.placement.translation);
        let tip = self.joints().last().and_then(|j| j.prior);
        let tip = tip.map_or(Vector3::zeros(), |p| 2.0 * p.inertia.center_of_mass);
        next.chain([tip]).collect()
    }
}
