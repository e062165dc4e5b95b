"""Thruster curves: monotone, invertible, within their limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.physics.thrusters import (
    command_from_thrust,
    commands_for,
    pack_curve,
    steady_thrust,
    thrust_from_command,
)
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load


@pytest.mark.parametrize("name", VEHICLES)
def test_thrust_never_falls_when_the_command_rises(name: str) -> None:
    curve = pack_curve(load(name).curve)

    forces = [thrust_from_command(command, curve) for command in np.linspace(-1.2, 1.2, 481)]

    assert np.all(np.diff(forces) >= 0.0)


@pytest.mark.parametrize("name", VEHICLES)
def test_thrust_stays_within_its_limits_and_reaches_them(name: str) -> None:
    vehicle = load(name)
    curve = pack_curve(vehicle.curve)
    forward, reverse = vehicle.curve.limits.value

    assert thrust_from_command(5.0, curve) == pytest.approx(forward, rel=1e-4)
    assert thrust_from_command(-5.0, curve) == pytest.approx(-reverse, rel=1e-4)


@given(force=st.floats(-95.0, 104.0).filter(lambda f: abs(f) > 0.1))
def test_the_command_for_a_force_gives_that_force(force: float) -> None:
    curve = pack_curve(load("girona500").curve)

    assert thrust_from_command(command_from_thrust(force, curve), curve) == pytest.approx(
        force, rel=1e-9
    )


def test_the_published_points_of_the_curve_are_met() -> None:
    """Setpoint to force in reverse, from the controller's published polynomial, within 0.01."""
    curve = pack_curve(load("girona500").curve)
    published = {1: 0.11, 5: 0.30, 10: 0.47, 20: 0.63, 40: 0.72, 50: 0.77, 70: 0.86, 90: 0.94}

    commands = {force: -command_from_thrust(-float(force), curve) for force in published}

    assert commands == pytest.approx(published, abs=0.011)


def test_small_commands_are_lost_in_the_dead_band() -> None:
    curve = pack_curve(load("girona500").curve)

    assert thrust_from_command(0.05, curve) == 0.0
    assert thrust_from_command(-0.05, curve) == 0.0
    assert thrust_from_command(0.06, curve) > 0.0


def test_uwsim_thrust_is_quadratic_up_to_154_newtons() -> None:
    curve = pack_curve(load("girona500-uwsim").curve)

    assert thrust_from_command(1.0, curve) == pytest.approx(153.8, abs=0.05)
    assert thrust_from_command(-0.5, curve) == pytest.approx(-153.8 / 4.0, abs=0.02)


def test_a_command_that_is_not_a_number_is_noticed() -> None:
    curve, out = pack_curve(load("girona500").curve), np.zeros(2)

    assert not steady_thrust(np.array([0.1, np.nan]), curve, out)


def test_commands_for_several_thrusters_are_those_of_each() -> None:
    curve, out = pack_curve(load("girona500").curve), np.zeros(3)
    forces = np.array([-20.0, 0.0, 50.0])

    commands_for(forces, curve, out)

    assert out.tolist() == [command_from_thrust(force, curve) for force in forces]
