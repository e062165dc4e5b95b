"""The check of a draft: the reference entries run in it, and a report says what to expect."""

from collections.abc import Collection
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session, undefer

from seamark.competitions import check_report
from seamark.competitions.check_report import Draft, Reference
from seamark.competitions.findings import Finding, Level
from seamark.server.accounts.permissions import Viewer
from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import CHECK, CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import Entry, Round
from seamark.server.database.tables import Run
from seamark.server.judging import entries, finals
from seamark.server.messaging import workers
from seamark.server.programs import own_files
from seamark.server.runs.ending import deletion, results
from seamark.server.runs.record import turns
from seamark.server.runs.record.states import LIVE, RunKind
from seamark.server.runs.record.trial_scores import block_of
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.server.settings import Settings

WATER = "check"  # all reference entries have the same seed: what they differ by is not the water


@dataclass(frozen=True, slots=True)
class CheckView:
    """How far a check is, and what it found so far."""

    asked: int  # reference entries; 0: it was never asked for
    waiting: int
    findings: tuple[Finding, ...]  # empty until all have ended
    references: tuple[Reference, ...]

    @property
    def has_ended(self) -> bool:
        """Whether the report is complete."""
        return self.asked > 0 and not self.waiting


def request(session: Session, competition: CompetitionView, settings: Settings) -> int:
    """Queue the reference entries of a draft, all or none, and return their number.

    Raises
    ------
    CompetitionRefused
        It is open, or its check is under way or has been made.
    SubmissionRejected, StorageUnavailable
        A reference entry cannot run.
    """
    if not competition.is_draft:
        raise CompetitionRefused("The competition is open: it was checked before.")
    acquire(session, AdvisoryLock.COMPETITIONS)
    row = _round(session, competition.id)
    if session.scalar(select(func.count()).where(Entry.round_id == row.id)):
        raise CompetitionRefused("The draft has been checked. Change it to check it again.")
    document, vehicle = competition.document, entries.vehicle_of(competition, settings)
    files = entries.files_of(competition, settings)
    with own_files.lent(vehicle, files):
        fixed = document.fixed()
    for name, baseline in document.base.baselines.items():
        entry = Entry(
            round_id=row.id,
            method=baseline.title,
            method_key=baseline.title.casefold(),
            reference=name,
        )
        owner = finals.owner_of(competition.id)
        sent = Submission(
            viewer=Viewer(user_id=competition.organiser_id),
            benchmark=document.benchmark,
            config={**baseline.config, **fixed},
            kind=RunKind.ENTRY,
            controller=baseline.built_in,
            vehicle=vehicle,
            files=files,
            title=baseline.title,
            notes=baseline.notes,
            entry=entries.terms_of(competition, row, owner, entry, settings, water=WATER),
            baseline=True,
        )
        submission.submit(session, validation.validate(sent, settings), settings)
    return len(document.base.baselines)


def view(session: Session, competition: CompetitionView) -> CheckView:
    """Return how far the check of a competition is, and its report if it has ended."""
    query = (
        select(Entry, Run)
        .options(undefer(Entry.scores))
        .join(Run, Run.id == Entry.run_id)
        .join(Round, Round.id == Entry.round_id)
        .where(Round.competition_id == competition.id, Round.number == CHECK)
        .order_by(Entry.score.desc())
    )
    rows = session.execute(query).all()
    waiting = sum(run.state in LIVE for _, run in rows)
    bounds = competition.document.base.reference_built_in
    references = tuple(_reference(entry, run, bounds) for entry, run in rows)
    if waiting or not rows:
        return CheckView(len(rows), waiting, (), references)
    findings = check_report.report(references, _draft(session, competition))
    if competition.document.final is None:
        findings.append(_no_final(competition.document.qualification.quota))
    return CheckView(len(rows), waiting, tuple(findings), references)


def open_up(session: Session, competition: CompetitionView) -> None:
    """Open a competition whose check has ended; raises CompetitionRefused."""
    if not view(session, competition).has_ended:
        raise CompetitionRefused("Wait for the check to end: its report tells what to expect.")
    competitions.open_up(session, competition)


def discard(session: Session, competition: CompetitionView) -> list[int]:
    """Forget the runs of a draft's check, before it is changed or deleted; return their ids.

    The caller removes their files after the commit (`deletion.remove_files`).
    """
    own = select(Entry.run_id).join(Round, Round.id == Entry.round_id)
    runs = session.scalars(own.where(Round.competition_id == competition.id)).all()
    for run_id in runs:
        results.cancel(session, run_id)
    emptied = deletion.empty(session, runs)
    turns.refresh(session, finals.owner_of(competition.id))
    return list(emptied)


def _round(session: Session, competition_id: int) -> Round:
    own = (Round.competition_id == competition_id, Round.number == CHECK)
    return session.scalars(select(Round).where(*own)).one()


def _reference(entry: Entry, run: Run, bounds: Collection[str]) -> Reference:
    failed = run.detail.get("title") or run.cause or "it was cancelled"
    wall_s = (run.finished_at or 0.0) - (run.started_at or run.finished_at or 0.0)
    return Reference(
        name=run.controller,
        title=entry.method,
        is_bound=run.controller in bounds,
        scores=entry.scores,
        failed_why="" if entry.scores else str(entry.refusal or failed),
        wall_s=wall_s,
    )


def _no_final(quota: int) -> Finding:
    if quota == 1:
        return Finding(
            Level.WARNING,
            "There is no final, so each team is placed by one submission, in water of its own. Add "
            "a final: it evaluates all on the same trials until their ranks separate.",
        )
    return Finding(
        Level.PROBLEM,
        f"There is no final, so a team is placed by the best of {quota} submissions, each in water "
        "of its own: the best of many is partly luck. Add a final.",
    )


def _draft(session: Session, competition: CompetitionView) -> Draft:
    plan = competition.document.qualification
    slots = session.scalar(select(workers.slots())) or 1
    return Draft(
        trials=plan.trials,
        block=block_of(competition.document.benchmark),
        paired=True,
        slots=max(int(slots), 1),
        quota=plan.quota,
        qualification_s=(plan.closes - plan.opens).total_seconds(),
    )
