//! What a document or a log may ask for at most.
//!
//! A small document can describe a large computation: a chain of ten thousand joints, a trajectory of a million harmonics, a log
//! whose last time stamp is a trillion seconds. Everything that the input controls (recursion, walks, loops, allocations) is held
//! to these limits while it is read, and the error states the limit that was exceeded.

/// Limits on the size of what the readers accept. Each is far above what arms, controllers and recordings have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputLimits {
    /// Levels of nesting in a JSON document; documents here are 8 deep.
    pub json_depth: usize,
    /// Levels of nesting in an XML document; a URDF file is 5 deep, an MJCF file as deep as its chain is long.
    pub xml_depth: usize,
    /// Elements in an XML document; a humanoid with hands has 5,000.
    pub xml_elements: usize,
    /// Attributes of one XML element; `<inertia>` has 6.
    pub xml_attributes: usize,
    /// XML prefixes without a declaration that are read as if they had one.
    pub xml_prefixes: usize,
    /// Joints of a chain. Redundant arms have 7, dual-arm chains 15; base parameters are tested up to 10.
    pub joints: usize,
    /// Characters of a name of a robot, joint, link or obstacle.
    pub name_characters: usize,
    /// Capsules of one link; a link of a real arm is covered by 1 to 4.
    pub capsules_per_link: usize,
    /// Half-spaces and boxes together.
    pub obstacles: usize,
    /// Pairs of bodies whose distance is kept: one evaluation of a design computes all of them at every sample.
    pub distance_pairs: usize,
    /// Harmonics of a Fourier series: more than any controller's bandwidth carries.
    pub harmonics: usize,
    /// Lowest and highest fundamental frequency (Hz): a period between a millisecond and a day.
    pub fundamental_hz: [f64; 2],
    /// Largest coefficient or offset of a trajectory (rad, rad/s, m or m/s).
    pub coefficient: f64,
    /// Least and largest standard deviation of a torque [N·m or N]. Squares of their ratio stay far from the range of doubles.
    pub torque_noise: [f64; 2],
    /// Effects in a model, and rivals of one effect.
    pub model_effects: usize,
    /// Own effects of a request, or of a robot.
    pub own_effects: usize,
    /// Largest mass (kg), inertia [kg m²] and friction [N·m·s/rad, N·m] of a link; the largest industrial arms weigh 10 t.
    pub mass: f64,
    /// Largest moment or product of inertia [kg m²].
    pub inertia: f64,
    /// Largest coefficient of friction [N·m s/rad or N s/m; N·m or N].
    pub friction: f64,
    /// Largest distance between two joints, or of a centre of mass from its joint (m): millimetres taken for metres land far
    /// above.
    pub length: f64,
    /// Notes about how a document was read.
    pub notes: usize,
    /// Rows of a log: at 1 kHz more than two hours.
    pub log_rows: usize,
    /// Largest measured position: a hundred thousand turns, or a thousand kilometres [rad or m].
    pub measured_position: f64,
    /// Largest measured velocity: far beyond the spindle of any drive [rad/s or m/s].
    pub measured_velocity: f64,
    /// Largest value of a further measured quantity, in whatever unit.
    pub measured_channel: f64,
    /// Further measured quantities of a log.
    pub channels: usize,
    /// Largest measured torque: far above what the largest crane lifts [N·m or N].
    pub measured_torque: f64,
    /// Largest time stamp (s): nanoseconds since 1970 taken for seconds are 2e18.
    pub time_stamp: f64,
    /// Columns of a log, used or not.
    pub log_columns: usize,
    /// Bytes of one line of a log. A file without line ends would fill the memory.
    pub log_line: usize,
    /// Bytes of the header of a log.
    pub log_header: usize,
    /// How many times larger than the file a compressed log may be, beyond `log_unpacked_free` bytes. Recordings compress to a
    /// tenth.
    pub log_expansion: u64,
    /// Bytes that a compressed log may unpack to whatever its size.
    pub log_unpacked_free: u64,
    /// Bytes of a log in a format that is read in memory (NPZ, MATLAB, Parquet): at 1 kHz some hours.
    pub log_in_memory: u64,
    /// Bytes of a log that is unpacked to the disk (rosbag2).
    pub log_on_disk: u64,
    /// Numbers of all columns of a log in such a format.
    pub log_numbers: usize,
    /// Values of a simulated log: rows times joints and two more columns. Of seven joints a quarter of an hour at 1 kHz; in
    /// memory 130 MB.
    pub simulated_values: usize,
    /// Steps of a simulation with elastic joints, times joints: of seven joints nearly five minutes.
    pub simulated_steps: usize,
}

/// The limits in force.
pub const INPUT_LIMITS: InputLimits = InputLimits {
    json_depth: 100,
    xml_depth: 200,
    xml_elements: 200_000,
    xml_attributes: 256,
    xml_prefixes: 64,
    joints: 30,
    name_characters: 200,
    capsules_per_link: 32,
    obstacles: 200,
    distance_pairs: 5_000,
    harmonics: 50,
    fundamental_hz: [1e-5, 1e3],
    coefficient: 1e6,
    torque_noise: [1e-9, 1e9],
    model_effects: 200,
    own_effects: 32,
    mass: 1e6,
    inertia: 1e9,
    friction: 1e9,
    length: 20.0,
    notes: 100,
    log_rows: 8_000_000,
    measured_position: 1e6,
    measured_velocity: 1e6,
    measured_channel: 1e12,
    channels: 8,
    measured_torque: 1e9,
    time_stamp: 1e20,
    log_columns: 4_096,
    log_line: 4 << 20,
    log_header: 200_000,
    log_expansion: 100,
    log_unpacked_free: 32 << 20,
    log_in_memory: 1 << 30,
    log_on_disk: 16 << 30,
    log_numbers: 128 << 20,
    simulated_values: 8_000_000,
    simulated_steps: 2_000_000,
};
