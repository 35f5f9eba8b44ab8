"""The client itself: requests by the standard library, jobs that are waited for."""

from __future__ import annotations

import json
import os
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Generic, TypeVar, Union

from . import effects as own
from . import results
from .effects import EffectEntry, EffectLike, OwnEffect
from .errors import DynidentError
from .model import Model
from .results import Design, Identification, KeptRobot, Validation
from .uploads import Log, as_file, many, multipart, robot_upload

T = TypeVar("T")
Robot = Union[str, dict[str, Any]]
#: Seconds that one request waits for the result of a job.
_WAIT = 20


class Job(Generic[T]):
    """Work of the server."""

    def __init__(self, client: Client, id: str, address: str, read: Callable[[dict[str, Any]], T]) -> None:
        self.id = id
        self._client = client
        self._address = address
        self._read = read

    def state(self) -> str:
        """`queued`, `running`, `done`, `failed` or `cancelled`, as the server calls it."""
        return str(self._client._json("GET", f"/jobs/{self.id}")["state"])

    def cancel(self) -> None:
        """Ends it; of a search the best found is kept."""
        self._client._send("DELETE", f"/jobs/{self.id}")

    def result(self, timeout_s: float | None = None) -> T:
        """Waits for the result.

        Raises `DynidentError` for a job that failed, `TimeoutError` after `timeout_s`.
        """
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            left = _WAIT if end is None else max(0, min(_WAIT, int(end - time.monotonic())))
            status, content = self._client._send("GET", self._address, headers={"Prefer": f"wait={left}"})
            if status == 200:
                return self._read(json.loads(content))
            if end is not None and time.monotonic() >= end:
                raise TimeoutError(f"job {self.id} goes on")


class Client:
    """A dynident server."""

    def __init__(self, url: str = "http://127.0.0.1:8080", *, token: str | None = None, timeout_s: float = 60.0) -> None:
        self._url = url.rstrip("/")
        self._token = token
        self._timeout_s = timeout_s

    def robots(self) -> list[str]:
        """Names of the robots that the server knows."""
        return [robot["id"] for robot in self._json("GET", "/robots")["robots"]]

    def base_parameters(self, robot: str) -> dict[str, Any]:
        """Names, expressions and numeric map of the base parameters of a known robot."""
        document: dict[str, Any] = self._json("GET", f"/robots/{robot}/base-parameters")
        return document

    def add_robot(
        self,
        robot: dict[str, Any] | str | os.PathLike[str],
        *,
        id: str | None = None,
        tip: str | None = None,
        base: str | None = None,
        effects: Sequence[EffectLike] | None = None,
    ) -> KeptRobot:
        """Keeps a robot of the lab: a document, or the path of a JSON, URDF or MJCF file or of a ZIP archive of a URDF file with its meshes.

        With `id` it takes the place of the robot that had this name. `tip` and `base` are the ends of the arm in a URDF or MJCF file that has more.
        `effects` are own effects that every identification of the robot has, in the place of those of the document; not for archives.
        """
        kind, body = robot_upload(robot, None if effects is None else own.effect_documents(effects))
        ends = {name: link for name, link in (("tip", tip), ("base", base)) if link is not None}
        query = f"?{urllib.parse.urlencode(ends)}" if ends else ""
        method, path = ("POST", "/robots") if id is None else ("PUT", f"/robots/{urllib.parse.quote(id, safe='')}")
        return results.kept_robot(json.loads(self._send(method, path + query, body, kind)[1]))

    def effects(self) -> list[EffectEntry]:
        """Own effects of the lab's catalogue, in the order of their names."""
        return [own.effect_entry(e) for e in self._json("GET", "/effects")["effects"]]

    def get_effect(self, name: str) -> OwnEffect:
        """The definition of an effect of the catalogue."""
        return own.own_effect(self._json("GET", _effect_path(name)))

    def save_effect(self, effect: OwnEffect | Mapping[str, Any]) -> EffectEntry:
        """Keeps a definition in the catalogue, in the place of the one that had its name; needs the role admin where there are tokens.

        Jobs that were submitted before keep the definition as it was.
        """
        document = own.effect_document(effect)
        return own.effect_entry(self._post("PUT", _effect_path(document.get("name", "")), document))

    def delete_effect(self, name: str) -> None:
        """Removes an effect from the catalogue; one that a robot of the lab names is refused (`effect_in_use`)."""
        self._send("DELETE", _effect_path(name))

    def preview_effect(self, effect: OwnEffect | Mapping[str, Any]) -> EffectEntry:
        """Checks a definition without keeping it; every bad field is in the `errors` of the exception."""
        return own.effect_entry(self._post("POST", "/effect-preview", own.effect_document(effect)))

    def start_excite(
        self,
        robot: Robot,
        *,
        order: int = 5,
        fundamental_hz: float = 0.1,
        sample_rate_hz: float = 100.0,
        criterion: str = "condition_number",
        constraints: dict[str, Any] | None = None,
        time_limit_s: float = 60.0,
        seed: int = 1,
        effects: Sequence[EffectLike] | None = None,
        **more: Any,
    ) -> Job[Design]:
        """Starts the design of a trajectory; `effects` are own effects whose detectable sizes are stated, `more` further fields of `POST /excitation`."""
        request: dict[str, Any] = {
            "robot": robot,
            "fourier": {"order": order, "fundamental_hz": fundamental_hz},
            "sample_rate_hz": sample_rate_hz,
            "criterion": criterion,
            "constraints": constraints or {"form": "exact", "start": "zero"},
            "search": {"seed": seed, "time_limit_s": time_limit_s},
            **more,
        }
        if effects is not None:
            request["effects"] = own.effect_documents(effects)
        body = json.dumps(request).encode()
        return self._start("/excitation", body, "application/json", lambda d: results.design(self, d))

    def excite(self, robot: Robot, **options: Any) -> Design:
        """Designs a trajectory and waits for it; options as for `start_excite`."""
        return self.start_excite(robot, **options).result()

    def start_identify(
        self,
        robot: Robot,
        logs: Log | list[Log],
        *,
        validation: Log | list[Log] | None = None,
        sample_rate_hz: float | None = None,
        period_s: float | None = None,
        columns: dict[str, Any] | None = None,
        effects: Sequence[EffectLike] | None = None,
        **more: Any,
    ) -> Job[Identification]:
        """Starts an identification.

        `sample_rate_hz` is for logs without time. `effects` are own effects: names of the catalogue, uses of it, or definitions. `more` are further
        fields of `POST /identify`.
        """
        request: dict[str, Any] = {"robot": robot, **more}
        if effects is not None:
            request["effects"] = own.effect_documents(effects)
        columns = dict(columns or {})
        if sample_rate_hz is not None:
            columns["sample_rate_hz"] = sample_rate_hz
        if columns:
            request["columns"] = columns
        if period_s is not None:
            request["period_s"] = period_s
        parts = self._parts(request, log=logs, validation=validation)
        return self._start("/identify", parts[1], parts[0], lambda d: results.identification(self, d))

    def identify(self, robot: Robot, logs: Log | list[Log], **options: Any) -> Identification:
        """Identifies a robot from logs and waits for the result; options as for `start_identify`."""
        return self.start_identify(robot, logs, **options).result()

    def identification(self, id: str) -> Identification:
        """The result of an earlier identification."""
        return results.identification(self, self._json("GET", f"/identify/{id}"))

    def validate(self, model: Model | dict[str, Any], logs: Log | list[Log], **more: Any) -> Validation:
        """Holds a model against logs; `more` are further fields of `POST /validate`."""
        document = model.document if isinstance(model, Model) else model
        kind, body = self._parts({"model": document, **more}, log=logs)
        return self._start("/validate", body, kind, results.validation).result()

    def _parts(self, request: dict[str, Any], **logs: Any) -> tuple[str, bytes]:
        parts: list[tuple[str, str | None, bytes]] = [("request", None, json.dumps(request).encode())]
        for name, some in logs.items():
            parts += [(name, *as_file(log, number)) for number, log in enumerate(many(some), 1)]
        return multipart(parts)

    def _start(self, path: str, body: bytes, kind: str, read: Callable[[dict[str, Any]], T]) -> Job[T]:
        job = json.loads(self._send("POST", path, body, kind)[1])
        return Job(self, job["id"], f"{path}/{job['id']}", read)

    def _json(self, method: str, path: str) -> Any:
        return json.loads(self._send(method, path)[1])

    def _post(self, method: str, path: str, document: Any) -> Any:
        return json.loads(self._send(method, path, json.dumps(document).encode(), "application/json")[1])

    def _send(
        self,
        method: str,
        path: str,
        body: bytes | None = None,
        kind: str | None = None,
        headers: dict[str, str] | None = None,
    ) -> tuple[int, bytes]:
        sent = dict(headers or {})
        if kind:
            sent["Content-Type"] = kind
        if self._token:
            sent["Authorization"] = f"Bearer {self._token}"
        request = urllib.request.Request(self._url + path, data=body, method=method, headers=sent)
        try:
            with urllib.request.urlopen(request, timeout=self._timeout_s) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            content = error.read()
            try:
                problem = json.loads(content)
            except ValueError:
                problem = {"code": "unknown", "detail": content.decode(errors="replace")[:500]}
            raise DynidentError(problem, error.code) from None


def _effect_path(name: str) -> str:
    # Without a name this would be the address of the whole catalogue.
    if not name:
        raise ValueError("the effect has no name")
    return f"/effects/{urllib.parse.quote(name, safe='')}"
