"""Several processes that start at once share the compilation of the simulator."""

import fcntl
import threading
from pathlib import Path

import pytest

from seamark.sim.numerics.shared_parts import run_parts


def test_a_part_that_another_process_is_at_is_loaded_last_and_after_it(tmp_path: Path) -> None:
    done: list[str] = []
    parts = {name: lambda name=name: done.append(name) for name in ("plant", "trackers", "v1")}
    with (tmp_path / "warm-up-plant.lock").open("ab") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        thread = threading.Thread(target=run_parts, args=(parts, tmp_path))
        thread.start()
        while len(done) < 2:
            thread.join(0.01)
        waiting = thread.is_alive()
        before = list(done)
        fcntl.flock(other, fcntl.LOCK_UN)
        thread.join()

    assert waiting
    assert before == ["trackers", "v1"]
    assert done == ["trackers", "v1", "plant"]


def test_without_a_folder_for_the_locks_all_parts_are_loaded(tmp_path: Path) -> None:
    done: list[str] = []
    (tmp_path / "file").write_text("")

    run_parts({"plant": lambda: done.append("plant")}, tmp_path / "file")

    assert done == ["plant"]


def test_a_part_that_fails_is_not_taken_for_loaded(tmp_path: Path) -> None:
    def fail() -> None:
        raise OSError("a texture is missing")

    with pytest.raises(OSError, match="texture"):
        run_parts({"plant": fail}, tmp_path)
