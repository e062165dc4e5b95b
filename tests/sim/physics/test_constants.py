"""Constants of the physics: every one has a source, and the simulator has no other."""

import subprocess
import sys

import numpy as np
import pytest

from seamark.sim.camera.target import Target
from seamark.sim.physics import constants, contact, current, plant, terrain
from seamark.sim.sensors import dvl
from seamark.sim.vehicles import STANDARD_GRAVITY, TAGS, Quantity

LISTED = [quantity for group in constants.GROUPS.values() for quantity in group]


def test_every_constant_of_the_module_is_in_a_group() -> None:
    named = [value for value in vars(constants).values() if isinstance(value, Quantity)]

    assert sorted(map(id, named)) == sorted(map(id, LISTED))


@pytest.mark.parametrize("quantity", LISTED, ids=lambda quantity: quantity.meaning)
def test_every_constant_has_a_source(quantity: Quantity) -> None:
    assert quantity.meaning
    assert quantity.unit
    assert quantity.source
    assert quantity.tag in TAGS
    assert np.isfinite(quantity.value).all()


def test_the_simulator_uses_these_constants() -> None:
    assert constants.STANDARD_GRAVITY.scalar == STANDARD_GRAVITY
    assert constants.STEP_S.scalar == plant.STEP_S
    assert constants.GUST_GRID_S.scalar == current.GUST_GRID_S
    assert constants.MIN_HEIGHT_M.scalar == current.MIN_HEIGHT_M
    assert constants.DVL_RANGE_M.value == dvl.RANGE_M
    assert constants.MOUND_REACH_M.scalar == terrain.REACH_M
    assert constants.GATE_M.scalar == contact.GATE_M
    box, target = contact.TargetBox(centre=(0.0, 0.0, 0.0)), Target()
    assert box.size == (target.length_m, target.width_m, target.height_m)


def test_reading_the_constants_loads_no_compiled_code() -> None:
    code = (
        "import sys, seamark.sim.physics.constants;"
        "print({'numba', 'cv2', 'pybullet'} & set(sys.modules))"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "set()"
