"""What counts as following a route."""

import numpy as np
import pytest

from seamark.sim.metrics.following import (
    CIRCLES_M,
    QUALITY,
    REJOIN_M,
    WINDOW_M,
    Following,
    share_followed,
)
from seamark.sim.metrics.windows import LevelFacts
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, Rows, width_for

FACTS = LevelFacts(level=0, speed=0.2, dt=0.05, settle_s=0.0, limits_n=(10.0, 10.0), thrusters=8)
LENGTH_M = 20.0


def rows_of(along: Array, error: float | Array = 0.0, thrust: float = 0.0) -> Rows:
    rows = np.zeros((len(along), width_for(8, route=True)))
    rows[:, ROUTE_INDEX["route_along"]] = along
    rows[:, ROUTE_INDEX["route_length"]] = LENGTH_M
    rows[:, ROUTE_INDEX["cross_track"]] = error
    rows[:, INDEX["thrust_0"] : INDEX["thrust_0"] + 8] = thrust
    return rows


def followed(rows: Rows) -> float:
    value = QUALITY.compute(Following(rows, FACTS))
    assert value is not None
    return value


WHOLE = np.linspace(0.0, LENGTH_M, 400)


def test_the_whole_route_without_error_and_power_is_one() -> None:
    assert followed(rows_of(WHOLE)) == pytest.approx(1.0)


def test_a_vehicle_that_stays_at_the_start_has_followed_nothing() -> None:
    assert followed(rows_of(np.zeros(400))) == 0.0


@pytest.mark.parametrize("circles", range(len(CIRCLES_M) + 1))
def test_each_circle_that_holds_the_error_counts_alike(circles: int) -> None:
    radii = (*CIRCLES_M, 0.0)
    error = 1.001 * radii[circles]

    assert followed(rows_of(WHOLE, error)) == pytest.approx(circles / len(CIRCLES_M))


def test_half_of_the_route_is_half_of_the_credit() -> None:
    assert followed(rows_of(0.5 * WHOLE)) == pytest.approx(0.5)


def test_a_part_that_is_left_out_does_not_count() -> None:
    along = np.where(WHOLE < 8.0, WHOLE, np.minimum(WHOLE + REJOIN_M, LENGTH_M))

    assert followed(rows_of(along)) == pytest.approx(1.0 - REJOIN_M / LENGTH_M, abs=0.01)


def test_full_power_costs_a_tenth() -> None:
    assert followed(rows_of(WHOLE, 0.0, thrust=10.0)) == pytest.approx(0.9)


def test_going_back_and_forth_earns_nothing_twice() -> None:
    there = np.linspace(0.0, 10.0, 200)
    waiting = np.full(200, 10.0)  # the way along never goes back

    assert followed(rows_of(np.concatenate([there, waiting]))) == pytest.approx(0.5)


def test_errors_after_the_end_do_not_count() -> None:
    errors = np.concatenate([np.full(400, 0.2), np.full(400, 9.0)])
    level = Following(rows_of(np.concatenate([WHOLE, np.full(400, LENGTH_M)]), errors), FACTS)

    assert level.completed
    assert max(level.error_m) == 0.2
    assert level.steps * level.dt == pytest.approx(20.0, abs=0.2)


def test_the_parts_of_a_level_add_up_to_the_whole() -> None:
    rows = rows_of(WHOLE, 0.3)
    parts, before = [], 0.0
    for row in rows:
        parts.append(float(share_followed(row[None], before)[0]))
        before = float(row[ROUTE_INDEX["route_along"]])

    assert sum(parts) == pytest.approx(Following(rows, FACTS).followed)
    assert max(parts) < WINDOW_M
