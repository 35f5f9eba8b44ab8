"""What a recording of a designed motion would reveal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class AssumedParameter:
    """A shape parameter that a detectable size is stated for."""

    name: str
    value: float
    unit: str


@dataclass(frozen=True)
class DetectableEffect:
    """The smallest size of an effect that a recording reveals."""

    #: Code of the effect, or the name of an own one.
    effect: str
    #: None for an effect of the whole robot.
    joints: list[str]
    parameter: str
    unit: str
    #: None where no size is found; `hidden` says why.
    size: float | None
    #: `absorbed`: base parameters or declared effects imitate it.
    hidden: str | None
    #: Parameters that the formula is not linear in, at the values that the size holds for.
    assumed: list[AssumedParameter]


@dataclass(frozen=True)
class InseparableEffects:
    """An effect that is found, and one that cannot be distinguished from it at that size."""

    effect: str
    joints: list[str]
    parameter: str
    rival: str
    rival_joints: list[str]
    correlation: float
    #: Size of the effect from which on the rival is excluded; None where no size does.
    told_apart_from: float | None
    unit: str


@dataclass(frozen=True)
class Detectable:
    """What a recording of a design would reveal, with the chance `power`; own effects of the robot and of the request are among `effects`."""

    power: float
    false_alarm: float
    periods: float
    torque_noise: list[float]
    noise_source: str
    effects: list[DetectableEffect]
    pairs: list[InseparableEffects]

    def of(self, effect: str, joint: str | None = None) -> list[DetectableEffect]:
        """The sizes of one effect, one per parameter and joint; on a joint if one is given."""
        return [e for e in self.effects if e.effect == effect and (joint is None or joint in e.joints)]


def detectable(d: Mapping[str, Any] | None) -> Detectable | None:
    """From the JSON document; None where there is no trajectory."""
    if d is None:
        return None
    pairs = [InseparableEffects(**{k: p.get(k) for k in InseparableEffects.__dataclass_fields__}) for p in d["pairs"]]
    return Detectable(d["power"], d["false_alarm"], d["periods"], d["torque_noise"], d["noise_source"], [_effect(e) for e in d["effects"]], pairs)


def _effect(e: Mapping[str, Any]) -> DetectableEffect:
    assumed = [AssumedParameter(a["name"], a["value"], a["unit"]) for a in e["assumed"]]
    return DetectableEffect(e["effect"], e["joints"], e["parameter"], e["unit"], e.get("size"), e.get("hidden"), assumed)
