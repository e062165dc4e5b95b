"""Leaderboards as JSON and as CSV."""

from __future__ import annotations

import csv
import io
from typing import Any

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from server import leaderboard
from server.api.benchmarks import check
from server.api.schemas import BenchmarkPath, RankQuery, RanksAnswer
from server.leaderboard import Cursor, Rank
from server.problems import Problem
from server.services import services

COLUMNS = (
    *("rank", "tied", "user", "controller", "run", "score", "score_low", "score_high"),
    *("level_held", "reached_at", "is_baseline", "title"),
)
PAGE = 50  # rows of an answer that does not say how many
_FORMULA = ("=", "+", "-", "@", "\t")  # a spreadsheet would execute a cell that starts so

api = APIBlueprint(
    "api_leaderboards",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Leaderboards", description="Public ranked runs, best first.")],
)


@api.get("/leaderboards/<string:benchmark>", responses={200: RanksAnswer})
def show(path: BenchmarkPath, query: RankQuery) -> Response:
    """Show the ranks of one benchmark, with intervals and ties; JSON or CSV."""
    check(path.benchmark)
    as_csv, after = _wants_csv(query), _cursor(query.after)
    limit = query.limit or (None if as_csv else PAGE)
    with services().database.reading() as database:
        ranks = leaderboard.page(database, path.benchmark, after=after, limit=limit)
    rows = [_row(rank) for rank in ranks]
    if as_csv:
        answer = Response(_csv(rows), content_type="text/csv; charset=utf-8")
    else:
        following = ranks[-1].cursor.text() if len(ranks) == limit else None
        answer = jsonify({"benchmark": path.benchmark, "ranks": rows, "next": following})
    answer.headers["Vary"] = "Accept"
    return answer


def _wants_csv(query: RankQuery) -> bool:
    if query.format is not None:
        return query.format == "csv"
    return request.accept_mimetypes.best_match(["application/json", "text/csv"]) == "text/csv"


def _cursor(text: str | None) -> Cursor | None:
    if text is None:
        return None
    try:
        return Cursor.parse(text)
    except (ValueError, OverflowError):
        raise Problem(
            "invalid-request",
            "This is not the end of a page.",
            errors={"after": "Send `next` of the page before, unchanged."},
        ) from None


def _row(rank: Rank) -> dict[str, Any]:
    return {
        "rank": rank.rank,
        "tied": rank.tied,
        "user": rank.user,
        "controller": rank.program_name or rank.controller,
        "run": rank.run_id,
        "score": rank.score,
        "score_low": rank.low,
        "score_high": rank.high,
        "level_held": rank.level_held,
        "reached_at": rank.reached_at,
        "is_baseline": rank.is_baseline,
        "title": rank.title,
    }


def _csv(rows: list[dict[str, Any]]) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    table.writerows([_cell(row[name]) for name in COLUMNS] for row in rows)
    return text.getvalue()


def _cell(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value
