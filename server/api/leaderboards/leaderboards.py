"""Leaderboards as JSON and as CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from flask import Response, jsonify, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action
from seamark.server.api.leaderboards.benchmarks import check
from seamark.server.api.leaderboards.leaderboard_schemas import (
    ANSWERED,
    RankQuery,
    RanksResponse,
    csv_columns,
)
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import BenchmarkPath
from seamark.server.database.engine import Database
from seamark.server.runs.leaderboard import leaderboard_filters, reference_entries
from seamark.server.runs.leaderboard.board_rows import Cursor, Rank
from seamark.server.runs.leaderboard.leaderboard_filters import BoardFilter, BoardPage
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.recomputation.verifications import VerificationView
from seamark.server.web import access, csv_export
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry
from seamark.sim.metrics.metric import Metric

Verified = Mapping[int, VerificationView]
PAGE = 50  # rows of a page by default
CSV_PAGE = 500  # rows that are read at a time

api = APIBlueprint(
    "api_leaderboards",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Leaderboards", description="Public ranked runs, best first.")],
)


@api.get("/leaderboards/<string:benchmark>", responses={200: RanksResponse})
def show(path: BenchmarkPath, query: RankQuery) -> Response:
    """Return the ranks of one benchmark, with their ranges and intervals, as JSON or CSV."""
    check(path.benchmark)
    board = _Board(services().database, path.benchmark, _filter(query), _metric(path, query))
    after = _cursor(query)
    if _wants_csv(query):
        answer = Response(board.lines(after, query.limit), content_type=csv_export.MEDIA_TYPE)
    else:
        page = board.page(after, query.limit or PAGE)
        following = None if page.next is None else page.next.text()
        verified = board.verified(page)
        rows = [_row(rank, verified) for rank in page.ranks]
        marks = _reference_entries(path.benchmark)
        listed = {"ranks": rows, "reference_entries": marks, "next": following}
        answer = jsonify({"benchmark": path.benchmark} | listed)
    answer.headers["Vary"] = "Accept"
    return answer


class _Board:
    """The rows that a request is about."""

    def __init__(
        self, database: Database, name: str, board_filter: BoardFilter, metric: Metric | None
    ) -> None:
        self._database, self._name = database, name
        self._filter, self._metric = board_filter, metric

    def page(self, after: Cursor | None, limit: int) -> BoardPage:
        with self._database.reading() as session:
            shown = (session, self._name)
            if self._metric is None:
                return leaderboard_filters.page(*shown, self._filter, after=after, limit=limit)
            ranks = leaderboard_filters.by_metric(*shown, self._metric, self._filter, limit=limit)
            return BoardPage(ranks, None)

    def verified(self, page: BoardPage) -> Verified:
        """Return the newest verifications of the rows of a page."""
        with self._database.reading() as session:
            return verifications.newest(session, [rank.run_id for rank in page.ranks])

    def lines(self, after: Cursor | None, limit: int | None) -> Iterator[str]:
        """Yield the CSV page by page: no transaction stays open while a slow client reads."""
        metrics = [metric.name for metric in registry.benchmark(self._name).board_metrics]
        columns = (*csv_columns(), *metrics)
        yield csv_export.lines(columns, ())
        while True:
            page = self.page(after, limit or CSV_PAGE)
            verified = self.verified(page)
            rows = (_flat(rank, metrics, verified) for rank in page.ranks)
            yield csv_export.lines(columns, rows, header=False)
            after = page.next
            if limit is not None or after is None:
                return


def _filter(query: RankQuery) -> BoardFilter:
    return BoardFilter(
        per=query.per,
        vehicle=query.vehicle,
        tracker=query.tracker,
        language=query.language,
        program=query.program,
        baselines=query.baselines,
        user_id=access.require_account(Action.VIEW_ACCOUNT) if query.mine else None,
    )


def _metric(path: BenchmarkPath, query: RankQuery) -> Metric | None:
    if not query.sort:
        return None
    known = {metric.name: metric for metric in registry.benchmark(path.benchmark).board_metrics}
    if query.sort not in known:
        hint = f"Choose one of {', '.join(known)}, or omit it to sort by score."
        raise Problem("invalid-request", "There is no such metric.", errors={"sort": hint})
    return known[query.sort]


def _wants_csv(query: RankQuery) -> bool:
    if query.format is not None:
        return query.format == "csv"
    return request.accept_mimetypes.best_match(["application/json", "text/csv"]) == "text/csv"


def _cursor(query: RankQuery) -> Cursor | None:
    if query.after is None:
        return None
    try:
        return Cursor.parse(query.after)
    except (ValueError, OverflowError):
        raise Problem(
            "invalid-request",
            "This is not a cursor of the leaderboard.",
            errors={"after": "Send `next` of the previous page unchanged."},
        ) from None


def _row(rank: Rank, verified: Verified) -> dict[str, Any]:
    verification = verified.get(rank.run_id)
    told = {column.answered: column.value(rank) for column in ANSWERED}
    return told | {"verification": None if verification is None else asdict(verification)}


def _reference_entries(name: str) -> list[dict[str, Any]]:
    with services().database.reading() as session:
        entries = reference_entries.entries(session, registry.benchmark(name))
    return [
        {
            "title": entry.title,
            "score": entry.score,
            "score_low": entry.low,
            "score_high": entry.high,
            "is_bound": entry.is_bound,
            "run": entry.run_id,
        }
        for entry in entries
    ]


def _flat(rank: Rank, metrics: Sequence[str], verified: Verified) -> Mapping[str, Any]:
    verification = verified.get(rank.run_id)
    mark = {"verification": None if verification is None else verification.outcome.value}
    return _row(rank, verified) | mark | {name: rank.metrics.get(name) for name in metrics}
