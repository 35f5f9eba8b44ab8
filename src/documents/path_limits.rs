//! Limits along the path: `constraints.torque` and `constraints.space`.

use super::cursor::Cursor;
use super::requests;
use crate::excitation::{
    DEFAULT_CLEARANCE_M, DEFAULT_SAFETY_FACTOR, HalfSpace, Obstacle, SelfCollision, SpaceLimits, TorqueLimits,
};
use crate::model::INPUT_LIMITS;

pub(super) fn read_torque_limits(cursor: &Cursor) -> Option<TorqueLimits> {
    let fields = cursor.fields_of::<requests::TorqueLimits>()?;
    let factor = fields.nullable("safety_factor").map(|c| c.number());
    Some(TorqueLimits {
        limits: fields.nullable("limits").and_then(|c| c.numbers(None)),
        safety_factor: factor.unwrap_or(Some(DEFAULT_SAFETY_FACTOR))?,
    })
}

/// `joints`: names, where the robot could be read; pairs to be ignored are named by them.
pub(super) fn read_space_limits(cursor: &Cursor, joints: Option<&[String]>) -> Option<SpaceLimits> {
    let fields = cursor.fields_of::<requests::SpaceLimits>()?;
    let list = |name: &str| {
        let cursor = fields.nullable(name)?;
        cursor.items_up_to(INPUT_LIMITS.obstacles, name)
    };
    let list = |name: &str| list(name).unwrap_or_default();
    let clearance = fields.nullable("clearance").map(|c| c.number());
    Some(SpaceLimits {
        half_spaces: list("half_spaces").iter().filter_map(read_half_space).collect(),
        boxes: list("boxes").iter().filter_map(read_box).collect(),
        self_collision: fields
            .nullable("self_collision")
            .and_then(|c| read_self_collision(&c, joints)),
        clearance: clearance.unwrap_or(Some(DEFAULT_CLEARANCE_M))?,
    })
}

fn read_half_space(cursor: &Cursor) -> Option<HalfSpace> {
    let fields = cursor.fields_of::<requests::HalfSpace>()?;
    let name = fields.required("name").and_then(|c| c.string());
    let normal = fields.required("normal").and_then(|c| c.vector());
    let offset = fields.required("offset").and_then(|c| c.number());
    Some(HalfSpace {
        name: name?.to_string(),
        normal: normal?,
        offset: offset?,
    })
}

fn read_box(cursor: &Cursor) -> Option<Obstacle> {
    let fields = cursor.fields_of::<requests::BoxObstacle>()?;
    let name = fields.required("name").and_then(|c| c.string());
    let center = fields.required("center").and_then(|c| c.vector());
    let size = fields.required("size").and_then(|c| c.vector());
    Some(Obstacle {
        name: name?.to_string(),
        center: center?,
        size: size?,
    })
}

fn read_self_collision(cursor: &Cursor, joints: Option<&[String]>) -> Option<SelfCollision> {
    let fields = cursor.fields_of::<requests::SelfCollision>()?;
    // As many pairs as a robot can have, and again the other way round.
    let most = INPUT_LIMITS.joints * INPUT_LIMITS.joints;
    let pairs = fields
        .nullable("ignore")
        .and_then(|c| c.items_up_to(most, "pairs"))
        .unwrap_or_default();
    let ignored = pairs.iter().filter_map(|pair| read_pair(pair, joints?)).collect();
    Some(SelfCollision { ignored })
}

fn read_pair(cursor: &Cursor, joints: &[String]) -> Option<(usize, usize)> {
    let names: Vec<(&str, usize)> = joints.iter().enumerate().map(|(i, n)| (n.as_str(), i)).collect();
    let items = cursor.items()?;
    let [one, other] = items.as_slice() else {
        cursor.complain("is not a pair: give the names of two joints");
        return None;
    };
    let (one, other) = (one.choice(&names), other.choice(&names));
    let (one, other) = (one?, other?);
    Some((one.min(other), one.max(other)))
}
