"""Logs as files: paths as they are, tables and arrays as NPZ."""

from __future__ import annotations

import io
import json
import os
import uuid
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Union

import numpy as np

#: A path, a pandas table, or arrays by name: `time` (N), `q`, `tau` and perhaps `qd` (N × n).
Log = Union[str, "os.PathLike[str]", Mapping[str, Any], Any]


def as_file(log: Log, number: int) -> tuple[str, bytes]:
    """Name and content of a log."""
    if isinstance(log, (str, os.PathLike)):
        path = Path(log)
        return path.name, path.read_bytes()
    columns: dict[str, Any]
    if isinstance(log, Mapping):
        columns = dict(log)
    elif hasattr(log, "columns") and hasattr(log, "to_numpy"):
        columns = {str(name): log[name].to_numpy() for name in log.columns}
    else:
        raise TypeError("a log is a path, a pandas table, or a dictionary of arrays")
    content = io.BytesIO()
    arrays: dict[str, Any] = {name: np.asarray(values) for name, values in columns.items()}
    np.savez(content, **arrays)
    return f"log{number}.npz", content.getvalue()


def robot_upload(robot: Mapping[str, Any] | str | os.PathLike[str], effects: list[Any] | None = None) -> tuple[str, bytes]:
    """Content type and body of a robot, with own effects where some are given; what a file is, its first bytes say."""
    if isinstance(robot, Mapping):
        document = dict(robot) if effects is None else {**robot, "effects": effects}
        return "application/json", json.dumps(document).encode()
    content = Path(robot).read_bytes()
    # Packed files are unpacked by the server, whatever they hold.
    is_zip, start = content.startswith(b"PK\x03\x04"), content.lstrip(b"\xef\xbb\xbf \t\r\n")[:1]
    if effects is not None:
        if is_zip or start not in (b"{", b"<"):
            raise ValueError(f"{robot}: own effects go with a document, or with a plain JSON, URDF or MJCF file")
        return robot_upload(_as_document(content, start == b"{"), effects)
    kind = "zip" if is_zip else "json" if start == b"{" else "xml"
    return f"application/{kind}", content


def _as_document(content: bytes, is_json: bool) -> dict[str, Any]:
    if is_json:
        document: dict[str, Any] = json.loads(content)
        return document
    text = content.decode("utf-8-sig")
    return {"mjcf" if "<mujoco" in text else "urdf": text}


def many(logs: Any) -> list[Any]:
    """One log or several."""
    if logs is None:
        return []
    single = isinstance(logs, (str, os.PathLike, Mapping)) or hasattr(logs, "columns")
    return [logs] if single else list(logs)


def multipart(parts: Iterable[tuple[str, str | None, bytes]]) -> tuple[str, bytes]:
    """Content type and body of `(name, file name, content)`."""
    boundary = uuid.uuid4().hex
    body = io.BytesIO()
    for name, file, content in parts:
        named = "" if file is None else '; filename="{}"'.format(file.replace('"', "_"))
        body.write(f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"{named}\r\n\r\n'.encode())
        body.write(content)
        body.write(b"\r\n")
    body.write(f"--{boundary}--\r\n".encode())
    return f"multipart/form-data; boundary={boundary}", body.getvalue()
