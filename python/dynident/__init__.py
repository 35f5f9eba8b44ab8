"""Client of a dynident server."""

from .client import Client, Job
from .errors import DynidentError, FieldError
from .model import Model
from .results import (
    BaseParameter,
    Design,
    Detectable,
    DetectableEffect,
    Effect,
    EffectParameter,
    Identification,
    InseparableEffects,
    KeptRobot,
    LogErrors,
    PhysicalParameters,
    Validation,
)

__all__ = [
    "BaseParameter",
    "Client",
    "Design",
    "Detectable",
    "DetectableEffect",
    "DynidentError",
    "Effect",
    "EffectParameter",
    "FieldError",
    "Identification",
    "InseparableEffects",
    "Job",
    "KeptRobot",
    "LogErrors",
    "Model",
    "PhysicalParameters",
    "Validation",
]
