"""From pixels to metres: the position error is the way to the station above the target."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.camera.camera import Camera
from seamark.sim.camera.optics import CURRENTS
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import Water
from seamark.sim.control.station_keeper import Geometry, StationKeeper, update_position_error

HEIGHT_M = 2.27
GEOMETRY = Geometry(
    focal_px=CURRENTS.focal_px,
    centre_px=CURRENTS.principal_px,
    height_m=HEIGHT_M,
    size_m=(0.42, 0.13),
)
CAMERA = Camera(CURRENTS, Water(), Target(), noise_seed=1)


def keeper(range_from: str = "altitude") -> Any:
    """Return the record of a station keeper."""
    return StationKeeper(GEOMETRY, range_from=range_from, level_out_tilt=True).record[0]


def moved(forward: float, starboard: float, down: float) -> np.ndarray:
    """Return a pose from which the vehicle has to move by that much."""
    return start_pose(CURRENTS, Target(), HEIGHT_M) - [forward, starboard, down, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("range_from", ["altitude", "size"])
@pytest.mark.parametrize("move", [(0.3, 0, 0), (0, -0.2, 0), (0, 0, 0.4), (0.1, 0.2, -0.3)])
def test_the_error_is_how_far_the_vehicle_has_to_move(
    range_from: str, move: tuple[float, float, float]
) -> None:
    corners, station = CAMERA.corners(moved(*move)).ravel(), keeper(range_from)

    update_position_error(station, corners, True, HEIGHT_M + move[2], (0.0, 0.0), 0.05)

    assert station["error"] == pytest.approx(move, abs=1e-6)


@given(
    roll=st.floats(-0.2, 0.2),
    pitch=st.floats(-0.2, 0.2),
    x=st.floats(-0.3, 0.3),
    y=st.floats(-0.3, 0.3),
)
def test_tilt_does_not_move_the_station(roll: float, pitch: float, x: float, y: float) -> None:
    optics = CURRENTS
    pose = moved(x, y, 0.0)
    pose[3:5] = roll, pitch
    mount = np.array(optics.mount_m)
    turn = rotation(roll, pitch)
    pose[:3] += mount - turn @ mount  # so that the camera stays where it was

    corners, station = CAMERA.corners(pose).ravel(), keeper()
    update_position_error(station, corners, True, HEIGHT_M, (roll, pitch), 0.05)

    assert station["error"][:2] == pytest.approx((x, y), abs=1e-6)


def rotation(roll: float, pitch: float) -> np.ndarray:
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return about_y @ about_x


def test_after_a_loss_the_error_is_kept_for_a_second_and_then_zero() -> None:
    station = keeper()
    corners = CAMERA.corners(moved(0.3, 0.0, 0.0)).ravel()
    update_position_error(station, corners, True, HEIGHT_M, (0.0, 0.0), 0.25)
    seen = station["error"].tolist()

    ages, errors = [], []
    for _ in range(6):
        update_position_error(station, corners, False, HEIGHT_M, (0.0, 0.0), 0.25)
        ages.append(float(station["age_s"]))
        errors.append(station["error"].tolist())
        assert not station["visible"]

    assert ages == [0.25, 0.5, 0.75, 1.0, 1.25, 1.5]
    assert errors == [seen] * 4 + [[0.0, 0.0, 0.0]] * 2
