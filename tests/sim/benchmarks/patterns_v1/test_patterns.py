"""patterns-v1: what is drawn, its score, and what cannot win."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.sim.benchmarks.patterns_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.patterns_v1.scenario import draw_conditions, draw_scenario
from seamark.sim.camera.bottom.things import OBJECTS
from seamark.sim.detectors import Detection
from seamark.sim.engine.detection_loop import Oracle
from seamark.sim.engine.replay import Replay
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.metrics.detection import COUNTS
from seamark.sim.metrics.recognition import AP, METRICS
from seamark.sim.recording.telemetry import INDEX, Rows, detections, objects_of
from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles.patterns import CLASSES

NAME = "patterns-v1"
ENTRY = benchmark(NAME)
SHORT: dict[str, Any] = {"optical_depths": [0.0, 3.0], "level_duration_s": 4.0}
MOTION = slice(INDEX["x"], INDEX["r"] + 1)
seeds = st.integers(0, 2**62)
shares = st.lists(st.floats(0.0, 100.0), min_size=3, max_size=3)


class Answering:
    """Gives the answers of a list, one element for each image, and keeps the images."""

    def __init__(self, answers: list[list[Detection]] | None = None) -> None:
        self._answers = answers
        self.images: list[np.ndarray[Any, np.dtype[np.uint8]]] = []

    def detect(self, image: np.ndarray[Any, np.dtype[np.uint8]]) -> list[Detection]:
        self.images.append(image.copy())
        return [] if self._answers is None else self._answers[len(self.images) - 1]


def ran(
    solution: Any, *, seed: int = 5, trial: int = 0, **changes: object
) -> tuple[TrialResult, Rows]:
    kept: list[Rows] = []
    config = ENTRY.read(SHORT | changes)
    result = run_trial(NAME, config, solution, seed=seed, trial=trial, on_rows=kept.append)
    return result, np.concatenate(kept)


@cache
def of_oracle() -> tuple[TrialResult, Rows]:
    return ran(Oracle.TRUTH)


def true_answers(rows: Rows) -> list[list[Detection]]:
    """What the oracle answered to each image."""
    return [
        [
            Detection(name, image[number, 1:9].reshape(4, 2), 1.0)
            for number, name in enumerate(CLASSES)
            if image[number, 0] == COUNTS
        ]
        for image in objects_of(detections(rows))
    ]


def scored(ap: list[float]) -> float:
    """The score of a trial with these average precisions [%] at optical depths of 0, 2 and 6."""
    config = ENTRY.read({"optical_depths": [0.0, 2.0, 6.0]})
    levels = [
        {"optical_depth": depth, "held": False}
        | dict.fromkeys((metric.name for metric in METRICS), 0.0)
        | {AP.name: share}
        for depth, share in zip(config.optical_depths, ap, strict=True)
    ]
    return EXPERIMENT.trial_score(config, levels).score


def test_the_oracle_is_perfect_at_every_depth_and_nothing_gets_nothing() -> None:
    oracle, _ = of_oracle()
    nothing, _ = ran(EXPERIMENT.built_in("nothing", ENTRY.read(SHORT)))

    assert oracle.score == pytest.approx(3.0)
    assert [level[AP.name] for level in oracle.levels] == [100.0, 100.0]
    assert nothing.score == 0.0


def test_every_level_has_a_bottom_of_its_own() -> None:
    config = ENTRY.read(SHORT)

    first, second = (draw_scenario(config, 5, 0, level) for level in (0, 1))

    assert not np.array_equal(first.bottom.tiles, second.bottom.tiles)
    assert first.bottom.objects[0].text != second.bottom.objects[0].text


@given(seed=seeds)
def test_the_conditions_of_a_level_do_not_depend_on_how_many_levels_there_are(seed: int) -> None:
    config = ENTRY.read({})
    fewer = ENTRY.read(SHORT)

    assert draw_conditions(config, seed, 1, 1) == draw_conditions(fewer, seed, 1, 1)


@pytest.mark.slow
@settings(max_examples=30)
@given(seed=seeds, level=st.integers(0, 6))
def test_objects_of_every_class_pass_by_in_every_level(seed: int, level: int) -> None:
    config = ENTRY.read({})
    scenario = draw_scenario(config, seed, 0, level)
    steps = config.control_steps_per_level
    poses = [
        np.array(scenario.path.pose_and_velocity(k * config.control_period_s)[0])
        for k in range(steps)
    ]

    middles = np.array(
        [[one.corners.mean(axis=0) for one in scenario.camera.seen(p)[:OBJECTS]] for p in poses]
    )

    inside = ((middles >= 0.0) & (middles <= (319.0, 239.0))).all(axis=2)
    assert inside.any(axis=0).sum() >= OBJECTS - 1  # one may pass beside the image


def test_a_program_is_told_neither_water_nor_path_nor_bottom() -> None:
    assert set(ENTRY.read({}).for_program()) == {"control_period_s", "colour"}


def test_a_detector_gets_grey_images_unless_it_asks_for_colour() -> None:
    grey, colour = Answering(), Answering()

    ran(grey)
    ran(colour, colour=True)

    assert grey.images[0].shape == (240, 320)
    assert colour.images[0].shape == (240, 320, 3)
    assert np.array_equal(colour.images[3][:, :, 1], grey.images[3])
    reds, _, blues = colour.images[0].reshape(-1, 3).mean(axis=0)
    assert reds > blues  # of sand and gravel as of grass: red comes first


def test_every_image_can_be_rendered_again_from_its_row() -> None:
    shown = Answering()
    _, rows = ran(shown)
    replay = Replay(NAME, ENTRY.read(SHORT), lambda _trial: 5)

    for number in (0, 3, 12):
        assert np.array_equal(replay.frame(rows[number]).grey(), shown.images[number])


@given(first=shares, second=shares)
def test_the_score_is_the_area_and_linear_in_every_level(
    first: list[float], second: list[float]
) -> None:
    both = [0.5 * (a + b) for a, b in zip(first, second, strict=True)]

    assert scored(both) == pytest.approx(0.5 * (scored(first) + scored(second)))
    assert scored([100.0, 100.0, 100.0]) == pytest.approx(6.0)
    assert scored([100.0, 100.0, 0.0]) == pytest.approx(4.0)


def test_a_trial_with_a_level_in_which_no_object_counts_does_not_rank() -> None:
    config = ENTRY.read({"optical_depths": [0.0, 2.0, 6.0]})
    levels = [
        {"optical_depth": depth, "held": False} | dict.fromkeys((m.name for m in METRICS), math.nan)
        for depth in config.optical_depths
    ]

    score = EXPERIMENT.trial_score(config, levels)

    assert not score.rankable
    assert "no object was in any image" in score.reason


def test_to_play_back_a_trial_wins_there_and_is_worth_nothing_on_a_fresh_bottom() -> None:
    _, rows = of_oracle()

    played, _ = ran(Answering(true_answers(rows)))
    fresh, _ = ran(Answering(true_answers(rows)), seed=6)

    assert played.score == of_oracle()[0].score
    assert fresh.score < 0.05 * played.score


def test_guessing_every_class_everywhere_is_worth_next_to_nothing() -> None:
    """Sixteen boxes in a grid, each with the class and confidence of its turn."""
    names, sides = list(CLASSES), np.array([[0, 0], [80, 0], [80, 60], [0, 60]], float)
    guesses = [
        [
            Detection(
                names[(number + k) % len(names)], np.add(sides, (80 * (k % 4), 60 * (k // 4))), 0.5
            )
            for k in range(16)
        ]
        for number in range(16)
    ]

    result, _ = ran(Answering(guesses))

    assert result.score < 0.05 * of_oracle()[0].score


def test_an_answer_beyond_the_image_or_of_no_class_changes_nothing() -> None:
    _, rows = of_oracle()
    junk = [
        Detection("mermaid", np.array([[0, 0], [9, 0], [9, 9], [0, 9]], float), 1.0),
        Detection("box", np.full((4, 2), 1e6), 1.0),
    ]
    answers = [junk + one for one in true_answers(rows)]

    assert ran(Answering(answers))[0].score == of_oracle()[0].score


def test_the_same_seed_gives_the_same_bytes_and_another_does_not() -> None:
    again, _ = ran(Oracle.TRUTH)
    other, _ = ran(Oracle.TRUTH, seed=6)

    assert again.digest == of_oracle()[0].digest
    assert other.digest != again.digest


@pytest.mark.parametrize(
    ("changes", "setting"),
    [
        ({"optical_depths": [0.0, 2.0, 2.0]}, "optical_depths"),
        ({"level_duration_s": 3.3}, "level_duration_s"),
        ({"altitude_m": 0.5}, "altitude_m"),
        ({"burial": 2.0}, "burial"),
        ({"detector": "clairvoyance"}, "detector"),
    ],
)
def test_settings_that_make_no_sense_are_refused_by_name(
    changes: dict[str, object], setting: str
) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        ENTRY.read(changes)

    assert list(refused.value.errors) == [setting]
