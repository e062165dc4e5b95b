"""From a claim to a stored result: drives one simulation and stores what comes of it."""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import structlog
from redis import Redis
from sqlalchemy.orm import Session

from seamark.programs import parameters
from seamark.programs.parameters import Parameter
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import DEFAULT_LANGUAGE
from seamark.server.database import data_folder
from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.monitoring import meters
from seamark.server.runs.data.files import RunFiles, StorageFailed
from seamark.server.runs.ending import first_results, results
from seamark.server.runs.ending.results import Report
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.columns import Part
from seamark.server.runs.record.seeds import SeedsMissing
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.sim import registry
from seamark.worker.evaluation.job import Job, PartProgram
from seamark.worker.ipc.outcomes import RunOutcome
from seamark.worker.service import run_report
from seamark.worker.service.live_states import LivePublisher
from seamark.worker.service.run_lease import Progress, RunLease
from seamark.worker.service.run_recorder import RunRecorder
from seamark.worker.service.run_upload import RunUpload, fetched_program
from seamark.worker.zygote.client import Simulation, Simulator, SimulatorBroken

START_STALL_S = 600.0  # [s] the very first start compiles the simulator
STALL_S = 90.0  # [s] without a message from a simulation that has started
STORE_AWAY_S = 600.0  # [s] that the object storage may be away at a stretch
STOP_UPLOAD_S = 2.0  # that a run which has ended otherwise waits for a part that is being stored
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunContext:
    """What a Celery child uses for all of its runs."""

    settings: Settings
    database: Database
    redis: "Redis"
    simulator: Simulator
    isolation: IsolationLevel
    shutting_down: Callable[[], bool]
    bridge: Path | None = None  # Unix socket at which a program connects that runs elsewhere


class RunDriver:
    """One run being evaluated."""

    def __init__(self, context: RunContext, claim: Claim) -> None:
        self._context, self._claim = context, claim
        self._claimed_at = time.monotonic()
        self._files = RunFiles(storage.workspace(context.settings), claim.run_id, claim.attempt)
        self._upload: RunUpload | None = None
        if (stored := objects.of(context.settings)) is not None:
            self._upload = RunUpload(stored, context.redis, self._files, claim.run_id)
        self._live = LivePublisher(context.redis, claim.run_id)
        benchmark = registry.benchmark(claim.benchmark)
        protocol = benchmark.protocol if claim.kind is RunKind.RANKED else None
        chosen, _ = parameters.split(claim.config)
        # The simulator's process reads the files of a user, and then the configuration.
        has_files = claim.vehicle_sha256 is not None or bool(claim.files)
        read = benchmark.restore if has_files else benchmark.read
        self._trial_s = benchmark.trial_duration_s(read(chosen))
        self._recorder = RunRecorder(
            self._files,
            trial_s=self._trial_s,
            truncate=None if self._upload is None else self._upload.truncate_rows,
            shown_trials=None if protocol is None else protocol.reference_trials,
        )
        self._isolation = context.isolation.name.lower() if _has_programs(claim) else None
        self.lease = RunLease(
            claim,
            context.database,
            self._live,
            settings=context.settings,
            shutting_down=context.shutting_down,
            progress=self._progress,
            isolation=self._isolation,
        )
        self._uploaded_bytes = 0
        self._disk_at = 0.0  # monotonic

    def run(self) -> Report:
        """Run the simulation and return its report.

        Raises
        ------
        LeaseEnded, ShuttingDown, SimulatorBroken, StreamBroken, StorageFailed, ProgramGone
            Why there is no report.
        """
        self._live.state(RunState.RUNNING, progress=0.0, t_simulated=0.0)
        self._files.remove()  # of a run that was deleted by hand and had the same number
        self._files.remove_earlier_attempts()
        if self._upload is not None:
            self._upload.start()
        with self._context.simulator.begin(self._job()) as simulation:
            outcome = simulation.run(self._recorder, lambda: self._watch(simulation))
        self._count(simulation, outcome)
        progress = 1.0 if outcome.failure is None else self._progress().done
        return run_report.of(
            self._settled(outcome),
            self._files,
            benchmark=self._claim.benchmark,
            progress=progress,
            t_simulated=self._recorder.t_simulated,
            isolation=self._isolation,
        )

    def _settled(self, outcome: RunOutcome) -> RunOutcome:
        """Show what was held back, or discard it; return what may be said of the outcome.

        Once it is shown, it counts as seen: even if the run cannot be stored after that.
        """
        if not self._recorder.holds_back:
            return outcome
        if not first_results.shows_fresh_trials(outcome.failure):
            self._recorder.discard()
            return replace(outcome, sentence="", traceback="")  # which the program could choose

        def record(session: Session) -> None:
            self.lease.require_held(session)
            digest = outcome.digest if outcome.failure is None else None
            first_results.record(session, self._claim.run_id, digest)

        self.lease.when_there(record)
        self._recorder.show()
        return outcome

    def _count(self, simulation: Simulation, outcome: RunOutcome) -> None:
        """Count how long the phases took, for monitoring; a run without rows never simulated."""
        ended_at = time.monotonic()
        started_at = simulation.started_at or ended_at
        first_rows_at = self._recorder.first_rows_at or ended_at
        meters.RUN_PHASE.labels("starting").observe(started_at - self._claimed_at)
        meters.RUN_PHASE.labels("preparing").observe(first_rows_at - started_at)
        meters.RUN_PHASE.labels("simulating").observe(ended_at - first_rows_at)
        for seconds in outcome.box_starts_s:
            meters.BOX_START.labels(self._claim.language or DEFAULT_LANGUAGE).observe(seconds)

    def store(self, report: Report) -> bool:
        """Store the report, then publish it; False if the claim is no longer valid."""
        if report.manifest is not None:
            self._files.write_json("manifest.json", report.manifest)
        if report.metrics is not None:
            self._files.write_json("metrics.json", report.metrics)
        report = replace(report, data_bytes=self._data_bytes())
        with meters.RUN_PHASE.labels("storing").time():
            self._store_files()
            stored = self._finish(report)
        if stored:
            self._live.state(report.state, progress=report.progress, t_simulated=report.t_simulated)
            if self._upload is not None:
                self._upload.remove_parts()
        return stored

    def _store_files(self) -> None:
        """Take the files to the object storage, if there is one: the result comes after them.

        Raises
        ------
        StorageFailed
            It is away, or is another one than before.
        LeaseEnded, ShuttingDown
            Meanwhile.
        """
        if self._upload is None:
            return
        mark = None
        with suppress(*DATABASE_AWAY), self._context.database.reading() as session:
            mark = data_folder.known_mark(session)
        self._upload.complete(self.lease.keep, within_s=STORE_AWAY_S, mark=mark)

    def close(self) -> None:
        """Stop the upload; what it did not take away is of no use to anybody."""
        if self._upload is not None:
            self._upload.stop(within_s=STOP_UPLOAD_S)
            self._files.remove()

    def _data_bytes(self) -> int:
        return self._files.size() + self._uploaded_bytes

    def make_room(self) -> None:
        """Remove what this attempt has recorded from this machine, perhaps for the database."""
        self._files.remove()

    def remove_stored(self) -> None:
        """Remove what this attempt has stored; a storage that is away may take its time."""
        if self._upload is not None:
            self._upload.remove()

    def _finish(self, report: Report) -> bool:
        return self.lease.when_there(lambda session: results.finish(session, self._claim, report))

    def store_cancelled(self) -> None:
        """Keep what there is of a run that its owner cancelled, and may be seen."""
        self._recorder.discard()
        t_simulated = self._recorder.t_simulated
        report = Report(
            state=RunState.CANCELLED,
            detail={"t_reached": t_simulated, "log_tail": run_report.log_tail(self._files)},
            progress=self._progress().done,
            t_simulated=t_simulated,
            isolation=self._isolation,
        )
        self.store(report)

    def _job(self) -> Job:
        claim = self._claim
        return Job(
            benchmark=claim.benchmark,
            config=claim.config,
            seeds=_seeds(claim),
            ranked=claim.kind is RunKind.RANKED,
            controller=claim.controller,
            program=self._uploaded(claim.program_sha256),
            filename=claim.program_name or "",
            language=claim.language or DEFAULT_LANGUAGE,
            parts=tuple(map(self._part, claim.parts)),
            vehicle=self._uploaded(claim.vehicle_sha256),
            files={one.setting: self._fetched(one.sha256) for one in claim.files},
            bridge=self._context.bridge,
        )

    def _part(self, part: Part) -> PartProgram:
        declared = [Parameter.from_json(one) for one in part.program_parameters or ()]
        return PartProgram(
            role=part.role,
            program=self._fetched(part.program_sha256),
            filename=part.program_name or "",
            language=part.language,
            parameters=parameters.defaults(declared),
        )

    def _uploaded(self, sha256: str | None) -> Path | None:
        """Return the file of what was uploaded for the run; None if nothing was."""
        return None if sha256 is None else self._fetched(sha256)

    def _fetched(self, sha256: str) -> Path:
        away_s = 0.0 if self._upload is None else STORE_AWAY_S
        settings = self._context.settings
        file = fetched_program(settings, sha256, self._watch_claim, within_s=away_s)
        self._uploaded_bytes += file.stat().st_size
        return file

    def _watch(self, simulation: Simulation) -> None:
        """Watch the claim; raise also if nothing happens in the simulation."""
        self._watch_claim()
        if simulation.silent_s > (STALL_S if simulation.started else START_STALL_S):
            raise SimulatorBroken(f"no message from the simulator for {simulation.silent_s:.0f} s")

    def _watch_claim(self) -> None:
        """Watch the lease, and from time to time the storage."""
        self.lease.watch()
        now = time.monotonic()
        if now >= self._disk_at:
            self._disk_at = now + self._context.settings.heartbeat_s
            self._require_storage()

    def _require_storage(self) -> None:
        """Stop while there is still room for the database to record that the run is repeated.

        While the object storage is away, the data of the run wait on this machine.
        """
        why = storage.machine_refusal(self._context.settings, share=storage.STOP_SHARE)
        if why is not None:
            raise StorageFailed(why)
        if self._upload is not None and self._upload.away_s > STORE_AWAY_S:
            raise StorageFailed(f"the object storage was away for {self._upload.away_s:.0f} s")

    def _progress(self) -> Progress:
        t_simulated = self._recorder.t_simulated
        return Progress(min(t_simulated / (self._trial_s * self._claim.trials), 1.0), t_simulated)


def _has_programs(claim: Claim) -> bool:
    return claim.program_sha256 is not None or bool(claim.parts)


def _seeds(claim: Claim) -> tuple[int, ...]:
    """Return the seed of each trial.

    Raises
    ------
    SeedsMissing
        An earlier version has inserted the run. Maintenance of a process with the key fills them
        in (`seeds.fill`).
    """
    if claim.seed is not None:
        return (claim.seed,) * claim.trials
    if claim.trial_seeds is None:
        _log.warning("seeds_missing", run=claim.run_id)
        raise SeedsMissing
    return claim.trial_seeds
