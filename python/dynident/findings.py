"""What a diagnosis has found: effects, laws, held-out errors, faults of the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class EffectParameter:
    """A parameter with one standard deviation, in SI units; None where the data do not determine it."""

    name: str
    value: float | None
    std_dev: float | None
    unit: str


@dataclass(frozen=True)
class CoveredRange:
    """The range of a variable in the identification logs: the law is known within it only."""

    variable: str
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Law:
    """A formula: of a law that was found, or of an own effect. `q4` and `qd4` are position and speed of the fourth joint."""

    #: What is added to the torque of the first joint of the finding [N·m or N].
    expression: str
    #: The same of every joint that it acts on, by its name.
    torques: dict[str, str]
    #: Whose gradient the torques are [J]; None for friction, and where none is known.
    energy: str | None
    variables: list[str]
    covered: list[CoveredRange]
    #: The torque of every joint, then the energy.
    mathml: list[str]


@dataclass(frozen=True)
class Effect:
    """An effect beside the declared model, estimated together with the base parameters."""

    effect: str
    joints: list[str]
    parameters: list[EffectParameter]
    in_model: bool
    #: Reported as a finding of the diagnosis; false for nuisance offsets and declared effects.
    finding: bool
    declared: bool
    #: Of laws and own effects.
    law: Law | None


@dataclass(frozen=True)
class Rival:
    """Another effect that the data do not exclude in the place of a finding."""

    effect: str
    joints: list[str]
    #: Difference in BIC in favour of the finding; below zero the rival fits better.
    bic_difference: float | None
    law: Law | None


@dataclass(frozen=True)
class HeldOutChange:
    """The model without an effect and with it on held-out data: RMS over its joints [N·m or N]; None where nothing was held out."""

    before: float | None
    after: float | None
    #: `better`, `same`, `worse` (beyond chance) or `not_tested`.
    change: str
    p_value: float | None


@dataclass(frozen=True)
class Finding:
    """An effect that the data show beyond chance."""

    #: Code of the effect, `law` for a formula, or the name of an own effect.
    effect: str
    joints: list[str]
    parameters: list[EffectParameter]
    #: The formula of a law or an own effect, whose constants are in `parameters`.
    law: Law | None
    #: What the diagnosis says of it, in words.
    sentence: str
    in_model: bool
    #: Difference in BIC with the effect, and the probability of the gain by chance.
    bic_difference: float | None
    p_value: float | None
    held_out: HeldOutChange
    rivals: list[Rival]
    #: Whether it is found again where the data are changed, by the change: `first_half`, `every_second_row`, …
    survivals: dict[str, bool]
    note: str | None


@dataclass(frozen=True)
class HeldOutJoint:
    """Errors of single measurements of one joint on held-out data [N·m or N]; `floor` is that of the noise alone."""

    joint: str
    before: float | None
    after: float | None
    floor: float | None
    change: str
    p_value: float | None


@dataclass(frozen=True)
class HeldOut:
    """The declared model and the final one on data that fitted neither."""

    #: `confirmed`, `not_confirmed` or `not_tested`.
    verdict: str
    source: str
    joints: list[HeldOutJoint]


@dataclass(frozen=True)
class DataFault:
    """A fault of the recording, such as a wrong sign of a torque; `parameters` are numbers that put it right."""

    code: str
    joints: list[str]
    detail: str
    remedy: str
    parameters: list[EffectParameter]


@dataclass(frozen=True)
class Residual:
    """The residual diagnosis of a log."""

    #: `nothing_missing`, `explained`, `partly_explained` or `unexplained`.
    verdict: str
    #: The verdict and its scope in sentences.
    summary: str
    #: Those in the model first.
    findings: list[Finding]
    held_out: HeldOut
    data_faults: list[DataFault]
    #: Standard deviation of one torque measurement of every joint [N·m or N]; None for a joint without rows.
    noise_floor: list[float | None]

    def finding(self, effect: str, joint: str | None = None) -> Finding | None:
        """The finding of an effect, on a joint if one is given; None where it was not found."""
        return next((f for f in self.findings if f.effect == effect and (joint is None or joint in f.joints)), None)


def _figure(value: Any) -> float | None:
    """`not_evaluated` stands in the place of figures that were not computed."""
    return float(value) if isinstance(value, (int, float)) else None


def _parameters(list_: Any) -> list[EffectParameter]:
    return [EffectParameter(p["name"], p["value"], p.get("std_dev"), p["unit"]) for p in list_ or []]


def law(d: Mapping[str, Any] | None) -> Law | None:
    """A formula from its JSON document."""
    if d is None:
        return None
    covered = [CoveredRange(c["variable"], c["low"], c["high"], c["unit"]) for c in d.get("covered", [])]
    torques = {t["joint"]: t["expression"] for t in d.get("torques", [])}
    return Law(d["expression"], torques, d.get("energy"), d.get("variables", []), covered, d.get("mathml", []))


def effect(d: Mapping[str, Any]) -> Effect:
    """An effect of a model from its JSON document."""
    parts = (d["effect"], d["joints"], _parameters(d["parameters"]), d["in_model"])
    return Effect(*parts, d.get("finding", False), d.get("declared", False), law(d.get("law")))


def _held_out_change(d: Mapping[str, Any]) -> HeldOutChange:
    return HeldOutChange(_figure(d.get("before")), _figure(d.get("after")), d.get("change", "not_tested"), _figure(d.get("p_value")))


def _finding(d: Mapping[str, Any]) -> Finding:
    evidence = d.get("evidence", {})
    rivals = [Rival(r["effect"], r["joints"], _figure(r.get("evidence")), law(r.get("law"))) for r in d.get("rivals", [])]
    survivals = {s["perturbation"]: s["survives"] for s in d.get("survivals", [])}
    return Finding(
        d["effect"],
        d["joints"],
        _parameters(d["parameters"]),
        law(d.get("law")),
        d.get("sentence", ""),
        d.get("in_model", False),
        _figure(evidence.get("log_evidence_ratio")),
        _figure(evidence.get("p_value")),
        _held_out_change(d.get("held_out", {})),
        rivals,
        survivals,
        d.get("note"),
    )


def _held_out(d: Mapping[str, Any]) -> HeldOut:
    names = HeldOutJoint.__dataclass_fields__
    return HeldOut(d["verdict"], d["source"], [HeldOutJoint(**{name: j.get(name) for name in names}) for j in d["joints"]])


def _fault(d: Mapping[str, Any]) -> DataFault:
    return DataFault(d["code"], d["joints"], d["detail"], d["remedy"], _parameters(d.get("parameters")))


def residual(d: Mapping[str, Any] | None) -> Residual | None:
    """A diagnosis from its JSON document; None where none was asked for."""
    if d is None:
        return None
    findings = [_finding(f) for f in d["findings"]]
    faults = [_fault(f) for f in d["data_faults"]]
    return Residual(d["verdict"], d["summary"], findings, _held_out(d["held_out"]), faults, d["noise_floor"])
