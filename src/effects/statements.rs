//! What an effect adds, as source code that C and Python share: both write sums, indices and calls alike.

/// An effect with its values as they are written: numbers in source code.
#[derive(Debug, Clone, PartialEq)]
pub struct Written<'a> {
    /// Which of its forms.
    pub form: usize,
    /// Its joints, from 0.
    pub joints: &'a [usize],
    /// Coefficients, in the order of its columns.
    pub coefficients: Vec<String>,
    /// Shape parameters.
    pub shape: Vec<String>,
    /// Values as they are reported, in brackets.
    pub reported: Vec<String>,
    /// Joints of the robot.
    pub count: usize,
}

/// Expressions in `q[j]`, `qd[j]`, `qdd[j]`, the torques `rigid[j]` of the bodies and `declared[j]` with friction, and the
/// functions `sign`, `clamp` (to ±1), `fabs`, `pow`, `exp`, `tanh`, `sin` and `cos`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Statements {
    /// Torque on a joint [N·m or N].
    pub torque: Vec<(usize, String)>,
    /// What the torque grows by with accelerations: row, column and entry of the mass matrix, `r[i][k]` being that of the bodies
    /// alone.
    pub inertia: Vec<(usize, usize, String)>,
}

impl Statements {
    /// A torque on one joint that does not grow with accelerations.
    pub fn torque_on(joint: usize, torque: String) -> Self {
        Self {
            torque: vec![(joint, torque)],
            inertia: Vec::new(),
        }
    }
}

impl Written<'_> {
    /// The torque on its first joint, made of `[q, qd, qdd]` of that joint.
    pub fn on_own_joint(&self, torque: impl Fn([String; 3]) -> String) -> Option<Statements> {
        let j = self.joints[0];
        let state = ["q", "qd", "qdd"].map(|x| format!("{x}[{j}]"));
        Some(Statements::torque_on(j, torque(state)))
    }
}
