"""Entries: a team submits a method to the round that is open, withdraws it, or chooses it.

What was submitted before a round closes counts, by the clock of the server, whenever it is
evaluated.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from sqlalchemy import ColumnElement, Row, Select, and_, func, or_, select, update
from sqlalchemy.orm import Session

from seamark.competitions import keys
from seamark.competitions.document import Carry
from seamark.competitions.document import Round as RoundPlan
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.competitions.teams import TeamView
from seamark.server.database.competition_tables import Entry, Round
from seamark.server.database.tables import Run
from seamark.server.programs import own_files, vehicles
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.record import method_names
from seamark.server.runs.record.states import LIVE, RunKind, RunState, seen_ended
from seamark.server.runs.submission.fixed_settings import with_fixed
from seamark.server.runs.submission.validation import (
    EntryTerms,
    Submission,
    SubmissionRejected,
)
from seamark.server.settings import Settings

FIELD = "competition"  # of forms and requests
METHOD = "method"
NOT_NOW = "No round of this competition accepts submissions now."


@dataclass(frozen=True, slots=True, kw_only=True)
class EntryView:
    """What a team submitted, as its members see it."""

    run_id: int
    round: int  # its number
    method: str
    user_id: int | None  # who submitted it
    state: RunState
    cause: str | None
    submitted_at: float
    chosen: bool
    withdrawn_at: float | None
    refusal: str | None
    score: float | None
    score_low: float | None
    score_high: float | None
    charged: bool  # whether it counts for the quota


def for_competition(
    session: Session, name: str, method: str, sent: Submission, settings: Settings
) -> Submission:
    """Return a submission of the viewer's team to the round that is open.

    The team chooses the program and the settings of a built-in solution.

    Raises
    ------
    SubmissionRejected
        The sender may not submit to it now, or sent something else than it asks for.
    """
    if sent.vehicle is not None:
        raise SubmissionRejected(
            "A competition fixes the vehicle. Leave yours out.", field=vehicles.FIELD
        )
    competition, team = team_in(session, name, sent.viewer.user_id)
    if sent.benchmark != competition.document.benchmark:
        raise SubmissionRejected(
            f"This competition asks for runs of {competition.document.benchmark}, not of "
            f"{sent.benchmark}.",
            field="benchmark",
        )
    one = competition.current
    if one is None:
        raise SubmissionRejected(NOT_NOW, field=FIELD)
    method = _method(method, sent)
    entry = Entry(
        round_id=one.id,
        team_id=team.id,
        user_id=sent.viewer.user_id,
        method=method,
        method_key=method.casefold(),
    )

    def require_allowed(session: Session) -> None:
        _require_open(session, one)
        _enforce_quota(session, competition, one, team, method)

    terms = terms_of(competition, one, team.owner, entry, settings, require=require_allowed)
    vehicle, files = vehicle_of(competition, settings), files_of(competition, settings)
    with own_files.lent(vehicle, files):
        document = competition.document
        config = with_fixed(document.base, document.fixed(), sent.config, by="competition")
    return replace(
        sent,
        kind=RunKind.ENTRY,
        seed=None,
        trials=None,
        config=config,
        vehicle=vehicle,
        files=files,
        title=method,
        entry=terms,
    )


def team_in(session: Session, name: str, user_id: int | None) -> tuple[CompetitionView, TeamView]:
    """Return an open competition and the team of an account in it.

    Raises
    ------
    SubmissionRejected
        There is no such competition or team.
    """
    competition = competitions.find(session, name)
    if competition is None or competition.is_draft:
        raise SubmissionRejected(f"There is no competition {name}.", field=FIELD)
    team = teams.of_user(session, competition.id, user_id)
    if team is None:
        raise SubmissionRejected("You are in no team of this competition.", field=FIELD)
    return competition, team


def terms_of(
    competition: CompetitionView,
    one: RoundView | Round,
    owner: str,
    entry: Entry,
    settings: Settings,
    *,
    require: Callable[[Session], None] = lambda _: None,
    water: str = "",
) -> EntryTerms:
    """Return what a round fixes of a run that is inserted together with its entry.

    Parameters
    ----------
    owner
        Of the run.
    entry
        Complete but for the run and the time.
    require
        Raises SubmissionRejected, in that transaction, if the entry is not allowed.
    water
        By which the seed is derived, if not by the digest of the submission.
    """
    key = keys.round_key(settings.seed_key.encode(), competition.name, one.number)

    def enter(session: Session, run_id: int) -> None:
        require(session)
        entry.run_id, entry.submitted_at = run_id, time.time()
        session.add(entry)
        session.flush()

    return EntryTerms(
        owner=owner,
        trials=competition.document.round(one.number).trials,
        seed_of=lambda submission: keys.seed(key, competition.name, water or submission),
        enter=enter,
    )


def vehicle_of(competition: CompetitionView, settings: Settings) -> StoredVehicle | None:
    """Return the vehicle that the organiser brought; None if it is one of ours."""
    if competition.vehicle_sha256 is None:
        return None
    name = str(competition.document.settings[vehicles.FIELD])
    return vehicles.stored(name, competition.vehicle_sha256, settings)


def files_of(competition: CompetitionView, settings: Settings) -> tuple[StoredFile, ...]:
    """Return the other files of the organiser that settings name."""
    return own_files.stored(competition.files, competition.document.settings, settings)


@contextmanager
def lent(competition: CompetitionView, settings: Settings) -> Iterator[None]:
    """Let what is done meanwhile know the organiser's files; raises as `own_files.lent`."""
    with own_files.lent(vehicle_of(competition, settings), files_of(competition, settings)):
        yield


def fixed(competition: CompetitionView, settings: Settings) -> dict[str, object]:
    """Return setting -> value of the scenario, which nobody who takes part may change."""
    with lent(competition, settings):
        return competition.document.fixed()


def own(session: Session, competition: CompetitionView, team_id: int) -> list[EntryView]:
    """Return what a team submitted, the newest first; its final is not among it."""
    numbers = {one.id: one.number for one in competition.rounds}
    query = _with_run().where(Entry.team_id == team_id, Entry.carried.is_(None))
    query = query.order_by(Entry.run_id.desc())
    return [_view(row, numbers) for row in session.execute(query)]


def left(entries: list[EntryView], one: RoundView) -> int:
    """Return how many submissions a team still has in a round."""
    quota = one.plan.quota if isinstance(one.plan, RoundPlan) else 0
    return quota - sum(entry.charged and entry.round == one.number for entry in entries)


def withdraw(session: Session, competition: CompetitionView, team: TeamView, run_id: int) -> None:
    """Take an entry out of the competition for good; it still counts for the quota.

    Raises
    ------
    CompetitionRefused
        It is not the team's, or the final has begun with it.
    """
    entry = _of_team(session, competition, team, run_id)
    _require_undecided(competition)
    entry.withdrawn_at, entry.chosen = time.time(), False


def choose(
    session: Session, competition: CompetitionView, team: TeamView, run_id: int, *, chosen: bool
) -> None:
    """Choose an entry of the qualification for the final, or no longer.

    Of each method one is chosen: it takes the place of another one.

    Raises
    ------
    CompetitionRefused
        Entries are not chosen in this competition, it is too late, or there are too many.
    """
    final, entry = competition.final, _of_team(session, competition, team, run_id)
    plan = competition.document.final
    if final is None or plan is None or plan.carry is not Carry.CHOSEN:
        raise CompetitionRefused("The best entries go into the final by themselves.")
    _require_undecided(competition)
    if entry.round_id != competition.qualification.id or entry.withdrawn_at is not None:
        raise CompetitionRefused("Choose an entry of the qualification that is not withdrawn.")
    others = and_(
        Entry.team_id == team.id, Entry.round_id == entry.round_id, Entry.run_id != run_id
    )
    if chosen:
        same = update(Entry).where(others, Entry.method_key == entry.method_key)
        session.execute(same.values(chosen=False))
        count = session.scalar(select(func.count()).where(others, Entry.chosen)) or 0
        if count >= plan.finalists:
            methods = "method" if plan.finalists == 1 else "methods"
            raise CompetitionRefused(
                f"A team has {plan.finalists} {methods} in the final. Take another one out first."
            )
    entry.chosen = chosen


def charged() -> ColumnElement[bool]:
    """Return the condition on `Run`: it counts for the quota of its team.

    Failures of the service do not, nor what was cancelled before it started.
    """
    return or_(Run.state.in_(LIVE), seen_ended())


def _enforce_quota(
    session: Session, competition: CompetitionView, one: RoundView, team: TeamView, method: str
) -> None:
    """Raise SubmissionRejected if a team has used up its submissions or its methods."""
    entries = own(session, competition, team.id)
    if left(entries, one) <= 0:
        raise SubmissionRejected(
            f"Your team has used its submissions of round {one.number}. Failures of the service, "
            "and what was cancelled before it started, do not count.",
            field=FIELD,
        )
    known = {entry.method.casefold() for entry in entries} | {method.casefold()}
    if len(known) > competition.document.methods:
        names = ", ".join(sorted({entry.method for entry in entries}))
        raise SubmissionRejected(
            f"A team has {competition.document.methods} methods at most. Yours are {names}.",
            field=METHOD,
        )


def _require_open(session: Session, one: RoundView) -> None:
    """Raise SubmissionRejected if a round has closed meanwhile."""
    closes_at = session.scalar(select(Round.closes_at).where(Round.id == one.id))
    if closes_at is None or closes_at <= time.time():
        raise SubmissionRejected("This round has closed.", field=FIELD)


def _method(method: str, sent: Submission) -> str:
    name = method_names.clean(method)
    program = None if sent.program is None else sent.program.name
    if not name and sent.program is None and not sent.parts:
        name = sent.controller
    if refusal := method_names.refusal(name, program_name=program):
        raise SubmissionRejected(refusal, field=METHOD)
    return name


def _of_team(session: Session, competition: CompetitionView, team: TeamView, run_id: int) -> Entry:
    entry = session.get(Entry, run_id)
    rounds = {one.id for one in competition.rounds}
    if entry is None or entry.team_id != team.id or entry.round_id not in rounds:
        raise CompetitionRefused(f"Run {run_id} is no entry of your team.")
    if entry.carried is not None:
        raise CompetitionRefused("What is in the final stays as it is.")
    return entry


def _require_undecided(competition: CompetitionView) -> None:
    final = competition.final
    begun = competition.ended_at is not None or (final is not None and final.batches > 0)
    if begun or (final is None and competition.qualification.decided_at is not None):
        raise CompetitionRefused("It is too late: the final has begun.")


def _with_run() -> Select[Entry, str, str | None, bool]:
    return select(Entry, Run.state, Run.cause, charged()).join(Run, Run.id == Entry.run_id)


def _view(row: Row[Entry, str, str | None, bool], numbers: dict[int, int]) -> EntryView:
    entry, state, cause, is_charged = row
    same = ("run_id", "method", "user_id", "submitted_at", "chosen", "withdrawn_at", "refusal")
    scores = ("score", "score_low", "score_high")
    return EntryView(
        **{name: getattr(entry, name) for name in (*same, *scores)},
        round=numbers[entry.round_id],
        state=RunState(state),
        cause=cause,
        charged=bool(is_charged),
    )
