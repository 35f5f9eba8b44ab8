//! Wrong data.
use serde::Serialize;
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DataFault { pub fault: FaultKind }
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind { TorqueSign, JointOrder, UnitMismatch, BadSamples }
pub struct RawLog;
pub fn data_faults(_: &RawLog) -> Vec<DataFault> { Vec::new() }
