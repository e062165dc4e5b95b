"""Ordering a run: the rules, the quotas and the row, in one transaction."""

import secrets
import time
from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES
from seamark.server import workers
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Run, User
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.failure_reasons import UNCHARGED
from seamark.server.runs.states import LIVE, RunKind, RunState
from seamark.server.settings import Settings
from seamark.sim.engine.seeds import SEED_MAX

UPLOAD = "upload"  # the name of the controller that an upload brings
_DAY_S = 86_400.0


class QuotaExceeded(Exception):
    """The owner has used up a quota. The text is for the form; `retry_after_s` for the API."""

    def __init__(self, sentence: str, *, retry_after_s: int) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


class SubmissionRejected(Exception):
    """The order breaks a rule of the service. The text is for the form."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """What somebody wants to have run. `config` may leave out whatever has a default."""

    viewer: Viewer
    benchmark: str
    config: Mapping[str, object]
    kind: RunKind = RunKind.PRACTICE
    controller: str = UPLOAD
    program: StoredProgram | None = None
    seed: int | None = None  # practice only; drawn if it is not given
    trials: int = 1  # practice only
    title: str = ""
    notes: str = ""
    rerun_of: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Quota:
    """What an owner has used and may use; runs cancelled or broken by us do not count."""

    live: int
    live_max: int
    day: int
    day_max: int


def enqueue(session: Session, order: Submission, settings: Settings) -> int:
    """Insert a queued run and return its id. The caller commits, then calls `broker.ring`.

    Raises
    ------
    ConfigurationInvalid
        The configuration is wrong: a sentence for each field.
    SubmissionRejected, QuotaExceeded
        The order breaks a rule, or a quota is used up.
    """
    config = _configuration(order)
    _check_rules(session, order, settings)
    acquire(session, AdvisoryLock.SUBMISSION)
    _check_quota(session, order.viewer, settings)
    run = _row(order, config, settings)
    session.add(run)
    session.flush()
    return run.id


def rerun(session: Session, run_id: int, viewer: Viewer, settings: Settings) -> int:
    """Queue the same order again, for `viewer`; return the new id. Raises as `enqueue`."""
    old = session.get_one(Run, run_id)
    program = None
    if old.program_sha256 is not None:
        names = (old.program_name or "", old.language or "")
        program = StoredProgram(old.program_sha256, *names, size=0)
    order = Submission(
        viewer=viewer,
        benchmark=old.benchmark,
        config=old.config,
        kind=RunKind(old.kind),
        controller=old.controller,
        program=program,
        seed=old.seed,
        trials=old.trials if old.kind == RunKind.PRACTICE else 1,
        title=old.title,
        notes=old.notes,
        rerun_of=old.id,
    )
    return enqueue(session, order, settings)


def quota(session: Session, viewer: Viewer, settings: Settings) -> Quota:
    """Return what the viewer has used of the quotas."""
    live = (Run.owner == viewer.owner, Run.state.in_(LIVE))
    charged = (Run.state == RunState.SUCCEEDED) | Run.cause.not_in(UNCHARGED)
    # The states are named so that an index leads to the last day of somebody's thousands of runs.
    ended = (Run.owner == viewer.owner, Run.state.in_((RunState.SUCCEEDED, RunState.FAILED)))
    recent = (*ended, Run.finished_at > time.time() - _DAY_S, charged)
    live_now = session.scalar(select(func.count()).select_from(Run).where(*live)) or 0
    day = live_now + (session.scalar(select(func.count()).select_from(Run).where(*recent)) or 0)
    day_max = settings.quota_day if viewer.user_id is not None else settings.guest_quota_day
    return Quota(live=live_now, live_max=settings.quota_live, day=day, day_max=day_max)


def role_of(benchmark: str) -> str:
    """Return what programs have to be in a benchmark; "controller" if there is no such one."""
    from seamark.sim import registry  # noqa: PLC0415 - the web process starts without reading benchmarks

    known = benchmark in registry.BENCHMARKS
    return registry.benchmark(benchmark).role if known else "controller"


def _configuration(order: Submission) -> dict[str, object]:
    """Return the complete configuration; a ranked run gets the benchmark's scenario."""
    from seamark.sim import registry  # noqa: PLC0415 - as above

    if order.benchmark not in registry.BENCHMARKS:
        raise SubmissionRejected(f"There is no benchmark {order.benchmark}.")
    benchmark = registry.benchmark(order.benchmark)
    config = benchmark.read(order.config)
    if order.kind is RunKind.RANKED:
        config = benchmark.ranked(config)
    return dict(config.model_dump(mode="json"))


def _check_rules(session: Session, order: Submission, settings: Settings) -> None:
    viewer = order.viewer
    if not can(viewer, Action.SUBMIT):
        raise SubmissionRejected(
            "Log in, or allow the cookie by which a guest's runs are found again."
        )
    if order.kind is RunKind.RANKED and not can(viewer, Action.SUBMIT_RANKED):
        raise SubmissionRejected("A ranked run needs an account: the leaderboard shows its name.")
    if order.kind is RunKind.PRACTICE:
        _check_practice(order, settings)
    if (order.controller == UPLOAD) != (order.program is not None):
        raise SubmissionRejected("Choose either a built-in controller or a program of your own.")
    if order.program is None:
        _check_built_in(order)
        return
    if not can(viewer, Action.UPLOAD):
        raise SubmissionRejected("Running a program of your own needs an account.")
    _check_role(order.benchmark, order.program)
    if reason := workers.upload_refusal(session, order.program.language, settings):
        raise SubmissionRejected(reason)


def _check_practice(order: Submission, settings: Settings) -> None:
    if not 1 <= order.trials <= settings.practice_trials_max:
        raise SubmissionRejected(f"A practice run has 1 to {settings.practice_trials_max} trials.")
    if order.seed is not None and not 0 <= order.seed <= SEED_MAX:
        raise SubmissionRejected(f"A seed is a whole number from 0 to {SEED_MAX}.")


def _check_built_in(order: Submission) -> None:
    from seamark.sim import registry  # noqa: PLC0415 - as above

    benchmark = registry.benchmark(order.benchmark)
    if not order.controller:
        raise SubmissionRejected(
            f"Choose a {benchmark.role}: {', '.join(benchmark.built_in)}, or your own program."
        )
    if order.controller not in benchmark.built_in:
        raise SubmissionRejected(
            f"There is no built-in {benchmark.role} {order.controller} in {order.benchmark}; "
            f"there is {', '.join(benchmark.built_in)}."
        )


def _check_role(benchmark: str, program: StoredProgram) -> None:
    """Refuse a language in which there can be no program of the benchmark's role."""
    from seamark.sim import registry  # noqa: PLC0415 - as above

    role, language = registry.benchmark(benchmark).role, LANGUAGES[program.language]
    if role not in language.roles:
        able = ", ".join(each.label for each in LANGUAGES.values() if role in each.roles)
        raise SubmissionRejected(
            f"{benchmark} compares {role}s; a {role} is written in {able}, not in {language.label}."
        )


def _check_quota(session: Session, viewer: Viewer, settings: Settings) -> None:
    if viewer.user_id is not None and session.get_one(User, viewer.user_id).is_baseline:
        return
    used = quota(session, viewer, settings)
    if used.live >= used.live_max:
        raise QuotaExceeded(
            f"You have {used.live} runs waiting or running, which is the most at a time. "
            "Wait for one to end, or cancel one.",
            retry_after_s=60,
        )
    if used.day >= used.day_max:
        raise QuotaExceeded(
            f"You have had {used.day} runs in the last 24 hours, which is the most. "
            "Cancelled runs and failures of the service do not count.",
            retry_after_s=3600,
        )


def _row(order: Submission, config: dict[str, object], settings: Settings) -> Run:
    ranked = order.kind is RunKind.RANKED
    drawn = order.seed if order.seed is not None else secrets.randbelow(SEED_MAX + 1)
    program = order.program
    return Run(
        owner=order.viewer.owner,
        user_id=order.viewer.user_id,
        guest=None if order.viewer.user_id is not None else order.viewer.guest,
        benchmark=order.benchmark,
        kind=order.kind,
        config=config,
        seed=None if ranked else drawn,
        trials=settings.ranked_trials if ranked else order.trials,
        controller=order.controller,
        program_sha256=program.sha256 if program else None,
        program_name=program.name if program else None,
        language=program.language if program else None,
        title=order.title.strip()[:120],
        notes=order.notes.strip()[:4000],
        rerun_of=order.rerun_of,
        state=RunState.QUEUED,
        queued_at=time.time(),
    )
