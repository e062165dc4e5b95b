"""Vehicles: every number has a unit and a source, and the presets are the promised ones."""

import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import TAGS, load
from seamark.sim.vehicles.urdf import urdf_of


@pytest.mark.parametrize("name", VEHICLES)
def test_every_number_says_where_it_is_from(name: str) -> None:
    vehicle = load(name)
    quantities = list(vehicle.quantities())

    assert len(quantities) > 20
    assert vehicle.name == name
    for key, quantity in quantities:
        assert quantity.meaning, key
        assert quantity.unit, key
        assert quantity.source, key
        assert quantity.tag in TAGS, key
        assert np.isfinite(quantity.value).all(), key


@pytest.mark.parametrize("name", VEHICLES)
def test_thrusters_can_drive_surge_sway_heave_and_yaw(name: str) -> None:
    matrix = load(name).allocation()

    assert np.linalg.matrix_rank(matrix[[0, 1, 2, 5]]) == 4


def test_the_girona_has_its_effective_masses_and_net_buoyancy() -> None:
    vehicle = load("girona500")
    mass = vehicle.mass_rigid() + vehicle.mass_added()

    assert np.diag(mass) == pytest.approx([300.0, 540.0, 540.0, 95.0, 110.0, 75.0])
    assert mass[0, 4] == pytest.approx(143.0 * 0.054)
    assert mass[1, 3] == pytest.approx(-143.0 * 0.054)
    assert vehicle.buoyancy.scalar - vehicle.weight.scalar == pytest.approx(10.0)


def test_the_uwsim_preset_is_the_published_model() -> None:
    vehicle = load("girona500-uwsim")
    rigid = vehicle.mass_rigid()

    assert np.diag(rigid) == pytest.approx([98.0, 98.0, 98.0, 8.0, 8.0, 8.0])
    assert abs(rigid[0, 4]) == pytest.approx(4.9)
    assert np.diag(vehicle.mass_added()) == pytest.approx([49.0, 49.0, 49.0, 0.0, 0.0, 0.0])
    assert vehicle.weight.scalar == vehicle.buoyancy.scalar
    assert vehicle.curve.limits.value == pytest.approx((153.8, 153.8), abs=0.05)


def test_thruster_arms_are_those_of_the_thruster_matrices() -> None:
    real, uwsim = load("girona500").allocation(), load("girona500-uwsim").allocation()

    assert np.abs(real[[4, 5]]).max(axis=1) == pytest.approx([0.5587, 0.2432])
    assert np.abs(uwsim[[4, 5]]).max(axis=1) == pytest.approx([0.35, 0.40])


def test_port_thrust_turns_to_starboard() -> None:
    assert load("girona500").allocation()[5].tolist() == [0.2432, -0.2432, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", ["nothing", "../girona500", "__init__x", "os.path"])
def test_unknown_vehicles_are_refused(name: str) -> None:
    with pytest.raises(LookupError, match="no vehicle called"):
        load(name)


def test_reading_a_vehicle_loads_no_compiled_code() -> None:
    program = (
        "import sys; from seamark.sim.vehicles import load; load('girona500-uwsim');"
        "print('numba' in sys.modules, 'cv2' in sys.modules)"
    )

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )

    assert done.stdout.split() == ["False", "False"]


@pytest.mark.parametrize("name", VEHICLES)
def test_a_urdf_holds_the_vehicles_own_numbers(name: str) -> None:
    vehicle = load(name)

    robot = ElementTree.fromstring(urdf_of(vehicle))  # noqa: S314  # our own text

    assert robot.get("name") == name
    (mass,) = robot.iterfind("link/inertial/mass")
    assert float(mass.get("value", "")) == vehicle.mass.scalar
    (inertia,) = robot.iterfind("link/inertial/inertia")
    own = [float(inertia.get(axis, "")) for axis in ("ixx", "iyy", "izz")]
    turned = np.diag(vehicle.mass_rigid())[3:]
    x, y, z = vehicle.centre_of_gravity.value
    squares = np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    assert own == pytest.approx(turned - vehicle.mass.scalar * squares)
    boxes = [box.get("size") for box in robot.iterfind("link/collision/geometry/box")]
    assert boxes == [" ".join(map(repr, piece.size.value)) for piece in vehicle.hull]
