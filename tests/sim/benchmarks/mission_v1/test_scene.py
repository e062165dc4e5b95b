"""Each level of a mission has a start, a decoy and a seabed of its own, of which nobody is told."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from seamark.sim.benchmarks.mission_v1 import scene
from seamark.sim.benchmarks.mission_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.mission_v1.settings import LETTERING, MissionConfiguration
from seamark.sim.camera.lettering import TEXT
from seamark.sim.control.observation import Observation
from seamark.sim.recording.telemetry import INDEX, SEARCH_INDEX, WORK_INDEX, Rows

SEED = 2026
CONFIG = MissionConfiguration.read({})
SHORT = MissionConfiguration.read({"levels": [0.1], "loop1_values": [0.5], "level_duration_s": 2.0})
DRAWS = [
    scene.draw_search(CONFIG, SEED, trial, level) for trial, level in product(range(20), range(6))
]


def test_starts_are_out_of_sight_and_in_every_direction() -> None:
    distances = [math.hypot(*draw.start_m) for draw in DRAWS]
    directions = [math.atan2(*draw.start_m) for draw in DRAWS]

    assert all(0.6 * CONFIG.start_offset_m <= one <= CONFIG.start_offset_m for one in distances)
    assert min(directions) < -2.5
    assert max(directions) > 2.5
    half_diagonal = 0.5 * math.hypot(CONFIG.camera_width_px, CONFIG.camera_height_px)
    in_view = half_diagonal / CONFIG.camera_focal_px * CONFIG.altitude_m
    assert min(distances) > in_view


def test_the_position_told_is_wrong_by_up_to_the_setting_evenly_over_the_disc() -> None:
    errors = np.array([math.hypot(*draw.told_error_m) for draw in DRAWS])

    assert errors.max() <= CONFIG.told_error_m
    # Half of a disc lies within 1/sqrt(2) of its radius.
    inner = float(np.mean(errors < CONFIG.told_error_m / math.sqrt(2.0)))
    assert inner == pytest.approx(0.5, abs=0.15)


def test_decoys_are_within_their_distances_and_lettered_otherwise() -> None:
    distances = [math.hypot(*draw.decoy_m) for draw in DRAWS]

    assert all(CONFIG.decoy_least_m <= one <= CONFIG.decoy_most_m for one in distances)
    assert all(a != b for draw in DRAWS for a, b in zip(draw.text, TEXT, strict=True))
    assert LETTERING == TEXT


def test_every_level_draws_anew_and_the_same_again() -> None:
    assert len({draw.start_m for draw in DRAWS}) == len(DRAWS)
    scene.draw_search.cache_clear()
    assert scene.draw_search(CONFIG, SEED, 0, 0) == DRAWS[0]


def test_two_levels_have_different_seabeds_and_the_share_of_litter_covers_more() -> None:
    bare, some, full = (scene.seabed(share, SEED, 0, 0) for share in (0.0, 0.5, 1.0))
    other = scene.seabed(0.5, SEED, 0, 1)

    changed = [float(np.mean(one != bare)) for one in (some, full)]
    assert 0.0 < changed[0] < changed[1]
    assert not np.array_equal(some, other)


def test_programs_are_told_the_lettering_and_not_what_is_drawn() -> None:
    told = CONFIG.for_program()

    assert told["lettering"] == TEXT
    assert not {"levels", "loop1_values", "turbidity_spread", "start_offset_m"} & set(told)


class Listener:
    """A program that rests, and keeps what it is told."""

    def __init__(self, config: MissionConfiguration) -> None:
        self.size = EXPERIMENT.built_in("nothing", config)._arm
        self.told: list[Any] = []

    def reset(self, level: Any) -> None:
        """Begin."""

    def step(self, values: Any) -> tuple[float, ...]:
        self.told.append(Observation(values, self.size, search=True))
        return (0.0,) * (4 + self.size.motors)


def run(config: MissionConfiguration) -> tuple[Rows, Listener]:
    parts: list[Rows] = []
    listener = Listener(config)
    EXPERIMENT.level(config, listener, seed=SEED, trial=0, level=0).run(parts.append)
    return np.concatenate(parts), listener


def test_a_level_starts_where_it_was_drawn_and_tells_about_where_the_box_is() -> None:
    rows, listener = run(SHORT)
    draw = scene.draw_search(SHORT, SEED, 0, 0)
    camera = EXPERIMENT.world(SHORT, seed=SEED, trial=0, level=0).camera

    first = rows[0]
    start = camera.position(first[INDEX["x"] : INDEX["yaw"] + 1])[:2]
    assert start == pytest.approx(draw.start_m, abs=1e-9)
    box = np.array([first[WORK_INDEX["workpiece_x"]], first[WORK_INDEX["workpiece_y"]]])
    told = box - first[[INDEX["x"], INDEX["y"]]] + draw.told_error_m
    # The box has its origin below the middle of its upper face, which a tilt moves aside.
    assert listener.told[0].told == pytest.approx(told, abs=0.05)
    assert listener.told[-1].told.tolist() == listener.told[0].told.tolist()


def test_the_decoy_lies_where_it_was_drawn_and_stays_there() -> None:
    rows, _ = run(SHORT)
    draw = scene.draw_search(SHORT, SEED, 0, 0)

    place = rows[:, [SEARCH_INDEX["decoy_x"], SEARCH_INDEX["decoy_y"]]]
    assert place[0] == pytest.approx(draw.decoy_m, abs=0.05)
    assert np.ptp(place, axis=0).max() < 1e-3
    assert rows[1:, SEARCH_INDEX["decoy_rest_n"]].min() > 0.0
    assert rows[:, SEARCH_INDEX["decoy_arm_n"]].max() == 0.0


def test_a_program_learns_nothing_of_a_box_that_no_detector_has_found() -> None:
    rows, listener = run(SHORT)

    assert rows[:, SEARCH_INDEX["searching"]].min() == 1.0
    assert not any(one.target_visible or one.confidence for one in listener.told)
    assert not any(one.corners.any() or one.error.any() for one in listener.told)
