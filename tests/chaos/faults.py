"""Faults of a service: a function injects one and returns when it is over.

`chance`, a seeded generator, decides when and where; how far a run has come by then differs.
"""

import os
import resource
import signal
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

from numpy.random import Generator
from sqlalchemy import update
from sqlalchemy.orm import Session

from seamark.server.database.engine import IDLE_S, Database
from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import broker
from seamark.server.runs.queue import queue
from seamark.server.runs.record.states import LIVE, RunState
from tests.chaos.installation import CHECK_LOOP, MAINTENANCE, Installation
from tests.services.faulty_s3 import Behaviour

Fault = Callable[[Installation, Generator], None]
HOUR_S = 3600.0
ERRORS_S, HANG_S = 25.0, 100.0
WORKING_S = 30.0  # that an object storage works between two faults
TICKETS_MAX = 1000


def kill_worker(service: Installation, chance: Generator) -> None:
    """SIGKILL of a worker's main process."""
    service.restart_worker(service.ready_worker(chance), signal.SIGKILL)


def stop_worker(service: Installation, chance: Generator) -> None:
    """SIGTERM of a worker, which is then replaced: a rolling restart."""
    service.restart_worker(service.ready_worker(chance), signal.SIGTERM)


def kill_pool_child(service: Installation, chance: Generator) -> None:
    """SIGKILL of the process of the pool."""
    worker = service.workers[service.ready_worker(chance)].pid
    _kill(service.pool_child(worker))


def kill_simulator(service: Installation, chance: Generator) -> None:
    """SIGKILL of the process that evaluates a run."""
    at = service.ready_worker(chance)
    if _none_has_broken(service):
        _kill(service.simulator_child(service.workers[at].pid))


def kill_maintenance(service: Installation, chance: Generator) -> None:
    """SIGKILL of the maintenance process of each worker."""
    _kill_everywhere(service, chance, MAINTENANCE)


def kill_check_process(service: Installation, chance: Generator) -> None:
    """SIGKILL of the check process of each worker."""
    _kill_everywhere(service, chance, CHECK_LOOP)


def kill_web_server(service: Installation, chance: Generator) -> None:
    """SIGKILL of one of the web servers."""
    service.restart_web_server(_web_server(service, chance), signal.SIGKILL)


def stop_web_server(service: Installation, chance: Generator) -> None:
    """SIGTERM of one of the web servers, which is then replaced."""
    service.restart_web_server(_web_server(service, chance), signal.SIGTERM)


def kill_broker(service: Installation, chance: Generator) -> None:
    """SIGKILL of the broker, which is away for a while."""
    service.broker.kill()
    time.sleep(chance.uniform(0.1, 5.0))
    service.broker.start()


def pause_broker(service: Installation, chance: Generator) -> None:
    """SIGSTOP of the broker: it accepts connections and answers nothing."""
    assert service.broker.pid is not None
    os.kill(service.broker.pid, signal.SIGSTOP)
    time.sleep(chance.uniform(5.0, 20.0))
    os.kill(service.broker.pid, signal.SIGCONT)


def several(service: Installation, chance: Generator) -> None:
    """A worker dies while a machine vanishes in a claim and the broker hangs."""
    faults = (kill_worker, vanish_in_claim, pause_broker)
    service.ready_worker(chance)
    with ThreadPoolExecutor(len(faults)) as threads:
        chances = chance.spawn(len(faults))
        pairs = zip(faults, chances, strict=True)
        injected = [threads.submit(fault, service, each) for fault, each in pairs]
    for future in injected:
        future.result()


def flush_broker(service: Installation, chance: Generator) -> None:
    """FLUSHALL: all tickets and live events are lost."""
    service.service.redis.flushall()


def confuse_tickets(service: Installation, chance: Generator) -> None:
    """Tickets that come twice, late and in another order."""
    redis, keys = service.service.redis, broker.ticket_keys(service.service.app)
    tickets = [(key, ticket) for key in keys for ticket in redis.lrange(key, 0, -1)]
    for key in keys:
        redis.delete(key)
    time.sleep(chance.uniform(0.1, 1.0))
    copies_max = 3 if len(tickets) < TICKETS_MAX else 1  # copies of copies would fill the broker
    for at in chance.permutation(len(tickets)):
        key, ticket = tickets[at]
        redis.rpush(key, *[ticket] * int(chance.integers(1, copies_max + 1)))


def pause_worker(service: Installation, chance: Generator) -> None:
    """SIGSTOP of all processes of a worker, until its leases have passed to another one."""
    at = service.ready_worker(chance)
    processes = Installation.processes(service.workers[at].pid, "")
    _signal(processes, signal.SIGSTOP)
    time.sleep(1.5 * service.settings.lease_s)
    _signal(processes, signal.SIGCONT)


def vanish_in_claim(service: Installation, chance: Generator) -> None:
    """A machine claims a run and is not heard of again: no commit, and no end of its connection."""
    machine = Database(service.settings.database_url)
    name, settings = "gone/0", service.settings
    with Session(machine.engine) as session:
        if queue.try_claim(session, name, languages=("python",), settings=settings) is not None:
            time.sleep(IDLE_S + chance.uniform(0.0, 2.0))
        session.invalidate()
    machine.close()


def restart_database(service: Installation, chance: Generator) -> None:
    """PostgreSQL is stopped, cleanly or not, is away for a while, and is started again."""
    service.database.stop((signal.SIGINT, signal.SIGQUIT)[chance.integers(2)])
    time.sleep(chance.uniform(0.0, 3.0))
    service.database.start()


def take_storage_away(service: Installation, chance: Generator) -> None:
    """The data folder is away for a while, as when a network storage is not mounted."""
    data = service.settings.data
    away = data.with_suffix(".away")
    data.rename(away)
    time.sleep(chance.uniform(0.1, 3.0))
    away.rename(data)


def fill_disk(service: Installation, chance: Generator) -> None:
    """For a while no file of a worker can grow: its writes fail as on a full disk."""
    pids = service.processes(service.workers[service.ready_worker(chance)].pid, "")
    _limit_file_size(pids, 4096)
    time.sleep(chance.uniform(0.1, 3.0))
    _limit_file_size(pids, resource.RLIM_INFINITY)


def jump_clock(service: Installation, chance: Generator) -> None:
    """All clocks jump by an hour: what was written before is an hour older, or in the future."""
    jump_s = (-HOUR_S, HOUR_S)[chance.integers(2)]
    with service.service.database.writing() as session:
        leases = update(Run).where(Run.state == RunState.RUNNING)
        session.execute(leases.values(lease_until=Run.lease_until - jump_s))
        session.execute(update(Worker).values(seen_at=Worker.seen_at - jump_s))


def fail_objects(service: Installation, chance: Generator) -> None:
    """The object storage answers 500 for a while."""
    _disturb_objects(service, "answers errors", ERRORS_S)


def hang_objects(service: Installation, chance: Generator) -> None:
    """The object storage accepts connections and answers nothing, for longer than leases last."""
    _disturb_objects(service, "hangs", HANG_S)


FAULTS: Mapping[str, Fault] = {
    "worker killed": kill_worker,
    "pool child killed": kill_pool_child,
    "simulator killed": kill_simulator,
    "maintenance killed": kill_maintenance,
    "check process killed": kill_check_process,
    "web server killed": kill_web_server,
    "web server stopped": stop_web_server,
    "broker killed": kill_broker,
    "broker paused": pause_broker,
    "broker flushed": flush_broker,
    "tickets confused": confuse_tickets,
    "worker paused past its lease": pause_worker,
    "machine vanishes in a claim": vanish_in_claim,
    "several at once": several,
    "database restarted": restart_database,
    "storage away": take_storage_away,
    "disk full": fill_disk,
    "clock jumps": jump_clock,
    "worker stopped": stop_worker,
}
# Of a service with object storage; none of them may cost a run its attempt.
OBJECT_FAULTS: Mapping[str, Fault] = {
    "object storage answers errors": fail_objects,
    "object storage hangs": hang_objects,
}


def _web_server(service: Installation, chance: Generator) -> int:
    return int(chance.integers(len(service.web_servers)))


def _disturb_objects(service: Installation, behaviour: Behaviour, seconds: float) -> None:
    assert service.objects is not None
    service.objects.behave(behaviour)
    time.sleep(seconds)
    service.objects.behave("works")
    time.sleep(WORKING_S)


def _none_has_broken(service: Installation) -> bool:
    """Return whether no live run has broken yet: the third time, it fails for good."""
    with service.service.database.reading() as session:
        broken = session.query(Run).where(Run.state.in_(LIVE), Run.failures > 0)
        return not broken.count()


def _kill_everywhere(service: Installation, chance: Generator, module: str) -> None:
    service.ready_worker(chance)
    for worker in service.workers:
        _signal(service.processes(worker.pid, module)[:1], signal.SIGKILL)


def _limit_file_size(pids: list[int], size: int) -> None:
    for pid in pids:
        with suppress(ProcessLookupError, PermissionError):  # boxes belong to other users
            _soft, hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)
            resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, hard))


def _kill(pid: int | None) -> None:
    _signal([] if pid is None else [pid], signal.SIGKILL)


def _signal(pids: list[int], number: signal.Signals) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):  # it ended meanwhile
            os.kill(pid, number)
