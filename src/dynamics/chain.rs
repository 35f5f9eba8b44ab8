//! The constants of a robot's kinematics, laid out for the recursions.

use crate::model::Robot;

/// One joint's fixed place: `rotation` (rows first) and `translation` of its frame in the previous one at q = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Link {
    pub rotation: [[f64; 3]; 3],
    pub translation: [f64; 3],
    pub revolute: bool,
}

/// Kinematics of a robot as plain numbers; immutable and shared by all threads.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    pub(super) links: Vec<Link>,
    /// Minus the acceleration of gravity in the base frame: a base that accelerates upwards feels like gravity.
    pub(super) base_acceleration: [f64; 3],
}

impl Chain {
    /// The chain of `robot`, with what does not change from sample to sample worked out.
    pub fn new(robot: &Robot) -> Self {
        let links = robot
            .joints()
            .iter()
            .map(|joint| {
                let r = joint.placement.rotation;
                Link {
                    rotation: std::array::from_fn(|i| std::array::from_fn(|k| r[(i, k)])),
                    translation: joint.placement.translation.into(),
                    revolute: joint.is_revolute(),
                }
            })
            .collect();
        Self {
            links,
            base_acceleration: (-robot.gravity()).into(),
        }
    }

    /// Number of joints n.
    pub fn joint_count(&self) -> usize {
        self.links.len()
    }
}
