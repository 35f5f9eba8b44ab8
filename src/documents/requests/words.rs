//! The core's types of the words that requests choose from.

use super::{Axis, Criterion, Estimator, FeasibleMethod, Form, JointKind, PreprocessMethod, Start, Triangle};
use crate::{excitation, identification::physical, model, preparation, regression};

impl From<Criterion> for excitation::Criterion {
    fn from(word: Criterion) -> Self {
        match word {
            Criterion::ConditionNumber => Self::ConditionNumber,
            Criterion::ScaledConditionNumber => Self::ScaledConditionNumber,
            Criterion::DOptimality => Self::DOptimality,
            Criterion::AOptimality => Self::AOptimality,
            // What an identification is for: torques predicted well wherever the arm may be. The name `recommended` stays when
            // the recommendation changes.
            Criterion::IOptimality | Criterion::Recommended => Self::IOptimality,
            Criterion::RivalEvidence => Self::RivalEvidence,
        }
    }
}

impl From<Form> for excitation::Form {
    fn from(word: Form) -> Self {
        match word {
            Form::Paper => Self::Paper,
            Form::Exact => Self::Exact,
        }
    }
}

impl From<Start> for excitation::Start {
    fn from(word: Start) -> Self {
        match word {
            Start::Zero => Self::Zero,
            Start::Free => Self::Free,
        }
    }
}

impl From<JointKind> for model::JointKind {
    fn from(word: JointKind) -> Self {
        match word {
            JointKind::Revolute => Self::Revolute,
            JointKind::Prismatic => Self::Prismatic,
        }
    }
}

impl From<Axis> for model::Axis {
    fn from(word: Axis) -> Self {
        match word {
            Axis::X => Self::X,
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
        }
    }
}

impl From<Estimator> for regression::Estimator {
    fn from(word: Estimator) -> Self {
        match word {
            Estimator::Ols => Self::Ordinary,
            Estimator::Wls => Self::Weighted,
            Estimator::Robust => Self::Robust,
        }
    }
}

impl From<PreprocessMethod> for preparation::Method {
    fn from(word: PreprocessMethod) -> Self {
        match word {
            PreprocessMethod::Automatic => Self::Automatic,
            PreprocessMethod::FourierFit => Self::FourierFit,
            PreprocessMethod::ParallelFilter => Self::ParallelFilter,
            PreprocessMethod::Paper => Self::Paper,
        }
    }
}

impl From<FeasibleMethod> for Option<physical::FeasibleMethod> {
    fn from(word: FeasibleMethod) -> Self {
        match word {
            FeasibleMethod::Consistent | FeasibleMethod::Convex => Some(physical::FeasibleMethod::Consistent),
            FeasibleMethod::Paper => Some(physical::FeasibleMethod::Paper),
            FeasibleMethod::Both => Some(physical::FeasibleMethod::Both),
            FeasibleMethod::None => None,
        }
    }
}

impl From<Triangle> for physical::Triangle {
    fn from(word: Triangle) -> Self {
        match word {
            Triangle::Principal => Self::Principal,
            Triangle::Diagonal => Self::Diagonal,
            Triangle::None => Self::None,
        }
    }
}
