"""What a run records on fresh trials is held back until somebody may see it."""

from pathlib import Path

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from seamark.worker.service.run_recorder import RunRecorder


def _trial(recorder: RunRecorder, trial: int, *, ends: bool = True) -> None:
    rows = np.zeros((2, WIDTH))
    rows[:, INDEX["trial"]] = trial
    rows[:, INDEX["t"]] = (0.0, 1.0)
    recorder.rows(rows)
    recorder.log(f"trial {trial}\n".encode())
    if ends:
        recorder.trial_ended(trial)


def _seen(files: RunFiles) -> list[float]:
    return files.rows()[:, INDEX["trial"]].tolist()


def test_the_trials_after_the_shown_ones_are_held_back(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    recorder = RunRecorder(files, trial_s=10.0, shown_trials=1)
    _trial(recorder, 0)
    _trial(recorder, 1)
    _trial(recorder, 2, ends=False)

    assert (_seen(files), files.log_text()) == ([0, 0], "trial 0\n")
    assert recorder.t_simulated == 21.0

    recorder.show()

    assert _seen(files) == [0, 0, 1, 1, 2, 2]
    assert files.log_text() == "trial 0\ntrial 1\ntrial 2\n"


def test_what_is_discarded_is_never_seen(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    recorder = RunRecorder(files, trial_s=10.0, shown_trials=1)
    _trial(recorder, 0)
    _trial(recorder, 1)

    recorder.discard()

    assert _seen(files) == [0, 0]
    assert [entry.name for entry in files.root.iterdir()] == ["1"]


def test_a_trial_that_starts_again_is_forgotten_where_it_was_written(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    recorder = RunRecorder(files, trial_s=10.0, shown_trials=1)
    _trial(recorder, 0, ends=False)
    recorder.trial_restarted(0, "slow")
    _trial(recorder, 0)
    _trial(recorder, 1)
    _trial(recorder, 2, ends=False)
    recorder.trial_restarted(2, "slow")
    _trial(recorder, 2)

    recorder.show()

    assert _seen(files) == [0, 0, 1, 1, 2, 2]


def test_a_practice_run_is_seen_as_it_is_recorded(tmp_path: Path) -> None:
    files = RunFiles(tmp_path, 7, 1)
    recorder = RunRecorder(files, trial_s=10.0)
    _trial(recorder, 0)
    _trial(recorder, 1)

    assert _seen(files) == [0, 0, 1, 1]
    assert not recorder.holds_back
