"""Competitions and their rounds as the API answers them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from seamark.competitions.document import Round as RoundPlan
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.web import competition_access


def answer(view: CompetitionView) -> dict[str, Any]:
    """Return the JSON of a competition."""
    team = competition_access.own_team(view)
    return summary(view, own_team=None if team is None else team.name) | {
        "document": view.document.canonical(),
        "digest": view.digest,
        "vehicle_sha256": view.vehicle_sha256,
        "files": dict(view.files),
        "is_organiser": competition_access.is_organiser(view),
    }


def summary(view: CompetitionView, *, own_team: str | None) -> dict[str, Any]:
    """Return the JSON of a competition in a list."""
    document, current = view.document, view.current
    ended = "ended" if view.ended_at is not None else "open"
    return {
        "name": view.name,
        "title": document.title,
        "question": document.question,
        "organiser": view.organiser,
        "benchmark": document.benchmark,
        "zone": document.zone,
        "state": "draft" if view.is_draft else ended,
        "teams": view.teams,
        "own_team": own_team,
        "current": None if current is None else current.number,
        "rounds": [_round(one) for one in view.rounds],
        "created_at": view.created_at,
        "opened_at": view.opened_at,
        "ended_at": view.ended_at,
        "links": _links(view),
    }


def _links(view: CompetitionView) -> dict[str, str]:
    base = f"/api/v1/competitions/{view.name}"
    links = {"self": base, "page": f"/competitions/{view.name}", "check": f"{base}/check"}
    return links | ({"picture": f"{base}/picture"} if view.has_picture else {})


def _round(one: RoundView) -> dict[str, Any]:
    same = (
        *("number", "opens_at", "closes_at", "accepts", "shows_board", "batches"),
        *("commitment", "key", "decided_at"),
    )
    return {name: getattr(one, name) for name in same} | {
        "kind": one.kind.value,
        "trials": one.plan.trials,
        "quota": one.plan.quota if isinstance(one.plan, RoundPlan) else None,
        "moves": [asdict(move) for move in one.moves],
    }
