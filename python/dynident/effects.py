"""Effects with formulas of your own, and the lab's catalogue of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union


@dataclass(frozen=True)
class OwnParameter:
    """A parameter of a formula, in an SI unit without prefix such as `N m/rad`.

    `low` and `high` are needed where the formula is not linear in it; of a coefficient they state what it can be.
    """

    name: str
    unit: str = "1"
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class OwnChannel:
    """A further measured quantity in a formula, such as a temperature; `reference` is its value along motions that have none."""

    name: str
    reference: float
    unit: str = "1"


@dataclass(frozen=True)
class OwnEffect:
    """A torque [N·m, or N of a sliding joint] that is added to one joint.

    In `expression`, `q1`, `qd1`, `qdd1` are position, speed and acceleration of the first joint, `q`, `qd`, `qdd` those of `joint`. Without
    `joint` it is a definition for the catalogue. `declared`: in the model from the start; otherwise the data decide.
    """

    name: str
    expression: str
    parameters: Sequence[OwnParameter]
    joint: str | None = None
    channels: Sequence[OwnChannel] = ()
    declared: bool = False

    def document(self) -> dict[str, Any]:
        """The JSON document of the interface; what is None is left out."""
        given = {"name": self.name, "joint": self.joint, "expression": self.expression, "declared": self.declared}
        lists = {"parameters": [_stated(p) for p in self.parameters], "channels": [_stated(c) for c in self.channels]}
        return {k: v for k, v in given.items() if v is not None} | {k: v for k, v in lists.items() if v or k == "parameters"}


@dataclass(frozen=True)
class UsedEffect:
    """An effect of the catalogue on a joint, under a name or as a part of its own; None: as in the catalogue."""

    use: str
    joint: str | None = None
    name: str | None = None
    declared: bool | None = None

    def document(self) -> dict[str, Any]:
        """The JSON document of the interface; what is None is left out."""
        return _stated(self)


#: What `effects` of requests and robots take: a name of the catalogue, a use of it, a definition, or a JSON document of either.
EffectLike = Union[str, UsedEffect, OwnEffect, Mapping[str, Any]]


@dataclass(frozen=True)
class EffectEntry:
    """An effect of the catalogue, or a definition that was checked."""

    name: str
    definition: OwnEffect
    #: The formula for browsers; None where it cannot be set.
    mathml: str | None


def own_effect(d: Mapping[str, Any]) -> OwnEffect:
    """A definition from its JSON document."""
    parameters = [OwnParameter(p["name"], p["unit"], p.get("low"), p.get("high")) for p in d["parameters"]]
    channels = [OwnChannel(c["name"], c["reference"], c.get("unit", "1")) for c in d.get("channels") or []]
    return OwnEffect(d["name"], d["expression"], parameters, d.get("joint"), channels, bool(d.get("declared")))


def effect_entry(d: Mapping[str, Any]) -> EffectEntry:
    """An entry of the catalogue from its JSON document."""
    return EffectEntry(d["name"], own_effect(d["definition"]), d.get("mathml"))


def effect_document(effect: EffectLike) -> Any:
    """As `effects` of a document has it."""
    if isinstance(effect, (OwnEffect, UsedEffect)):
        return effect.document()
    return effect if isinstance(effect, str) else dict(effect)


def effect_documents(effects: Sequence[EffectLike]) -> list[Any]:
    """All of them; a single one that is no list is refused, because letters of a name are names too."""
    if isinstance(effects, (str, Mapping)):
        raise TypeError("effects is a list")
    return [effect_document(effect) for effect in effects]


def _stated(part: OwnParameter | OwnChannel | UsedEffect) -> dict[str, Any]:
    return {name: value for name, value in vars(part).items() if value is not None}
