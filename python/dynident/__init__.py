"""Client of a dynident server."""

from .client import Client, Job
from .detectable import AssumedParameter, Detectable, DetectableEffect, InseparableEffects
from .effects import EffectEntry, EffectLike, OwnChannel, OwnEffect, OwnParameter, UsedEffect
from .errors import DynidentError, FieldError
from .findings import (
    CoveredRange,
    DataFault,
    Effect,
    EffectParameter,
    Finding,
    HeldOut,
    HeldOutChange,
    HeldOutJoint,
    Law,
    Residual,
    Rival,
)
from .model import Model
from .results import BaseParameter, Design, Identification, KeptRobot, LogErrors, PhysicalParameters, Validation

__all__ = [
    "AssumedParameter",
    "BaseParameter",
    "Client",
    "CoveredRange",
    "DataFault",
    "Design",
    "Detectable",
    "DetectableEffect",
    "DynidentError",
    "Effect",
    "EffectEntry",
    "EffectLike",
    "EffectParameter",
    "FieldError",
    "Finding",
    "HeldOut",
    "HeldOutChange",
    "HeldOutJoint",
    "Identification",
    "InseparableEffects",
    "Job",
    "KeptRobot",
    "Law",
    "LogErrors",
    "Model",
    "OwnChannel",
    "OwnEffect",
    "OwnParameter",
    "PhysicalParameters",
    "Residual",
    "Rival",
    "UsedEffect",
    "Validation",
]
