"""The whole chain on short levels."""

import json
import math
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.control.observation import BOOLEANS, FIELDS, STARTS, empty
from seamark.sim.engine.program import BuiltIn, Command
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, NAMES, Rows
from seamark.sim.settings.configuration import Configuration
from tests.services.prepared import printed
from tests.sim.conftest import SHORT, RunOf

ONE_RUN = f"""
import json, sys
from seamark.sim.engine.program import BuiltIn
from seamark.sim.registry import benchmark
from seamark.sim.engine.trial import run_trial
config = benchmark("currents-v1").read({SHORT!r})
result = run_trial("currents-v1", config, BuiltIn("pi", config), seed=5, trial=0,
                   on_rows=lambda rows: None)
print(json.dumps([result.digest, result.score, "pybullet" in sys.modules]))
"""


class Watching:
    """Runs the built-in PI and records its inputs."""

    def __init__(self, config: Configuration) -> None:
        self._inner = BuiltIn("pi", config)
        self.levels: list[dict[str, float | int]] = []
        self.observations: list[NDArray[np.float64]] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        self.levels.append(dict(level))
        self._inner.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        self.observations.append(values.copy())
        return self._inner.step(values)


class Broken:
    """Works for a while, then raises."""

    def __init__(self, steps: int) -> None:
        self._left = steps

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, values: NDArray[np.float64]) -> Command:
        self._left -= 1
        if self._left < 0:
            raise ArithmeticError("the program ended")
        values[:] = math.nan  # what a program does to its observation is its own business
        return 0.0, 0.0, 0.0, 0.0


def test_the_closed_loop_keeps_station_with_a_perfect_tracker(run_short: RunOf) -> None:
    result, rows = run_short({"tracker": "truth", "velocity_observer_1_s": 1.5})

    assert rows.shape == (240, telemetry.WIDTH)
    assert rows[:, INDEX["distance"]].max() < 0.1
    assert result.score > 80.0


def test_the_closed_loop_keeps_station_with_the_template_tracker(run_short: RunOf) -> None:
    result, rows = run_short({})

    assert rows[:, INDEX["tracker_error"]].max() < 0.5
    assert rows[:, INDEX["tracker_ok"]].min() == 1.0
    assert result.trial_score.level_held == 0.3


def test_pi_keeps_a_bluerov_on_station_with_all_thrusters_active(run_short: RunOf) -> None:
    result, rows = run_short({"vehicle": "bluerov2-heavy", "tracker": "truth"})

    assert np.isfinite(rows).all()
    assert rows[:, INDEX["distance"]].max() < 0.6
    assert (np.ptp(rows[:, INDEX["thrust_0"] : INDEX["thrust_7"] + 1], axis=0) > 0.1).all()
    assert result.trial_score.rankable


def test_rows_are_in_order_and_the_vehicle_is_reset_at_each_level(run_short: RunOf) -> None:
    _result, rows = run_short({})

    assert rows[:, INDEX["t"]] == pytest.approx(np.arange(240) * 0.05)
    assert rows[:, INDEX["level"]].tolist() == [0.0] * 120 + [1.0] * 120
    place = slice(INDEX["x"], INDEX["r"] + 1)
    assert np.array_equal(rows[0, place], rows[120, place])


def test_every_column_varies_and_none_has_nan(run_short: RunOf) -> None:
    _result, rows = run_short({"current_azimuth_rad": 0.5})

    assert np.isfinite(rows).all()
    idle = {
        "trial",
        "tracker_ok",
        "current_z",
        "ref_w",
        "ref_r",
        "thrust_5",
        "thrust_6",
        "thrust_7",
        "contact_n",
    }
    dead = {name for name, column in zip(NAMES, rows.T, strict=True) if np.ptp(column) == 0.0}
    assert dead == idle


def test_every_observation_varies_and_none_is_nan(short: Configuration) -> None:
    program = Watching(short)
    run_trial("currents-v1", short, program, seed=5, trial=0, on_rows=lambda _rows: None)
    observed = np.array(program.observations)

    assert observed.shape == (240, len(empty(5)))
    assert np.isfinite(observed).all()
    idle = {"dt", "target_age", *BOOLEANS}
    for name, count, _unit, _meaning in FIELDS:
        values = observed[:, STARTS[name] : STARTS[name] + max(count, 1)]
        assert (np.ptp(values, axis=0) > 0.0).all() == (name not in idle), name


def test_the_program_is_told_each_level_but_not_its_current(short: Configuration) -> None:
    program = Watching(short)
    run_trial("currents-v1", short, program, seed=5, trial=0, on_rows=lambda _rows: None)

    assert [level["index"] for level in program.levels] == [0, 1]
    assert [level["t"] for level in program.levels] == [0.0, 6.0]
    assert set(program.levels[0]) == {"index", "count", "duration_s", "dt", "t"}


def test_rows_are_delivered_once_a_second_and_the_rest_when_the_program_raises(
    short: Configuration,
) -> None:
    delivered: list[Rows] = []

    with pytest.raises(ArithmeticError, match="the program ended"):
        run_trial("currents-v1", short, Broken(130), seed=5, trial=0, on_rows=delivered.append)

    assert [len(rows) for rows in delivered] == [20] * 6 + [10]
    rows = np.concatenate(delivered)
    assert rows[:, INDEX["t"]] == pytest.approx(np.arange(130) * 0.05)
    assert np.isfinite(rows).all()


@pytest.mark.slow
def test_two_processes_give_the_same_bytes_and_load_bullet_only_for_contacts(
    run_short: RunOf,
) -> None:
    here, _rows = run_short({})

    assert json.loads(printed(ONE_RUN)) == [here.digest, here.score, False]


def test_the_digest_of_a_trial_is_that_of_its_rows(run_short: RunOf) -> None:
    result, rows = run_short({})

    assert result.digest == telemetry.digest(rows)
    assert result.rows == len(rows)


def test_another_seed_or_trial_gives_another_trajectory(short: Configuration) -> None:
    digests = {
        run_trial(
            "currents-v1", short, BuiltIn("pi", short), seed=seed, trial=trial, on_rows=_ignore
        ).digest
        for seed, trial in ((5, 0), (6, 0), (5, 1))
    }

    assert len(digests) == 3


def test_the_tracker_may_start_from_perturbed_corners(run_short: RunOf) -> None:
    _result, rows = run_short({"start_error_px": 1.0})

    assert rows[0, INDEX["tracker_error"]] > 0.3


class Steady:
    """Always answers the same."""

    def __init__(self, command: Command) -> None:
        self._command = command

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, values: NDArray[np.float64]) -> Command:
        return self._command


@pytest.mark.parametrize("vehicle", ["girona500", "girona500-uwsim"])
@pytest.mark.parametrize(
    "command", [(0.0, 0.0, 1.0, 0.0), (1.0, 0.0, -1.0, 9.0), (1e300, -1e300, 1e300, 1e300)]
)
def test_an_erratic_program_ends_with_a_finite_state_above_the_seabed_and_few_points(
    vehicle: str, command: Command, currents: Benchmark
) -> None:
    config = currents.read({**SHORT, "vehicle": vehicle, "levels": 0.1, "level_duration_s": 20})
    rows: list[Rows] = []

    result = run_trial("currents-v1", config, Steady(command), seed=5, trial=0, on_rows=rows.append)

    states = np.concatenate(rows)[:, INDEX["x"] : INDEX["current_z"] + 1]
    assert np.isfinite(states).all()
    assert states[:, 2].max() < 5.0
    assert 0.0 <= result.score < 40.0


def test_diving_onto_the_seabed_is_a_collision_in_rows_and_metrics(currents: Benchmark) -> None:
    config = currents.read({**SHORT, "levels": 0.1, "level_duration_s": 20, "tracker": "truth"})
    rows: list[Rows] = []

    dive = Steady((0.0, 0.0, 1.0, 0.0))
    result = run_trial("currents-v1", config, dive, seed=5, trial=0, on_rows=rows.append)

    force = np.concatenate(rows)[:, INDEX["contact_n"]]
    touched = np.flatnonzero(force)
    assert touched[0] > 100
    assert 10.0 < force[-1] < 300.0
    level = result.levels[0]
    assert level["whole_collisions"] >= 1.0
    assert level["whole_contact_s"] == pytest.approx(len(touched) * 0.05)
    assert level["whole_contact_max_n"] == force.max()


def test_an_unknown_benchmark_is_a_key_error(short: Configuration) -> None:
    with pytest.raises(KeyError):
        run_trial("x-v1", short, BuiltIn("p", short), seed=0, trial=0, on_rows=_ignore)


def _ignore(_rows: Rows) -> None:
    pass
