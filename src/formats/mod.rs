//! Files as people have them, one folder each way: robots and logs in, trajectories and models out.
//!
//! A format knows the types of the core and none of the [documents](crate::documents), which are made of it.

pub mod json;
pub mod logs;
mod mathml;
pub mod models;
pub mod robots;
pub mod trajectories;
mod words;

pub use crate::model::shortest;
pub use json::{Malformed, Parsed, parse};
pub(crate) use mathml::mathml;
pub use models::{FinalModel, Missing, MissingEffect, ModelFormat, Patched, urdf, urdf_gravity};
pub use robots::{RobotArchive, add_shapes, is_archive, meshes_of, robot_archive, robot_file, shapes_of_meshes};
pub use trajectories::{
    MOST_ROWS, Parts, TrajectoryFile, TrajectoryFormat, trajectory_csv, trajectory_csv_parts, trajectory_json_parts,
};
pub use words::{listed, measured, significant, unit};
