import time
from typing import Any

from sqlalchemy import update

from seamark.server.database.result_code import result_code
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from tests.cast import Backend


def _register(both: Backend, name: str, *, slots: int = 2, code: str | None = None) -> None:
    with both.database.writing() as session:
        worker = Worker(name=name, slots=slots, level="strong", languages=[], findings=[])
        worker.result_code = code
        workers.register(session, worker)


def _silence(both: Backend, name: str, seconds: float) -> None:
    """Let the last heartbeat of a worker be some seconds ago."""
    with both.database.writing() as session:
        change = update(Worker).where(Worker.name == name)
        session.execute(change.values(seen_at=time.time() - seconds))


def test_a_worker_is_alive_until_its_heartbeats_stop(backend: Backend) -> None:
    _register(backend, "a", slots=2)
    _register(backend, "b", slots=3)
    _silence(backend, "b", workers.ALIVE_S + 1)

    with backend.database.reading() as session:
        counts = workers.alive_count(session), workers.slot_count(session)
        listed = {worker.name: worker.alive for worker in workers.listed(session)}

    assert counts == (1, 2)
    assert listed == {"a": True, "b": False}


def test_a_heartbeat_brings_a_worker_back(backend: Backend) -> None:
    _register(backend, "a")
    _silence(backend, "a", workers.ALIVE_S + 1)

    with backend.database.writing() as session:
        assert workers.heartbeat(session, "a", {})

    with backend.database.reading() as session:
        assert workers.alive_count(session) == 1


def test_a_heartbeat_of_a_worker_that_is_not_listed_has_no_effect(backend: Backend) -> None:
    with backend.database.writing() as session:
        assert not workers.heartbeat(session, "a", {})

    with backend.database.reading() as session:
        assert workers.listed(session) == []


def test_a_worker_that_dies_before_the_clock_is_set_back_is_dead(both: Backend) -> None:
    _register(both, "a")
    _silence(both, "a", -3600.0)

    with both.database.reading() as session:
        assert workers.alive_count(session) == 0
        assert not any(worker.alive for worker in workers.listed(session))


def test_a_worker_that_shuts_down_or_is_dead_for_a_day_is_not_listed(backend: Backend) -> None:
    for name in ("stopped", "dead", "alive"):
        _register(backend, name)
    _silence(backend, "dead", workers.LISTED_S + 1)

    with backend.database.writing() as session:
        workers.unregister(session, "stopped")
        workers.forget_dead(session)

    with backend.database.reading() as session:
        assert [worker.name for worker in workers.listed(session)] == ["alive"]


def test_the_side_processes_of_a_worker_are_reported(both: Backend) -> None:
    _register(both, "a")

    with both.database.writing() as session:
        states = {"maintenance": workers.RUNNING, "checks": "restarting since 12:00:05"}
        workers.heartbeat(session, "a", states)

    with both.database.reading() as session:
        (status,) = workers.listed(session)
    assert status.processes == states
    assert status.broken_processes == {"checks": "restarting since 12:00:05"}


def test_a_worker_that_prepares_its_simulator_is_not_broken(both: Backend) -> None:
    _register(both, "a")
    seen = []

    for state in (workers.preparing(0, 0), workers.preparing(2, 6), workers.RUNNING):
        with both.database.writing() as session:
            workers.heartbeat(session, "a", {workers.SIMULATOR: state})
        with both.database.reading() as session:
            (status,) = workers.listed(session)
        seen.append((status.preparing, status.broken_processes))

    assert seen == [(True, {}), (True, {}), (False, {})]


def test_the_simulator_is_said_to_be_compiled_until_that_of_one_worker_is_ready(
    backend: Backend,
) -> None:
    said = []

    for states in (
        {"a": workers.preparing(0, 0)},
        {"a": workers.preparing(2, 6), "b": workers.preparing(1, 6)},
        {"a": workers.preparing(5, 6), "b": workers.RUNNING},
    ):
        for name, state in states.items():
            _register(backend, name)
            with backend.database.writing() as session:
                workers.heartbeat(session, name, {workers.SIMULATOR: state})
        with backend.database.reading() as session:
            said.append(workers.preparation(session))

    assert said[0] is not None
    assert "parts" not in said[0]
    assert said[1] is not None
    assert "2 of 6 parts are ready" in said[1]
    assert said[2] is None


def test_a_worker_that_starts_again_reports_its_side_processes_anew(both: Backend) -> None:
    _register(both, "a")
    with both.database.writing() as session:
        workers.heartbeat(session, "a", {"checks": "restarting since 12:00:05"})

    _register(both, "a")

    with both.database.reading() as session:
        (status,) = workers.listed(session)
    assert status.processes == {}


def _reports(both: Backend, name: str, *components: tuple[str, str, str]) -> None:
    """Register a worker that runs Python with these components."""
    contents = [dict(zip(("kind", "name", "version"), one, strict=True)) for one in components]
    with both.database.writing() as session:
        worker = Worker(name=name, slots=1, level="strong", languages=["python"], findings=[])
        worker.contents = {"python": contents}
        workers.register(session, worker)


def test_what_workers_differ_in_is_told_apart_from_what_all_of_them_have(backend: Backend) -> None:
    python, numpy = ("interpreter", "Python", "3.11.2"), ("library", "NumPy", "2.4.1")
    _reports(backend, "a", python, numpy)
    _reports(backend, "b", python, ("library", "NumPy", "2.4.0"), ("library", "SciPy", "1.17.0"))
    _reports(backend, "dead", ("library", "PyTorch", "9"))
    _silence(backend, "dead", workers.ALIVE_S + 1)

    with backend.database.reading() as session:
        (found,) = workers.environments(session)

    assert (found.language, found.workers) == ("python", 2)
    versions = {one.name: dict(one.versions) for one in found.components}
    assert versions == {
        "Python": {"3.11.2": 2},
        "NumPy": {"2.4.1": 1, "2.4.0": 1},
        "SciPy": {"1.17.0": 1},
    }
    everywhere = [one.name for one in found.components if one.is_everywhere(found.workers)]
    assert everywhere == ["Python"]


def test_without_a_living_worker_nothing_is_in_the_box(backend: Backend) -> None:
    _reports(backend, "dead", ("interpreter", "Python", "3.11.2"))
    _silence(backend, "dead", workers.ALIVE_S + 1)

    with backend.database.reading() as session:
        assert workers.environments(session) == []


def test_a_drained_worker_claims_no_run_until_it_is_resumed(both: Backend) -> None:
    _register(both, "a")
    both.queue("ann")
    with both.database.writing() as session:
        assert workers.drain(session, "a")
        assert not workers.drain(session, "a")
    refused, taken = both.claim("a/0"), both.claim("b/0")

    with both.database.writing() as session:
        assert workers.resume(session, "a")
    both.queue("ben")

    assert refused is None
    assert taken is not None
    assert both.claim("a/0") is not None


def test_a_drained_worker_counts_for_nobody_who_waits(backend: Backend) -> None:
    _register(backend, "a", slots=2)
    with backend.database.writing() as session:
        workers.drain(session, "a")

    with backend.database.reading() as session:
        (status,) = workers.listed(session)
        counts = workers.alive_count(session), workers.slot_count(session)

    assert (status.alive, status.claims, counts) == (True, False, (0, 0))


def test_a_worker_that_would_compute_other_results_counts_for_nobody_who_waits(
    backend: Backend,
) -> None:
    _register(backend, "old", slots=1, code="{}")
    _register(backend, "new", slots=2, code=result_code())
    _register(backend, "unknown", slots=4)  # of a version that did not report it

    with backend.database.reading() as session:
        claims = {worker.name: worker.claims for worker in workers.listed(session)}
        counts = workers.alive_count(session), workers.slot_count(session)

    assert claims == {"new": True, "old": False, "unknown": True}
    assert counts == (2, 6)


def test_the_clocks_of_the_machines_do_not_matter(both: Backend, monkeypatch: Any) -> None:
    true_time = time.time
    for name, ahead_s in (("a", 3600.0), ("b", -3600.0)):
        monkeypatch.setattr(time, "time", lambda ahead_s=ahead_s: true_time() + ahead_s)
        _register(both, name)
        with both.database.writing() as session:
            workers.heartbeat(session, name, {})
            workers.forget_dead(session)
            listed = workers.listed(session)
            alive = workers.alive_count(session)

    assert [worker.alive for worker in listed] == [True, True]
    assert alive == 2
    assert all(worker.silent_s < workers.ALIVE_S for worker in listed)


def test_a_worker_stays_drained_when_it_is_stopped_and_starts_again(both: Backend) -> None:
    _register(both, "a")
    with both.database.writing() as session:
        workers.drain(session, "a")
        workers.unregister(session, "a")
        assert not workers.heartbeat(session, "a", {})  # so that it registers when it starts
    with both.database.reading() as session:
        (stopped,) = workers.listed(session)

    _register(both, "a")

    with both.database.reading() as session:
        (started,) = workers.listed(session)
    assert (stopped.alive, started.alive) == (False, True)
    assert started.drained_at == stopped.drained_at is not None
