"""An identified model."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from .client import Client

Array = NDArray[np.float64]
_FORMATS = {".json": "json", ".urdf": "urdf", ".xml": "mjcf", ".mjcf": "mjcf", ".sdf": "sdf", ".csv": "csv", ".c": "c", ".py": "python"}


class Model:
    """Bodies and the effects found. Torques in N·m (N of sliding joints) for positions in rad (m)."""

    def __init__(self, client: Client, identification: str) -> None:
        self._client = client
        self._id = identification
        self._module: ModuleType | None = None
        self._json: dict[str, Any] | None = None

    @property
    def document(self) -> dict[str, Any]:
        """The JSON model, as `validate` takes it."""
        if self._json is None:
            document: dict[str, Any] = self._client._json("GET", f"/identify/{self._id}/model?format=json")
            self._json = document
        return self._json

    def text(self, format: str) -> str:
        """The file in a format: json, urdf, mjcf, sdf, csv, c or python."""
        return self._client._send("GET", f"/identify/{self._id}/model?format={format}")[1].decode()

    def save(self, path: str | Path) -> None:
        """Writes the file in the format of the name's ending."""
        path = Path(path)
        format = _FORMATS.get(path.suffix.lower())
        if format is None:
            raise ValueError(f"{path.name}: endings are {', '.join(_FORMATS)}")
        path.write_text(self.text(format))

    def patch_urdf(self, urdf: str | Path, out: str | Path, *, base: str | None = None, tip: str | None = None) -> None:
        """Writes a URDF file of your own with the identified bodies put in, all else as it is."""
        query = "&".join(f"{k}={v}" for k, v in (("base", base), ("tip", tip)) if v)
        address = f"/identify/{self._id}/model" + (f"?{query}" if query else "")
        patched = self._client._send("POST", address, Path(urdf).read_bytes(), "application/xml")[1]
        Path(out).write_bytes(patched)

    def missing_in(self, format: str) -> list[dict[str, Any]]:
        """Effects that a format has no place for, with the torque that is missing along the logs (RMS and largest per joint)."""
        formats = {f["format"]: f for f in self.document.get("formats", [])}
        return list(formats.get(format, {}).get("effects", []))

    def _source(self) -> ModuleType:
        """The model as Python source of the server."""
        if self._module is None:
            module = ModuleType("dynident_model")
            exec(compile(self.text("python"), f"model-{self._id}.py", "exec"), module.__dict__)
            self._module = module
        return self._module

    @property
    def joints(self) -> list[str]:
        return list(self._source().JOINTS)

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Torques for one state (n) or many (N × n)."""
        states = [np.asarray(values, dtype=float) for values in (q, qd, qdd)]
        if len({s.shape for s in states}) != 1:
            raise ValueError("q, qd and qdd have one shape, (n) or (N, n)")
        source = self._source()
        if states[0].ndim == 1:
            return np.array(source.inverse_dynamics(*states))
        rows = [source.inverse_dynamics(*row) for row in zip(*states)]
        return np.array(rows).reshape(states[0].shape)

    def gravity(self, q: ArrayLike) -> Array:
        """Torques that hold the arm still at one position (n) or many (N × n)."""
        q = np.asarray(q, dtype=float)
        still = np.zeros_like(q)
        return self.inverse_dynamics(q, still, still)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """n × n at one position."""
        return np.array(self._source().mass_matrix(np.asarray(q, dtype=float)))
