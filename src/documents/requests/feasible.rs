//! How physical parameters are found.

use super::robot::{Axis, InertiaBounds};
use serde::{Deserialize, Serialize};

/// Physical parameters. `consistent` (or `convex`): least squares with a positive definite pseudo-inertia of every link. `paper`:
/// the nonlinear problem (10a-d) from many starts, and its gap to a lower bound. `both`: the first is the model, the second is
/// reported beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Feasible {
    /// How the physical parameters are found.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = FeasibleMethod, required = false, default = "consistent"))]
    pub method: Option<FeasibleMethod>,
    /// Weight of the pull towards the robot's prior parameters, in noise variances. Left out: at most 1, and no more than what
    /// moves the base parameters by 0.3 of their standard deviations (root mean square).
    pub prior_weight: Option<f64>,
    /// Least eigenvalue of the pseudo-inertia, in units of the prior link's.
    #[cfg_attr(feature = "service", schema(default = 1e-4))]
    pub least_eigenvalue: Option<f64>,
    /// Least viscous friction (N·m·s/rad or N·s/m).
    #[cfg_attr(feature = "service", schema(default = 0.0))]
    pub least_viscous: Option<f64>,
    /// On single links, in the place of the robot's own.
    pub bounds: Option<Vec<LinkBounds>>,
    /// Per link, in the place of the robot's own; null for none (`paper`).
    pub slender_axes: Option<Vec<Option<Axis>>>,
    /// Whether (10d) holds besides (10c) (`paper`).
    #[cfg_attr(feature = "service", schema(default = true))]
    pub gazebo: Option<bool>,
    /// Which triangle inequality of the moments of inertia holds (`paper`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Triangle, required = false, default = "principal"))]
    pub triangle: Option<Triangle>,
    /// Local solves (`paper`).
    #[cfg_attr(feature = "service", schema(default = 8, minimum = 1, maximum = 1000))]
    pub starts: Option<u32>,
    /// Of the random starts (`paper`).
    #[cfg_attr(feature = "service", schema(default = 1))]
    pub seed: Option<u64>,
}

/// Method for physical parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum FeasibleMethod {
    /// Least squares with a positive definite pseudo-inertia of every link, a semidefinite problem.
    Consistent,
    /// Another name for `consistent`.
    Convex,
    /// The nonlinear problem (10a-d) of the paper.
    Paper,
    /// Both; the result of `consistent` is the model.
    Both,
    /// No physical parameters.
    None,
}

/// `principal`: of the principal moments, as simulators check it. `diagonal`: of the tensor's diagonal, as in the paper. `none`:
/// not asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Triangle {
    /// `I_1 ≤ I_2 + I_3` for the principal moments of inertia: what a mass density can have.
    Principal,
    /// The same for the diagonal elements only, as the paper has it.
    Diagonal,
    /// No triangle inequality.
    None,
}

/// Bounds on one link, `[lower, upper]`, in its frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct LinkBounds {
    /// From 1.
    pub link: u32,
    /// (kg)
    pub mass: Option<[f64; 2]>,
    /// x, y, z in the link frame (m).
    pub center_of_mass: Option<Vec<Vec<f64>>>,
    /// About the centre of mass (`paper` alone).
    pub inertia: Option<InertiaBounds>,
    /// N·m·s/rad or N·s/m
    pub viscous: Option<[f64; 2]>,
    /// N·m or N
    pub coulomb: Option<[f64; 2]>,
}
