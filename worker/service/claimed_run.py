"""The run of a claim, evaluated whatever happens: nobody keeps a lease on a run that broke."""

import time
from contextlib import suppress

import structlog
from sqlalchemy.exc import SQLAlchemyError
from structlog.contextvars import bound_contextvars

from seamark.programs.failure_reasons import FailureReason, describe
from seamark.server.database.engine import DATABASE_AWAY
from seamark.server.monitoring import meters
from seamark.server.runs.data.files import StorageFailed
from seamark.server.runs.ending import results
from seamark.server.runs.ending.results import Report
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue.lost_attempts import AttemptEnd
from seamark.server.runs.queue.queue import Claim, LeaseStatus
from seamark.server.runs.record.seeds import SeedsMissing
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.worker.ipc.messages import StreamBroken
from seamark.worker.ipc.outcomes import RunOutcome, no_longer_valid
from seamark.worker.service.live_states import LivePublisher
from seamark.worker.service.run_driver import RunContext, RunDriver
from seamark.worker.service.run_lease import LeaseEnded
from seamark.worker.service.run_upload import ProgramGone
from seamark.worker.service.worker_process import ShuttingDown
from seamark.worker.zygote.client import BoxBroken, SimulatorBroken

_log = structlog.get_logger()


def evaluate_or_release(context: RunContext, claim: Claim) -> bool:
    """Evaluate a claimed run, and release it if that fails; False if the platform failed."""
    try:
        return evaluate(context, claim)
    except Exception as error:
        _log.exception("run_not_evaluated", run=claim.run_id, attempt=claim.attempt)
        end = blame(context.settings, error)
    with suppress(SQLAlchemyError), context.database.writing() as session:
        lost_attempts.release(session, claim, end, settings=context.settings)
    return False


def evaluate(context: RunContext, claim: Claim) -> bool:
    """Evaluate one claimed run and store how it ended; False if the platform failed."""
    ids = {"run": claim.run_id, "attempt": claim.attempt, "user": claim.user_id}
    with bound_contextvars(**ids, worker=claim.worker, request=claim.request_id):
        return _evaluate(context, claim)


def _evaluate(context: RunContext, claim: Claim) -> bool:
    _log.info("run_started", benchmark=claim.benchmark, kind=claim.kind)
    try:
        driver = RunDriver(context, claim)
    except (ConfigurationInvalid, KeyError) as error:  # most likely accepted by an older version
        _log.error("configuration_invalid", why=str(error))
        return _fail(context, claim, no_longer_valid(error))
    try:
        return _drive(context, driver)
    finally:
        driver.close()


def _drive(context: RunContext, driver: RunDriver) -> bool:
    """Run and store; False if the platform failed."""
    started_at = time.monotonic()
    try:
        report = driver.run()
        stored = driver.store(report)
        if not stored and driver.lease.cancelled():  # meanwhile
            driver.store_cancelled()
    except LeaseEnded as ended:
        _log.info("run_stopped", why=ended.status.name.lower())
        if ended.status is LeaseStatus.CANCELLED:
            driver.store_cancelled()
        else:
            meters.LEASES_LOST.inc()
        return True
    except (ShuttingDown, SeedsMissing) as stopped:
        driver.lease.release(AttemptEnd.SHUTDOWN)
        return isinstance(stopped, ShuttingDown)
    except (SimulatorBroken, StreamBroken, ProgramGone) as broken:
        _log.error("evaluation_broke", why=str(broken))
        meters.BOX_FAILURES.inc(isinstance(broken, BoxBroken))
        driver.lease.release(blame(context.settings, broken))
        return False
    except StorageFailed as failed:
        _log.error("storage_failed", why=str(failed))
        driver.make_room()
        driver.lease.release(AttemptEnd.STORAGE_FAILED)
        driver.remove_stored()
        return False
    except DATABASE_AWAY as away:  # the lease ends, and the run is repeated
        _log.error("database_away", why=str(away))
        return False
    seconds = round(time.monotonic() - started_at, 3)
    _log.info("run_ended", state=report.state, cause=report.cause, stored=stored, wall_s=seconds)
    return True


def blame(settings: Settings, error: Exception) -> AttemptEnd:
    """Return why an attempt ended by an error: without the storage no run has a chance."""
    if isinstance(error, OSError):  # also if the storage is back by now
        return AttemptEnd.STORAGE_FAILED
    away = storage.worker_refusal(settings, share=storage.STOP_SHARE)
    return AttemptEnd.STORAGE_FAILED if away else AttemptEnd.EVALUATION_BROKE


def _fail(context: RunContext, claim: Claim, outcome: RunOutcome) -> bool:
    """End a run that cannot start; a retry would not help and no program is to blame."""
    cause = outcome.failure or FailureReason.BENCHMARK_ERROR
    detail = describe(cause, sentence=outcome.sentence)
    detail |= {"traceback": "", "log_tail": "", "t_reached": 0.0}
    report = Report(state=RunState.FAILED, cause=cause, detail=detail, progress=0.0)
    with context.database.writing() as session:
        stored = results.finish(session, claim, report)
    if stored:
        live = LivePublisher(context.redis, claim.run_id)
        live.state(report.state, progress=0.0, t_simulated=0.0)
    return True
