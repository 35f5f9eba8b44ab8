//! Documents and files at the edge: JSON, URDF, logs and trajectories to and from the types of the core.
//!
//! Reading collects everything that is wrong with a document ([`Findings`]) before it gives up, so that one round of corrections is
//! enough: the reader's own findings (unknown fields, wrong types) and the core's (limits the wrong way round, too many harmonics)
//! end in one list, each with a JSON pointer, what is wrong, and the remedy.

mod augmented_document;
mod base_document;
mod bounds_document;
mod columns_document;
mod cursor;
mod design_document;
mod excitation_request;
mod identify_document;
mod identify_request;
mod inspect_document;
mod json;
mod knowledge_request;
pub mod log;
mod mathml;
mod model_document;
mod model_file;
mod motion_document;
mod path_limits;
mod residual_document;
mod residual_reading;
mod robot;
mod robot_report;
pub mod shipped;
mod trajectory_file;
mod validate_request;
mod warm_start;
mod words;

pub use crate::model::shortest;
pub use augmented_document::{ReadModel, augmented_value, diagnosis_value, read_augmented};
pub use base_document::{BaseParameterDocument, BaseParametersDocument};
pub use cursor::{Cursor, Fields, Findings};
pub use design_document::{
    Assessed, AssumedParameterDocument, Coefficients, CriteriaDocument, DesignDocument, DetectableDocument,
    DetectableEffectDocument, EffectDocument, FirstRunDocument, FurtherDocument, InseparableDocument, MarginDocument,
    PredictedDocument, SearchDocument, StartDocument,
};
pub use excitation_request::{ExcitationRequest, Search, criterion_name, read_excitation_request};
pub use identify_document::*;
pub use identify_request::{IdentifyRequest, NamedExcitations, NoExcitations, read_identify_request};
pub use inspect_document::{InspectDocument, InspectedJoint, InspectedLog};
pub use json::{Malformed, Parsed, parse};
pub use knowledge_request::{DesignModel, DesignTerms, MOST_GIVEN};
pub use model_document::{robot_value, urdf, urdf_gravity};
pub use model_file::{FinalModel, Missing, MissingEffect, ModelFormat, Patched};
pub use motion_document::{
    DrawnCapsule, DrawnJoint, DrawnLink, MotionDocument, MotionRequest, SampledMotion, read_motion_request,
};
pub use residual_document::*;
pub use robot::{NamedRobots, RobotDocument, read_robot, robot_document, robot_document_rounded, robot_file, shapes_of_meshes};
pub use robot::{RobotArchive, is_archive, robot_archive};
pub use robot_report::{ReportedJoint, RobotReport};
pub use trajectory_file::{
    MOST_ROWS, Parts, TrajectoryFile, TrajectoryFormat, trajectory_csv, trajectory_csv_parts, trajectory_json_parts,
};
pub use validate_request::{ModelEffect, ValidateDocument, ValidateRequest, ValidatedLog, read_validate_request};
pub use words::{listed, measured, significant, unit};

/// Every object that requests may have, by its name in the OpenAPI document, with the fields that its reader knows.
pub const KNOWN_FIELDS: &[(&str, &[&str])] = &[
    ("ExcitationRequest", excitation_request::REQUEST_FIELDS),
    ("Fourier", excitation_request::FOURIER_FIELDS),
    ("Constraints", excitation_request::CONSTRAINT_FIELDS),
    ("Search", excitation_request::SEARCH_FIELDS),
    ("IdentificationReference", knowledge_request::REFERENCE_FIELDS),
    ("Rivals", knowledge_request::RIVALS_FIELDS),
    ("EffectPlace", knowledge_request::PLACE_FIELDS),
    ("GivenDesign", knowledge_request::GIVEN_DESIGN_FIELDS),
    ("GivenTrajectory", knowledge_request::GIVEN_TRAJECTORY_FIELDS),
    ("IdentifyRequest", identify_request::IDENTIFY_FIELDS),
    ("MotionRequest", motion_document::MOTION_FIELDS),
    ("Series", motion_document::SERIES_FIELDS),
    ("ValidateRequest", validate_request::VALIDATE_FIELDS),
    ("Model", validate_request::MODEL_FIELDS),
    ("AugmentedModel", augmented_document::AUGMENTED_FIELDS),
    ("AddedEffect", augmented_document::EFFECT_FIELDS),
    ("RivalEffect", augmented_document::RIVAL_FIELDS),
    ("ModelNoise", augmented_document::NOISE_FIELDS),
    ("Preprocess", identify_request::PREPROCESS_FIELDS),
    ("Filter", identify_request::FILTER_FIELDS),
    ("Feasible", identify_request::FEASIBLE_FIELDS),
    ("LinkBounds", bounds_document::BOUND_FIELDS),
    ("JointBounds", bounds_document::JOINT_BOUND_FIELDS),
    ("InertiaBounds", robot::INERTIA_FIELDS),
    ("Columns", columns_document::COLUMNS_FIELDS),
    ("ColumnQuantity", columns_document::QUANTITY_FIELDS),
    ("JointRobot", robot::ROBOT_FIELDS),
    ("UrdfRobot", robot::URDF_FIELDS),
    ("MjcfRobot", robot::MJCF_FIELDS),
    ("Joint", robot::JOINT_FIELDS),
    ("Mdh", robot::MDH_FIELDS),
    ("Dh", robot::DH_FIELDS),
    ("Placement", robot::PLACEMENT_FIELDS),
    ("Limits", robot::LIMIT_FIELDS),
    ("LinkPrior", robot::PRIOR_FIELDS),
    ("Inertia", robot::INERTIA_FIELDS),
];
