"""Telemetry of a trial or a level, thinned, on the axis of an overlaid chart."""

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.overlaid_series import Part, Series, series
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import Backend

CONFIG = {"levels": [0.1, 0.3], "level_duration_s": 4.0, "settle_s": 1.0}


def _recorded(backend: Backend, levels: tuple[int, ...] = (0, 1), trials: int = 1) -> int:
    """Return a run of trials of levels of 4 s, whose distance is 10 times the trial + the level."""
    run_id = backend.succeeded(config=CONFIG, trials=trials)
    for trial in range(trials):
        rows = np.zeros((80 * len(levels), WIDTH))
        rows[:, INDEX["trial"]] = trial
        rows[:, INDEX["t"]] = 0.05 * np.arange(len(rows))
        rows[:, INDEX["level"]] = np.repeat(levels, 80)
        rows[:, INDEX["distance"]] = 10 * trial + rows[:, INDEX["level"]]
        RunFiles(backend.settings.data, run_id, 1).append_rows(rows)
    return run_id


def _series(backend: Backend, run_id: int, part: Part, max_points: int = 1000) -> Series:
    files = RunFiles(backend.settings.data, run_id)
    return series(backend.show(run_id), files, ["distance"], part, max_points)


@pytest.mark.parametrize(("order", "start_s"), [((0, 1), 4.0), ((1, 0), 0.0)])
def test_a_level_starts_at_0_whenever_it_ran(
    backend: Backend, order: tuple[int, ...], start_s: float
) -> None:
    run_id = _recorded(backend, order, trials=2)

    found = _series(backend, run_id, Part(trial=1, level=1))

    assert found.start_s == start_s
    assert (len(found.t), found.t[0], found.t[-1]) == (80, 0.0, 3.95)
    assert set(found.values[:, 0]) == {11.0}


def test_a_whole_trial_is_thinned_and_keeps_its_peak(backend: Backend) -> None:
    run_id = _recorded(backend)
    peak = np.zeros((1, WIDTH))
    peak[0, [INDEX["t"], INDEX["level"], INDEX["distance"]]] = 8.0, 1, 999.0
    RunFiles(backend.settings.data, run_id, 1).append_rows(peak)

    found = _series(backend, run_id, Part(), max_points=20)

    assert (found.start_s, found.t[0], found.t[-1]) == (0.0, 0.0, 8.0)
    assert len(found.t) <= 20
    assert found.values.max() == 999.0


@pytest.mark.parametrize("part", [Part(trial=3), Part(level=7), Part(trial=3, level=0)])
def test_a_part_that_did_not_run_is_empty(backend: Backend, part: Part) -> None:
    found = _series(backend, _recorded(backend), part)

    assert (found.start_s, len(found.t), found.values.shape) == (None, 0, (0, 1))


def test_a_level_that_is_still_running_has_the_rows_so_far(backend: Backend) -> None:
    run_id = _recorded(backend, (0,))
    started = np.zeros((50, WIDTH))
    started[:, INDEX["t"]] = 4.0 + 0.05 * np.arange(50)
    started[:, INDEX["level"]] = 1
    RunFiles(backend.settings.data, run_id, 1).append_rows(started)

    assert len(_series(backend, run_id, Part(level=1)).t) == 50
