import asyncio
from collections.abc import AsyncIterator, Coroutine
from contextlib import asynccontextmanager, suppress
from typing import Any

import pytest
from redis import Redis

from seamark.server.messaging import live_events
from seamark.server.runs.ending import cancellation
from seamark.server.runs.record.states import RunState
from seamark.server.web.streams.feed import TICK_S
from seamark.server.web.streams.hub import Hub
from tests.server.web.streams.conftest import Recording
from tests.server.web.streams.test_access_watch import revoke, token
from tests.services.viewer import DEADLINE_S, Viewer


def run(test: Coroutine[Any, Any, None]) -> None:
    """Run a test on an event loop."""
    asyncio.run(asyncio.wait_for(test, 2 * DEADLINE_S))


@asynccontextmanager
async def watching(*viewers: Viewer) -> AsyncIterator[None]:
    """Let viewers watch until the block ends."""
    tasks = [asyncio.create_task(viewer.watch()) for viewer in viewers]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task


async def _ended(*viewers: Viewer) -> None:
    async with asyncio.timeout(DEADLINE_S):
        await asyncio.gather(*(viewer.watch() for viewer in viewers))


@pytest.mark.slow
def test_all_viewers_receive_the_same_bytes_made_once(recording: Recording, hub: Hub) -> None:
    viewers = [Viewer(hub, recording.run_id) for _ in range(50)]

    async def test() -> None:
        async with watching(*viewers):
            for viewer in viewers:
                await viewer.receives("state")
            for _ in range(3):
                received = len(viewers[0].events("telemetry"))
                recording.record(20)
                for viewer in viewers:
                    await viewer.receives("telemetry", received + 1)

    run(test())

    pieces = [[id(piece) for piece in viewer.pieces if b"telemetry" in piece] for viewer in viewers]
    assert len(pieces[0]) >= 3
    assert all(mine == pieces[0] for mine in pieces)


@pytest.mark.slow
def test_a_fast_run_sends_no_more_than_twenty_kilobytes_a_second(
    recording: Recording, hub: Hub
) -> None:
    viewer = Viewer(hub, recording.run_id)
    ticks = 8

    async def test() -> None:
        async with watching(viewer):
            for number in range(ticks):
                recording.record(5000)
                recording.files.append_log(b"chatty " * 2000)
                await viewer.receives("log", number + 1)

    run(test())

    sent = [len(piece) for piece in viewer.pieces if b"event: state" not in piece]
    assert sum(sent) <= 60_000 + ticks * TICK_S * 20_000


def test_a_viewer_without_the_right_to_the_log_sees_none_of_it(
    recording: Recording, hub: Hub
) -> None:
    owner, stranger = (Viewer(hub, recording.run_id, shows_log=shows) for shows in (True, False))
    recording.files.append_log(b"before\n")

    async def test() -> None:
        async with watching(owner, stranger):
            await owner.receives("log")
            recording.record(3)
            recording.files.append_log(b"after\n")
            await owner.receives("log", 2)
            await stranger.receives("telemetry")

    run(test())

    assert owner.log() == "before\nafter\n"
    assert stranger.events("log") == []


def test_a_viewer_who_joins_late_sees_the_newest_trial_and_then_what_follows(
    recording: Recording, hub: Hub
) -> None:
    first, late = Viewer(hub, recording.run_id), Viewer(hub, recording.run_id)
    recording.record(20, trial=0)
    recording.record(10, trial=1)

    async def test() -> None:
        async with watching(first):
            await first.receives("telemetry")
            async with watching(late):
                await late.receives("telemetry")
                recording.record(5, trial=1)
                await late.receives("telemetry", 2)

    run(test())

    assert late.times() == pytest.approx([0.05 * row for row in range(20, 35)])


def test_a_viewer_who_resumes_misses_nothing_and_sees_nothing_twice(
    recording: Recording, hub: Hub
) -> None:
    first = Viewer(hub, recording.run_id)
    second = Viewer(hub, recording.run_id)

    async def test() -> None:
        async with watching(first):
            recording.record(10)
            recording.files.append_log(b"one\n")
            await first.receives("log")
        recording.record(10)
        recording.files.append_log(b"two\n")
        second.after = first.last_id
        async with watching(second):
            await second.receives("log")
            recording.record(10)
            await second.receives("telemetry", 2)

    run(test())

    assert first.times() + second.times() == pytest.approx([0.05 * row for row in range(30)])
    assert first.log() + second.log() == "one\ntwo\n"


def test_a_viewer_from_another_process_that_was_ahead_sees_nothing_twice(
    recording: Recording, hub: Hub
) -> None:
    other, ahead = Viewer(hub, recording.run_id), Viewer(hub, recording.run_id, after="1-25-0")

    async def test() -> None:
        recording.record(10)
        async with watching(other):
            await other.receives("telemetry")
            recording.record(20)
            async with watching(ahead):
                await ahead.receives("telemetry")

    run(test())

    assert ahead.times() == pytest.approx([0.05 * row for row in range(25, 30)])


@pytest.mark.slow
def test_a_viewer_who_does_not_read_is_dropped_and_can_resume(recording: Recording) -> None:
    hub = Hub(recording.database, recording.settings, waiting_max=20_000)
    reader, sleeper = Viewer(hub, recording.run_id), Viewer(hub, recording.run_id)

    async def test() -> None:
        recording.record(1)
        sleeper.gone = asyncio.get_running_loop().create_future()
        stream = hub.follow(
            recording.run_id, None, shows_log=True, gone=sleeper.gone, abort=sleeper.abort
        )
        sleeper.pieces.append(await anext(stream))
        async with watching(reader):
            while not sleeper.aborted:
                received = len(reader.events("telemetry"))
                recording.record(20)
                await reader.receives("telemetry", received + 1)
        await stream.aclose()

    run(test())
    resumed = Viewer(hub, recording.run_id, after=sleeper.last_id)

    async def resume() -> None:
        async with watching(resumed):
            await resumed.receives("telemetry")

    run(resume())

    assert not reader.aborted
    assert resumed.times()[-1] == reader.times()[-1]
    hub.close()


def test_the_end_of_a_run_comes_after_its_last_rows(recording: Recording, hub: Hub) -> None:
    viewer = Viewer(hub, recording.run_id)

    async def test() -> None:
        watched = asyncio.create_task(_ended(viewer))
        await viewer.receives("state")
        recording.record(30)
        assert recording.cancel(recording.run_id)
        with Redis.from_url(recording.settings.broker_url) as redis:
            live_events.publish_state(redis, recording.run_id, RunState.CANCELLED)
        await watched

    run(test())

    assert viewer.times()[-1] == pytest.approx(0.05 * 29)
    assert viewer.events("state")[-1]["state"] == "cancelled"
    assert viewer.pieces[-1] == b"event: end\ndata: {}\n\n"


def test_viewers_of_a_queued_run_learn_at_once_that_it_was_cancelled(
    recording: Recording, hub: Hub
) -> None:
    run_id = recording.queue("ann")
    viewer = Viewer(hub, run_id)

    async def test() -> None:
        watched = asyncio.create_task(_ended(viewer))
        await viewer.receives("state")
        with Redis.from_url(recording.settings.broker_url) as redis:
            await asyncio.to_thread(cancellation.cancel, recording.database, redis, run_id)
        await watched

    run(test())

    states = [state["state"] for state in viewer.events("state")]
    assert (states[0], states[-1]) == ("queued", "cancelled")


@pytest.mark.slow
def test_streams_go_on_while_the_broker_is_away(recording: Recording) -> None:
    nowhere = recording.settings.model_copy(update={"broker_url": "unix:///nothing/here"})
    hub = Hub(recording.database, nowhere)
    viewer = Viewer(hub, recording.run_id)

    async def test() -> None:
        watched = asyncio.create_task(_ended(viewer))
        recording.record(10)
        await viewer.receives("telemetry")
        assert recording.cancel(recording.run_id)
        await watched

    run(test())
    hub.close()

    assert viewer.events("state")[-1]["state"] == "cancelled"


def test_all_streams_end_when_the_process_stops_and_none_begins(
    recording: Recording, hub: Hub
) -> None:
    viewers = [Viewer(hub, recording.run_id) for _ in range(3)]

    async def test() -> None:
        watched = asyncio.create_task(_ended(*viewers))
        for viewer in viewers:
            await viewer.receives("state")
        hub.end_all()
        await watched
        await Viewer(hub, recording.run_id).watch()

    run(test())

    assert all(viewer.events("end") == [] for viewer in viewers)  # so that they connect again


def test_nothing_keeps_running_at_whatever_moment_the_process_stops(recording: Recording) -> None:
    async def stop_after(steps: int) -> None:
        hub = Hub(recording.database, recording.settings)
        before = asyncio.all_tasks()
        watching = asyncio.create_task(Viewer(hub, recording.run_id).watch())
        for _ in range(steps):
            await asyncio.sleep(0)
        started = asyncio.all_tasks() - before
        hub.end_all()
        watching.cancel()
        _, running = await asyncio.wait(started, timeout=DEADLINE_S / 4)
        hub.close()
        assert not running, f"after {steps} steps: {running}"

    async def test() -> None:
        for steps in range(2, 32, 2):  # the listener connects in about so many
            await stop_after(steps)

    run(test())


def test_a_stream_beyond_the_limit_ends_at_once(recording: Recording) -> None:
    hub = Hub(recording.database, recording.settings.model_copy(update={"streams_max": 1}))
    first, second = Viewer(hub, recording.run_id), Viewer(hub, recording.run_id)

    async def test() -> None:
        async with watching(first):
            await first.receives("state")
            await _ended(second)
            assert hub.full

    run(test())
    hub.close()

    assert second.pieces == []
    assert hub.open_streams == 0


@pytest.mark.slow
def test_the_streams_of_a_token_end_when_it_is_revoked_and_no_others(
    recording: Recording, hub: Hub
) -> None:
    with recording.database.writing() as session:
        made = [token(session, recording.user_id(name)) for name in ("ben", "eva")]
    ben, eva = (Viewer(hub, recording.run_id, credential=one) for one in made)
    guest = Viewer(hub, recording.run_id)

    async def test() -> None:
        async with watching(eva, guest):
            task = asyncio.create_task(ben.watch())
            for viewer in (ben, eva, guest):
                await viewer.receives("state")
            with recording.database.writing() as session:
                revoke(session, recording.user_id("ben"))
            async with asyncio.timeout(DEADLINE_S):
                await task
            for viewer in (eva, guest):
                received = len(viewer.events("telemetry"))
                recording.record(20)
                await viewer.receives("telemetry", received + 1)

    run(test())
