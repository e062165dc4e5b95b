"""A varied vehicle differs from the nominal one by its factors, and in nothing else."""

import numpy as np
import pytest

from seamark.sim.physics.dynamics import body_parameters
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load
from seamark.sim.vehicles.variation import VehicleFactors, varied

FACTORS = VehicleFactors(
    mass=1.05,
    added_mass=(0.7, 0.8, 0.9, 1.1, 1.2, 1.3),
    drag=(0.8, 0.9, 1.0, 1.1, 1.2, 0.95),
)


@pytest.mark.parametrize("name", VEHICLES)
def test_every_parameter_is_multiplied_by_its_own_factor(name: str) -> None:
    vehicle, other = load(name), varied(load(name), FACTORS)

    assert other.mass_rigid() == pytest.approx(1.05 * vehicle.mass_rigid())
    assert np.diag(other.mass_added()) == pytest.approx(
        np.diag(vehicle.mass_added()) * FACTORS.added_mass
    )
    assert other.linear_drag() == pytest.approx(vehicle.linear_drag() * FACTORS.drag)
    assert other.quadratic_drag() == pytest.approx(vehicle.quadratic_drag() * FACTORS.drag)


@pytest.mark.parametrize("name", VEHICLES)
def test_weight_buoyancy_and_thrusters_stay(name: str) -> None:
    vehicle, other = load(name), varied(load(name), FACTORS)

    assert (other.weight, other.buoyancy) == (vehicle.weight, vehicle.buoyancy)
    assert (other.thrusters, other.curve, other.lag) == (
        *(vehicle.thrusters, vehicle.curve),
        vehicle.lag,
    )


@pytest.mark.parametrize("name", VEHICLES)
def test_factors_of_one_change_no_bit(name: str) -> None:
    nominal, same = (
        body_parameters(load(name)),
        body_parameters(varied(load(name), VehicleFactors())),
    )

    assert all(np.array_equal(a, b) for a, b in zip(nominal, same, strict=True))
