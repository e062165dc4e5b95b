"""Leaderboards as JSON and as CSV."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.benchmarks import check
from seamark.server.api.schemas import BenchmarkPath, RankQuery, RanksResponse
from seamark.server.database.engine import Database
from seamark.server.runs import leaderboard
from seamark.server.runs.leaderboard import Cursor, Rank
from seamark.server.web import csv_export
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

COLUMNS = (
    *(
        "rank",
        "rank_low",
        "rank_high",
        "user",
        "controller",
        "run",
        "score",
        "score_low",
        "score_high",
    ),
    *("level_held", "submissions", "reached_at", "is_baseline", "title"),
)
PAGE = 50  # rows of a page by default
CSV_PAGE = 500  # rows that are read at a time

api = APIBlueprint(
    "api_leaderboards",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Leaderboards", description="Public ranked runs, best first.")],
)


@api.get("/leaderboards/<string:benchmark>", responses={200: RanksResponse})
def show(path: BenchmarkPath, query: RankQuery) -> Response:
    """Return the ranks of one benchmark, with their ranges and intervals, as JSON or CSV."""
    check(path.benchmark)
    after = _cursor(query.after)
    if _wants_csv(query):
        lines = _lines(services().database, path.benchmark, after, query.limit)
        answer = Response(lines, content_type=csv_export.MEDIA_TYPE)
    else:
        limit = query.limit or PAGE
        ranks = _page(services().database, path.benchmark, after, limit)
        following = ranks[-1].cursor.text() if len(ranks) == limit else None
        rows = [_row(rank) for rank in ranks]
        answer = jsonify({"benchmark": path.benchmark, "ranks": rows, "next": following})
    answer.headers["Vary"] = "Accept"
    return answer


def _page(database: Database, benchmark: str, after: Cursor | None, limit: int) -> list[Rank]:
    with database.reading() as session:
        return leaderboard.page(session, benchmark, after=after, limit=limit)


def _lines(
    database: Database, benchmark: str, after: Cursor | None, limit: int | None
) -> Iterator[str]:
    """Yield the CSV page by page: no transaction stays open while a slow client reads."""
    yield csv_export.lines(COLUMNS, ())
    while True:
        ranks = _page(database, benchmark, after, limit or CSV_PAGE)
        yield csv_export.lines(COLUMNS, map(_row, ranks), header=False)
        if limit is not None or len(ranks) < CSV_PAGE:
            return
        after = ranks[-1].cursor


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
            "This is not a cursor of the leaderboard.",
            errors={"after": "Send `next` of the previous page unchanged."},
        ) from None


def _row(rank: Rank) -> dict[str, Any]:
    return {
        "rank": rank.rank,
        "rank_low": rank.rank_low,
        "rank_high": rank.rank_high,
        "user": rank.user,
        "controller": rank.program_name or rank.controller,
        "run": rank.run_id,
        "score": rank.score,
        "score_low": rank.low,
        "score_high": rank.high,
        "level_held": rank.level_held,
        "submissions": rank.submissions,
        "reached_at": rank.reached_at,
        "is_baseline": rank.is_baseline,
        "title": rank.title,
    }
