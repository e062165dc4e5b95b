from collections.abc import Sequence

import numpy as np
import pytest

from seamark.server.runs.data.files import Rows, RunFiles
from seamark.server.web.streams import excerpts
from seamark.server.web.streams.events import Position
from seamark.server.web.streams.excerpts import START, Budget, excerpt, position_now
from tests.server.web.streams.conftest import Recording
from tests.services.viewer import parsed

LONG_RUN = 120_000  # rows: 6000 s
SMALL = Budget(telemetry=3_300, log=900)
ROW = 47 * 12  # [byte] of one row, generously


def _size(found: excerpts.Excerpt) -> int:
    return sum(len(frame.data) for frame in found.frames)


def _times(found: excerpts.Excerpt) -> list[float]:
    rows = [data for kind, _, data in parsed(found.frames[0].data) if kind == "telemetry"]
    return [row[rows[0]["columns"].index("t")] for row in rows[0]["rows"]]


@pytest.mark.slow
@pytest.mark.parametrize("budget", [START, SMALL])
def test_an_excerpt_of_a_long_run_holds_what_a_screen_shows(
    recording: Recording, budget: Budget
) -> None:
    recording.record(LONG_RUN)
    recording.files.append_log(b"a line of the program\n" * 5000)

    found = excerpt(recording.files, Position(1, 0, 0), position_now(recording.files), budget)

    times = _times(found)
    gaps = np.diff(times)
    assert _size(found) < budget.telemetry + budget.log + 2 * ROW + 600  # the names of the columns
    assert len(times) > budget.telemetry / ROW
    assert times[-1] == pytest.approx(0.05 * (LONG_RUN - 1))
    assert gaps.max() - gaps.min() < 0.11  # evenly


@pytest.mark.slow
def test_a_long_run_is_not_read_as_a_whole(recording: Recording) -> None:
    recording.record(LONG_RUN)
    until = position_now(recording.files)
    sizes = []

    class CountedFiles(RunFiles):
        def rows_at(self, indices: Sequence[int]) -> Rows:
            sizes.append(len(indices))
            return super().rows_at(indices)

    files = CountedFiles(recording.settings.data, recording.run_id)
    excerpt(files, Position(1, 0, 0), until, START)

    assert 0 < sum(sizes) < 500


def test_successive_excerpts_have_each_row_once_and_in_order(recording: Recording) -> None:
    position, times, text = Position(1, 0, 0), [], ""
    for number in range(40):
        recording.record(7)
        recording.files.append_log(f"{number}\n".encode())
        found = excerpt(recording.files, position, position_now(recording.files), SMALL)
        events = [event for frame in found.frames for event in parsed(frame.data)]
        times += _times(found)
        text += "".join(data["text"] for kind, _, data in events if kind == "log")
        position = found.end

    assert times == pytest.approx([0.05 * row for row in range(280)])
    assert text == "".join(f"{number}\n" for number in range(40))


def test_the_id_of_an_event_is_where_its_data_end(recording: Recording) -> None:
    recording.record(5)
    recording.files.append_log(b"one\n")

    found = excerpt(recording.files, Position(1, 0, 0), position_now(recording.files), SMALL)

    ids = [event_id for frame in found.frames for _, event_id, _ in parsed(frame.data)]
    assert ids == ["1-5-0", "1-5-4"]


def test_a_new_attempt_is_shown_from_its_start(recording: Recording) -> None:
    recording.record(5)
    recording.attempt = 2
    recording.record(3)

    found = excerpt(recording.files, Position(1, 5, 0), position_now(recording.files), SMALL)

    assert _times(found) == pytest.approx([0.0, 0.05, 0.1])


def test_a_trial_that_starts_again_continues_with_its_new_rows(recording: Recording) -> None:
    recording.record(9)
    before = position_now(recording.files)
    recording.files.truncate_rows(4)

    restarted = excerpt(recording.files, before, position_now(recording.files), SMALL)
    recording.record(2)
    found = excerpt(recording.files, restarted.end, position_now(recording.files), SMALL)

    assert restarted.frames == ()
    assert _times(found) == pytest.approx([0.2, 0.25])


def test_escapes_do_not_make_a_log_larger_than_its_budget(recording: Recording) -> None:
    recording.files.append_log(b"\x1b" * 5000)

    found = excerpt(recording.files, Position(1, 0, 0), position_now(recording.files), SMALL)

    ((_, _, data),) = parsed(found.frames[0].data)
    assert _size(found) <= SMALL.log
    assert data["gap"]
    assert data["text"].endswith(r"\x1b\x1b")


def test_the_start_of_a_trial_is_found_among_the_rows(recording: Recording) -> None:
    recording.record(30, trial=0)
    recording.record(12, trial=1)
    recording.files.append_log(b"12345")

    assert excerpts.start_of_trial(recording.files) == Position(1, 30, 5)
