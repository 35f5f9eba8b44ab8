//! Weighted least squares of a robot's model, with or without effects: one engine under identification and diagnosis.
//!
//! A [`Stretch`] is the dataset: motion, torque, weights and gaps, from a prepared log. [`AugmentedModel`] is the declared model
//! with effects; its torque is `tau = Y(q, qd, qdd) phi + sum of C_k c_k`, where distortions change q, gravity or gains before Y
//! is taken. Rows are whitened by a [`NoiseModel`] per joint, the model is linearised (`jacobian`), summed to normal equations,
//! and solved by Gauss-Newton steps; rank is decided once (`rank`). What a further block of columns would gain is found after the
//! model's own columns are projected out (`partial_regression`). Covariances are those of the noise where it accounts for the
//! residual, and of blocks of time where more is left (`block_jackknife`, `hac`). [`estimate`] is the whole in one call.

mod ar_noise;
mod behind_filter;
mod block_jackknife;
mod column_cache;
mod dataset;
mod decimation;
mod declared_torque;
mod distortion;
mod errors;
mod estimate;
mod explained;
mod from_log;
mod gauss_newton;
mod hac;
mod huber;
mod jacobian;
mod joint_normal;
mod kept;
mod model;
pub(crate) mod motion_error;
mod noise_floor;
mod normal_equations;
mod partial_regression;
mod period_groups;
mod perturbed;
mod present;
mod product;
mod rank;
mod recorded_filter;
mod rows;
mod settings;
mod solution;
mod tail;
mod torque_derivatives;

pub(crate) use ar_noise::deviation;
pub use ar_noise::{NoiseModel, NoiseSource};
pub(crate) use block_jackknife::{TimeBlock, jackknife_sum, left_out, time_blocks};
pub(crate) use column_cache::{ColumnKey, Shaped};
pub(crate) use dataset::spans;
pub use dataset::{Stretch, Unfiltered};
pub use errors::PredictionErrors;
pub(crate) use errors::{raw_residual, squares};
pub(crate) use estimate::estimated;
pub use estimate::{Estimate, Estimator, Fitted, JointFit, estimate};
pub use explained::{Explained, explained_share};
pub(crate) use explained::{folds_in_time, shares, with_constant};
pub(crate) use gauss_newton::persistence;
pub(crate) use hac::{chance_of, misfit_from, single_estimate};
pub(crate) use jacobian::shape_derivatives;
pub use joint_normal::JointNormal;
pub use model::{AugmentedModel, Term, reported};
pub(crate) use noise_floor::floor;
pub use normal_equations::Prior;
pub(crate) use normal_equations::{Data, System, Thinned};
pub(crate) use partial_regression::{Reduced, Whitened, reduce, width};
pub(crate) use present::Present;
pub(crate) use product::transposed_product;
pub(crate) use rank::{directions, directions_above, pseudo_inverse, pseudo_root};
pub(crate) use recorded_filter::{Phase, RecordedFilter, SampledFilter};
pub use settings::{SETTINGS, Settings};
pub use solution::Solution;
pub(crate) use tail::{chi_square_tail, f_tail};
