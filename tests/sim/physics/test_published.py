"""What is published about station keeping in a current, with perfect sight and a sampled DVL."""

import numpy as np
import pytest

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.sensors.dvl import Dvl
from seamark.sim.vehicles import load
from tests.sim.sampling import Truth, sample

PIXELS_PER_METRE = 514.7 / 2.27  # S: camera 2.27 m above the target
KP, KI = 0.5, 0.02  # S: the published gains


def errors_px(level: float, ki: float) -> Array:
    """Error in image X (sway) and Y (surge), (2400, 2) [px], with the published laws at 20 Hz."""
    pattern = Pattern(law="force", speed_swing=0.0)
    plant = Plant(load("girona500-uwsim"), Current(level, pattern=pattern))
    dvl = Dvl(streams(1, 0, 0).dvl)
    total, rows = np.zeros(2), []
    for step in range(0, 12_000, 5):
        pose, velocity = plant.pose(), plant.velocity()
        measured, _valid = sample(dvl, step, Truth(pose, velocity, 3.0))
        error = -pose[:2]  # the heading stays at zero: nothing turns this plant
        total += 0.05 * error
        surge, sway = KP * error + ki * total - measured[:2]
        heave = -measured[2]
        command = np.array([5 * surge, 5 * surge, 5 * heave, 5 * heave, 6 * sway])
        plant.advance(step, command, 5)
        rows.append(-error[::-1] * PIXELS_PER_METRE)
    return np.array(rows)


@pytest.mark.parametrize(("level", "expected"), [(0.1, 4.5), (0.2, 9.0), (0.3, 13.5), (0.4, 18.0)])
def test_p_settles_aside_by_more_the_stronger_the_current(level: float, expected: float) -> None:
    settled = errors_px(level, ki=0.0)[-600:, 0]

    assert settled.mean() == pytest.approx(expected, abs=0.3)
    assert np.ptp(settled) < 2.0


def test_pi_returns_to_zero_within_a_minute_at_the_strongest_level() -> None:
    sway = errors_px(0.4, ki=KI)[:, 0]

    outside = np.nonzero(np.abs(sway) > 2.0)[0]

    assert np.abs(sway).max() > 8.0
    assert 35.0 < 0.05 * outside[-1] < 60.0
    assert abs(sway[-600:].mean()) < 0.5


def test_neither_cancels_the_sinusoid_but_pi_is_better() -> None:
    p, pi = errors_px(0.4, ki=0.0)[-600:, 1], errors_px(0.4, ki=KI)[-600:, 1]

    assert np.ptp(p) > 6.0
    assert np.ptp(pi) > 6.0
    assert np.sqrt(np.mean(pi**2)) < np.sqrt(np.mean(p**2))


@pytest.mark.parametrize(
    ("azimuth", "command", "held"),
    [(0.0, [1.0, 1.0, 0.0, 0.0, 0.0], True), (np.pi / 2, [0.0, 0.0, 0.0, 0.0, 1.0], False)],
)
def test_the_real_vehicle_holds_bow_on_but_not_abeam(
    azimuth: float, command: list[float], held: bool
) -> None:
    """Drag of 42 N ahead is within 209 N; 112 N abeam is more than the one sway thruster has."""
    pattern = Pattern(azimuth_rad=azimuth, azimuth_swing_rad=0.0, speed_swing=0.0)
    plant = Plant(load("girona500"), Current(0.4, pattern=pattern))

    plant.advance(0, np.array(command), 6000)
    against_the_water = -float(plant.current_world() @ plant.pose()[:3])

    assert (against_the_water > 0.0) == held
