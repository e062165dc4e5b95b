"""The host of a worker: what it can enforce and run, probed once at the worker's start."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from typing import Any, Self

import structlog
from sqlalchemy.orm import Session

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.probing.kept_tests import KeptTests
from seamark.sandbox.probing.probes import Finding, IsolationReport, probe
from seamark.sandbox.probing.self_test import Component, Result
from seamark.server.database.engine import Database
from seamark.server.database.result_code import result_code
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.settings import Settings
from seamark.worker.evaluation.cores import new_locks
from seamark.worker.evaluation.worker_slot import NO_MOTHER, WorkerSlot

# A user has one check at a time, so that one whose program sleeps never holds both.
CHECK_PROCESSES = 2
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Host:
    """One worker's host. `languages` are those of the uploads that it can run.

    `contents` is what programs in each of them find in their boxes.
    """

    settings: Settings
    name: str
    isolation: IsolationLevel
    findings: tuple[Finding, ...]
    languages: tuple[str, ...]
    core_locks: int = field(default_factory=new_locks)
    contents: Mapping[str, Sequence[Component]] = field(default_factory=dict)
    mother: int = NO_MOTHER

    @classmethod
    def probe(cls, settings: Settings, *, name: str) -> Self:
        """Probe what this host can enforce and run."""
        report = probe()
        tried = _try_languages(report, settings)
        contents = {name: one.contents for name, one in tried.items() if not one.why_not}
        missing = tuple(
            _finding(language, one.why_not) for language, one in tried.items() if one.why_not
        )
        findings = report.findings + missing
        host = cls(settings, name, report.level, findings, tuple(contents), contents=contents)
        _log.info(
            "worker_starting", worker=name, isolation=host.isolation.name, languages=host.languages
        )
        return host

    def slot(self, index: int) -> WorkerSlot:
        """Return the slot of one process of the pool."""
        cores = sorted(os.sched_getaffinity(0))
        shared = tuple(cores[: self.settings.workers])
        return self._slot(
            cores[index % len(cores)], shared_cores=shared, core_locks=self.core_locks
        )

    def side_process_commands(self) -> dict[str, list[str]]:
        """Return the processes beside the pool: name -> what `nursery.spawn` takes."""
        commands = {"maintenance": ["-m", "seamark.worker.service.maintenance"]}
        if self.settings.mail_url:
            commands["mail"] = ["-m", "seamark.worker.service.mail_sender"]
        if self.languages:
            cores = sorted(os.sched_getaffinity(0), reverse=True)
            for number in range(CHECK_PROCESSES):
                process, slot = f"checks-{number + 1}", self._slot(cores[number % len(cores)])
                arguments = [f"{self.name}/{process}", slot.to_json()]
                commands[process] = ["-m", "seamark.worker.service.check_loop", *arguments]
        for number in range(self.settings.bridge_places):
            process = f"bridges-{number + 1}"
            commands[process] = [
                "-m",
                "seamark.worker.service.bridge_loop",
                f"{self.name}/{process}",
                str(self.mother),
            ]
        return commands

    def heartbeat(self, processes: dict[str, str]) -> None:
        """Report that this worker is alive, with the state of each process."""
        states = processes | {workers.SIMULATOR: self._simulator_state()}
        with self._writing() as session:
            if not workers.heartbeat(session, self.name, states):
                # It has just started, or was silent for so long that others have forgotten it.
                workers.register(session, self._row())
                workers.heartbeat(session, self.name, states)

    def _simulator_state(self) -> str:
        """Return whether a run can start now: the first start of all compiles the simulator."""
        cores = self.slot(0).cores()
        return workers.RUNNING if cores.any_warm() else workers.preparing(*cores.parts())

    def unregister(self) -> None:
        """Remove this worker from the database."""
        with self._writing() as session:
            workers.unregister(session, self.name)

    def _slot(self, core: int, **cores: Any) -> WorkerSlot:
        # A host that runs no uploads starts no box.
        isolation = self.isolation if self.languages else IsolationLevel.NONE
        return WorkerSlot(
            isolation,
            core,
            languages=self.languages,
            warm_boxes=self.settings.warm_boxes,
            mother=self.mother,
            **cores,
        )

    def _row(self) -> Worker:
        return Worker(
            name=self.name,
            slots=self.settings.workers,
            level=self.isolation.name.lower(),
            version=version("seamark"),
            result_code=result_code(),
            languages=list(self.languages),
            findings=[asdict(finding) for finding in self.findings],
            contents={
                language: [asdict(component) for component in components]
                for language, components in self.contents.items()
            },
        )

    @contextmanager
    def _writing(self) -> Iterator[Session]:
        """Give a session, and close its connection: the pool forks, and must not inherit it."""
        database = Database(self.settings.database_url)
        try:
            with database.writing() as session:
                yield session
        finally:
            database.close()


def _try_languages(report: IsolationReport, settings: Settings) -> dict[str, Result]:
    """Return the result of each language's self-test; none if isolation is too weak."""
    if report.level < IsolationLevel[settings.sandbox_min_level.upper()]:
        return {}
    tests = KeptTests(report.level)
    tried = {name: tests.result(name) for name in LANGUAGES}
    for name, result in tried.items():
        if result.why_not:
            _log.warning("language_missing", language=name, why=result.why_not)
    return tried


def _finding(language: str, why: str) -> Finding:
    remedy = f"{LANGUAGES[language].remedy}, then restart the worker"
    return Finding(workers.finding_of(language), ok=False, why=why, remedy=remedy)
