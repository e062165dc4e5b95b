"""What `seamark doctor` has found of one thing."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Check:
    """A result: ok, warning (something works less well) or bad (something does not work)."""

    name: str
    state: str  # "ok", "warning", "bad"
    says: str
    remedy: str = ""
