"""From a claim to a stored result: drives one simulation, minds the lease, writes what it tells."""

import time
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import structlog
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.database.engine import Database
from seamark.server.programs import store
from seamark.server.runs import door as runs
from seamark.server.runs.door import Beat, Claim, Report, RunState
from seamark.server.runs.failure_reasons import Cause, words
from seamark.server.runs.files import RunFiles
from seamark.server.runs.seeds import trial_seeds
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.settings.configuration import ConfigurationInvalid
from seamark.worker.evaluation.job import Job
from seamark.worker.ipc.messages import Frame, StreamBroken
from seamark.worker.ipc.messages import Kind as FrameKind
from seamark.worker.service.live_publisher import Broadcast
from seamark.worker.zygote.client import Simulation, Simulator, SimulatorBroken

LOOK_S = 0.4  # [s] between two looks at the cancel flag
WAIT_S = 0.2  # [s] for the simulator's next message
START_STALL_S = 600.0  # [s] the first start of all compiles the simulator
STALL_S = 90.0  # [s] without a message from a simulation that runs
LOG_TAIL = 2000  # [byte] of the log shown with a failure


class Stopping(Exception):
    """The worker shuts down: the run goes back to its place, no failure of anybody."""


class NoLonger(Exception):
    """The run is no longer ours to run: cancelled, or in other hands."""

    def __init__(self, beat: Beat) -> None:
        super().__init__(beat.name)
        self.beat = beat


@dataclass(frozen=True, slots=True, kw_only=True)
class Tools:
    """What a celery child has for its runs."""

    settings: Settings
    database: Database
    redis: "Redis"
    simulator: Simulator
    isolation: IsolationLevel
    stopping: "StopFlag"


class StopFlag(Protocol):
    """Whether the worker shuts down."""

    def is_set(self) -> bool:
        """Return whether to stop."""


def evaluate(tools: Tools, claim: Claim) -> bool:
    """Evaluate one claimed run and store how it ended; False if something of ours broke."""
    log = structlog.get_logger().bind(run=claim.run_id, attempt=claim.attempt)
    log.info("run_started", benchmark=claim.benchmark, kind=claim.kind, worker=claim.worker)
    try:
        drive = Drive(tools, claim)
    except (ConfigurationInvalid, KeyError) as wrong:  # taken in by an older version, most likely
        log.error("configuration_invalid", why=str(wrong))
        return _refuse(tools, claim, f"This configuration is no longer valid: {wrong}")
    try:
        report = drive.to_its_end()
    except NoLonger as change:
        log.info("run_stopped", why=change.beat.name.lower())
        if change.beat is Beat.CANCEL:
            drive.close_cancelled()
        return True
    except Stopping:
        drive.give_back("the worker shuts down", counts=False)
        return True
    except (SimulatorBroken, StreamBroken) as broken:
        log.error("simulator_broken", why=str(broken), traceback=drive.our_traceback)
        drive.give_back(str(broken), counts=True)
        return False
    stored = drive.store(report)
    seconds = round(time.monotonic() - drive.began, 3)
    log.info("run_ended", state=report.state, cause=report.cause, stored=stored, wall_s=seconds)
    return True


class Drive:
    """One run being evaluated."""

    def __init__(self, tools: Tools, claim: Claim) -> None:
        self.began = time.monotonic()
        self.our_traceback = ""
        self._tools, self._claim = tools, claim
        self._files = RunFiles(tools.settings.data, claim.run_id, claim.attempt)
        self._live = Broadcast(tools.redis, claim.run_id)
        benchmark = registry.benchmark(claim.benchmark)
        self._trial_s = benchmark.trial_duration_s(benchmark.read(claim.config))
        self._trial_start_row = 0
        self._t_simulated = 0.0
        self._ending: dict[str, Any] | None = None
        self._next_look = self._next_beat = 0.0
        self._heard_at = time.monotonic()

    def to_its_end(self) -> Report:
        """Run the simulation and return its report.

        Raises
        ------
        NoLonger, Stopping, SimulatorBroken
            Why there is no report.
        """
        self._live.state(RunState.RUNNING, progress=0.0, t_simulated=0.0)
        with self._tools.simulator.begin(self._job()) as simulation:
            while self._ending is None:
                for frame in simulation.read(WAIT_S):
                    self._heard_at = time.monotonic()
                    self._take(frame)
                    if self._ending is not None:
                        break
                self._mind(simulation)
        return self._report(self._ending)

    def store(self, report: Report) -> bool:
        """Store the report, then tell those who watch; False if the claim is no longer valid."""
        if report.manifest is not None:
            self._files.write_json("manifest.json", report.manifest)
        if report.metrics is not None:
            self._files.write_json("metrics.json", report.metrics)
        with self._tools.database.writing() as session:
            stored = runs.finish(session, self._claim, report)
        if stored:
            self._live.flush()
            self._live.state(report.state, progress=report.progress, t_simulated=report.t_simulated)
            self._live.end()
        return stored

    def close_cancelled(self) -> None:
        """Keep what there is of a run that its owner cancelled."""
        report = Report(
            state=RunState.CANCELLED,
            detail={"t_reached": self._t_simulated, "log_tail": self._log_tail()},
            progress=self._progress(),
            t_simulated=self._t_simulated,
            isolation=self._isolation(),
        )
        self.store(report)

    def give_back(self, why: str, *, counts: bool) -> None:
        """Put the run back to its place in the line, or fail it for good."""
        with self._tools.database.writing() as session:
            state = runs.give_back(
                session, self._claim, why, counts=counts, settings=self._tools.settings
            )
        if state is not None:
            self._live.state(state, progress=0.0, t_simulated=0.0)
        if state is RunState.FAILED:
            self._live.end()

    def _job(self) -> Job:
        claim, settings = self._claim, self._tools.settings
        program = claim.program_sha256
        return Job(
            benchmark=claim.benchmark,
            config=claim.config,
            seeds=tuple(map(trial_seeds(claim, settings), range(claim.trials))),
            shown_seed=claim.seed,
            controller=claim.controller,
            program=None if program is None else store.path(settings.data, program),
            filename=claim.program_name or "",
            language=claim.language or "python",
        )

    def _take(self, frame: Frame) -> None:
        """Keep what the simulation tells."""
        match frame.kind:
            case FrameKind.ROWS:
                self._take_rows(frame.payload)
            case FrameKind.LOG:
                self._files.append_log(frame.payload)
                self._live.log(frame.payload)
            case FrameKind.TRIAL:
                self._trial_start_row = self._files.row_count()
            case FrameKind.CUT:
                self._files.cut_rows(self._trial_start_row)
                self._say(f"[Trial {frame.json()['trial'] + 1} is done again: the host was slow.]")
            case FrameKind.ENDING:
                self._ending = frame.json()
            case FrameKind.ERROR:
                self.our_traceback = frame.payload.decode("utf-8", "replace")

    def _take_rows(self, payload: bytes) -> None:
        rows = np.frombuffer(payload, "<f8").reshape(-1, self._files.width)
        self._files.append_rows(rows)
        self._t_simulated = float(rows[-1, 0]) * self._trial_s + float(rows[-1, 2])
        self._live.rows(rows)

    def _say(self, line: str) -> None:
        text = f"{line}\n".encode()
        self._files.append_log(text)
        self._live.log(text)

    def _mind(self, simulation: Simulation) -> None:
        """Renew the lease, notice a cancel, a shutdown and a simulator that hangs."""
        if self._tools.stopping.is_set():
            raise Stopping
        now = time.monotonic()
        if now >= self._next_beat:
            self._next_beat = now + self._tools.settings.heartbeat_s
            self._next_look = now + LOOK_S
            self._obey(self._beat())
        elif now >= self._next_look:
            self._next_look = now + LOOK_S
            with self._tools.database.reading() as session:
                self._obey(runs.look(session, self._claim))
        silent = now - self._heard_at
        if silent > (STALL_S if simulation.begun else START_STALL_S):
            raise SimulatorBroken(f"the simulator was silent for {silent:.0f} s")

    def _beat(self) -> Beat:
        with self._tools.database.writing() as session:
            beat = runs.heartbeat(
                session,
                self._claim,
                progress=self._progress(),
                t_simulated=self._t_simulated,
                isolation=self._isolation(),
            )
        self._live.state(RunState.RUNNING, progress=self._progress(), t_simulated=self._t_simulated)
        return beat

    def _obey(self, beat: Beat) -> None:
        if beat is not Beat.CONTINUE:
            raise NoLonger(beat)

    def _progress(self) -> float:
        return min(self._t_simulated / (self._trial_s * self._claim.trials), 1.0)

    def _isolation(self) -> str | None:
        return self._tools.isolation.name.lower() if self._claim.program_sha256 else None

    def _log_tail(self) -> str:
        return self._files.log_text()[-LOG_TAIL:]

    def _report(self, ending: dict[str, Any]) -> Report:
        """Translate how the simulation ended into what is stored and shown."""
        succeeded = ending["verdict"] == "ok"
        detail: dict[str, Any] = {"usage": ending["usage"]}
        if not succeeded:
            detail |= words(Cause(ending["verdict"]), sentence=ending["sentence"])
            detail |= {"traceback": ending["traceback"], "log_tail": self._log_tail()}
            detail["t_reached"] = self._t_simulated
        return Report(
            state=RunState.SUCCEEDED if succeeded else RunState.FAILED,
            cause=None if succeeded else ending["verdict"],
            detail=detail,
            metrics=ending["metrics"],
            manifest=ending["manifest"],
            digest=ending["digest"],
            progress=1.0 if succeeded else self._progress(),
            t_simulated=self._t_simulated,
            isolation=self._isolation(),
        )


def _refuse(tools: Tools, claim: Claim, sentence: str) -> bool:
    """End a run that cannot begin; trying again would not help and no program is to blame."""
    detail = words(Cause.BENCHMARK_ERROR, sentence=sentence)
    report = Report(
        state=RunState.FAILED,
        cause=Cause.BENCHMARK_ERROR,
        detail=detail | {"traceback": "", "log_tail": "", "t_reached": 0.0},
        progress=0.0,
    )
    with tools.database.writing() as session:
        stored = runs.finish(session, claim, report)
    if stored:
        live = Broadcast(tools.redis, claim.run_id)
        live.state(report.state, progress=0.0, t_simulated=0.0)
        live.end()
    return True
