"""P and PI, written with the interface that uploads have."""

from typing import Any

import numpy as np
import pytest

from seamark.sim.control.observation import BOOLEANS, FIELDS, STARTS, Observation, empty, layout
from seamark.sim.control.position import p, pi
from seamark.sim.engine.program import BuiltIn
from seamark.sim.registry import CONTROLLERS, VEHICLES, benchmark
from seamark.sim.vehicles import load

CONFIG: dict[str, Any] = {"kp": 0.5, "ki": 0.1, "control_heave": False, "reference_limit_m_s": 1.0}


def seeing(error: tuple[float, float, float], *, visible: bool = True) -> Observation:
    values = empty(5)
    values[STARTS["error"] : STARTS["error"] + 3] = error
    values[STARTS["dt"]] = 0.05
    values[STARTS["target_visible"]] = visible
    return Observation(values)


def test_p_acts_on_x_and_y_alone() -> None:
    assert p.Controller(CONFIG).step(seeing((0.2, -0.4, 0.6))) == [0.1, -0.2, 0.0, 0.0]


def test_p_acts_on_z_if_heave_is_controlled() -> None:
    controller = p.Controller(CONFIG | {"control_heave": True})

    assert controller.step(seeing((0.2, -0.4, 0.6))) == [0.1, -0.2, 0.3, 0.0]


def test_the_integral_grows_with_error_times_time_and_is_reset_at_a_level() -> None:
    controller = pi.Controller(CONFIG)
    for _ in range(20):
        answer = controller.step(seeing((0.2, 0.0, 0.0)))

    assert answer[0] == pytest.approx(0.5 * 0.2 + 0.1 * 0.2 * 20 * 0.05)
    controller.reset({})
    assert controller.step(seeing((0.0, 0.0, 0.0))) == [0.0, 0.0, 0.0, 0.0]


def test_the_integral_does_not_wind_up_at_the_limit() -> None:
    controller = pi.Controller(CONFIG)
    for _ in range(1000):
        assert controller.step(seeing((9.0, 0.0, 0.0)))[0] == 1.0

    assert controller.step(seeing((-0.1, 0.0, 0.0)))[0] == pytest.approx(-0.05, abs=1e-3)


def test_the_integral_is_constant_while_the_target_is_lost() -> None:
    controller = pi.Controller(CONFIG)
    for _ in range(100):
        controller.step(seeing((0.2, 0.0, 0.0), visible=False))

    assert controller.step(seeing((0.0, 0.0, 0.0)))[0] == 0.0


@pytest.mark.parametrize("name", CONTROLLERS)
def test_every_built_in_controller_moves_against_the_error_within_the_limit(name: str) -> None:
    config = benchmark("currents-v1").read({"reference_limit_m_s": 0.5})
    program = BuiltIn(name, config)
    program.reset({"index": 0})
    values = empty(5)
    values[STARTS["dt"]], values[STARTS["target_visible"]] = 0.05, True

    answers = []
    for error in ((0.1, -0.1, 0.0), (100.0, -100.0, 100.0)):
        values[STARTS["error"] : STARTS["error"] + 3] = error
        answers.append(program.step(values))

    assert all(type(value) is float for answer in answers for value in answer)
    assert 0.0 < answers[0][0] < 0.5
    assert -0.5 < answers[0][1] < 0.0
    assert answers[1][0] == 0.5
    if name == "mpc":  # asks for no more than one sway thruster gives
        assert -0.5 < answers[1][1] < answers[0][1]
    else:
        assert answers[1][1] == -0.5
    assert [answer[3] for answer in answers] == [0.0, 0.0]


def test_an_observation_is_a_mapping_and_has_attributes() -> None:
    values = np.arange(float(len(empty(5))))
    observation = Observation(values)

    assert list(observation) == [name for name, *_ in FIELDS]
    assert observation["error"].tolist() == observation.error.tolist() == [2.0, 3.0, 4.0]
    assert (observation.t, len(observation.thrust)) == (0.0, 5)
    assert all(isinstance(observation[name], bool) for name in BOOLEANS)
    with pytest.raises(AttributeError, match="no current"):
        _ = observation.current


def test_vectors_of_an_observation_are_arrays_that_cannot_be_changed() -> None:
    observation = Observation(empty(5))
    vectors = [name for name, count, *_ in FIELDS if count]

    for name in vectors:
        assert observation[name].dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            observation[name][0] = 1.0


def test_an_observation_that_was_kept_does_not_change_with_the_next_one() -> None:
    values = empty(5)
    kept = Observation(values)

    values[:] = 1.0

    assert (kept.t, kept.error.tolist()) == (0.0, [0.0, 0.0, 0.0])


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_the_layout_covers_the_whole_observation(vehicle: str) -> None:
    thrusters = len(load(vehicle).thrusters)
    fields = layout(vehicle)["observation"]

    assert sum(max(count, 1) for _name, count in fields) == len(empty(thrusters))
    assert len(Observation(empty(thrusters)).thrust) == dict(fields)["thrust"] == thrusters
    assert set(BOOLEANS) <= set(dict(fields))
