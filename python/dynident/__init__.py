"""Client of a dynident server."""

from .client import Client, Job
from .errors import DynidentError, FieldError
from .model import Model
from .results import (
    BaseParameter,
    Design,
    Effect,
    EffectParameter,
    Identification,
    LogErrors,
    PhysicalParameters,
    Validation,
)

__all__ = [
    "BaseParameter",
    "Client",
    "Design",
    "DynidentError",
    "Effect",
    "EffectParameter",
    "FieldError",
    "Identification",
    "Job",
    "LogErrors",
    "Model",
    "PhysicalParameters",
    "Validation",
]
