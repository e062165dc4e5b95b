"""The maintenance process of each worker: recovers runs of dead workers, deletes old data.

    python -s -P -m seamark.worker.service.maintenance <parent>

A process of its own and not a Celery task: tasks wait while all children are busy with long runs.
Of many workers three are on duty (`Duty`); the others look only whether they are needed.
"""

import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import structlog
from celery import Celery
from redis import Redis

from seamark.server.accounts import audit
from seamark.server.database.engine import DATABASE_AWAY, Database
from seamark.server.judging import finals
from seamark.server.messaging import broker
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring import log, meters
from seamark.server.monitoring.outages import Outage
from seamark.server.programs import check_queue, store
from seamark.server.runs.data.disk_usage import measure_if_old
from seamark.server.runs.data.retention import Sweep, trim
from seamark.server.runs.data.retention_pass import RetentionPass
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.record import seeds
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.worker.service.duty import Duty
from seamark.worker.service.lease_watch import LeaseWatch
from seamark.worker.service.live_states import announce
from seamark.worker.service.worker_process import are_restricted, follow_worker

FORGET_EVERY_S = 3600.0
SWEEP_EVERY_S = 30.0
TRIM_EVERY_S = 60.0
COMPLETE_EVERY_S = 60.0
VERIFY_EVERY_S = 60.0
PASS_EVERY_S = 2.0  # between the steps of a pass that an admin has asked for
MEASURE_EVERY_S = 30.0
# More than the role of a worker may do (seamark.server.database.worker_role).
NEEDS_ALL_RIGHTS = (
    *("advance_competitions", "delete_accounts", "forget_audit", "retention_pass"),
    "verify_first",
)
# In a thread of their own: what waits for a storage that hangs holds up no recovery.
RECOVERS = ("recover_runs", "recover_checks")
RECOVERY = "recovery"
BROKER_S = 2.0  # that a recovery waits for a broker that hangs, with each command
JOIN_S = 2.0
# Which workers of other machines do without.
NEEDS_SEED_KEY = ("advance_competitions", "fill_seeds", "verify_first")
_log = structlog.get_logger()


@dataclass(slots=True)
class PeriodicTask:
    """An action that is repeated; it runs for the first time one period after the start."""

    name: str
    period_s: float
    action: Callable[[], None]
    due_at: float = 0.0  # monotonic
    outage: Outage = field(init=False)

    def __post_init__(self) -> None:
        """Schedule the first time."""
        self.postpone()
        self.outage = Outage("database", task=self.name)
        meters.MAINTENANCE_FAILURES.labels(self.name)

    @property
    def is_due(self) -> bool:
        """Whether it has to run now."""
        return time.monotonic() >= self.due_at

    def postpone(self) -> None:
        """Let it be due one period from now."""
        self.due_at = time.monotonic() + self.period_s


def next_due_in_s(tasks: Sequence[PeriodicTask]) -> float:
    """Return how long nothing is due [s]."""
    return max(min(task.due_at for task in tasks) - time.monotonic(), 0.0)


def run_due(tasks: Sequence[PeriodicTask], *, on_duty: Callable[[], bool]) -> bool:
    """Run what is due, if this process is on duty; otherwise another one does.

    A failure is logged, and stops neither the other tasks nor the next time. Returns whether
    anything ran.
    """
    due = [task for task in tasks if task.is_due]
    for task in due:
        task.postpone()
    if not due or not on_duty():
        return False
    for task in due:
        try:
            with meters.MAINTENANCE_SECONDS.labels(task.name).time():
                task.action()
            task.outage.over()
        except Exception as error:
            meters.MAINTENANCE_FAILURES.labels(task.name).inc()
            if isinstance(error, DATABASE_AWAY):
                task.outage.failed(error)
            else:
                _log.exception("maintenance_failed", task=task.name)
    return True


class Recoverer:
    """Returns to their queues what dead workers have left."""

    def __init__(self, app: Celery, database: Database, redis: "Redis", settings: Settings) -> None:
        self._app, self._database, self._redis, self._settings = app, database, redis, settings
        self._runs, self._checks = (
            LeaseWatch(lease_s=settings.lease_s, renewal_s=settings.heartbeat_s) for _ in range(2)
        )

    def recover_runs(self) -> None:
        """Return runs to the queue, publish that, and add missing tickets."""
        with self._database.reading() as session:
            leases = lost_attempts.leases(session)
        abandoned = self._runs.abandoned(leases, now_s=time.monotonic())
        with self._database.writing() as session:
            recovery = lost_attempts.recover(session, abandoned, self._settings)
        announce(self._app, self._redis, recovery)
        with self._database.writing() as session:  # whatever it waits for, the runs do not
            lost_attempts.tidy(session)

    def recover_checks(self) -> None:
        """Return checks to the queue, and forget old ones."""
        with self._database.reading() as session:
            leases = check_queue.leases(session)
        abandoned = self._checks.abandoned(leases, now_s=time.monotonic())
        with self._database.writing() as session:
            check_queue.recover(session, abandoned)


def forget_programs(database: Database, settings: Settings) -> None:
    """Delete old programs that neither a run nor a check refers to."""

    def used(sha256: str) -> bool:
        with database.reading() as session:
            return check_queue.refers_to(session, sha256)

    count = store.delete_unused(settings, used=used)
    if count:
        _log.info("programs_forgotten", count=count)


def complete_leaderboards(database: Database) -> None:
    """Compute the rows that an earlier version stored in part."""
    with database.writing() as session:
        count = best_runs.complete(session)
    if count:
        _log.info("leaderboards_completed", users=count)


def verify_first(app: Celery, database: Database, settings: Settings) -> None:
    """Queue verifications of the first entries of each leaderboard."""
    if not settings.verify_top or storage.is_away(settings):
        return
    with database.writing() as session:
        queued = verifications.request_first(session, settings)
    if queued:
        _log.info("verifications_queued", count=len(queued))
        broker.send_tickets(app, len(queued))


def fill_seeds(database: Database, settings: Settings) -> None:
    """Give runs their seeds that an earlier version has inserted without them."""
    with database.writing() as session:
        count = seeds.fill(session, settings)
    if count:
        _log.info("seeds_filled", runs=count)


def advance_competitions(app: Celery, database: Database, settings: Settings) -> None:
    """Decide the rounds that have ended, and add batches to finals."""
    if storage.is_away(settings):
        return
    with database.reading() as session:
        due = finals.undecided(session)
    for competition_id in due:
        with database.writing() as session:
            queued = finals.advance(session, competition_id, settings)
        broker.send_tickets(app, queued)


def forget_audit(database: Database, settings: Settings) -> None:
    """Delete a batch of old entries of the audit log."""
    with database.writing() as session:
        audit.forget_old(session, settings.audit_days)


def delete_accounts(database: Database, settings: Settings) -> None:
    """Delete a batch of the runs of closed accounts."""
    if not storage.is_away(settings) and account_deletion.step(database, settings):
        _log.info("account_deletion_step")


def by_rights(
    tasks: Sequence[PeriodicTask], *, all_rights: bool, key: bool
) -> dict[str, list[PeriodicTask]]:
    """Return what a process can do: recovery, and the rest by the rights or the seed key it needs.

    Parameters
    ----------
    all_rights, key
        Whether this process has them.
    """
    chosen: dict[str, list[PeriodicTask]] = {RECOVERY: [], "": [], "all": [], "seeds": []}
    for task in tasks:
        if task.name in RECOVERS:
            chosen[RECOVERY].append(task)
            continue
        needs_rights, needs_key = task.name in NEEDS_ALL_RIGHTS, task.name in NEEDS_SEED_KEY
        if (all_rights or not needs_rights) and (key or not needs_key):
            chosen["seeds" if needs_key else "all" if needs_rights else ""].append(task)
    return chosen


def carry_out(
    duties: Mapping[str, Sequence[PeriodicTask]],
    redis: "Redis",
    stopping: threading.Event,
    shared: SharedMeters,
    *,
    kept_s: float,
) -> None:
    """Run tasks when they are due, until the worker shuts down.

    Parameters
    ----------
    duties
        Kind -> its tasks. Each kind has holders of its own: those of the common tasks may all be
        restricted.
    shared
        One for the whole process: it counts everything since the last time.
    kept_s
        How long a duty outlasts the silence of its holder.
    """
    held = [(Duty(redis, kind, kept_s=kept_s), tasks) for kind, tasks in duties.items()]
    ours = [task for tasks in duties.values() for task in tasks]
    while not stopping.wait(next_due_in_s(ours)):
        if any([run_due(tasks, on_duty=duty.is_mine) for duty, tasks in held]):
            shared.add()
    for duty, _ in held:
        duty.give_up()


def maintain(
    duties: Mapping[str, Sequence[PeriodicTask]],
    redis: "Redis",
    impatient: "Redis",
    stopping: threading.Event,
    shared: SharedMeters,
    *,
    kept_s: float,
) -> None:
    """Carry out recovery in a thread of its own, and the rest in this one.

    Parameters
    ----------
    impatient
        The broker as recovery asks it.
    shared
        From before the tasks were made: their meters are there from the first time on, at zero.
    """
    recovery = {RECOVERY: duties[RECOVERY]}
    rest = {kind: tasks for kind, tasks in duties.items() if kind != RECOVERY}
    recovers = threading.Thread(
        target=carry_out,
        args=(recovery, impatient, stopping, shared),
        kwargs={"kept_s": kept_s},
        daemon=True,
    )
    recovers.start()
    carry_out(rest, redis, stopping, shared, kept_s=kept_s)
    recovers.join(JOIN_S)


def main(parent: str) -> None:
    """Be the maintenance process of one worker."""
    stopping = follow_worker(int(parent))
    settings = Settings.load()
    log.configure(settings.log_level)
    app, redis = broker.celery_app(settings), broker.connect(settings)
    impatient = broker.connect(settings, timeout_s=BROKER_S)
    shared = SharedMeters(impatient)
    database, recovery_s = Database(settings.database_url), settings.sweep_s
    recoverer = Recoverer(app, database, impatient, settings)
    tasks = [
        PeriodicTask("recover_runs", recovery_s, recoverer.recover_runs),
        PeriodicTask("recover_checks", recovery_s, recoverer.recover_checks),
        PeriodicTask(
            "forget_programs", FORGET_EVERY_S, lambda: forget_programs(database, settings)
        ),
        PeriodicTask("sweep_data", SWEEP_EVERY_S, Sweep(database, settings).step),
        PeriodicTask(
            "complete_leaderboards", COMPLETE_EVERY_S, lambda: complete_leaderboards(database)
        ),
        PeriodicTask("fill_seeds", recovery_s, lambda: fill_seeds(database, settings)),
        PeriodicTask("verify_first", VERIFY_EVERY_S, lambda: verify_first(app, database, settings)),
        PeriodicTask(
            "advance_competitions",
            recovery_s,
            lambda: advance_competitions(app, database, settings),
        ),
        PeriodicTask("delete_accounts", SWEEP_EVERY_S, lambda: delete_accounts(database, settings)),
        PeriodicTask("forget_audit", FORGET_EVERY_S, lambda: forget_audit(database, settings)),
        PeriodicTask("trim_data", TRIM_EVERY_S, lambda: trim(database, settings)),
        PeriodicTask("retention_pass", PASS_EVERY_S, RetentionPass(database, settings).step),
        PeriodicTask("measure_disk", MEASURE_EVERY_S, lambda: measure_if_old(database, settings)),
    ]
    restricted = are_restricted(database, stopping)
    duties = by_rights(tasks, all_rights=not restricted, key=settings.derives_seeds)
    maintain(duties, redis, impatient, stopping, shared, kept_s=3 * recovery_s)


if __name__ == "__main__":
    main(*sys.argv[1:])
