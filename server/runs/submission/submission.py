"""Submitting a run: all its rules, for the form, the API, checks and baselines.

1. `validate` checks everything that needs no database and parses the configuration once.
2. `submit` checks the workers and the quota and inserts the row, in one transaction.
3. The caller commits, then calls `broker.send_tickets`.
"""

import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import structlog
from sqlalchemy.orm import Session

from seamark.programs import configurations
from seamark.programs.configurations import RunConfiguration
from seamark.programs.parameters import Parameter
from seamark.sandbox.languages import role_refusal
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.classes import assignments
from seamark.server.classes.refusals import ClassRefused
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.engine import after_commit
from seamark.server.database.tables import Run
from seamark.server.messaging import workers
from seamark.server.programs import store
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.data import run_size
from seamark.server.runs.data.run_size import RunSize
from seamark.server.runs.queue import paces
from seamark.server.runs.record import anonymity, seeds, turns
from seamark.server.runs.record.run_notes import clean_notes, clean_title
from seamark.server.runs.record.seeds import submission_digest
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import quota, ranked_scenario
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.seeds import SEED_MAX
from seamark.sim.settings.configuration import Configuration

_log = structlog.get_logger()
UPLOAD = "upload"  # the controller of a run whose program was uploaded


class SubmissionRejected(Exception):
    """The submission breaks a rule. The text is for the user; `field` names the part at fault."""

    def __init__(self, sentence: str, *, field: str = "") -> None:
        super().__init__(sentence)
        self.field = field


class SignInNeeded(SubmissionRejected):
    """The viewer has neither an account nor a guest's cookie, so could not find the run again."""


class AccountNeeded(SubmissionRejected):
    """Guests may not submit this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """What a user sends, not validated. `config` may leave out settings that have defaults."""

    viewer: Viewer
    benchmark: str
    config: Mapping[str, object]
    kind: RunKind = RunKind.PRACTICE
    controller: str = UPLOAD
    program: StoredProgram | None = None
    seed: int | None = None  # practice only; None: drawn
    trials: int | None = None  # practice only; None: one
    title: str = ""
    notes: str = ""
    rerun_of: int | None = None
    assignment: int | None = None  # of a class, for which the run is to count
    baseline: bool = False  # submitted by the service; may use the benchmark's reference solutions
    connected: bool = False  # its program takes part over the network, see `solutions`


@dataclass(frozen=True, slots=True)
class ValidSubmission:
    """A submission that `validate` accepted, with its complete configuration."""

    submission: Submission
    benchmark: Benchmark
    config: Configuration
    trials: int
    size: RunSize  # what it may record
    whole: RunConfiguration  # as it was sent, with the parameters of the program


def validate(submission: Submission, settings: Settings) -> ValidSubmission:
    """Return the submission with its parsed configuration.

    Raises
    ------
    ConfigurationInvalid
        The configuration is wrong: a sentence for each setting.
    SubmissionRejected
        Another rule is broken.
    """
    benchmark = find_benchmark(submission.benchmark)
    program = submission.program
    declared: tuple[Parameter, ...] = ()
    if program is not None:
        declared = configurations.declared_in(benchmark, program.language, program.parameters)
    whole = configurations.read(benchmark, submission.config, declared)
    config = whole.settings
    require_permission(
        submission.viewer, kind=submission.kind, uploads=submission.program is not None
    )
    if submission.kind is RunKind.RANKED:
        chosen = submission.controller
        config = ranked_scenario.apply(benchmark, submission.config, config, controller=chosen)
        trials = _ranked_trials(submission, benchmark, settings)
    else:
        trials = _practice_trials(submission, settings)
    if (submission.controller == UPLOAD) != (submission.program is not None):
        raise SubmissionRejected(
            f"Choose either a built-in {benchmark.role} or your own program.", field="controller"
        )
    if submission.connected:
        _check_connected(submission, benchmark)
    elif submission.program is None:
        _check_built_in(benchmark, submission.controller, baseline=submission.baseline)
    else:
        _check_language(benchmark, submission.program.language)
    program_bytes = None if program is None else program.size
    size = run_size.estimate(config, trials=trials, program_bytes=program_bytes)
    refusal = size.refusal(settings.run_max_bytes)
    if refusal is not None and submission.kind is RunKind.PRACTICE:
        raise SubmissionRejected(refusal)
    return ValidSubmission(submission, benchmark, config, trials, size, whole)


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
    storage.require(settings)
    # Two submissions at once must not both see the last free run of a quota.
    acquire(session, AdvisoryLock.SUBMISSION)
    new_bytes = sum(each.size.bytes for each in valids)
    quota.enforce(session, submission.viewer, settings, new_bytes=new_bytes, new_runs=len(valids))
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
    turns.refresh(session, submission.viewer.owner or "")
    return ids


def _insert(session: Session, valid: ValidSubmission, run: Run, settings: Settings) -> int:
    """Insert one row and return its id: in the order of the queue."""
    submission = valid.submission
    if not submission.connected:  # whose pace is that of a network
        run.expected_s = paces.expected_s(session, run, valid.config.trial_duration_s())
    if submission.kind is RunKind.RANKED and valid.benchmark.protocol is not None:
        run.submission = submission_digest(run)
    run.trial_seeds = seeds.derived(run, settings)
    session.add(run)
    session.flush()
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
        config = ranked_scenario.with_effect(benchmark, config, controller=old.controller)
    submission = Submission(
        viewer=viewer,
        benchmark=old.benchmark,
        config=config,
        kind=RunKind(old.kind),
        controller=old.controller,
        program=program_of(old, settings),
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
    found = assignments.of_run(session, run.id)
    if found is None or viewer.user_id is None or run.user_id != viewer.user_id:
        return None
    try:
        return assignments.open_for(session, found.id, viewer.user_id).id
    except ClassRefused:
        return None


def find_benchmark(name: str) -> Benchmark:
    """Return a benchmark; raises SubmissionRejected if it does not exist."""
    if name not in registry.BENCHMARKS:
        raise SubmissionRejected(f"There is no benchmark {name}.", field="benchmark")
    return registry.benchmark(name)


def ranked_trials(benchmark: Benchmark, settings: Settings) -> int:
    """Return the number of trials of a ranked run."""
    protocol = benchmark.protocol
    return settings.ranked_trials if protocol is None else protocol.trials


def require_permission(
    viewer: Viewer, *, kind: RunKind = RunKind.PRACTICE, uploads: bool = False
) -> None:
    """Raise SubmissionRejected if the viewer may not submit such a run."""
    if kind is RunKind.RANKED and not can(viewer, Action.SUBMIT_RANKED):
        raise AccountNeeded("A ranked run needs an account: the leaderboard shows its name.")
    if uploads and not can(viewer, Action.UPLOAD):
        raise AccountNeeded("Uploading a program needs an account.", field="program")
    if not can(viewer, Action.SUBMIT):
        raise SignInNeeded("Sign in, or allow cookies: a guest's runs are found by a cookie.")


def require_language(
    session: Session, benchmark: Benchmark, language: str, settings: Settings
) -> None:
    """Raise SubmissionRejected if programs in a language cannot run in a benchmark now."""
    _check_language(benchmark, language)
    if refusal := workers.upload_refusal(session, language, settings):
        raise SubmissionRejected(refusal, field="program")


def _enter(session: Session, assignment_id: int, run: Run) -> None:
    try:
        assignments.enter(session, assignment_id, run.user_id or 0, run.id)
    except ClassRefused as refusal:
        raise SubmissionRejected(str(refusal), field=refusal.field) from None


def _check_language(benchmark: Benchmark, language: str) -> None:
    if refusal := role_refusal(language, benchmark.role):
        sentence = f"{benchmark.name} compares {benchmark.role}s. {refusal}"
        raise SubmissionRejected(sentence, field="program")


def _ranked_trials(submission: Submission, benchmark: Benchmark, settings: Settings) -> int:
    trials = ranked_trials(benchmark, settings)
    if submission.seed is not None:
        raise SubmissionRejected(ranked_scenario.SEED_REFUSAL, field="seed")
    if submission.trials not in (None, trials):
        raise SubmissionRejected(ranked_scenario.trials_refusal(trials), field="trials")
    return trials


def _practice_trials(submission: Submission, settings: Settings) -> int:
    trials, trials_max = (
        1 if submission.trials is None else submission.trials,
        settings.practice_trials_max,
    )
    if not 1 <= trials <= trials_max:
        raise SubmissionRejected(f"A practice run has 1 to {trials_max} trials.", field="trials")
    if submission.seed is not None and not 0 <= submission.seed <= SEED_MAX:
        raise SubmissionRejected(f"A seed is a whole number from 0 to {SEED_MAX}.", field="seed")
    return trials


def _check_connected(submission: Submission, benchmark: Benchmark) -> None:
    if benchmark.role != "controller":
        raise SubmissionRejected(
            f"{benchmark.name} evaluates a {benchmark.role}; a bridge connects a controller.",
            field="benchmark",
        )
    if submission.kind is not RunKind.PRACTICE:
        raise SubmissionRejected(
            "A connected program cannot be run again, so its run does not rank: upload the program."
        )


def _check_built_in(benchmark: Benchmark, controller: str, *, baseline: bool) -> None:
    if controller in benchmark.built_in:
        return
    if controller in benchmark.reference_built_in:
        if baseline:
            return
        raise SubmissionRejected(
            f"{benchmark.reference_built_in[controller]} is a reference entry: the service runs it "
            "itself, as a mark on the leaderboard.",
            field="controller",
        )
    choice = f"Choose a {benchmark.role}: {', '.join(benchmark.built_in)}, or your own program."
    unknown = f"{benchmark.name} has no built-in {benchmark.role} {controller}. "
    raise SubmissionRejected(unknown + choice if controller else choice, field="controller")


def program_of(run: Run, settings: Settings) -> StoredProgram | None:
    """Return the program of a run, to be run again; None if its solution is built in.

    Raises
    ------
    SubmissionRejected
        It has been deleted.
    """
    if run.program_sha256 is None:
        return None
    size = store.touch(settings, run.program_sha256)
    if size is None:
        raise SubmissionRejected("The program of this run has been deleted.", field="program")
    name = anonymity.file_name(run.program_name) if run.anonymous else run.program_name
    names = (name or "", run.language or "")
    declared = tuple(map(Parameter.from_json, run.program_parameters or ()))
    return StoredProgram(run.program_sha256, *names, size=size, parameters=declared)


def _row(valid: ValidSubmission) -> Run:
    submission, viewer, program = (
        valid.submission,
        valid.submission.viewer,
        valid.submission.program,
    )
    ranked = submission.kind is RunKind.RANKED
    drawn = submission.seed if submission.seed is not None else secrets.randbelow(SEED_MAX + 1)
    return Run(
        owner=viewer.owner,
        user_id=viewer.user_id,
        guest=None if viewer.user_id is not None else viewer.guest,
        benchmark=submission.benchmark,
        kind=submission.kind,
        config=valid.whole.document(valid.config),
        seed=None if ranked else drawn,
        trials=valid.trials,
        controller=submission.controller,
        program_sha256=program.sha256 if program else None,
        program_name=program.name if program else None,
        language=program.language if program else None,
        program_parameters=[one.to_json() for one in valid.whole.declared] or None,
        title=clean_title(submission.title),
        notes=clean_notes(submission.notes),
        rerun_of=submission.rerun_of,
        state=RunState.QUEUED,
        queued_at=time.time(),
        data_bytes=valid.size.bytes,
    )
