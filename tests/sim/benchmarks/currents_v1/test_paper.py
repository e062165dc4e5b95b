"""What the published experiment reports comes out on its own plant, with its own laws."""

from collections.abc import Mapping

import numpy as np
import pytest

from performance.simulator.validation.experiment import X_AXIS, Y_AXIS, facts, planar_check, run
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.recording.telemetry import INDEX, Rows

pytestmark = pytest.mark.slow
SPEEDS = (0.0, 0.1, 0.2, 0.3, 0.4)
SOME = {"levels": [0.0, 0.2, 0.4]}


@pytest.fixture(scope="module")
def rows() -> Mapping[str, Rows]:
    return {law: run(law, "esm") for law in ("p", "pi")}


@pytest.mark.parametrize(("level", "px"), [(1, 4.5), (2, 9.0), (3, 13.5), (4, 18.1)])
def test_the_steady_state_error_of_p_grows_with_the_current(
    rows: Mapping[str, Rows], level: int, px: float
) -> None:
    settled = facts(rows["p"], level, "x")

    assert settled.mean == pytest.approx(px, rel=0.05)
    assert planar_check(X_AXIS, SPEEDS[level], 0.0)[0] == pytest.approx(px, rel=0.05)


@pytest.mark.parametrize(("level", "seconds"), [(1, 23), (2, 39), (3, 48), (4, 55)])
def test_pi_returns_to_the_target_at_every_level(
    rows: Mapping[str, Rows], level: int, seconds: float
) -> None:
    settled = facts(rows["pi"], level, "x")

    assert abs(settled.mean) < 0.5
    assert settled.return_s == pytest.approx(seconds, abs=6.0)


@pytest.mark.parametrize("level", [2, 3, 4])
@pytest.mark.parametrize(("law", "ki"), [("p", 0.0), ("pi", 0.02)])
def test_the_sinusoid_remains_on_y_with_both_laws_as_in_the_planar_check(
    rows: Mapping[str, Rows], level: int, law: str, ki: float
) -> None:
    ours, planar = facts(rows[law], level, "y"), planar_check(Y_AXIS, SPEEDS[level], ki)

    assert ours[:3] == pytest.approx(planar, abs=1.0)
    assert ours.maximum - ours.minimum > 2.0 * level


def test_the_amplitude_of_the_sinusoid_grows_with_the_current(rows: Mapping[str, Rows]) -> None:
    for law in rows:
        swings = [
            (fact := facts(rows[law], level, "y")).maximum - fact.minimum for level in range(5)
        ]
        assert swings == sorted(swings)


def test_without_current_p_and_pi_are_alike(rows: Mapping[str, Rows]) -> None:
    for axis in "xy":
        means = [facts(rows[law], 0, axis).mean for law in ("p", "pi")]
        assert means == pytest.approx([0.0, 0.0], abs=0.3)


def test_pi_is_a_little_better_than_p_on_y(rows: Mapping[str, Rows]) -> None:
    def rms(law: str) -> float:
        late = rows[law][rows[law][:, INDEX["level"]] == 4][-600:]
        return float(np.sqrt(np.mean(late[:, INDEX["error_y_px"]] ** 2)))

    assert 0.5 * rms("p") < rms("pi") < 0.8 * rms("p")


def test_an_observer_in_the_velocity_loop_keeps_station_within_centimetres(
    currents: Benchmark,
) -> None:
    result = _on_the_realistic_vehicle(currents, "pi", velocity_observer_1_s=1.5)

    assert [level["rmse_m"] < 0.06 for level in result.levels] == [True] * 3
    assert result.trial_score.level_held == 0.4


@pytest.mark.slow
def test_in_a_head_current_p_has_a_steady_state_error_and_pi_has_none(currents: Benchmark) -> None:
    p, pi = (_on_the_realistic_vehicle(currents, name) for name in ("p", "pi"))

    beside = [abs(level["mean_y_px"]) for level in p.levels]
    assert beside == sorted(beside)
    assert beside[-1] > 25.0
    assert max(abs(level["mean_y_px"]) for level in pi.levels) < 5.0
    assert pi.score > p.score + 3.0


def _on_the_realistic_vehicle(
    currents: Benchmark, controller: str, **settings: object
) -> TrialResult:
    config = currents.read(SOME | settings)
    program = BuiltIn(controller, config)
    return run_trial("currents-v1", config, program, seed=1, trial=0, on_rows=lambda _rows: None)
