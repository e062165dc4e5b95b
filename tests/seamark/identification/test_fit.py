"""Parameters of synthetic logs are found again, and their intervals are honest."""

from dataclasses import replace

import numpy as np
import pytest

from performance.statistics.identification.coverage import held
from performance.statistics.identification.tank_day import log_of
from seamark.identification import fit as fit_module
from seamark.identification.fit import excited, fit, noise
from seamark.identification.parameters import COUNT, parameters_of, vehicle_with
from seamark.identification.series import series_of
from seamark.identification.whiteness import is_white
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import Vehicle, load

SECONDS = 20.0


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load("bluerov2-heavy-v2")


def wrong(vehicle: Vehicle) -> Vehicle:
    return vehicle_with(vehicle, parameters_of(vehicle) * np.linspace(0.7, 1.4, COUNT))


@pytest.mark.slow
def test_a_log_without_noise_gives_the_parameters_exactly(vehicle: Vehicle) -> None:
    log = log_of(vehicle, 3, seconds=SECONDS, noise=0.0)

    solution = fit(series_of(log, vehicle), wrong(vehicle), np.ones(COUNT, dtype=bool))

    assert solution.values == pytest.approx(parameters_of(vehicle), rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("logs", [1, pytest.param(5, marks=pytest.mark.long)])
def test_intervals_hold_the_truth_about_as_often_as_they_say(logs: int) -> None:
    inside = [held(seed, seconds=12.0) for seed in range(1000, 1000 + logs)]

    # With 95 %, five logs hold at most half of all in less than one case of 10,000: masses and
    # drags share a factor, so their errors come together.
    assert np.mean(inside) > 0.5


@pytest.mark.slow
def test_intervals_do_not_depend_on_the_step_of_the_derivatives(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this log the error of a coarse step looks like information: the interval shrinks."""
    series = series_of(log_of(vehicle, 1006, seconds=10.0), vehicle)
    widths = {}
    for step in (fit_module._CENTRAL_STEP, 1e-6, 1e-4):
        monkeypatch.setattr(fit_module, "_CENTRAL_STEP", step)
        solution = fit(series, vehicle, np.ones(COUNT, dtype=bool))
        widths[step] = float(solution.errors(robust=False)[0])

    ours, finer, coarse = widths.values()
    assert ours == pytest.approx(finer, rel=0.01)
    assert coarse < 0.9 * finer


@pytest.mark.slow
def test_only_what_moves_is_fitted(vehicle: Vehicle) -> None:
    log = log_of(vehicle, 6, seconds=SECONDS)
    values = {"u": log.values["u"]}
    pushed = 0.5 * (np.arange(len(log.stamps)) // 60 % 2)
    for at in range(4):  # the horizontal thrusters push ahead alone, the others not at all
        values[f"command_{at}"] = np.sign(vehicle.thrusters[at].direction[0]) * pushed
        values[f"command_{at + 4}"] = np.zeros(len(log.stamps))
    series = series_of(replace(log, values=values), vehicle)

    free = excited(series, vehicle, noise(series))

    assert free[[0, 12]].all()
    assert not free[[1, 5, 7, 11, 13, 17]].any()  # sway and yaw


def walk(correlation: float) -> Array:
    generator = np.random.default_rng(2)
    values = generator.standard_normal((400, 9))
    for at in range(1, 400):
        values[at] += correlation * values[at - 1]
    return values


@pytest.mark.parametrize(("correlation", "white"), [(0.0, True), (0.4, False)])
def test_residuals_that_follow_each_other_are_not_white(correlation: float, white: bool) -> None:
    assert is_white(walk(correlation), np.array([[0, 200], [200, 400]])) == white
