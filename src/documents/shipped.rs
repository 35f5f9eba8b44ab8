//! The robots that come with the program, by name.

use super::robot::{NamedRobots, RobotDocument, robot_document};
use crate::formats::json::parse;

/// Name and document of every robot in `examples/robots/`.
pub const ROBOTS: [(&str, &str); 14] = [
    ("iiwa14", include_str!("../../examples/robots/iiwa14.json")),
    ("iiwa7", include_str!("../../examples/robots/iiwa7.json")),
    ("fr3", include_str!("../../examples/robots/fr3.json")),
    ("ur10", include_str!("../../examples/robots/ur10.json")),
    ("ur3e", include_str!("../../examples/robots/ur3e.json")),
    ("ur5e", include_str!("../../examples/robots/ur5e.json")),
    ("ur10e", include_str!("../../examples/robots/ur10e.json")),
    ("lwr4", include_str!("../../examples/robots/lwr4.json")),
    ("panda", include_str!("../../examples/robots/panda.json")),
    ("tx40", include_str!("../../examples/robots/tx40.json")),
    ("puma560", include_str!("../../examples/robots/puma560.json")),
    ("gen3", include_str!("../../examples/robots/gen3.json")),
    ("scara", include_str!("../../examples/robots/scara.json")),
    ("planar_two_link", include_str!("../../examples/robots/planar_two_link.json")),
];

/// The robots that come with the program.
#[derive(Debug, Clone, Copy, Default)]
pub struct Shipped;

impl NamedRobots for Shipped {
    fn named(&self, name: &str) -> Option<RobotDocument> {
        let (_, text) = ROBOTS.iter().find(|(known, _)| *known == name)?;
        let parsed = parse(text.as_bytes()).expect("shipped documents are JSON");
        Some(robot_document(&parsed).expect("shipped documents are valid"))
    }

    fn names(&self) -> Vec<String> {
        ROBOTS.iter().map(|(name, _)| name.to_string()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_robot_is_valid() {
        for name in Shipped.names() {
            let read = Shipped.named(&name).expect("listed");
            assert!(read.notes.is_empty(), "{name}: {:?}", read.notes);
            assert!(
                read.robot.joints().iter().all(|j| j.limits.velocity.is_some()),
                "{name} can be excited as it is"
            );
        }
    }
}
