"""Results as dataclasses; `document` of each is the whole answer."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import detectable, findings
from .findings import Effect, Finding, Residual
from .model import Array, Model

if TYPE_CHECKING:
    from .client import Client


@dataclass(frozen=True)
class BaseParameter:
    name: str
    expression: str
    #: None where the log does not determine it.
    value: float | None
    std_dev: float | None
    relative_std_dev_percent: float | None
    unit: str


@dataclass(frozen=True)
class KeptRobot:
    """A robot of the lab, as the server has read it."""

    #: What requests call it.
    id: str
    name: str
    joints: list[str]
    #: What to know about how it was read.
    notes: list[str]
    document: dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class PhysicalParameters:
    """A link: kg, m, kg m² about the centre of mass; friction in N·m s/rad and N·m (N s/m, N)."""

    link: int
    mass: float
    center_of_mass: tuple[float, float, float]
    inertia: dict[str, float]
    viscous: float
    coulomb: float


@dataclass(frozen=True)
class LogErrors:
    """RMS error of a model on a log, per joint [N·m or N]."""

    name: str
    rms: list[float]


@dataclass(frozen=True)
class Design:
    """A designed trajectory."""

    id: str
    status: str
    condition_number: float | None
    fundamental_hz: float
    document: dict[str, Any] = field(repr=False)
    _client: Client = field(repr=False)

    @property
    def period_s(self) -> float:
        return 1.0 / self.fundamental_hz

    @property
    def detectable(self) -> detectable.Detectable | None:
        """What a recording would reveal; None where there is no trajectory."""
        return detectable.detectable(self.document.get("detectable"))

    def samples(
        self,
        *,
        rate_hz: float | None = None,
        periods: int = 1,
        from_pose: Any = None,
        run_in_s: float | None = None,
        run_out_s: float | None = None,
    ) -> dict[str, Array]:
        """`time` (N) and `q`, `qd`, `qdd` (N × n); with a pose, the ways into the motion and out of it, within all limits."""
        table = self._client._json("GET", self._address("json", rate_hz, periods, from_pose, run_in_s, run_out_s))
        rows = np.array(table["rows"])
        n = (rows.shape[1] - 1) // 3
        return {"time": rows[:, 0], "q": rows[:, 1 : 1 + n], "qd": rows[:, 1 + n : 1 + 2 * n], "qdd": rows[:, 1 + 2 * n :]}

    def save(self, path: str, format: str, *, rate_hz: float | None = None, periods: int = 1, from_pose: Any = None) -> None:
        """Writes the trajectory: csv, json, joint_trajectory, yaml, urscript, mcap or npz."""
        content = self._client._send("GET", self._address(format, rate_hz, periods, from_pose, None, None))[1]
        with open(path, "wb") as file:
            file.write(content)

    def _address(self, format: str, rate_hz: Any, periods: int, pose: Any, run_in_s: Any, run_out_s: Any) -> str:
        query = {"format": format, "periods": periods, "rate_hz": rate_hz, "run_in_s": run_in_s, "run_out_s": run_out_s}
        if pose is not None:
            query["from"] = ",".join(repr(float(q)) for q in pose)
        stated = "&".join(f"{name}={value}" for name, value in query.items() if value is not None)
        return f"/excitation/{self.id}/trajectory?{stated}"


@dataclass(frozen=True)
class Identification:
    """The model that was found."""

    id: str
    joints: list[str]
    verdict: str
    base_parameters: list[BaseParameter]
    #: None where none were asked for, or none make a robot.
    physical_parameters: list[PhysicalParameters] | None
    #: Listed, own and declared effects, and laws, estimated together with the base parameters.
    effects: list[Effect]
    validation: list[LogErrors]
    #: The diagnosis of the residual, with all findings; None where none was asked for.
    residual: Residual | None
    model: Model
    document: dict[str, Any] = field(repr=False)

    @property
    def residual_verdict(self) -> str | None:
        """`nothing_missing`, `explained`, `partly_explained` or `unexplained`; None without a diagnosis."""
        return self.residual.verdict if self.residual else None

    @property
    def findings(self) -> list[Finding]:
        """Effects that the data show beyond chance, those in the model first; empty without a diagnosis."""
        return self.residual.findings if self.residual else []


@dataclass(frozen=True)
class Validation:
    """How well a model predicts logs."""

    id: str
    logs: list[LogErrors]
    #: What has changed since the model was made; None where no diagnosis was asked for.
    residual: Residual | None
    document: dict[str, Any] = field(repr=False)

    @property
    def findings(self) -> list[Finding]:
        """Changes that the data show beyond chance; empty without a diagnosis."""
        return self.residual.findings if self.residual else []


def kept_robot(d: dict[str, Any]) -> KeptRobot:
    return KeptRobot(d["id"], d["name"], d["joints"], d["notes"], d)


def design(client: Client, d: dict[str, Any]) -> Design:
    return Design(d["id"], d["status"], d.get("condition_number"), d["fundamental_hz"], d, client)


def identification(client: Client, d: dict[str, Any]) -> Identification:
    base = [
        BaseParameter(p["name"], p["expression"], p["value"], p["std_dev"], p["relative_std_dev_percent"], p["unit"])
        for p in d["base_parameters"]
    ]
    links = d.get("physical_parameters")
    physical = links and [
        PhysicalParameters(p["link"], p["mass"], tuple(p["center_of_mass"]), p["inertia"], p["viscous"] or 0.0, p["coulomb"] or 0.0)
        for p in links
    ]
    effects = [findings.effect(e) for e in d.get("effects") or []]
    validation = [LogErrors(v["name"], (v.get("physical") or v["base"])["rms"]) for v in d["rms"]["validation"]]
    return Identification(
        d["id"],
        d["joints"],
        d["quality"]["verdict"],
        base,
        physical or None,
        effects,
        validation,
        findings.residual(d.get("residual")),
        Model(client, d["id"]),
        d,
    )


def validation(d: dict[str, Any]) -> Validation:
    logs = [LogErrors(log["name"], log["rms"]) for log in d["logs"]]
    return Validation(d["id"], logs, findings.residual(d.get("residual")), d)
