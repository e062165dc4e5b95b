"""What is kept of a check for its report."""

import json

import numpy as np

from seamark.sim.metrics.detection import HIT
from seamark.sim.recording.telemetry import INDEX, WIDTH
from seamark.worker.evaluation.check_recorder import IMAGES, SEED, CheckRecorder
from tests.sim.metrics.detector_rows import Answered, Image, rectangle, rows_of, seen

BOX = rectangle(10, 10, 80, 40)
FOUND = Image({"box": seen(BOX)}, [Answered("box", BOX)])


def test_of_a_detector_the_first_images_are_kept_whole_however_they_arrive() -> None:
    recorder, rows = CheckRecorder(), rows_of([FOUND] * 8)
    rows[:, INDEX["t"]] = 0.5 * np.arange(8)

    for pair in np.split(rows, 4):
        recorder.rows(pair)

    kept = json.loads(json.dumps(recorder.seen(), allow_nan=False))
    restored = np.array(kept["rows"], dtype=np.float64)
    assert kept["seed"] == SEED
    np.testing.assert_array_equal(restored, rows[:IMAGES])
    assert np.isnan(restored).any()  # of what is not in the image
    assert HIT in restored


def test_of_other_programs_and_of_a_trial_that_starts_again_no_image_is_kept() -> None:
    controller, again = CheckRecorder(), CheckRecorder()

    controller.rows(np.zeros((20, WIDTH)))
    again.rows(rows_of([FOUND]))
    again.trial_restarted(0, "the host was slow")

    assert (controller.seen()["rows"], again.seen()["rows"]) == ([], [])
