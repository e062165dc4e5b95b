"""Images to train detectors with: drawn anew, labelled as the benchmark counts, of no run."""

from itertools import islice

import numpy as np
import pytest

from seamark.sim.benchmarks.patterns_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.patterns_v1.scenario import draw_scenario
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.benchmarks.patterns_v1.training import IMAGES
from seamark.sim.engine.detection_loop import DetectionLoop, Oracle
from seamark.sim.engine.labelled_images import (
    LabelledImage,
    labelled_images,
    labels_of,
    training_seed,
)
from seamark.sim.engine.seeds import SEED_BITS, SEED_MAX
from seamark.sim.metrics.detection import COUNTS, IGNORED
from seamark.sim.recording.telemetry import Rows, detections, objects_of

CONFIG = PatternsConfiguration()


def drawn(
    count: int, *, seed: int = 3, config: PatternsConfiguration = CONFIG
) -> list[LabelledImage]:
    return list(labelled_images(EXPERIMENT, config, seed=seed, count=count))


@pytest.mark.parametrize("seed", [0, 1, 2026, SEED_MAX])
def test_no_run_can_have_the_seed_of_a_training_scene(seed: int) -> None:
    assert training_seed(seed) > SEED_MAX
    assert training_seed(seed).bit_length() > SEED_BITS
    assert training_seed(seed) != training_seed(seed + 1)


def test_a_training_scene_is_not_the_trial_of_the_same_numbers() -> None:
    config = CONFIG.model_copy(update={"optical_depths": (0.0,)})
    trial = draw_scenario(config, 2026, 0, 0)

    [image] = drawn(1, seed=2026, config=config)

    motion = np.concatenate(trial.path.pose_and_velocity(0.0))
    of_trial = labels_of(trial.camera.seen(motion), (320, 240))
    assert image.optical_depth == 0.0
    assert not np.array_equal(image.image, trial.camera.grey(motion, 0))
    assert [label.distance for label in image.labels] != [label.distance for label in of_trial]


def test_fewer_images_are_the_beginning_of_more() -> None:
    few, many = drawn(2), drawn(IMAGES + 2)

    for one, other in zip(few, many, strict=False):
        np.testing.assert_array_equal(one.image, other.image)
        assert one.optical_depth == other.optical_depth
    assert [one.scene for one in many] == [0] * IMAGES + [1, 1]
    assert not np.array_equal(many[0].image, many[IMAGES].image)


def test_the_optical_depths_are_between_those_of_the_first_and_the_last_level() -> None:
    config = CONFIG.model_copy(update={"optical_depths": (1.0, 1.5, 2.0)})

    depths = [
        next(iter(EXPERIMENT.labelled_scene(config, number, seed=5, images=1))).optical_depth
        for number in range(6)
    ]

    assert len(set(depths)) == len(depths)
    assert 1.0 <= min(depths) < 1.4
    assert 1.6 < max(depths) <= 2.0


def test_images_are_in_the_colours_that_the_configuration_says() -> None:
    [grey] = drawn(1)
    [colour] = drawn(1, config=CONFIG.model_copy(update={"colour": True}))

    assert grey.image.shape == (240, 320)
    np.testing.assert_array_equal(colour.image[:, :, 1], grey.image)


def test_labels_are_what_the_benchmark_records_of_the_same_image() -> None:
    config = CONFIG.model_copy(update={"optical_depths": (2.0,), "level_duration_s": 6.0})
    scenario = draw_scenario(config, 9, 0, 0)
    kept: list[Rows] = []
    loop = DetectionLoop(config, scenario.path, scenario.camera, Oracle.TRUTH, trial=0, level=0)
    loop.run(lambda rows: kept.append(rows.copy()))
    recorded = objects_of(detections(np.concatenate(kept)))
    states = set()

    for step, row in enumerate(islice(recorded, 12)):
        motion = np.concatenate(scenario.path.pose_and_velocity(step * config.control_period_s))
        labels = {one.number: one for one in labels_of(scenario.camera.seen(motion), (320, 240))}

        for number, (state, *rest) in enumerate(row.tolist()):
            assert (number in labels) == (state in {COUNTS, IGNORED})
            if number in labels:
                label = labels[number]
                told = [*label.corners.ravel(), label.visible, label.distance, label.angle]
                assert told == pytest.approx(rest)
                assert label.counts == (state == COUNTS)
                states.add(state)
    assert states == {COUNTS, IGNORED}
