"""Errors of the server, as it states them (RFC 9457)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class FieldError:
    """One bad field of a request."""

    pointer: str
    detail: str
    hint: str | None


class DynidentError(Exception):
    """The server refused a request, or a job failed."""

    def __init__(self, problem: dict[str, Any], status: int | None = None) -> None:
        self.code: str = problem.get("code", "unknown")
        self.detail: str = problem.get("detail", "")
        self.hint: str | None = problem.get("hint")
        self.status: int | None = problem.get("status", status)
        self.errors: list[FieldError] = [
            FieldError(e.get("pointer", ""), e.get("detail", ""), e.get("hint")) for e in problem.get("errors") or []
        ]
        lines = [f"{self.code}: {self.detail}", *(f"  {e.pointer} {e.detail}" for e in self.errors)]
        if self.hint:
            lines.append(f"  {self.hint}")
        super().__init__("\n".join(lines))
