//! How physical parameters are found.

use super::robot::{AxisSchema, InertiaBoundsSchema};
use serde::Serialize;
use utoipa::ToSchema;

/// Physical parameters. `consistent` (or `convex`): least squares with a positive definite pseudo-inertia of every link. `paper`: the
/// nonlinear problem (10a-d) from many starts, and its gap to a lower bound. `both`: the first is the model, the second is told beside it.
#[derive(Serialize, ToSchema)]
#[schema(as = Feasible)]
#[serde(deny_unknown_fields)]
pub struct FeasibleSchema {
    #[schema(required = false, default = "consistent")]
    method: FeasibleMethodSchema,
    /// Weight of the pull towards the robot's prior parameters, in noise variances. Left out: at most 1, and no more than what moves the base parameters by 0.3 of
    /// their standard deviations (root mean square).
    prior_weight: Option<f64>,
    /// Least eigenvalue of the pseudo-inertia, in units of the prior link's.
    #[schema(default = 1e-4)]
    least_eigenvalue: Option<f64>,
    /// Least viscous friction (N·m·s/rad or N·s/m).
    #[schema(default = 0.0)]
    least_viscous: Option<f64>,
    /// On single links, in the place of the robot's own.
    bounds: Option<Vec<LinkBoundsSchema>>,
    /// Per link, in the place of the robot's own; null for none (`paper`).
    slender_axes: Option<Vec<Option<AxisSchema>>>,
    /// Whether (10d) holds besides (10c) (`paper`).
    #[schema(default = true)]
    gazebo: Option<bool>,
    /// Which triangle inequality of the moments of inertia holds (`paper`).
    #[schema(required = false, default = "principal")]
    triangle: TriangleSchema,
    /// Local solves (`paper`).
    #[schema(default = 8, minimum = 1, maximum = 1000)]
    starts: Option<u32>,
    /// Of the random starts (`paper`).
    #[schema(default = 1)]
    seed: Option<u64>,
}

#[derive(Serialize, ToSchema)]
#[schema(as = FeasibleMethod, rename_all = "snake_case")]
pub enum FeasibleMethodSchema {
    Consistent,
    Convex,
    Paper,
    Both,
    None,
}

/// `principal`: of the principal moments, as simulators check it. `diagonal`: of the tensor's diagonal, as in the paper. `none`: not asked.
#[derive(Serialize, ToSchema)]
#[schema(as = Triangle, rename_all = "snake_case")]
pub enum TriangleSchema {
    Principal,
    Diagonal,
    None,
}

/// Bounds on one link, `[lower, upper]`, in its frame.
#[derive(Serialize, ToSchema)]
#[schema(as = LinkBounds)]
#[serde(deny_unknown_fields)]
pub struct LinkBoundsSchema {
    /// From 1.
    link: u32,
    /// (kg)
    mass: Option<[f64; 2]>,
    /// x, y, z in the link frame (m).
    center_of_mass: Option<Vec<Vec<f64>>>,
    /// About the centre of mass (`paper` alone).
    inertia: Option<InertiaBoundsSchema>,
    /// N·m·s/rad or N·s/m
    viscous: Option<[f64; 2]>,
    /// N·m or N
    coulomb: Option<[f64; 2]>,
}
