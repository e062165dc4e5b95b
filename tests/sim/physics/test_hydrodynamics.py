"""Laws of single forces: what drag, Coriolis and restoring forces may and may not do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.linear_algebra import inverse
from seamark.sim.physics.hydrodynamics import (
    add_coriolis,
    add_drag,
    add_restoring,
    write_rotation,
)
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load

velocities = arrays(np.float64, 6, elements=st.floats(-5.0, 5.0))
directions = arrays(np.float64, 4, elements=st.floats(-1.0, 1.0)).filter(
    lambda q: float(np.linalg.norm(q)) > 0.1
)


@given(velocity=velocities)
@pytest.mark.parametrize("name", VEHICLES)
def test_drag_only_dissipates_energy(name: str, velocity: Array) -> None:
    vehicle, wrench = load(name), np.zeros(6)

    add_drag(vehicle.linear_drag(), vehicle.quadratic_drag(), velocity, wrench)

    assert wrench @ velocity <= 0.0


@pytest.mark.slow
@given(velocity=velocities)
@pytest.mark.parametrize("name", VEHICLES)
def test_coriolis_forces_do_no_work(name: str, velocity: Array) -> None:
    vehicle, wrench = load(name), np.zeros(6)
    mass = vehicle.mass_rigid() + vehicle.mass_added()

    add_coriolis(mass, velocity, np.empty(6), wrench)

    assert abs(wrench @ velocity) <= 1e-12 * (1.0 + float(velocity @ mass @ velocity) * 30.0)


@given(quaternion=directions)
def test_rotations_keep_lengths_and_handedness(quaternion: Array) -> None:
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    rotation = np.empty((3, 3))

    write_rotation(w, x, y, z, rotation)

    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_an_upright_vehicle_has_its_net_weight_and_no_moment() -> None:
    wrench = np.zeros(6)

    add_restoring(-10.0, np.array([0.0, 0.0, 300.0]), (0.0, 0.0, 1.0), wrench)

    assert wrench.tolist() == [0.0, 0.0, -10.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", VEHICLES)
def test_mass_matrices_are_symmetric_positive_and_inverted_exactly(name: str) -> None:
    vehicle = load(name)
    mass = vehicle.mass_rigid() + vehicle.mass_added()

    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0.0
    assert inverse(mass) @ mass == pytest.approx(np.eye(6), abs=1e-13)


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    with pytest.raises(ValueError, match="not positive definite"):
        inverse(np.diag([1.0, -1.0]))
