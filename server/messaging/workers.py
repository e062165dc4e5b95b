"""The workers of the service: which are alive, what their hosts can run, how they are doing."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, ScalarSelect, bindparam, delete, false, func, select, update
from sqlalchemy.orm import Session

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.server.database import clock, data_folder
from seamark.server.database.clock import Now
from seamark.server.database.tables import Worker
from seamark.server.settings import Settings
from seamark.server.storage import installation

ALIVE_S = 35.0  # a worker counts as dead after this time without a heartbeat
LISTED_S = 86_400.0  # dead workers stay listed for a day
# No heartbeat is from the future, unless the clock of the database was set back since.
_ALIVE = Worker.seen_at.between(Now() - ALIVE_S, Now() + ALIVE_S)
# Not known of workers of versions that did not report it.
_OUTDATED = func.coalesce(Worker.result_code != data_folder.CURRENT_CODE, false())
_CLAIMS = _ALIVE & Worker.drained_at.is_(None) & ~_OUTDATED
LISTED_MAX = 1000  # workers whose boxes are compared
RUNNING = "running"  # state of a process; any other text but those of `preparing` is a fault
_PREPARING = "preparing"
SIMULATOR = "simulator"  # name of the process of a worker that prepares at its start


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerStatus:
    """A worker as the status page and the metrics show it."""

    name: str
    alive: bool
    slots: int
    level: str
    languages: Sequence[str]
    findings: Sequence[Mapping[str, Any]]
    processes: Mapping[str, str]  # process -> "running", "preparing (2 of 6)" or what is wrong
    version: str
    started_at: float
    seen_at: float
    silent_s: float  # since it was seen
    drained_at: float | None  # since when it claims no more runs
    outdated: bool  # it would compute something else than the service, and claims no runs

    @property
    def claims(self) -> bool:
        """Whether it starts runs: alive, not drained and not outdated."""
        return self.alive and self.drained_at is None and not self.outdated

    @property
    def broken_processes(self) -> dict[str, str]:
        """The processes that neither run nor prepare to, with what is wrong."""
        expected = (RUNNING, _PREPARING)
        return {
            name: state
            for name, state in self.processes.items()
            if state.partition(" ")[0] not in expected
        }

    @property
    def preparing(self) -> bool:
        """Whether its runs wait until the simulator is loaded, or compiled for the first time."""
        return is_preparing(self.processes)


def is_preparing(processes: Mapping[str, str]) -> bool:
    """Return whether the simulator of a worker, whose processes are given, is not ready yet."""
    return processes.get(SIMULATOR, "").startswith(_PREPARING)


def preparing(ready: int, of: int) -> str:
    """Return the state of a simulator that is loading, or compiled for the first time.

    Parameters
    ----------
    ready, of
        How many of its parts can be used, and how many it has; 0: not known.
    """
    return f"{_PREPARING} ({ready} of {of})" if of else _PREPARING


def register(session: Session, worker: Worker) -> None:
    """List a worker that starts; replaces an earlier entry of the same name, but stays drained."""
    worker.started_at = worker.seen_at = clock.now(session)
    worker.processes = {}
    session.merge(worker)  # leaves `drained_at`, which nobody has set in `worker`


def heartbeat(session: Session, name: str, processes: Mapping[str, str]) -> bool:
    """Record that a worker is alive, and how its side processes are doing; False if not listed.

    Parameters
    ----------
    processes
        Process -> `RUNNING`, what `preparing` returns, or for instance "restarting since 12:00:05".
    """
    change = update(Worker).where(Worker.name == name, Worker.slots > 0)  # 0: it has stopped
    change = change.values(seen_at=Now(), processes=dict(processes))
    return session.scalar(change.returning(Worker.name)) is not None


def unregister(session: Session, name: str) -> None:
    """Take a worker that shuts down off the list; a drained one stays listed for a day."""
    named = Worker.name == name
    session.execute(delete(Worker).where(named, Worker.drained_at.is_(None)))
    session.execute(update(Worker).where(named).values(seen_at=Now() - ALIVE_S - 1.0, slots=0))


def forget(session: Session, name: str) -> None:
    """Take a worker that has ended off the list, though it was drained."""
    session.execute(delete(Worker).where(Worker.name == name))


def drain(session: Session, name: str) -> bool:
    """Let a worker claim no more runs; it ends those it has. False if that changes nothing.

    The decision outlasts a restart of the worker, unless it is away for more than a day.
    """
    change = update(Worker).where(Worker.name == name, Worker.drained_at.is_(None))
    change = change.values(drained_at=Now())
    return session.scalar(change.returning(Worker.name)) is not None


def resume(session: Session, name: str) -> bool:
    """Let a drained worker claim runs again; False if that changes nothing."""
    change = update(Worker).where(Worker.name == name, Worker.drained_at.is_not(None))
    return session.scalar(change.values(drained_at=None).returning(Worker.name)) is not None


def is_drained(session: Session, process: str) -> bool:
    """Return whether the worker of a process, named "<worker>/<process>", is drained."""
    return bool(session.scalar(select(drained()), bound(process)))


def drained() -> ColumnElement[bool]:
    """Return `is_drained` as an expression, for a query that asks for more; see `bound`."""
    mine = (Worker.name == bindparam("this_worker"), Worker.drained_at.is_not(None))
    return select(Worker.name).where(*mine).exists()


def bound(process: str) -> dict[str, object]:
    """Return the values of the expression that `drained` returns."""
    return {"this_worker": worker_of(process)}


def worker_of(process: str) -> str:
    """Return the name of the worker of a process that claims runs or checks."""
    return process.rpartition("/")[0] or process


def forget_dead(session: Session) -> None:
    """Take the workers off the list that have been dead for a day."""
    session.execute(delete(Worker).where(Worker.seen_at < Now() - LISTED_S))


def listed(session: Session) -> list[WorkerStatus]:
    """Return all workers that were seen in the last day, by name."""
    values = (Worker, _ALIVE, Now() - Worker.seen_at, _OUTDATED)
    recent = select(*values).where(Worker.seen_at > Now() - LISTED_S).order_by(Worker.name)
    return [
        WorkerStatus(
            name=worker.name,
            alive=alive,
            slots=worker.slots,
            level=worker.level,
            languages=worker.languages,
            findings=worker.findings,
            processes=worker.processes,
            version=worker.version,
            started_at=worker.started_at,
            seen_at=worker.seen_at,
            silent_s=max(silent_s, 0.0),
            drained_at=worker.drained_at,
            outdated=outdated,
        )
        for worker, alive, silent_s, outdated in session.execute(recent)
    ]


def alive_count(session: Session) -> int:
    """Return how many workers claim runs."""
    return session.scalar(select(func.count()).where(_CLAIMS)) or 0


def preparation(session: Session) -> str | None:
    """Return what is being done until the first simulator is ready; None if one is, or no worker.

    The first start of all compiles the simulator, for minutes on a slow machine.
    """
    states = list(session.scalars(select(Worker.processes).where(_CLAIMS).limit(LISTED_MAX)))
    if not states or not all(is_preparing(processes) for processes in states):
        return None
    known = sorted(_parts(processes) for processes in states)[-1]
    progress = f" {known} parts are ready." if known else ""
    return f"The simulator is being compiled, once, at the first start of the service.{progress}"


def _parts(processes: Mapping[str, str]) -> str:
    """Return how much of a simulator is ready, as in "2 of 6"; empty: not known."""
    return processes[SIMULATOR].partition("(")[2].removesuffix(")")


def slot_count(session: Session) -> int:
    """Return how many runs the workers that claim runs can run together."""
    return session.scalar(select(slots())) or 0


def slots() -> ScalarSelect[int | None]:
    """Return `slot_count` as an expression; NULL without workers."""
    return select(func.sum(Worker.slots)).where(_CLAIMS).scalar_subquery()


def waits_for_installation(session: Session, language: str, settings: Settings) -> bool:
    """Return whether no worker can run `language` yet, and what it needs may be being installed."""
    if not installation.is_under_way(settings):
        return False
    known = session.scalars(select(Worker.languages).where(_CLAIMS).limit(LISTED_MAX))
    return not any(language in languages for languages in known)


@dataclass(frozen=True, slots=True)
class ComponentVersions:
    """A component of boxes: each of its versions with the number of workers that have it."""

    kind: str
    name: str
    versions: Mapping[str, int]

    def is_everywhere(self, count: int) -> bool:
        """Return whether all of `count` workers have the same version."""
        return list(self.versions.values()) == [count]


@dataclass(frozen=True, slots=True)
class Environment:
    """What programs in one language find in the boxes of the living workers."""

    language: str
    workers: int  # that run programs in it
    components: Sequence[ComponentVersions]


def environments(session: Session) -> list[Environment]:
    """Return what programs find now, for each language that a worker can run."""
    alive = list(session.scalars(select(Worker).where(_CLAIMS).limit(LISTED_MAX)))
    merged = []
    for language in LANGUAGES:
        running = [worker for worker in alive if language in worker.languages]
        if running:
            reports = [worker.contents.get(language, []) for worker in running]
            merged.append(Environment(language, len(running), _merged(reports)))
    return merged


def _merged(reports: Iterable[Sequence[Mapping[str, str]]]) -> list[ComponentVersions]:
    """Return the components of several workers, in the order of the first that has each."""
    versions = dict[tuple[str, str], Counter[str]]()
    for report in reports:
        for component in report:
            key = component["kind"], component["name"]
            versions.setdefault(key, Counter())[component["version"]] += 1
    return [
        ComponentVersions(kind, name, dict(counts)) for (kind, name), counts in versions.items()
    ]


def finding_of(language: str) -> str:
    """Return the name of the finding by which a worker says why it cannot run a language."""
    known = LANGUAGES.get(language)  # None: of a run that an earlier version accepted
    return f"programs in {language if known is None else known.label}"


def upload_refusal(session: Session, language: str, settings: Settings) -> str | None:
    """Return why uploads in `language` cannot be run now, or None if they can.

    Without a worker that claims runs, the run waits for one and is not refused; so it does while
    programs are being installed that uploads may need.
    """
    return upload_refusals(session, [language], settings)[language]


def upload_refusals(
    session: Session, languages: Iterable[str], settings: Settings
) -> dict[str, str | None]:
    """Return for each language what `upload_refusal` does."""
    alive = list(session.scalars(select(Worker).where(_CLAIMS)))
    if not alive or installation.is_under_way(settings):
        return dict.fromkeys(languages)
    return {language: _refusal(language, alive, settings) for language in languages}


def _refusal(language: str, alive: Collection[Worker], settings: Settings) -> str | None:
    needed = IsolationLevel[settings.sandbox_min_level.upper()]
    isolating = [worker for worker in alive if IsolationLevel[worker.level.upper()] >= needed]
    if not isolating:
        return (
            "This service cannot run uploaded programs: none of its workers reaches the "
            f"isolation level {settings.sandbox_min_level}. Built-in controllers and trackers "
            "work. For the operator: `seamark doctor` says what is missing."
        )
    if any(language in worker.languages for worker in isolating):
        return None
    return _language_refusal(language, isolating)


def _language_refusal(language: str, workers: Collection[Worker]) -> str:
    name = finding_of(language)
    findings = (finding for worker in workers for finding in worker.findings)
    why = next((finding["why"] for finding in findings if finding["name"] == name), "")
    sentence = f"No worker of this service can run {name}"
    return f"{sentence}: {why.rstrip('.')}." if why else f"{sentence}."
