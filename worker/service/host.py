"""What the host of a worker can enforce, found out once at the worker's start."""

import os
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import structlog

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.probing import self_test
from seamark.sandbox.probing.probes import probe
from seamark.sandbox.probing.report import Finding, IsolationReport
from seamark.server import workers
from seamark.server.database.engine import Database
from seamark.server.database.tables import Worker
from seamark.server.settings import Settings
from seamark.worker.evaluation.cores import new_locks
from seamark.worker.evaluation.job import Place

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Host:
    """One worker's host. `languages` are those of the uploads that it may run."""

    settings: Settings
    name: str
    isolation: IsolationLevel
    findings: tuple[Finding, ...]
    languages: tuple[str, ...]
    core_locks: int = field(default_factory=new_locks)

    @classmethod
    def look(cls, settings: Settings, *, name: str) -> Self:
        """Try what this host can enforce and write it down for the web pages."""
        report = probe()
        tried = _tried(report, settings)
        languages = tuple(one for one, why in tried.items() if not why)
        missing = tuple(_finding(one, why) for one, why in tried.items() if why)
        findings = report.findings + missing
        host = cls(settings, name, report.level, findings, languages)
        host._enlist()
        _log.info(
            "worker_starting", worker=name, isolation=host.isolation.name, languages=host.languages
        )
        return host

    @property
    def box_isolation(self) -> IsolationLevel:
        """The level at which boxes are made; none where uploads are not run."""
        return self.isolation if self.languages else IsolationLevel.NONE

    def place(self, index: int) -> Place:
        """Return where the runs of one process of the pool are at home."""
        cores = sorted(os.sched_getaffinity(0))
        share = tuple(cores[: self.settings.workers])
        home = cores[index % len(cores)]
        return self._place(home, share=share, locks=self.core_locks)

    def _place(self, core: int, **facts: Any) -> Place:
        warm_boxes = self.settings.warm_boxes
        return Place(self.box_isolation, core, warm=self.languages, warm_boxes=warm_boxes, **facts)

    def supervise(self) -> None:
        """Start what works beside the pool: who sweeps and says that this worker lives; checks."""
        _start("seamark.worker.service.supervise", self.name)
        if self.languages:
            last = max(os.sched_getaffinity(0))
            place = self._place(last)
            _start("seamark.worker.service.check_loop", place.to_text(), ",".join(self.languages))

    def leave(self) -> None:
        """Take this worker off the list."""
        database = Database(self.settings.database_url)
        with database.writing() as session:
            workers.unregister(session, self.name)
        database.close()

    def _enlist(self) -> None:
        database = Database(self.settings.database_url)
        with database.writing() as session:
            workers.register(
                session,
                Worker(
                    name=self.name,
                    slots=self.settings.workers,
                    level=self.isolation.name.lower(),
                    languages=list(self.languages),
                    findings=[asdict(finding) for finding in self.findings],
                ),
            )
        database.close()  # before the pool forks: connections must not be shared


def _start(module: str, *arguments: str) -> None:
    command = [sys.executable, "-s", "-P", "-m", module, *arguments]
    subprocess.Popen(command, stdin=subprocess.DEVNULL)


def _tried(report: IsolationReport, settings: Settings) -> dict[str, str]:
    """Return each language with why it cannot be run here, empty if it can; none if too open."""
    if report.level < IsolationLevel[settings.sandbox_min_level.upper()]:
        return {}
    tried = {name: self_test.why_not(name, report.level) for name in LANGUAGES}
    for name, why in tried.items():
        if why:
            _log.warning("language_missing", language=name, why=why)
    return tried


def _finding(language: str, why: str) -> Finding:
    remedy = f"{LANGUAGES[language].remedy}, then restart the worker"
    return Finding(workers.finding_of(language), ok=False, why=why, remedy=remedy)
