//! What an effect says about itself, and what it is evaluated on.

use super::{Formula, Statements, Written};
use crate::dynamics::{Coulomb, Motion};
use crate::model::Robot;
use nalgebra::{DMatrix, Vector3};

/// One stretch of motion, with the torques that the present model predicts for it: all that a column can be made of.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The robot as declared, under the gravity that the effects give it.
    pub robot: &'a Robot,
    /// The motion after all distortions.
    pub motion: &'a Motion,
    /// Rigid-body torque of every joint over the samples, without friction [N·m or N]; n × N.
    pub rigid: &'a [Vec<f64>],
    /// Torque of the declared model with friction [N·m or N]; n × N.
    pub declared: &'a [Vec<f64>],
    /// Time between samples (s).
    pub interval: f64,
    /// Whether the sample after the last is the first.
    pub periodic: bool,
    /// How the sign of a velocity is taken: as it is for data, smooth where a motion is searched along gradients.
    pub coulomb: Coulomb,
}

impl Scene<'_> {
    /// Sign of a velocity; 0 for 0.
    pub fn sign(&self, velocity: f64) -> f64 {
        self.coulomb.value(velocity)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.motion.samples()
    }
}

/// The torque that one unit of a coefficient adds: rows of the joints named, zero on all others.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// `(joint, values over the samples)` of every joint that the column is not zero on [N·m or N per unit of the coefficient].
    pub rows: Vec<(usize, Vec<f64>)>,
}

impl Column {
    /// A column on one joint alone.
    pub fn on(joint: usize, values: Vec<f64>) -> Self {
        Self {
            rows: vec![(joint, values)],
        }
    }
}

/// What the regressor is evaluated at: a distortion changes it before Y is computed.
#[derive(Debug, Clone)]
pub struct World {
    /// The motion that the motors really make, on whose side friction is.
    pub motion: Motion,
    /// The motion of the links, where a gear gives way between.
    pub links: Option<Motion>,
    /// The gravity that it is really under [m/s²].
    pub gravity: Vector3<f64>,
    /// Factor on the torque of every joint.
    pub gain: Vec<f64>,
}

impl World {
    /// A motion as it was measured, under the robot's own gravity, read by true torque channels.
    pub fn measured(motion: &Motion, robot: &Robot) -> Self {
        Self {
            motion: motion.clone(),
            links: None,
            gravity: robot.gravity(),
            gain: vec![1.0; robot.joint_count()],
        }
    }

    /// What both sides of the gears do.
    pub fn motions(&self) -> Motions<'_> {
        Motions {
            motors: &self.motion,
            links: self.links.as_ref().unwrap_or(&self.motion),
        }
    }
}

/// What both sides of the gears do: rigid bodies follow the links, friction the motors (Spong 1987).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motions<'a> {
    /// Of the motors.
    pub motors: &'a Motion,
    /// Of the links.
    pub links: &'a Motion,
}

impl<'a> Motions<'a> {
    /// Gears that do not give way.
    pub fn stiff(motion: &'a Motion) -> Self {
        Self {
            motors: motion,
            links: motion,
        }
    }
}

/// How an effect enters the equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectKind {
    /// `tau += C(motion; shape) c`.
    Additive,
    /// Enters every row through the model: the distorted motion, gravity or gain is what Y is evaluated at, its parameters are
    /// found by Gauss-Newton from the derivative of the whole torque.
    Distortion,
    /// Columns that the base parameters hold already: only against an existing model can they be seen.
    AgainstModel,
    /// Seen only when the periods are looked at one by one.
    BetweenPeriods,
}

/// What the columns of an effect at one sample depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reads {
    /// On the states of the effect's own joints at that sample.
    OwnJoints,
    /// On the state of the whole arm at that sample.
    Arm,
    /// On other samples as well.
    Course,
}

/// A parameter that is reported.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterInfo {
    /// Name as it is reported.
    pub name: String,
    /// Unit as it is reported.
    pub unit: String,
}

impl ParameterInfo {
    /// A parameter of this name and unit, without a range.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
        }
    }
}

/// A parameter the columns are not linear in: where it may lie, and the values a search starts from.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Values that a search begins from.
    pub grid: Vec<f64>,
}

impl Shape {
    /// A grid of `count` values at equal ratios.
    pub fn geometric(low: f64, high: f64, count: usize) -> Self {
        let ratio = (high / low).powf(1.0 / (count - 1) as f64);
        Self {
            low,
            high,
            grid: (0..count).map(|i| low * ratio.powi(i as i32)).collect(),
        }
    }

    /// A value that is given and not estimated, such as the position at which an amplitude holds. Fixed shapes come after all
    /// others.
    pub fn fixed(value: f64) -> Self {
        Self {
            low: value,
            high: value,
            grid: vec![value],
        }
    }

    /// Whether it is given.
    pub fn is_fixed(&self) -> bool {
        self.low == self.high
    }
}

/// How far a joint moved over all data: shape parameters are searched where the data can show them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Difference of the largest and smallest position [rad or m].
    pub range: f64,
    /// Largest position [rad or m].
    pub highest: f64,
    /// Largest speed [rad/s or m/s].
    pub speed: f64,
    /// Time between samples (s).
    pub interval: f64,
    /// Standard deviation of the speeds' error [rad/s or m/s].
    pub speed_error: f64,
}

/// Positions that a joint can take [rad or m]: its limits, or what it was seen to take where it has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Lowest position.
    pub low: f64,
    /// Highest position.
    pub high: f64,
}

/// What the residual of an effect's joint is plotted over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlotVariable {
    /// Of the joint.
    Position,
    /// Of the joint.
    Speed,
    /// Of the joint.
    Acceleration,
    /// Of the joint.
    Torque,
    /// Of the log.
    Time,
}

/// Description of an effect for readers: all that pages, reports and sentences say of it comes from here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Its name, as a heading.
    pub name: &'static str,
    /// Its name within a sentence, with an article where it takes one.
    pub phrase: &'static str,
    /// What it is, in a sentence for the glossary.
    pub meaning: &'static str,
    /// What shows it best.
    pub over: PlotVariable,
    /// When it can be identified, and when base parameters hide it.
    pub identifiable: &'static str,
    /// Codes of effects it is easily taken for.
    pub rivals: &'static [&'static str],
    /// Where its law is published.
    pub source: &'static str,
}

/// A physical effect.
pub trait Effect: Sync + Send {
    /// The stable code of findings.
    fn code(&self) -> &str;

    /// The effect in words: its law, and what it stands for.
    fn about(&self) -> About;

    /// How it enters the model.
    fn kind(&self) -> EffectKind {
        EffectKind::Additive
    }

    /// What its columns at one sample depend on. Designs differentiate them by that and nothing else.
    fn reads(&self) -> Reads {
        Reads::OwnJoints
    }

    /// Whether its columns depend on the torques of the scene; otherwise the motion alone makes them.
    fn reads_torques(&self) -> bool {
        false
    }

    /// The joints it can sit on: one list per candidate; an empty list stands for the whole robot.
    fn places(&self, robot: &Robot) -> Vec<Vec<usize>> {
        (0..robot.joint_count()).map(|j| vec![j]).collect()
    }

    /// The places of one of its [forms](Self::forms): the same for all unless said otherwise.
    fn places_of(&self, _form: usize, robot: &Robot) -> Vec<Vec<usize>> {
        self.places(robot)
    }

    /// Of the joints of a place, those whose torque it changes, as findings name them: all unless said otherwise.
    fn acts_on(&self, _form: usize, joints: &[usize]) -> Vec<usize> {
        joints.to_vec()
    }

    /// Its formula, where the code alone does not say what is added.
    fn formula(&self, _form: usize, _joints: &[usize]) -> Option<Formula> {
        None
    }

    /// What it adds as source code; `None` where it is no function of the state at one sample, and where nobody has written it.
    fn statements(&self, _written: &Written) -> Option<Statements> {
        None
    }

    /// `count` coefficients that are well visible in noise of `noise` [N·m or N] on a joint that carries about `load` [N·m or N],
    /// at speeds and positions of about 1: for tests. Four times the noise by every column unless said otherwise.
    fn example(&self, count: usize, noise: f64, _load: f64) -> Vec<f64> {
        vec![4.0 * noise; count]
    }

    /// Variants with fewer or more shape parameters, simplest first.
    fn forms(&self) -> usize {
        1
    }

    /// Parameters the columns are not linear in.
    fn shapes(&self, _form: usize, _joints: &[usize], _spans: &[Span]) -> Vec<Shape> {
        Vec::new()
    }

    /// One column per coefficient. Distortions have none.
    fn columns(&self, _form: usize, _scene: &Scene, _joints: &[usize], _shape: &[f64]) -> Vec<Column> {
        Vec::new()
    }

    /// Applies a distortion with parameters `theta`. Effects of other kinds leave the world as it is.
    fn distort(&self, _scene: &Scene, _joints: &[usize], _theta: &[f64], _world: &mut World) {}

    /// Whether a distortion depends on the torques of [`Scene::rigid`]: those of the distorted motion, which are then found by
    /// iteration.
    fn distorts_by_load(&self) -> bool {
        false
    }

    /// Whether a distortion leaves the motion as it is: it turns gravity or scales torques.
    fn keeps_motion(&self) -> bool {
        false
    }

    /// Whether gravity has another direction in the world that a distortion makes: base parameters that gravity along an axis
    /// hides can then be seen.
    fn turns_gravity(&self) -> bool {
        false
    }

    /// For every parameter of a distortion: the step that its derivative is differenced with, small beside any value of interest
    /// and large beside the rounding of the torques.
    fn steps(&self) -> &'static [f64] {
        &[]
    }

    /// Whether differences are taken on both sides of a value: reversals lie between the values, and one side would have them
    /// all. One side does where the torque is smooth over a step.
    fn is_differenced_both_ways(&self) -> bool {
        false
    }

    /// Least step where columns go through a filter, with samples every `interval` seconds: they are differenced over no less.
    fn least_step(&self, _interval: f64) -> f64 {
        0.0
    }

    /// Coefficients (parameters of a distortion, `count` of them) of the effect with size one, in each of its parameters that
    /// have a size. `middle` is the middle of where its first joint moves. Each parameter by itself unless said otherwise.
    fn units(&self, _form: usize, count: usize, _middle: f64) -> Vec<Vec<f64>> {
        let unit = |at: usize| (0..count).map(|i| if i == at { 1.0 } else { 0.0 }).collect();
        (0..count).map(unit).collect()
    }

    /// What is reported: the coefficients in the order of the columns, then the shape parameters; for a distortion its
    /// parameters.
    fn parameters(&self, form: usize, robot: &Robot, joints: &[usize]) -> Vec<ParameterInfo>;

    /// The physically consistent coefficients nearest to these, in the metric of their information matrix. The same unless said
    /// otherwise.
    fn consistent(&self, coefficients: &[f64], _information: &DMatrix<f64>) -> Vec<f64> {
        coefficients.to_vec()
    }

    /// Which of the coefficients, then shapes (for a distortion its parameters), are positive by their physical meaning. One that
    /// the data say is negative is an imitation.
    fn positive(&self, _form: usize) -> &[usize] {
        &[]
    }

    /// Whether every robot has it, more or less: what the standard dynamic parameters of a joint hold besides body and friction
    /// (Khalil & Dombre 2004: Ia and offset). Where the data do not decide, such an effect is the likelier one.
    fn is_everyday(&self) -> bool {
        false
    }

    /// Whether few robots have it, by construction or because it is a fault that commissioning finds. Where the noise is not
    /// measured, it needs better evidence.
    fn is_rare(&self) -> bool {
        false
    }

    /// Whether its torque times the speed is power that friction takes. Such effects on one joint are judged together: one alone
    /// may give some of it back.
    fn is_friction(&self, _form: usize) -> bool {
        false
    }

    /// Where the shape parameters, or the parameters of a distortion, lie on robots ([`ranges`](super::ranges)); empty where
    /// nothing is known.
    fn ranges(&self, _form: usize, _robot: &Robot, _joints: &[usize]) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// Whether these coefficients are those of a real thing, as far as `covariance` lets it be seen, on a joint that can be
    /// anywhere in `travel`.
    fn is_plausible(&self, _coefficients: &[f64], _covariance: &DMatrix<f64>, _travel: Travel) -> bool {
        true
    }

    /// Codes of the effects on the same joints that it comes to where its parameters go to a limit: it fits no worse than those,
    /// whatever the cause.
    fn contains(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether these coefficients, or some within three of their standard deviations, are those of a real thing, and not the
    /// limit at which it is one of the effects that it [contains](Self::contains).
    fn is_within_reach(&self, _coefficients: &[f64], _covariance: &DMatrix<f64>) -> bool {
        true
    }

    /// Directions of the coefficients at the border between real things and the effects that it [contains](Self::contains): those
    /// that [`is_within_reach`](Self::is_within_reach) parts where the data leave no doubt. None where it contains nothing.
    fn borders(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// The coefficients of the real thing that is most like one with these. The same where these are those of a real thing.
    fn brought_within_reach(&self, coefficients: &[f64]) -> Vec<f64> {
        coefficients.to_vec()
    }

    /// Reported values from coefficients and shape; differentiable, for the standard deviations. The identity unless said
    /// otherwise.
    fn reported(&self, _form: usize, coefficients: &[f64], shape: &[f64]) -> Vec<f64> {
        coefficients.iter().chain(shape).copied().collect()
    }
}

/// A column on `joint` from its own `[q, qd, qdd]`.
pub(crate) fn own_joint(scene: &Scene, joint: usize, value: impl Fn([f64; 3]) -> f64) -> Column {
    Column::on(
        joint,
        (0..scene.samples()).map(|s| value(scene.motion.get(joint, s))).collect(),
    )
}

/// `N m s/rad` and the like: effort unit of the joint with `suffix` written for its position unit.
pub(crate) fn times_position_unit(robot: &Robot, joint: usize, suffix: &str) -> String {
    let joint = &robot.joints()[joint];
    format!("{}{}", joint.effort_unit(), suffix.replace("rad", joint.position_unit()))
}
