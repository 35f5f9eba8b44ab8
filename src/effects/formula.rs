//! An effect in symbols.

/// What an effect adds to the torques, in symbols: `q4` and `qd4` are position and speed of the fourth joint, the constants are
/// named as the effect's parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Formula {
    /// Joint and what is added to its torque [N·m or N].
    pub torques: Vec<(usize, String)>,
    /// The energy that the torques are the gradient of (J); `None` for friction, and for what acts on one joint alone though it
    /// depends on two.
    pub energy: Option<String>,
    /// Positions and speeds in it, in the order of the joints.
    pub variables: Vec<String>,
}
