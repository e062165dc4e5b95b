"""What a watched run records reaches its viewers on another machine before it is stored."""

import asyncio
from collections.abc import Callable, Coroutine, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from redis import Redis

from seamark.server.messaging import broker, live_data
from seamark.server.runs.data.files import HEAD_MAX, RunFiles
from seamark.server.storage import storage
from seamark.server.web.streams import listener
from seamark.server.web.streams.hub import Hub
from seamark.worker.service import run_upload
from seamark.worker.service.run_upload import RunUpload
from tests.cast import Backend
from tests.services import s3, tables
from tests.services.machines import Machines, numbered_rows
from tests.services.viewer import DEADLINE_S, Viewer

NEVER_S = 3600.0


class Watched(Machines):
    """A run that a worker records on one machine, and viewers on the other."""

    def __init__(self, folder: Path, shared: dict[str, Any]) -> None:
        super().__init__(folder, shared)
        self.database = tables.create(self.web)
        claim = Backend.with_cast(self.database, self.web).running("ann")
        self.run_id, self.attempt = claim.run_id, claim.attempt
        self.redis = broker.connect(self.web)

    def begin(self) -> tuple[RunFiles, RunUpload]:
        return self.recording(self.run_id, self.attempt)

    def hub(self) -> Hub:
        return Hub(self.database, self.web)

    def published(self, channel: Any) -> list[live_data.Piece]:
        """Return the pieces of telemetry that were published."""
        found = list[live_data.Piece]()
        while (message := channel.get_message(timeout=0.2)) is not None:
            if message["type"] == "message":
                found += live_data.parse(message["data"]).pieces[:1]
        return [piece for piece in found if piece.content]


@pytest.fixture
def watched(
    tmp_path: Path, database_url: str, redis_url: str, s3_server: s3.Server, monkeypatch: Any
) -> Iterator[Watched]:
    """A running run whose parts are never stored, unless a test says so."""
    monkeypatch.setattr(run_upload, "PART_EVERY_S", NEVER_S)
    monkeypatch.setattr(listener, "BROKER_RETRY_S", 0.05)
    shared = s3_server.settings(tmp_path.name) | {"secret_key": "only-for-tests"}
    places = {"database_url": database_url, "broker_url": redis_url}
    made = Watched(tmp_path, shared | places)
    yield made
    made.database.close()
    made.redis.close()


def _watch(test: Callable[[], Coroutine[Any, Any, None]], *viewers: Viewer) -> None:
    """Run a test while viewers watch."""

    async def watching() -> None:
        tasks = [asyncio.create_task(viewer.watch()) for viewer in viewers]
        try:
            async with asyncio.timeout(2 * DEADLINE_S):
                await test()
        finally:
            for task in tasks:
                task.cancel()
                with suppress(asyncio.CancelledError):
                    await task

    asyncio.run(watching())
    for viewer in viewers:
        viewer.hub.close()


async def _until(holds: Callable[[], object]) -> None:
    async with asyncio.timeout(DEADLINE_S):
        while not holds():
            await asyncio.sleep(0.02)


def _times(rows: int) -> Any:
    return [round(0.05 * row, 2) for row in range(rows)]


@pytest.mark.slow
def test_a_viewer_sees_rows_and_log_before_anything_is_stored(watched: Watched) -> None:
    viewer = Viewer(watched.hub(), watched.run_id)
    files, upload = watched.begin()

    async def test() -> None:
        files.append_rows(numbered_rows(0, 10))
        files.append_log(b"one\n")
        await _until(lambda: viewer.log() == "one\n" and len(viewer.times()) == 10)
        files.append_rows(numbered_rows(10, 10))
        files.append_log(b"two\n")
        await _until(lambda: viewer.log() == "one\ntwo\n" and len(viewer.times()) == 20)

    _watch(test, viewer)
    upload.stop()

    assert viewer.times() == _times(20)
    assert watched.parts(watched.run_id) == 0


@pytest.mark.slow
def test_the_end_of_a_long_log_is_seen_before_it_is_stored(watched: Watched) -> None:
    viewer = Viewer(watched.hub(), watched.run_id)
    files, upload = watched.begin()
    files.append_log(b"x" * (HEAD_MAX + 100_000))

    async def test() -> None:
        await viewer.receives("log")
        files.append_log(b"the end")
        await _until(lambda: viewer.log().endswith("the end"))

    _watch(test, viewer)
    upload.stop()


@pytest.mark.slow
def test_what_is_lost_on_the_way_is_healed_and_nothing_is_seen_twice(
    watched: Watched, monkeypatch: Any
) -> None:
    monkeypatch.setattr(run_upload, "PART_EVERY_S", 0.5)
    viewer = Viewer(watched.hub(), watched.run_id)
    files, upload = watched.begin()

    async def test() -> None:
        for row in range(60):
            files.append_rows(numbered_rows(row, 1))
            if row in (20, 40):  # what is published now is for nobody
                watched.redis.client_kill_filter(_type="pubsub")
            await asyncio.sleep(0.02)
        await _until(lambda: viewer.times()[-1:] == _times(60)[-1:])

    _watch(test, viewer)
    upload.stop()

    copied = watched.read(watched.run_id)
    assert copied.rows().tolist() == numbered_rows(0, 60).tolist()
    assert viewer.times() == sorted(set(viewer.times()))


@pytest.mark.slow
def test_rows_that_a_trial_takes_back_are_replaced_for_viewers(watched: Watched) -> None:
    viewer = Viewer(watched.hub(), watched.run_id)
    files, upload = watched.begin()

    async def test() -> None:
        files.append_rows(numbered_rows(0, 30))
        await _until(lambda: watched.read(watched.run_id).row_count() == 30)
        upload.truncate_rows(10)
        files.append_rows(numbered_rows(10, 5, value=1.0))
        await _until(lambda: watched.read(watched.run_id).row_count() == 15)

    _watch(test, viewer)
    upload.stop()

    assert watched.read(watched.run_id).rows()[:, 5].tolist() == [0.0] * 10 + [1.0] * 5


@pytest.mark.slow
def test_everything_is_published_once_whatever_the_number_of_viewers_and_web_processes(
    watched: Watched,
) -> None:
    hubs = [watched.hub() for _ in range(3)]
    viewers = [Viewer(hub, watched.run_id) for hub in hubs for _ in range(5)]
    files, upload = watched.begin()
    channel: Any = watched.redis.pubsub()  # type: ignore[no-untyped-call]

    async def test() -> None:
        files.append_rows(numbered_rows(0, 10))
        await _until(lambda: all(len(viewer.times()) == 10 for viewer in viewers))
        await asyncio.sleep(2 * listener.ASK_S)  # until nobody asks for what was before any more
        channel.subscribe(live_data.channel(watched.run_id))
        for row in range(10, 30):
            files.append_rows(numbered_rows(row, 1))
            await asyncio.sleep(0.05)
        await _until(lambda: all(len(viewer.times()) == 30 for viewer in viewers))

    _watch(test, *viewers)
    upload.stop()

    sizes = [(piece.offset, len(piece.content)) for piece in watched.published(channel)]
    assert sum(size for _, size in sizes) == numbered_rows(10, 20).nbytes
    assert sizes[0][0] == numbered_rows(0, 10).nbytes


@pytest.mark.slow
def test_a_run_that_nobody_watches_is_not_published_and_leaves_nothing_in_the_broker(
    watched: Watched,
) -> None:
    viewer = Viewer(watched.hub(), watched.run_id)
    files, upload = watched.begin()
    channel: Any = watched.redis.pubsub()  # type: ignore[no-untyped-call]
    channel.subscribe(live_data.channel(watched.run_id))
    files.append_rows(numbered_rows(0, 10))
    unwatched = watched.published(channel)

    async def test() -> None:
        await _until(lambda: len(viewer.times()) == 10)

    _watch(test, viewer)
    (key,) = watched.redis.keys("*")
    left_s = watched.redis.ttl(key)
    watched.redis.expire(key, 0)
    going_on, row = True, 10
    while going_on and row < 300:  # until the worker knows that the viewers have gone
        files.append_rows(numbered_rows(row, 1))
        going_on, row = bool(watched.published(channel)), row + 1
    files.append_rows(numbered_rows(row, 10))
    afterwards = watched.published(channel)
    upload.stop()

    assert unwatched == afterwards == []
    assert 0 < left_s <= live_data.WATCHED_S
    assert watched.redis.keys("*") == []


@pytest.mark.slow
def test_a_run_ends_while_the_broker_is_away(watched: Watched) -> None:
    nowhere = Redis(unix_socket_path="/nothing/here")
    files = RunFiles(storage.workspace(watched.worker), 9, 1)
    upload = RunUpload(watched.stored, nowhere, files, 9)
    upload.start()
    files.append_rows(numbered_rows(0, 10))

    upload.complete(lambda: None, within_s=10.0)

    assert watched.read(9, 1).row_count() == 10
