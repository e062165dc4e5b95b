"""Runs that count in a competition: who may see them, and their scores by the organiser's rules."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.competitions.document import Programs, RoundKind
from seamark.competitions.scores import EntryScore, summary, trial_scores
from seamark.server.database.competition_tables import (
    Competition,
    Entry,
    Round,
    Team,
    TeamMember,
)
from seamark.server.database.tables import Run
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.record.trial_scores import block_of
from seamark.sim.metrics.score_expression import ExpressionInvalid

REFERENCE = "reference entry"  # in place of the name of a team


@dataclass(frozen=True, slots=True, kw_only=True)
class EntryAccess:
    """Where a run counts, and who may see it before everybody may."""

    competition: str  # its name
    title: str
    round: int  # its number; 0: the check of a draft
    kind: RoundKind
    batch: int  # of a final; 0: of another round
    method: str
    team_id: int | None  # None: a reference entry
    team: str
    members: frozenset[int]
    organiser_id: int | None
    organiser_reads: bool  # the programs of teams, by the rules
    sealed: bool  # nobody sees it until the final is decided

    def seen_by(self, user_id: int | None, *, program: bool) -> bool:
        """Return whether an account sees the run, or its program and its log."""
        if user_id is None or self.sealed:
            return False
        if user_id in self.members:
            return True
        return user_id == self.organiser_id and (self.organiser_reads or not program)


def access_of(session: Session, run: Run) -> EntryAccess | None:
    """Return where a run counts; None if it is no entry."""
    if run.kind != RunKind.ENTRY:
        return None
    query = (
        select(Entry, Round, Competition.name, Competition.document, Competition.organiser_id)
        .add_columns(Team.name)
        .join(Round, Round.id == Entry.round_id)
        .join(Competition, Competition.id == Round.competition_id)
        .outerjoin(Team, Team.id == Entry.team_id)
        .where(Entry.run_id == run.id)
    )
    row = session.execute(query).one_or_none()
    if row is None:
        return None
    entry, of, name, document, organiser_id, team = row
    of_team = select(TeamMember.user_id).where(TeamMember.team_id == entry.team_id)
    members = frozenset[int]() if entry.team_id is None else frozenset(session.scalars(of_team))
    return EntryAccess(
        competition=name,
        title=document["title"],
        round=of.number,
        kind=RoundKind(of.kind),
        batch=entry.batch,
        method=entry.method,
        team_id=entry.team_id,
        team=team or REFERENCE,
        members=members,
        organiser_id=organiser_id,
        organiser_reads=entry.team_id is None or document["programs"] != Programs.HIDDEN,
        sealed=of.kind == RoundKind.FINAL and of.decided_at is None,
    )


def record(session: Session, run_id: int, metrics: Mapping[str, Any] | None) -> str | None:
    """Store the score of an entry whose run has succeeded, in the transaction of its result.

    Returns why it has none; None if it has one, and if the run is no entry.
    """
    entry = session.get(Entry, run_id)
    if entry is None or metrics is None:
        return None
    run = session.get_one(Run, run_id)
    scored = score(run.benchmark, run.config, metrics)
    entry.refusal = scored.refusal
    if scored.refusal is None:
        entry.scores = list(scored.scores)
        entry.score, entry.score_low, entry.score_high = scored.score, scored.low, scored.high
        entry.standard_error, entry.degrees = scored.standard_error, scored.degrees
    return scored.refusal


def record_again(session: Session, run_id: int, metrics: Mapping[str, Any] | None) -> None:
    """Give an entry the score of a run that was computed again, unless its round is decided.

    Places of a decided round stay, and so does what its audit shows.
    """
    entry = session.get(Entry, run_id)
    if entry is None or session.get_one(Round, entry.round_id).decided_at is not None:
        return
    for name in ("refusal", "scores", "score", "score_low", "score_high", "standard_error"):
        setattr(entry, name, None)
    record(session, run_id, metrics)


def score(benchmark: str, config: Mapping[str, Any], metrics: Mapping[str, Any]) -> EntryScore:
    """Return the score of an entry: of the organiser's expression, or else of the benchmark.

    The rules that keep what cannot do the task off a leaderboard are made for the scenario of the
    benchmark. In another one they would keep off what can, so the score alone decides.
    """
    trials: Sequence[Mapping[str, Any]] = metrics.get("trials", ())
    try:
        scores = trial_scores(benchmark, config, trials)
    except ExpressionInvalid as error:
        return EntryScore(refusal=f"The score of the competition has no value: {error}")
    if not scores or not all(map(math.isfinite, scores)):
        return EntryScore(refusal="A trial has no finite score.")
    return summary(scores, block_of(benchmark))
