//! Trajectories as recordings: one `sensor_msgs/msg/JointState` for every sample.

use super::ros::stamp;
use super::table::{Course, states};
use byteorder::LittleEndian;
use mcap::records::MessageHeader;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Cursor;

/// Not that of the robot itself: a recording that is played must not pass for its state.
const TOPIC: &str = "/excitation";
const SCHEMA: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n\
================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

#[derive(Serialize)]
struct JointState<'a> {
    sec: i32,
    nanosec: u32,
    frame_id: &'a str,
    name: &'a [String],
    position: &'a [f64],
    velocity: &'a [f64],
    effort: &'a [f64],
}

pub(super) fn mcap(joints: &[String], course: &Course) -> Result<Vec<u8>, String> {
    let wrong = |e: mcap::McapError| e.to_string();
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .create(Cursor::new(Vec::new()))
        .map_err(wrong)?;
    let schema = writer
        .add_schema("sensor_msgs/msg/JointState", "ros2msg", SCHEMA.as_bytes())
        .map_err(wrong)?;
    let channel = writer.add_channel(schema, TOPIC, "cdr", &BTreeMap::new()).map_err(wrong)?;
    for index in 0..course.rows() {
        let state = states(course.row(index));
        let (sec, nanosec) = stamp(state.time);
        let [position, velocity, _] = &state.of;
        let message = JointState {
            sec: i32::try_from(sec).unwrap_or(i32::MAX),
            nanosec,
            frame_id: "",
            name: joints,
            position,
            velocity,
            effort: &[],
        };
        let mut data = vec![0, 1, 0, 0];
        data.extend(cdr_encoding::to_vec::<_, LittleEndian>(&message).map_err(|e| e.to_string())?);
        let at = sec * 1_000_000_000 + u64::from(nanosec);
        let header = MessageHeader {
            channel_id: channel,
            sequence: index as u32,
            log_time: at,
            publish_time: at,
        };
        writer.write_to_known_channel(&header, &data).map_err(wrong)?;
    }
    writer.finish().map_err(wrong)?;
    Ok(writer.into_inner().into_inner())
}
