"""Many runs under one fault, injected again and again, and what became of them."""

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import cycle
from typing import Any

import httpx
from numpy.random import default_rng
from sqlalchemy import func, select
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.database.tables import Check, Result, Run
from seamark.server.messaging import broker
from seamark.server.programs import check_queue
from seamark.server.runs.data import stored_files
from seamark.server.runs.record.states import FINAL, RunState
from seamark.sim.recording.telemetry import digest
from seamark.worker.evaluation.local import evaluate_locally
from tests.cast import USERS
from tests.chaos.faults import Fault
from tests.chaos.installation import Installation
from tests.worker.conftest import wait_until
from tests.worker.processes import command_line

SEED = 3
BUILT_IN = {"levels": [0.0, 0.2], "level_duration_s": 60.0, "settle_s": 1.0}
UPLOADED = {"levels": [0.0, 0.2], "level_duration_s": 8.0, "settle_s": 1.0}
PROGRAM = b"""
class Controller:
    def __init__(self, config):
        self.kp, self.limit = config["kp"], config["reference_limit_m_s"]
    def reset(self, level):
        pass
    def step(self, observation):
        u, v = (min(max(self.kp * e, -self.limit), self.limit) for e in observation.error[:2])
        return [u, v, 0.0, 0.0]
"""
UPLOADS = 4  # one of so many runs is of an uploaded program
POLL_S = 0.25
VISIT_S = 0.5  # a page takes more CPU time than all other looks
COMMAND_MAX = 120  # [characters] to print
# A process that had just been started sees that its parent has gone when its modules are loaded.
ORPHANS_S = 40.0
STUCK_S = 180.0  # without any run that ends: the campaign is given up


@dataclass
class Findings:
    """What a campaign has shown."""

    injected: int = 0
    too_late: int = 0  # of the first of each: all runs had ended
    attempts: int = 0  # of the run that needed most
    seconds: float = 0.0
    standstill_s: float = 0.0  # the longest time in which no run ended
    wrong: list[str] = field(default_factory=list)  # runs and checks, with what is wrong
    pages_broken: int = 0
    left: list[str] = field(default_factory=list)  # processes that lost their part of the service

    @property
    def problems(self) -> list[str]:
        """What must not happen, in words."""
        found = list(self.wrong)
        found += [f"{self.pages_broken} pages broken"] if self.pages_broken else []
        found += [f"left: {command}" for command in self.left]
        return found


class Campaign:
    """Runs under one fault."""

    def __init__(
        self, installation: Installation, runs: int, seed: int, *, pause_max_s: float = 2.0
    ) -> None:
        self._installation = installation
        self._service = installation.service
        self._chance, self._pause_max_s = default_rng(seed), pause_max_s
        self._wanted = self._submit(runs)
        self._checks: list[int] = []
        self._over, self._progress = threading.Event(), threading.Event()
        self.findings = Findings()

    def run(self, *faults: Fault) -> Findings:
        """Inject the faults in turn until all runs have ended, then look at what there is."""
        turn = cycle(faults)
        started_at = time.monotonic()
        watchers = [threading.Thread(target=each) for each in (self._watch, self._visit)]
        for watcher in watchers:
            watcher.start()
        while not self._over.wait(self._chance.uniform(0.0, self._pause_max_s)) or (
            self.findings.injected < len(faults)
        ):
            self._order_check()
            self._progress.clear()
            self.findings.too_late += self._over.is_set() and self.findings.injected < len(faults)
            next(turn)(self._installation, self._chance)
            self.findings.injected += 1
            # A service that never comes to anything before the next fault would show nothing.
            while not self._over.is_set() and not self._progress.wait(POLL_S):
                pass
        for watcher in watchers:
            watcher.join()
        self.findings.seconds = time.monotonic() - started_at
        self._compare()
        self._wait_for_checks()
        self._count_orphans()
        return self.findings

    @property
    def wanted(self) -> Mapping[int, str]:
        """The runs, with the digest that each has when nothing disturbs it."""
        return self._wanted

    def _submit(self, runs: int) -> dict[int, str]:
        """Queue the runs; return run -> the digest that it has when nothing disturbs it."""
        program = self._service.store_program(PROGRAM)
        built_in = evaluate_locally("currents-v1", BUILT_IN, seed=SEED, controller="pi").digest
        uploaded = evaluate_locally("currents-v1", UPLOADED, seed=SEED, controller="p").digest
        wanted = {}
        for number in range(runs):
            who = USERS[number % len(USERS)]  # one alone would never have all places
            if number % UPLOADS:
                wanted[self._service.queue(who, config=BUILT_IN, seed=SEED)] = built_in
            else:
                order: dict[str, Any] = {"controller": "upload", "program": program}
                wanted[self._service.queue(who, config=UPLOADED, seed=SEED, **order)] = uploaded
        broker.send_tickets(self._service.app, runs)
        return wanted

    def _watch(self) -> None:
        """Measure standstills, until all runs have ended or none does any more."""
        ended, ended_at = -1, time.monotonic()
        while ended < len(self._wanted):
            now, count = time.monotonic(), self._ended()
            self.findings.standstill_s = max(self.findings.standstill_s, now - ended_at)
            if count is not None and count > ended:
                ended, ended_at = count, now
                self._progress.set()
            if now - ended_at > STUCK_S:
                break
            time.sleep(POLL_S)
        self._over.set()

    def _ended(self) -> int | None:
        """Return how many runs have ended; None while the database is away."""
        mine = select(func.count()).where(Run.id.in_(self._wanted), Run.state.in_(FINAL))
        try:
            with self._service.database.reading() as session:
                return session.scalar(mine) or 0
        except SQLAlchemyError:
            return None

    def _visit(self) -> None:
        """Read pages, as a proxy in front of both web servers would: from one or the other."""
        with httpx.Client(timeout=30.0) as client:
            while not self._over.wait(VISIT_S):
                answers = [self._status(client, port) for port in self._installation.ports]
                self.findings.pages_broken += min(answers) >= 500 and 503 not in answers

    @staticmethod
    def _status(client: httpx.Client, port: int) -> int:
        try:
            return client.get(f"http://127.0.0.1:{port}/").status_code
        except httpx.TransportError:
            return 599

    def _order_check(self) -> None:
        """Order a check, unless the previous one has not been answered."""
        try:
            with self._service.database.writing() as session:
                user_id, program = (
                    self._service.user_id("ann"),
                    self._service.store_program(PROGRAM),
                )
                check_id = check_queue.enqueue(session, user_id, "currents-v1", {}, program)
        except (check_queue.CheckRefused, SQLAlchemyError, OSError):
            return
        self._checks.append(check_id)
        check_queue.wake_worker(self._service.redis)

    def _wait_for_checks(self) -> None:
        """The last check is answered; earlier ones may have been replaced in the queue."""

        def answers() -> list[Mapping[str, object]]:
            with self._service.database.reading() as session:
                mine = select(Check.answer).where(Check.id.in_(self._checks[-1:]))
                return [answer for answer in session.scalars(mine) if answer is not None]

        if self._checks:
            wait_until(answers)
            self.findings.wrong += [f"check: {a['problems']}" for a in answers() if not a["ok"]]

    def _compare(self) -> None:
        results = select(Result.run_id, func.count()).group_by(Result.run_id)
        with self._service.database.reading() as session:
            count = {run_id: number for run_id, number in session.execute(results)}
        for run_id, wanted in self._wanted.items():
            view = self._service.show(run_id)
            self.findings.attempts = max(self.findings.attempts, view.attempt)
            if view.state is not RunState.SUCCEEDED:
                self.findings.wrong.append(f"run {run_id}: {view.state} {view.cause}")
            elif count[run_id] != 1 or view.digest != wanted:
                self.findings.wrong.append(f"run {run_id}: another result")
            elif digest(stored_files.of_run(self._service.settings, view).rows()) != wanted:
                self.findings.wrong.append(f"run {run_id}: another file")

    def _count_orphans(self) -> None:
        deadline = time.monotonic() + ORPHANS_S
        while self._installation.orphans() and time.monotonic() < deadline:
            time.sleep(POLL_S)
        left = map(command_line, self._installation.orphans())
        self.findings.left = [each.replace(b"\0", b" ").decode()[:COMMAND_MAX] for each in left]
