"""Sensors have the right mean and noise, and sample at their own period from their own stream."""

import numpy as np
import pytest

from seamark.sim.numerics.random_streams import streams
from seamark.sim.registry import benchmark
from seamark.sim.sensors.ahrs import Ahrs, wrap_angle
from seamark.sim.sensors.altimeter import Altimeter
from seamark.sim.sensors.depth import DepthGauge
from seamark.sim.sensors.dvl import Dvl
from seamark.sim.sensors.sensor import Sensor
from tests.sim.sampling import Truth, sample

TRUTH = Truth(
    pose=np.array([1.0, 2.0, 3.0, 0.01, -0.02, 3.1415]),
    velocity=np.array([0.3, -0.2, 0.1, 0.01, 0.02, 0.03]),
    altitude=2.5,
)
EXPECTED = {
    "dvl": (TRUTH.velocity[:3], 0.0015),
    "depth": (TRUTH.pose[2:3], 0.01),
    "altimeter": (np.array([2.5]), 0.001),
}


def sensor(name: str, seed: int = 1) -> Sensor:
    source = streams(seed, 0, 0)
    return {
        "dvl": lambda: Dvl(source.dvl),
        "depth": lambda: DepthGauge(source.depth),
        "altimeter": lambda: Altimeter(source.altimeter),
        "ahrs": lambda: Ahrs(source.ahrs),
    }[name]()


def above_bottom(altitude: float, roll: float = 0.0) -> Truth:
    return Truth(np.array([0.0, 0.0, 0.0, roll, 0.0, 0.0]), TRUTH.velocity, altitude)


@pytest.mark.parametrize("name", EXPECTED)
def test_readings_have_the_right_mean_and_standard_deviation(name: str) -> None:
    device, (mean, sigma) = sensor(name), EXPECTED[name]

    readings = np.array([sample(device, 20 * i, TRUTH)[0] for i in range(4000)])

    assert readings.mean(axis=0) == pytest.approx(mean, abs=5.0 * sigma / 4000**0.5)
    assert readings.std(axis=0) == pytest.approx(np.full(mean.size, sigma), rel=0.06)


@pytest.mark.parametrize("name", [*EXPECTED, "ahrs"])
def test_a_value_is_held_until_the_next_measurement(name: str) -> None:
    device = sensor(name)

    first, valid = sample(device, 0, TRUTH)
    held, _valid = sample(device, 4, TRUTH)
    new, _valid = sample(device, 20, TRUTH)

    assert valid
    assert np.array_equal(first, held)
    assert not np.array_equal(first, new)


def test_the_heading_is_wrapped_across_the_south() -> None:
    device = sensor("ahrs")

    yaws = [sample(device, 5 * i, TRUTH)[0][2] for i in range(400)]

    assert min(yaws) < -3.1410
    assert max(yaws) > 3.1410
    assert wrap_angle(-np.pi) == np.pi


def test_without_bottom_lock_the_last_valid_velocity_is_held() -> None:
    device = Dvl(streams(1, 0, 0).dvl, sigma=0.0)

    good, valid = sample(device, 0, TRUTH)
    high, lock_high = sample(device, 20, above_bottom(100.0))
    tilted, lock_tilted = sample(device, 40, above_bottom(2.0, roll=0.8))
    _back, lock_back = sample(device, 60, above_bottom(2.0))

    assert (valid, lock_high, lock_tilted, lock_back) == (True, False, False, True)
    assert np.array_equal(good, high)
    assert np.array_equal(good, tilted)


def test_nothing_is_valid_before_the_first_valid_reading() -> None:
    _values, valid = sample(Dvl(streams(1, 0, 0).dvl), 0, above_bottom(0.1))

    assert not valid


def test_bias_and_scale_act_on_each_axis() -> None:
    device = Dvl(streams(1, 0, 0).dvl, sigma=0.0, bias=(0.01, 0.02, -0.03), scale_error=0.1)

    values, _valid = sample(device, 0, TRUTH)

    assert values == pytest.approx(TRUTH.velocity[:3] * 1.1 + [0.01, 0.02, -0.03])


def test_the_bias_of_an_ahrs_acts_on_its_angles_and_keeps_them_in_one_turn() -> None:
    device = Ahrs(streams(1, 0, 0).ahrs, sigma=0.0, rate_sigma=0.0, bias=(0.01, -0.02, 0.03))

    values, _valid = sample(device, 0, TRUTH)

    expected = [0.02, -0.04, 3.1715 - 2 * np.pi, *TRUTH.velocity[3:]]
    assert values == pytest.approx(expected)


def test_drop_outs_are_as_frequent_as_configured_and_do_not_change_the_noise() -> None:
    clean, broken = Dvl(streams(1, 0, 0).dvl), Dvl(streams(1, 0, 0).dvl, dropout=0.3)

    pairs = [(sample(clean, 20 * i, TRUTH), sample(broken, 20 * i, TRUTH)) for i in range(3000)]
    lost = [not valid for _clean, (_values, valid) in pairs]
    kept = [(a[0], b[0]) for a, b in pairs if b[1]]

    assert np.mean(lost) == pytest.approx(0.3, abs=0.04)
    assert all(np.array_equal(a, b) for a, b in kept)


def test_another_sensor_never_changes_this_one() -> None:
    alone, shared = streams(5, 0, 0), streams(5, 0, 0)
    dvl_alone, dvl_shared = Dvl(alone.dvl), Dvl(shared.dvl)
    depth = DepthGauge(shared.depth)

    readings = []
    for step in range(0, 400, 20):
        sample(depth, step, TRUTH)
        readings.append((sample(dvl_alone, step, TRUTH)[0], sample(dvl_shared, step, TRUTH)[0]))

    assert all(np.array_equal(a, b) for a, b in readings)


def test_a_sensor_without_a_period_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one step"):
        Dvl(streams(1, 0, 0).dvl, period_steps=0)


def test_a_sensor_refuses_more_readings_than_it_has_noise_for() -> None:
    device = DepthGauge(streams(1, 0, 0).depth, readings=2)
    for step in (0, 19, 20, 39):
        sample(device, step, TRUTH)

    with pytest.raises(IndexError, match="fewer readings"):
        sample(device, 40, TRUTH)


def test_the_number_of_readings_does_not_change_the_readings() -> None:
    few, many = (Dvl(streams(1, 0, 0).dvl, readings=count) for count in (5, 500))

    pairs = [(sample(few, 20 * i, TRUTH), sample(many, 20 * i, TRUTH)) for i in range(5)]

    assert all(one == other for one, other in pairs)


RATES = [(5.0, 0.01, 20), (20.0, 0.01, 5), (20.0, 0.005, 10)]


@pytest.mark.parametrize(("rate", "physics_step", "period"), RATES)
def test_a_dvl_samples_at_its_rate_whatever_the_physics_step(
    rate: float, physics_step: float, period: int
) -> None:
    config = benchmark("currents-v1").read({"dvl_rate_hz": rate, "physics_step_s": physics_step})
    device = Dvl(streams(1, 0, 0).dvl, period_steps=config.dvl_period_steps)

    readings = [sample(device, step, TRUTH)[0] for step in range(4 * period)]

    assert len(set(readings)) == 4
    assert all(len(set(readings[i * period : (i + 1) * period])) == 1 for i in range(4))
