//! Sampled trajectories in the formats of controllers and recorders.

#[cfg(feature = "formats")]
mod archive;
#[cfg(feature = "formats")]
mod recording;
mod ros;
mod table;
mod urscript;

use self::table::Course;
use crate::trajectory::FourierSeries;
use std::path::Path;
pub use table::{MOST_ROWS, trajectory_csv, trajectory_csv_parts, trajectory_json_parts};

/// How a sampled trajectory is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// `time, q1…, qd1…, qdd1…`.
    Csv,
    /// An object of `columns` and `rows`.
    Json,
    /// `trajectory_msgs/msg/JointTrajectory` of ROS 2, as JSON.
    JointTrajectory,
    /// A goal of `control_msgs/action/FollowJointTrajectory`, as YAML.
    Yaml,
    /// A program of `servoj` for the controllers of Universal Robots.
    Urscript,
    /// `sensor_msgs/msg/JointState` messages.
    Mcap,
    /// NumPy arrays `time`, `q`, `qd`, `qdd`.
    Npz,
}

/// Positions in a file of a format that is made in memory, of all joints together: with velocities, accelerations and the file
/// itself about 70 bytes each, 100 MB.
const MOST_IN_MEMORY: usize = 1_400_000;

impl TrajectoryFormat {
    /// Names of the formats, as requests have them.
    pub const ALL: [(&'static str, Self); 7] = [
        ("csv", Self::Csv),
        ("json", Self::Json),
        ("joint_trajectory", Self::JointTrajectory),
        ("yaml", Self::Yaml),
        ("urscript", Self::Urscript),
        ("mcap", Self::Mcap),
        ("npz", Self::Npz),
    ];

    /// By the ending of a file's name; CSV where it is none of those known.
    pub fn of_file(path: &Path) -> Self {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("json") => Self::JointTrajectory,
            Some("yaml" | "yml") => Self::Yaml,
            Some("script" | "urscript") => Self::Urscript,
            Some("mcap") => Self::Mcap,
            Some("npz") => Self::Npz,
            _ => Self::Csv,
        }
    }

    /// Type of the content, and ending of a file.
    pub fn kind(self) -> (&'static str, &'static str) {
        match self {
            Self::Csv => ("text/csv; charset=utf-8", "csv"),
            Self::Json | Self::JointTrajectory => ("application/json", "json"),
            Self::Yaml => ("application/yaml", "yaml"),
            Self::Urscript => ("text/plain; charset=utf-8", "script"),
            Self::Mcap => ("application/octet-stream", "mcap"),
            Self::Npz => ("application/octet-stream", "npz"),
        }
    }

    /// Rows that can be written of so many joints.
    pub fn most_rows(self, joints: usize) -> usize {
        match self {
            Self::Mcap | Self::Npz => MOST_IN_MEMORY / joints.max(1),
            _ => MOST_ROWS,
        }
    }
}

/// `periods` periods of a trajectory of these joints at `rate_hz`, with the first sample of the period after them: the motion
/// ends where it began. Before them a run-in, after them a run-out.
pub struct TrajectoryFile<'a> {
    /// Names of the joints.
    pub joints: &'a [String],
    /// The trajectory of one period.
    pub series: &'a FourierSeries,
    /// Rows per second (Hz).
    pub rate_hz: f64,
    /// Number of periods.
    pub periods: usize,
    /// Series whose first half periods are the ways into the motion and out of it, whole numbers of samples
    /// ([`run_in`](crate::excitation::run_in)).
    pub run_in: Option<FourierSeries>,
    /// Series of the way out, as in `run_in`; nothing if the motion ends with the last period.
    pub run_out: Option<FourierSeries>,
}

/// Bytes of a file, part by part: the whole may be gigabytes.
pub type Parts = Box<dyn Iterator<Item = Vec<u8>> + Send>;

impl TrajectoryFile<'_> {
    /// The file in `format`.
    ///
    /// # Errors
    /// Why the format does not hold this robot's motion, in words.
    pub fn parts(&self, format: TrajectoryFormat) -> Result<Parts, String> {
        let course = Course {
            series: self.series.clone(),
            rate_hz: self.rate_hz,
            periods: self.periods,
            run_in: self.run_in.clone(),
            run_out: self.run_out.clone(),
        };
        let most = format.most_rows(self.joints.len());
        if course.rows() > most {
            return Err(format!(
                "has more than {most} rows; take a lower rate or fewer periods, or a format of text"
            ));
        }
        let text = |parts: Box<dyn Iterator<Item = String> + Send>| Box::new(parts.map(String::into_bytes)) as Parts;
        Ok(match format {
            TrajectoryFormat::Csv => text(Box::new(table::csv_parts(course))),
            TrajectoryFormat::Json => text(Box::new(table::json_parts(course))),
            TrajectoryFormat::JointTrajectory => text(Box::new(ros::json_parts(self.joints, course))),
            TrajectoryFormat::Yaml => text(Box::new(ros::yaml_parts(self.joints, course))),
            TrajectoryFormat::Urscript => text(Box::new(urscript::parts(course)?)),
            #[cfg(feature = "formats")]
            TrajectoryFormat::Mcap => one(recording::mcap(self.joints, &course)?),
            #[cfg(feature = "formats")]
            TrajectoryFormat::Npz => one(archive::npz(&course)?),
            #[cfg(not(feature = "formats"))]
            TrajectoryFormat::Mcap | TrajectoryFormat::Npz => return Err("this build lacks the feature `formats`".into()),
        })
    }
}

#[cfg(feature = "formats")]
fn one(bytes: Vec<u8>) -> Parts {
    Box::new(std::iter::once(bytes))
}
