//! JSON documents of every interface: requests in, answers out. Service, command line, pages and report read the same types.
//!
//! Reading collects everything that is wrong with a document ([`Findings`]) before it gives up, so that one round of corrections
//! is enough: the reader's own findings (unknown fields, wrong types) and the core's (limits the wrong way round, too many
//! harmonics) end in one list, each with a JSON pointer, what is wrong, and the remedy.

mod augmented;
mod base_parameters;
mod bounds;
mod columns;
mod cursor;
mod design;
mod effect_list;
mod excitation_request;
mod final_model;
mod identification;
mod identify_request;
mod inspection;
mod knowledge;
mod motion;
mod own_effects;
mod path_limits;
pub mod requests;
mod residual;
mod residual_reading;
mod robot;
mod robot_report;
pub mod shipped;
mod used_effects;
mod validation;
mod warm_start;

pub use augmented::{ReadModel, augmented_value, read_augmented, written_diagnosis};
pub use base_parameters::{BaseParameterDocument, BaseParametersDocument};
pub use cursor::{Cursor, Fields, Findings};
pub use design::{
    Assessed, AssumedParameterDocument, Coefficients, CriteriaDocument, DesignDocument, DetectableDocument,
    DetectableEffectDocument, EffectDocument, FirstRunDocument, FurtherDocument, InseparableDocument, MarginDocument,
    PredictedDocument, SearchDocument, StartDocument,
};
pub use effect_list::effects_named;
pub use excitation_request::{ExcitationRequest, Search, criterion_name, read_excitation_request};
pub use identification::*;
pub use identify_request::{IdentifyRequest, NamedExcitations, NoExcitations, read_identify_request};
pub use inspection::{InspectDocument, InspectedJoint, InspectedLog};
pub use knowledge::{DesignModel, DesignTerms, MOST_GIVEN};
pub use motion::{DrawnCapsule, DrawnJoint, DrawnLink, MotionDocument, MotionRequest, SampledMotion, read_motion_request};
pub use own_effects::catalogue_effect;
pub use residual::*;
pub use robot::{
    NamedRobots, RobotDocument, read_robot, robot_document, robot_document_of, robot_document_rounded, robot_value, written_robot,
};
pub use robot_report::{ReportedJoint, RobotReport};
pub use validation::{ModelEffect, ValidateDocument, ValidateRequest, ValidatedLog, read_validate_request};
