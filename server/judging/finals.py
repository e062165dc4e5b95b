"""Deciding rounds: when nothing of a round is left to evaluate, its key is revealed; a final adds
batches of trials until its ranks separate or its budget is spent.

Maintenance calls `advance` again and again; each step is one transaction, so that nothing is lost
or done twice when a process dies in between.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import structlog
from sqlalchemy import func, select, update
from sqlalchemy.orm import Session, undefer

from seamark.competitions import keys, standings
from seamark.competitions.document import Carry, Final, Programs, RoundKind
from seamark.competitions.scores import EntryScore, summary
from seamark.competitions.standings import Finalist, Placing, Standings, Ties
from seamark.programs.failure_reasons import FailureReason
from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import CHECK, CompetitionView, RoundView
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import Competition, Entry, FinalPlace, Round
from seamark.server.database.tables import Run
from seamark.server.judging import boards
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record import copies, turns
from seamark.server.runs.record.states import LIVE, RunState
from seamark.server.runs.record.trial_scores import block_of
from seamark.server.settings import Settings

OWNER = "competition:"  # start of the owner of the runs that the service makes for one
ATTEMPTS_MAX = 5  # evaluations of an entry in a batch that failed because of the service
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True, kw_only=True)
class Decided:
    """How an entry came out: its first run in the round, and what all of its trials say."""

    entry: Entry
    result: EntryScore


def owner_of(competition_id: int) -> str:
    """Return the owner of the runs that the service makes for a competition."""
    return f"{OWNER}{competition_id}"


def undecided(session: Session) -> list[int]:
    """Return the open competitions in which a round may have to be decided."""
    due = (
        select(Round.competition_id)
        .join(Competition, Competition.id == Round.competition_id)
        .where(Competition.opened_at.is_not(None), Competition.ended_at.is_(None))
        .where(
            Round.decided_at.is_(None),
            func.coalesce(Round.closes_at, Round.opens_at) <= time.time(),
        )
    )
    return sorted(set(session.scalars(due)))


def advance(session: Session, competition_id: int, settings: Settings) -> int:
    """Do what is due in a competition; return the number of runs that were queued."""
    acquire(session, AdvisoryLock.COMPETITIONS)
    competition = competitions.get(session, competition_id)
    if competition.ended_at is not None:
        return 0
    for one in competition.rounds:
        if one.decided_at is not None:
            continue
        if one.kind is RoundKind.FINAL:
            return _advance_final(session, competition, one, settings) if one.has_opened else 0
        if not one.has_closed or _is_live(session, one):
            return 0
        _decide(session, competition, one, settings)
    return 0


def standings_of(session: Session, competition: CompetitionView) -> Standings | None:
    """Return the standings after the batches so far; None without a final that has begun."""
    one, plan = competition.final, competition.document.final
    if one is None or plan is None or not one.batches:
        return None
    return _table(competition, plan, _results(session, competition, one))


def _advance_final(
    session: Session, competition: CompetitionView, one: RoundView, settings: Settings
) -> int:
    plan = competition.document.final
    if plan is None:
        raise RuntimeError(f"{competition.name} has no final")
    if _is_live(session, one):
        return 0
    if queued := _repeat_broken(session, competition, one, settings):
        return queued
    if one.batches:
        decided = _results(session, competition, one)
        table = _table(competition, plan, decided)
        if table.separated or one.batches >= plan.batches:
            _store_places(session, competition, one, decided, table)
            _decide(session, competition, one, settings)
            return 0
        carried = [each.entry.carried or 0 for each in decided if each.result.refusal is None]
    else:
        carried = _carried(session, competition, plan)
        if not any(session.get_one(Entry, run_id).team_id for run_id in carried):
            _decide(session, competition, one, settings)  # nobody has qualified
            return 0
    batch = one.batches + 1
    session.execute(update(Round).where(Round.id == one.id).values(batches=batch))
    for run_id in carried:
        _enqueue(session, competition, one, run_id, batch, settings)
    turns.refresh(session, owner_of(competition.id))
    _log.info("final_batch", competition=competition.name, batch=batch, runs=len(carried))
    return len(carried)


def _carried(session: Session, competition: CompetitionView, plan: Final) -> list[int]:
    """Return the runs whose entries are carried into the final, with the reference entries."""
    best = (
        select(Entry)
        .where(Entry.round_id == competition.qualification.id, Entry.team_id.is_not(None))
        .where(Entry.score.is_not(None), Entry.withdrawn_at.is_(None))
        .order_by(Entry.team_id, Entry.score.desc(), Entry.submitted_at, Entry.run_id)
    )
    carried: list[int] = []
    for _, of_team in groupby(session.scalars(best), key=lambda entry: entry.team_id):
        carried += [entry.run_id for entry in _of_team(list(of_team), plan)]
    references = (
        select(Entry.run_id)
        .join(Round, Round.id == Entry.round_id)
        .where(Round.competition_id == competition.id, Round.number == CHECK)
        .where(Entry.score.is_not(None))
        .order_by(Entry.run_id)
    )
    return [*carried, *session.scalars(references)]


def _of_team(best_first: Sequence[Entry], plan: Final) -> list[Entry]:
    """Return the entries of one team: those it has chosen, or the best of its best methods."""
    chosen = [entry for entry in best_first if entry.chosen]
    if plan.carry is Carry.CHOSEN and chosen:
        return chosen[: plan.finalists]
    first = dict[str, Entry]()
    for entry in best_first:
        first.setdefault(entry.method_key, entry)
    return list(first.values())[: plan.finalists]


def _enqueue(
    session: Session,
    competition: CompetitionView,
    one: RoundView,
    carried: int,
    batch: int,
    settings: Settings,
) -> None:
    """Queue the evaluation of an entry on the trials of a batch."""
    load = [undefer(Run.program_parameters)]
    original, entry = session.get_one(Run, carried, options=load), session.get_one(Entry, carried)
    trials, label = one.plan.trials, keys.final_label(batch)
    key = keys.round_key(settings.seed_key.encode(), competition.name, one.number)
    run = copies.copy_of(
        *(original, owner_of(competition.id)),
        trials=trials,
        seed=keys.seed(key, competition.name, label),
        submission=label,
        title=entry.method,
        data_bytes=max(original.data_bytes // original.trials, 1) * trials,
    )
    if run.expected_s is not None:
        run.expected_s *= trials / original.trials
    session.add(run)
    session.flush()
    session.add(
        Entry(
            run_id=run.id,
            round_id=one.id,
            team_id=entry.team_id,
            user_id=entry.user_id,
            method=entry.method,
            method_key=entry.method_key,
            reference=entry.reference,
            carried=carried,
            batch=batch,
            submitted_at=entry.submitted_at,
        )
    )
    session.flush()


def _is_live(session: Session, one: RoundView) -> bool:
    query = select(Entry.run_id).join(Run, Run.id == Entry.run_id)
    live = query.where(Entry.round_id == one.id, Run.state.in_(LIVE))
    return session.scalar(live.limit(1)) is not None


def _broken(session: Session, one: RoundView) -> list[Entry]:
    """Return the entries of the last batch whose runs say nothing: the service failed."""
    query = (
        select(Entry)
        .join(Run, Run.id == Entry.run_id)
        .where(Entry.round_id == one.id, Entry.batch == one.batches, Entry.withdrawn_at.is_(None))
        .where((Run.state == RunState.CANCELLED) | (Run.cause == FailureReason.PLATFORM_ERROR))
        .where(Entry.refusal.is_(None))
    )
    return list(session.scalars(query))


def _repeat_broken(
    session: Session, competition: CompetitionView, one: RoundView, settings: Settings
) -> int:
    """Evaluate what broke once more, on the same trials; what breaks too often has failed."""
    count = 0
    for entry in _broken(session, one):
        same = (Entry.round_id == one.id, Entry.batch == entry.batch)
        tries = select(func.count()).where(*same, Entry.carried == entry.carried)
        if (session.scalar(tries) or 0) < ATTEMPTS_MAX:
            entry.withdrawn_at = time.time()
            _enqueue(session, competition, one, entry.carried or 0, entry.batch, settings)
            count += 1
        else:
            entry.refusal = "The service could not evaluate it."
            _log.error("final_entry_broken", competition=competition.name, run=entry.run_id)
    if count:
        turns.refresh(session, owner_of(competition.id))
    return count


def _results(session: Session, competition: CompetitionView, one: RoundView) -> list[Decided]:
    """Return what the trials of all batches together say of each entry."""
    query = (
        select(Entry)
        .options(undefer(Entry.scores))
        .where(Entry.round_id == one.id, Entry.withdrawn_at.is_(None))
        .order_by(Entry.carried, Entry.batch)
    )
    decided: list[Decided] = []
    for _, rows in groupby(session.scalars(query), key=lambda entry: entry.carried):
        batches = list(rows)
        decided.append(Decided(entry=batches[0], result=_joined(session, competition, batches)))
    return decided


def _joined(session: Session, competition: CompetitionView, batches: Sequence[Entry]) -> EntryScore:
    failed = next((entry for entry in batches if entry.score is None), None)
    if failed is not None:
        return EntryScore(refusal=failed.refusal or _why_failed(session, failed))
    scores = [score for entry in batches for score in entry.scores or ()]
    return summary(scores, block_of(competition.document.benchmark))


def _why_failed(session: Session, entry: Entry) -> str:
    detail = session.get_one(Run, entry.run_id).detail
    return str(detail.get("title") or detail.get("sentence") or "The program failed.")


def _table(competition: CompetitionView, plan: Final, decided: Sequence[Decided]) -> Standings:
    """Return the places of the teams' entries; reference entries are marks without a place."""
    finalists = [
        Finalist(
            key=each.entry.carried or 0,
            submitted_at=each.entry.submitted_at,
            scores=each.result.scores if each.result.refusal is None else None,
        )
        for each in decided
        if each.entry.team_id is not None
    ]
    block = block_of(competition.document.benchmark)
    return standings.decide(
        finalists, block=block, looks=plan.batches, ties=competition.document.ties
    )


def _store_places(
    session: Session,
    competition: CompetitionView,
    one: RoundView,
    decided: Sequence[Decided],
    table: Standings,
) -> None:
    placings = {placing.key: placing for placing in table.placings}
    for each in decided:
        placing = placings.get(each.entry.carried or 0)
        session.add(_place(one, each, placing))


def _place(one: RoundView, each: Decided, placing: Placing | None) -> FinalPlace:
    entry, result = each.entry, each.result
    return FinalPlace(
        round_id=one.id,
        run_id=entry.run_id,
        team_id=entry.team_id,
        method=entry.method,
        place=None if placing is None else placing.place,
        place_low=None if placing is None else placing.place_low,
        place_high=None if placing is None else placing.place_high,
        score=result.score,
        score_low=result.low,
        score_high=result.high,
        trials=len(result.scores),
        refusal=result.refusal,
    )


def _decide(
    session: Session, competition: CompetitionView, one: RoundView, settings: Settings
) -> None:
    """End a round: reveal its key, and with the last one end the competition."""
    now = time.time()
    values: dict[str, object] = {"decided_at": now}
    key = keys.round_key(settings.seed_key.encode(), competition.name, one.number)
    if keys.commitment(key) == one.commitment:
        values["key"] = key.hex()
    else:  # the operator has changed the seed key of the service
        _log.error("round_key_lost", competition=competition.name, round=one.number)
    session.execute(update(Round).where(Round.id == one.id).values(**values))
    if one.id == competition.deciding.id:
        if one.kind is not RoundKind.FINAL:
            _store_board(session, competition, one)
        _publish(session, competition, one)
        ended = update(Competition).where(Competition.id == competition.id)
        session.execute(ended.values(ended_at=now))
    _log.info("round_decided", competition=competition.name, round=one.number)


def _store_board(session: Session, competition: CompetitionView, one: RoundView) -> None:
    """Store the places of a competition without a final: those of its qualification."""
    board = boards.board(session, competition, one, by_method=True)
    shared = competition.document.ties is Ties.SHARED
    for row in (*board.rows, *board.references):
        session.add(
            FinalPlace(
                round_id=one.id,
                run_id=row.run_id,
                team_id=row.team_id,
                method=row.method,
                place=row.place_low if shared else row.place,
                place_low=row.place_low,
                place_high=row.place_high,
                score=row.score,
                score_low=row.low,
                score_high=row.high,
                trials=one.plan.trials,
            )
        )
    session.flush()


def _publish(session: Session, competition: CompetitionView, one: RoundView) -> None:
    """Show the runs that decided the competition to everybody, programs only by its rules."""
    places = select(FinalPlace.run_id).where(FinalPlace.round_id == one.id)
    is_final = one.kind is RoundKind.FINAL
    shown = Entry.round_id == one.id if is_final else Entry.run_id.in_(places)
    program = competition.document.programs is Programs.PUBLIC
    for entry in session.scalars(select(Entry).where(shown, Entry.withdrawn_at.is_(None))).all():
        terms = Terms(method=entry.method, program=program or entry.team_id is None)
        publications.publish(session, entry.run_id, terms)
