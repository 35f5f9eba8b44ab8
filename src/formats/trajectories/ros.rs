//! Trajectories of ROS 2: `trajectory_msgs/msg/JointTrajectory` as JSON, and the goal of
//! `control_msgs/action/FollowJointTrajectory` as YAML.

use super::table::{Course, State, decimal, parts, states};
use serde_json::json;
use std::fmt::Write;

/// Whole seconds and nanoseconds.
pub(super) fn stamp(time: f64) -> (u64, u32) {
    let nanoseconds = (time * 1e9).round() as u64;
    (nanoseconds / 1_000_000_000, (nanoseconds % 1_000_000_000) as u32)
}

fn list(values: &[f64]) -> String {
    values.iter().map(|&v| decimal(v)).collect::<Vec<_>>().join(",")
}

pub(super) fn json_parts(joints: &[String], course: Course) -> impl Iterator<Item = String> + Send + 'static {
    let header = json!({"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""});
    let head = format!("{{\"header\":{header},\"joint_names\":{},\"points\":[\n", json!(joints));
    let write = |text: &mut String, index: usize, state: State| {
        let (sec, nanosec) = stamp(state.time);
        let separator = if index == 0 { "" } else { ",\n" };
        let [q, qd, qdd] = state.of.map(|v| list(&v));
        write!(
            text,
            "{separator}{{\"positions\":[{q}],\"velocities\":[{qd}],\"accelerations\":[{qdd}],\"effort\":[],\
             \"time_from_start\":{{\"sec\":{sec},\"nanosec\":{nanosec}}}}}"
        )
        .expect("writing to a string cannot fail");
    };
    let points = parts(course, move |text, index, row| write(text, index, states(row)));
    std::iter::once(head)
        .chain(points)
        .chain(std::iter::once("\n]}\n".to_string()))
}

pub(super) fn yaml_parts(joints: &[String], course: Course) -> impl Iterator<Item = String> + Send + 'static {
    // JSON strings are YAML strings.
    let head = format!(
        "# Goal of control_msgs/action/FollowJointTrajectory. The arm has to be at the first point when it begins.\ntrajectory:\n  joint_names: {}\n  points:\n",
        json!(joints)
    );
    let write = |text: &mut String, state: State| {
        let (sec, nanosec) = stamp(state.time);
        let [q, qd, qdd] = state.of.map(|v| list(&v));
        write!(
            text,
            "  - positions: [{q}]\n    velocities: [{qd}]\n    accelerations: [{qdd}]\n    time_from_start: {{sec: {sec}, nanosec: {nanosec}}}\n"
        )
        .expect("writing to a string cannot fail");
    };
    let points = parts(course, move |text, _, row| write(text, states(row)));
    std::iter::once(head).chain(points)
}
