"""An object storage that hangs or fails costs nobody more than a few seconds."""

import threading
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from seamark.server.settings import Settings
from seamark.server.storage import objects
from seamark.server.storage.objects import MARK, Objects, ObjectsAway
from tests.services import faulty_s3, s3
from tests.services.faulty_s3 import Behaviour, FaultyS3

PATIENCE_S = 40.0  # less than a request that writes may take


@pytest.fixture
def storage(s3_server: s3.Server) -> Iterator[FaultyS3]:
    with faulty_s3.in_front_of(s3_server.endpoint) as proxy:
        yield proxy


@pytest.fixture
def stored(storage: FaultyS3, s3_server: s3.Server, tmp_path: Path, monkeypatch: Any) -> Objects:
    """The objects of a service, with a short limit for what is read."""
    monkeypatch.setattr(objects, "SILENCE", timedelta(seconds=1))
    shared = s3_server.settings(tmp_path.name) | {"storage_endpoint": storage.endpoint}
    found = objects.of(Settings.model_validate(shared | {"data": tmp_path}))
    assert found is not None
    found.put(MARK, b"mine")
    return found


def _in_time(ask: Callable[[], object]) -> list[object]:
    """Return what asking gives, in a list; fail if it takes as long as the storage hangs."""
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.append(ask()), daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    return found


@pytest.mark.slow
def test_a_storage_with_the_mark_answers_and_one_without_does_not(
    stored: Objects, s3_server: s3.Server, tmp_path: Path
) -> None:
    other = s3_server.settings(f"{tmp_path.name}-other")
    empty = objects.of(Settings.model_validate(other | {"data": tmp_path}))

    assert empty is not None
    assert (stored.answers(), empty.answers()) == (True, False)


@pytest.mark.slow
@pytest.mark.parametrize("behaviour", ["answers errors", "hangs"])
def test_nobody_who_asks_whether_a_storage_answers_waits_until_it_does(
    stored: Objects, storage: FaultyS3, behaviour: Behaviour, monkeypatch: Any
) -> None:
    before = stored.answers()
    monkeypatch.setattr(objects, "PROBE_S", 0.0)  # what was found is old at once
    storage.behave(behaviour)

    found = _in_time(lambda: [stored.answers() for _ in range(3)])

    assert (before, found) == (True, [[False] * 3])


@pytest.mark.slow
def test_what_was_found_just_now_is_told_without_a_look(stored: Objects, storage: FaultyS3) -> None:
    first = stored.answers()
    storage.behave("hangs")

    assert (first, stored.answers(), storage.asked) == (True, True, 0)


@pytest.mark.slow
def test_a_storage_that_hangs_ends_what_is_read_from_it(stored: Objects, storage: FaultyS3) -> None:
    storage.behave("hangs")

    def read() -> str:
        try:
            return str(stored.get(MARK))
        except ObjectsAway:
            return "away"

    assert _in_time(read) == ["away"]
