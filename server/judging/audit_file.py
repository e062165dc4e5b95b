"""The audit document of a competition: all that anybody needs to check how it was decided.

Of a round that is not decided it has the commitment alone. Teams show their programs only by the
rules; their digests are there all the same.
"""

from collections.abc import Iterator
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from seamark.competitions import audit_document
from seamark.competitions.audit_document import Audit, Decision
from seamark.competitions.document import Final, Programs
from seamark.competitions.standings import Placing
from seamark.server.competitions import teams
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.database.competition_tables import Entry
from seamark.server.database.tables import Result, Run
from seamark.server.judging import boards, finals
from seamark.server.judging import entries as organisers
from seamark.server.programs import vehicles
from seamark.server.runs.record import run_parts, seeds
from seamark.server.runs.record.trial_scores import block_of
from seamark.server.settings import Settings


def audit_of(session: Session, competition: CompetitionView, settings: Settings) -> dict[str, Any]:
    """Return the audit document of a competition, as JSON values."""
    rounds = [_round(competition, one) for one in competition.rounds]
    decided = [one for one in competition.rounds if one.decided_at is not None]
    entries = [entry for one in decided for entry in _entries(session, competition, one)]
    final = competition.final
    has_ended = final is not None and final.decided_at is not None
    return audit_document.as_document(
        Audit(
            competition=competition.name,
            title=competition.document.title,
            benchmark=competition.document.benchmark,
            frozen=competition.document.canonical(),
            frozen_sha256=competition.digest,
            files=_files(competition, settings) if decided else {},
            rounds=rounds,
            entries=entries,
            standings=_decision(session, competition) if has_ended else None,
            board=_board(session, competition),
        )
    )


def _files(competition: CompetitionView, settings: Settings) -> dict[str, str]:
    """Return setting -> text of the organiser's own files, without which nothing runs again."""
    found = {one.setting: one.content for one in organisers.files_of(competition, settings)}
    vehicle = organisers.vehicle_of(competition, settings)
    if vehicle is not None:
        found[vehicles.FIELD] = vehicle.content
    return {setting: content.decode("utf-8") for setting, content in found.items()}


def _round(competition: CompetitionView, one: RoundView) -> audit_document.Round:
    document = competition.document
    return audit_document.Round(
        number=one.number,
        kind=one.kind,
        opens_at=one.opens_at,
        closes_at=one.closes_at,
        commitment=one.commitment,
        key=one.key,
        trials=one.plan.trials,
        block=block_of(document.benchmark),
        looks=one.plan.batches if isinstance(one.plan, Final) else 1,
        ties=document.ties,
        moves=[
            audit_document.Move(
                at=each.at, before=each.before, after=each.after, reason=each.reason
            )
            for each in one.moves
        ],
    )


def _entries(
    session: Session, competition: CompetitionView, one: RoundView
) -> Iterator[audit_document.Entry]:
    query = (
        select(Entry, Run, Result.digest)
        .options(undefer(Entry.scores))
        .join(Run, Run.id == Entry.run_id)
        .outerjoin(Result, Result.run_id == Entry.run_id)
        .where(Entry.round_id == one.id, Entry.withdrawn_at.is_(None))
        .order_by(Entry.run_id)
    )
    rows = session.execute(query).all()
    run_parts.load(session, (row[1] for row in rows))
    names = teams.names(session, competition.id)
    all_shown = competition.document.programs is Programs.PUBLIC
    for entry, run, digest in rows:
        values = seeds.submitted(run)
        yield audit_document.Entry(
            round=one.number,
            key=entry.carried or entry.run_id,
            batch=entry.batch or None,
            team=None if entry.team_id is None else names[entry.team_id],
            method=entry.method,
            submitted_at=entry.submitted_at,
            submission=seeds.submission_digest(run),
            submitted=values if all_shown or entry.team_id is None else None,
            run=run.id,
            seed=run.seed or 0,
            scores=entry.scores,
            score=entry.score,
            digest=digest,
        )


def _decision(session: Session, competition: CompetitionView) -> Decision | None:
    table = finals.standings_of(session, competition)
    if table is None or competition.final is None:
        return None
    return Decision(
        batches=competition.final.batches, separated=table.separated, placings=table.placings
    )


def _board(session: Session, competition: CompetitionView) -> list[Placing] | None:
    """Return the places of a competition that was decided without a final."""
    if competition.final is not None or competition.ended_at is None:
        return None
    board = boards.board(session, competition, competition.deciding, by_method=True)
    return [
        Placing(
            key=row.run_id,
            place=row.place,
            place_low=row.place_low,
            place_high=row.place_high,
            score=row.score,
            score_low=row.low,
            score_high=row.high,
        )
        for row in board.rows
    ]
