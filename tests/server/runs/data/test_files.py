import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from seamark.sandbox.printable_text import printable_text
from seamark.server.runs.data import files
from seamark.server.runs.data.files import HEAD_MAX, TAIL_MAX, RunFiles, StorageFailed
from seamark.sim.recording.telemetry import INDEX, WIDTH, names, width_for
from tests.services.full_disk import files_end_at


def _rows(count: int, start: int = 0) -> files.Rows:
    return np.arange(start * WIDTH, (start + count) * WIDTH, dtype=np.float64).reshape(count, WIDTH)


def test_rows_can_be_read_while_they_are_written(tmp_path: Path) -> None:
    writer, reader = RunFiles(tmp_path, 7, 1), RunFiles(tmp_path, 7, 1)
    assert reader.rows().shape == (0, WIDTH)

    writer.append_rows(_rows(3))
    assert np.array_equal(reader.rows(), _rows(3))
    writer.append_rows(_rows(2, start=3))

    assert np.array_equal(reader.rows(), _rows(5))
    assert np.array_equal(reader.rows(1, 4), _rows(5)[1:4])
    assert reader.rows(9).shape == (0, WIDTH)


def test_an_incomplete_row_is_not_read(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    files.append_rows(_rows(2))

    with files.telemetry_path.open("ab") as file:
        file.write(b"half a row")

    assert np.array_equal(files.rows(), _rows(2))


@pytest.mark.parametrize("width", [WIDTH - 1, WIDTH + 1])
def test_rows_of_another_width_than_the_first_ones_are_refused(tmp_path: Path, width: int) -> None:
    files = RunFiles(tmp_path, 7, 1)
    files.append_rows(_rows(1))

    with pytest.raises(ValueError, match="shape"):
        files.append_rows(np.zeros((1, width)))


def test_rows_with_too_few_columns_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="shape"):
        RunFiles(tmp_path, 7, 1).append_rows(np.zeros((1, WIDTH - 1)))


def test_rows_of_a_vehicle_with_more_thrusters_keep_all_of_them(tmp_path: Path) -> None:
    rows = np.arange(2.0 * (WIDTH + 3)).reshape(2, WIDTH + 3)
    RunFiles(tmp_path, 7, 1).append_rows(rows)

    files = RunFiles(tmp_path, 7)

    assert files.columns[-3:] == ("thrust_8", "thrust_9", "thrust_10")
    assert np.array_equal(files.rows(), rows)


@pytest.mark.parametrize(
    "kinds",
    [
        *((), ("detections",), ("route",), ("route", "detections"), ("dock",)),
        *(("dock", "detections"), ("arm",), ("arm", "work"), ("arm", "work", "search")),
    ],
)
@pytest.mark.parametrize("thrusters", [6, 11])
def test_rows_of_every_kind_of_run_have_the_columns_they_were_written_with(
    tmp_path: Path, kinds: tuple[str, ...], thrusters: int
) -> None:
    width = width_for(thrusters, **dict.fromkeys(kinds, True))
    rows = np.arange(2.0 * width).reshape(2, width)
    RunFiles(tmp_path, 7, 1).append_rows(rows)

    files = RunFiles(tmp_path, 7)

    assert files.columns == names(width)
    assert np.array_equal(files.rows(), rows)


def test_a_restarted_trial_leaves_no_rows(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    files.append_rows(_rows(5))

    files.truncate_rows(3)

    assert np.array_equal(files.rows(), _rows(3))


def test_the_latest_attempt_is_shown_and_the_others_are_kept(tmp_path: Path) -> None:
    RunFiles(tmp_path, 7, 1).append_rows(_rows(1))
    RunFiles(tmp_path, 7, 10).append_rows(_rows(2))
    RunFiles(tmp_path, 7, 9).append_rows(_rows(3))

    shown = RunFiles(tmp_path, 7)

    assert shown.attempts() == [1, 9, 10]
    assert shown.row_count() == 2


@given(parts=st.lists(st.binary(max_size=300_000), max_size=6), after=st.integers(0, 10**6))
@hypothesis_settings(max_examples=40, deadline=None)
def test_a_long_log_is_its_head_and_tail_and_the_size_of_the_gap(
    tmp_path_factory: pytest.TempPathFactory, parts: list[bytes], after: int
) -> None:
    files = RunFiles(tmp_path_factory.mktemp("log"), 7, 1)
    for part in parts:
        files.append_log(part)
    whole = b"".join(parts)

    read = files.log(after)

    gone = range(HEAD_MAX, max(len(whole) - TAIL_MAX, HEAD_MAX))
    lost = range(max(after, gone.start), max(gone.stop, after, gone.start))
    kept = bytes(b for at, b in enumerate(whole[after:], after) if at not in gone)
    assert read.next == len(whole)
    assert read.dropped == len(lost)
    assert read.text == printable_text(kept.decode("utf-8", "replace"))


def test_a_log_is_followed_without_duplicates_and_gaps(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    text, at = "", 0
    for word in ("one ", "two ", "three"):
        files.append_log(word.encode())
        part = files.log(at)
        text, at = text + part.text, part.next

    assert text == "one two three" == files.log_text()


def test_documents_are_written_atomically(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    assert files.manifest() is None

    files.write_json("manifest.json", {"digest": "d"})

    assert files.manifest() == {"digest": "d"}
    assert [path.name for path in files.folder.iterdir()] == ["manifest.json"]


def test_rows_of_a_version_with_other_columns_stay_readable(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    files.append_rows(_rows(3))
    older = ("trial", "level", "t", "gone")
    (files.folder / "columns.json").write_text(json.dumps(older))
    files.telemetry_path.write_bytes(np.arange(8.0).tobytes())

    found = RunFiles(tmp_path, 7)

    assert found.row_count() == 2
    assert found.rows(1)[0, [INDEX["trial"], INDEX["t"]]].tolist() == [4.0, 6.0]
    assert np.isnan(found.rows()[:, INDEX["x"]]).all()


def test_a_full_disk_leaves_whole_rows_and_a_clear_reason(tmp_path: Path) -> None:
    writer = RunFiles(tmp_path, 7, 1)
    writer.append_rows(_rows(2))

    with files_end_at(4 * 8 * WIDTH - 100), pytest.raises(StorageFailed, match="telemetry"):
        writer.append_rows(_rows(5, start=2))
    assert writer.telemetry_path.stat().st_size == 2 * 8 * WIDTH

    writer.append_rows(_rows(3, start=2))
    assert np.array_equal(writer.rows(), _rows(5))


@pytest.mark.parametrize("before", [None, {"digest": "before"}])
def test_a_document_that_does_not_fit_leaves_nothing_half(
    tmp_path: Path, before: dict[str, str] | None
) -> None:
    writer = RunFiles(tmp_path, 7, 1)
    writer.append_log(b"started")
    if before is not None:
        writer.write_json("metrics.json", before)

    with files_end_at(100), pytest.raises(StorageFailed):
        writer.write_json("metrics.json", {"digest": "x" * 200})

    assert writer.metrics() == before
    assert all(not path.name.startswith(".") for path in writer.folder.iterdir())


def test_a_worker_that_lost_its_attempt_cannot_write_any_more(tmp_path: Path) -> None:
    late, new = RunFiles(tmp_path, 7, 1), RunFiles(tmp_path, 7, 2)
    late.append_rows(_rows(1))
    late.append_log(b"one")
    new.append_rows(_rows(1))

    new.remove_earlier_attempts()

    with pytest.raises(StorageFailed):
        late.append_rows(_rows(1))
    with pytest.raises(StorageFailed):
        late.append_log(b"two")
    with pytest.raises(StorageFailed):
        late.write_json("metrics.json", {})
    assert new.attempts() == [2]


def test_later_attempts_are_not_removed(tmp_path: Path) -> None:
    for attempt in (1, 2, 3):
        RunFiles(tmp_path, 7, attempt).append_rows(_rows(1))

    RunFiles(tmp_path, 7, 2).remove_earlier_attempts()

    assert RunFiles(tmp_path, 7).attempts() == [2, 3]


def test_without_the_data_folder_nothing_is_written_in_its_place(tmp_path: Path) -> None:
    with pytest.raises(StorageFailed, match="No such file"):
        RunFiles(tmp_path / "away", 7, 1).append_rows(_rows(1))

    assert not (tmp_path / "away").exists()


def test_files_that_were_removed_during_the_read_are_empty(tmp_path: Path) -> None:
    RunFiles(tmp_path, 7, 1).append_rows(_rows(3))
    reader = RunFiles(tmp_path, 7)
    assert reader.row_count() == 3

    class Removing(RunFiles):
        def row_count(self) -> int:
            count = super().row_count()
            self.telemetry_path.unlink(missing_ok=True)
            return count

    assert Removing(tmp_path, 7).rows().shape == (0, WIDTH)


def test_the_size_is_that_of_all_files_of_the_attempt(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    assert files.size() == 0

    files.append_rows(_rows(3))
    files.append_log(b"12345")

    columns = (files.folder / "columns.json").stat().st_size
    assert files.size() == 3 * 8 * WIDTH + 5 + columns


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.booleans(), st.integers(1, HEAD_MAX + TAIL_MAX)), max_size=6),
    st.integers(1, 255),
)
@hypothesis_settings(max_examples=30, deadline=None)
def test_what_was_held_back_is_read_as_if_it_had_been_written_at_once(
    tmp_path_factory: pytest.TempPathFactory, pieces: list[tuple[bool, int]], first: int
) -> None:
    plain = RunFiles(tmp_path_factory.mktemp("plain"), 7, 1)
    shown = RunFiles(tmp_path_factory.mktemp("held"), 7, 1)
    held = shown.held_back()
    for is_held, size in sorted(pieces):
        text = bytes((first + at) % 95 + 32 for at in range(size))
        for where in (plain, held if is_held else shown):
            where.append_log(text)
            where.append_rows(_rows(size % 5 + 1))

    shown.append_all(held)

    assert np.array_equal(shown.rows(), plain.rows())
    assert (shown.log_text(), shown.log_length()) == (plain.log_text(), plain.log_length())
    assert not held.folder.exists()


def test_what_is_held_back_is_in_no_file_of_the_run(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    files.append_rows(_rows(2))
    files.held_back().append_rows(_rows(3))
    files.held_back().append_log(b"secret")

    seen = RunFiles(tmp_path, 7)

    assert (seen.attempt, seen.row_count(), seen.log_text()) == (1, 2, "")


def test_a_later_attempt_removes_what_an_earlier_one_held_back(tmp_path: Path) -> None:
    earlier = RunFiles(tmp_path, 7, 1)
    earlier.append_rows(_rows(2))
    earlier.held_back().append_rows(_rows(3))

    RunFiles(tmp_path, 7, 2).remove_earlier_attempts()

    assert list(earlier.root.iterdir()) == []
