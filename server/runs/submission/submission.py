"""Submitting a run, for the form, the API and baselines.

1. `validation.validate` checks everything that needs no database and parses the configuration once.
2. `submit` checks the workers and the quota and inserts the row, in one transaction.
3. The caller commits, then calls `broker.send_tickets`.
"""

import secrets
import time
from collections.abc import Sequence
from functools import partial

import structlog
from sqlalchemy.orm import Session

from seamark.programs import parts
from seamark.programs.parameters import Parameter
from seamark.server.accounts.permissions import Viewer
from seamark.server.classes import assignments
from seamark.server.classes.refusals import ClassRefused
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.engine import after_commit
from seamark.server.database.tables import Run, RunFile, RunPart
from seamark.server.messaging import workers
from seamark.server.programs import own_files, store, vehicles
from seamark.server.programs.own_files import FileDeleted, StoredFile
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.queue import paces
from seamark.server.runs.record import anonymity, seeds, turns
from seamark.server.runs.record.run_notes import clean_notes, clean_title
from seamark.server.runs.record.seeds import submission_digest
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import quota, ranked_scenario
from seamark.server.runs.submission.validation import (
    Submission,
    SubmissionRejected,
    ValidSubmission,
    check_language,
    find_benchmark,
    validate,
)
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.seeds import SEED_MAX

_log = structlog.get_logger()


def submit(session: Session, valid: ValidSubmission, settings: Settings) -> int:
    """Insert a queued run and return its id; raises as `submit_all`."""
    return submit_all(session, [valid], settings)[0]


def submit_all(
    session: Session,
    valids: Sequence[ValidSubmission],
    settings: Settings,
    *,
    sweep_id: int | None = None,
) -> list[int]:
    """Insert queued runs of one viewer and one program, all or none, and return their ids.

    Raises
    ------
    SubmissionRejected, QuotaExceeded
        No worker can run the program, or a quota is used up.
    StorageUnavailable
        There is no room for what they may record, or the data folder is away.
    """
    valid = valids[0]
    submission = valid.submission
    if submission.program is not None:
        require_language(session, valid.benchmark, submission.program.language, settings)
    for role, part in submission.parts.items():
        require_language(session, valid.benchmark, part.language, settings, role=role)
    storage.require(settings)
    # Two submissions at once must not both see the last free run of a quota.
    acquire(session, AdvisoryLock.SUBMISSION)
    new_bytes = sum(each.size.bytes for each in valids)
    if submission.entry is None:  # a round has a quota of its own
        quota.enforce(
            *(session, submission.viewer, settings), new_bytes=new_bytes, new_runs=len(valids)
        )
    if submission.kind is RunKind.RANKED:
        quota.enforce_ranked(session, submission.viewer, submission.benchmark, settings)
    ids: list[int] = []
    for cell, each in enumerate(valids):
        run = _row(each)
        if sweep_id is not None:
            run.sweep_id, run.sweep_cell = sweep_id, cell
        ids.append(_insert(session, each, run, settings))
        submitted = partial(_log.info, "run_submitted", run=run.id, benchmark=run.benchmark)
        after_commit(session, submitted)
    turns.refresh(session, _owner(submission) or "")
    return ids


def _insert(session: Session, valid: ValidSubmission, run: Run, settings: Settings) -> int:
    """Insert one row and return its id: in the order of the queue."""
    submission = valid.submission
    if not submission.connected:  # whose pace is that of a network
        run.expected_s = paces.expected_s(session, run, valid.config.trial_duration_s())
    if submission.kind is RunKind.RANKED and valid.benchmark.protocol is not None:
        run.submission = submission_digest(run)
    if submission.entry is not None:
        run.submission = submission_digest(run)
        run.seed = submission.entry.seed_of(run.submission)
    run.trial_seeds = seeds.derived(run, settings)
    session.add(run)
    session.flush()
    if submission.entry is not None:
        submission.entry.enter(session, run.id)
    if submission.assignment is not None:
        _enter(session, submission.assignment, run)
    return run.id


def rerun(session: Session, run_id: int, viewer: Viewer, settings: Settings) -> int:
    """Submit a run again, for `viewer`; return the new id. Raises as `validate` and `submit`."""
    old = session.get_one(Run, run_id)
    if old.kind == RunKind.LOG:
        raise SubmissionRejected("This is the log of a mission, which cannot be run again.")
    if old.controller == ROSBRIDGE:
        raise SubmissionRejected(
            "The program of this run was connected by rosbridge: connect it again."
        )
    config = old.config
    if old.kind == RunKind.RANKED:
        benchmark = find_benchmark(old.benchmark)
        config = ranked_scenario.with_effect(
            *(benchmark, config),
            controller=old.controller,
            parts=[part.role for part in old.parts],
        )
    submission = Submission(
        viewer=viewer,
        benchmark=old.benchmark,
        config=config,
        kind=RunKind.PRACTICE if old.kind == RunKind.ENTRY else RunKind(old.kind),
        controller=old.controller,
        program=program_of(old, settings),
        parts=parts_of(old, settings),
        vehicle=vehicle_of(old, settings),
        files=files_of(old, settings),
        seed=old.seed,
        trials=old.trials,
        title=old.title,
        notes=old.notes,
        rerun_of=old.id,
        assignment=_open_assignment(session, old, viewer),
    )
    return submit(session, validate(submission, settings), settings)


def _open_assignment(session: Session, run: Run, viewer: Viewer) -> int | None:
    """Return the assignment that a run of the viewer was for, if it still accepts runs."""
    assignment = assignments.of_run(session, run.id)
    if assignment is None or viewer.user_id is None or run.user_id != viewer.user_id:
        return None
    try:
        return assignments.open_for(session, assignment.id, viewer.user_id).id
    except ClassRefused:
        return None


def require_language(
    session: Session, benchmark: Benchmark, language: str, settings: Settings, *, role: str = ""
) -> None:
    """Raise SubmissionRejected if programs in a language cannot run in a benchmark now.

    Without a `role` it is the one of the benchmark; with one the program is a part of the run.
    """
    check_language(benchmark, language, role=role)
    if refusal := workers.upload_refusal(session, language, settings):
        raise SubmissionRejected(refusal, field=parts.field(role) if role else "program")


def _enter(session: Session, assignment_id: int, run: Run) -> None:
    try:
        assignments.enter(session, assignment_id, run.user_id or 0, run.id)
    except ClassRefused as refusal:
        raise SubmissionRejected(str(refusal), field=refusal.field) from None


def parts_of(run: Run, settings: Settings) -> dict[str, StoredProgram]:
    """Return role -> further program of a run, to be run again.

    Raises
    ------
    SubmissionRejected
        One has been deleted.
    """
    return {
        part.role: _stored(part, settings, what=part.role, hidden=run.anonymous)
        for part in run.parts
    }


def program_of(run: Run, settings: Settings) -> StoredProgram | None:
    """Return the program of a run, to be run again; None if its solution is built in.

    Raises
    ------
    SubmissionRejected
        It has been deleted.
    """
    if run.program_sha256 is None:
        return None
    return _stored(run, settings, what="program", hidden=run.anonymous)


def _stored(of: Run | RunPart, settings: Settings, *, what: str, hidden: bool) -> StoredProgram:
    sha256 = of.program_sha256 or ""
    size = store.touch(settings, sha256)
    if size is None:
        at = what if isinstance(of, Run) else parts.field(what)
        raise SubmissionRejected(f"The {what} of this run has been deleted.", field=at)
    name = anonymity.file_name(of.program_name) if hidden else of.program_name
    declared = tuple(map(Parameter.from_json, of.program_parameters or ()))
    return StoredProgram(sha256, name or "", of.language or "", size=size, parameters=declared)


def vehicle_of(run: Run, settings: Settings) -> StoredVehicle | None:
    """Return the own vehicle of a run, to be run again; None if it has one of ours.

    Raises
    ------
    SubmissionRejected
        It has been deleted.
    """
    try:
        return vehicles.of_run(run, settings)
    except FileNotFoundError:
        raise SubmissionRejected(
            "The vehicle of this run has been deleted.", field=vehicles.FIELD
        ) from None


def files_of(run: Run, settings: Settings) -> tuple[StoredFile, ...]:
    """Return the files that settings of a run name, to be run again; raises as `vehicle_of`."""
    try:
        return own_files.of_run(run, settings)
    except FileDeleted as deleted:
        raise SubmissionRejected(str(deleted), field=deleted.setting) from None


def _owner(submission: Submission) -> str | None:
    """Return whose run it is: not of who submits the entry of a team."""
    return submission.viewer.owner if submission.entry is None else submission.entry.owner


def _row(valid: ValidSubmission) -> Run:
    submission, viewer, program = (
        valid.submission,
        valid.submission.viewer,
        valid.submission.program,
    )
    config, vehicle = valid.whole.document(valid.config), submission.vehicle
    own = vehicle is not None and config[vehicles.FIELD] == vehicle.name  # a sweep may have others
    ranked, personal = submission.kind is RunKind.RANKED, submission.entry is None
    drawn = submission.seed if submission.seed is not None else secrets.randbelow(SEED_MAX + 1)
    return Run(
        owner=_owner(submission),
        user_id=viewer.user_id if personal else None,
        guest=viewer.guest if personal and viewer.user_id is None else None,
        benchmark=submission.benchmark,
        kind=submission.kind,
        config=config,
        seed=None if ranked else drawn,
        trials=valid.trials,
        controller=submission.controller,
        program_sha256=program.sha256 if program else None,
        program_name=program.name if program else None,
        language=program.language if program else None,
        vehicle_sha256=vehicle.sha256 if vehicle is not None and own else None,
        program_parameters=[one.to_json() for one in valid.whole.declared] or None,
        parts=[_part(role, part) for role, part in submission.parts.items()],
        files=[
            RunFile(setting=file.setting, sha256=file.sha256)
            for file in submission.files
            if config[file.setting] == file.name
        ],
        title=clean_title(submission.title),
        notes=clean_notes(submission.notes),
        rerun_of=submission.rerun_of,
        state=RunState.QUEUED,
        queued_at=time.time(),
        data_bytes=valid.size.bytes,
    )


def _part(role: str, program: StoredProgram) -> RunPart:
    return RunPart(
        role=role,
        program_sha256=program.sha256,
        program_name=program.name,
        language=program.language,
        program_parameters=[one.to_json() for one in program.parameters] or None,
    )
