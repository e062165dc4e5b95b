"""What counts as docked, and what it scores."""

import numpy as np
import pytest

from seamark.sim.metrics.docking import (
    DOCKED,
    FORCE_SHARE,
    LATCH_S,
    QUALITY,
    STAGES,
    STRUCK,
    TIME_SHARE,
    Docking,
    reached,
)
from seamark.sim.recording.telemetry import DOCK_INDEX, INDEX, Rows, width_for

DT, STEPS, STRIKE_N = 0.05, 1200, 100.0
COLUMNS = {**INDEX, **DOCK_INDEX}
MOUTH_M = 0.65
ARRIVES, SITS = 200, 400  # steps at which it is above the dock, and at rest on the rails


def rows_of(**columns: float) -> Rows:
    """A vehicle that comes from afar, sinks, and then has these values in the dock."""
    rows = np.zeros((STEPS, width_for(8, dock=True)))
    put(rows, slice(0, ARRIVES), dock_ahead=5.0, dock_below=-3.0)
    put(rows, slice(ARRIVES, SITS), dock_below=-1.0, w=0.1)
    put(rows, slice(SITS, STEPS), **columns)
    rows[:, COLUMNS["dock_depth"]] = rows[:, COLUMNS["dock_below"]] + MOUTH_M
    return rows


def put(rows: Rows, at: slice, **columns: float) -> None:
    for name, value in columns.items():
        rows[at, COLUMNS[name]] = value


def docking(rows: Rows) -> Docking:
    return Docking(rows, DT, STRIKE_N)


def test_a_vehicle_that_rests_on_the_rails_is_docked_when_the_latch_has_closed() -> None:
    level = docking(rows_of())

    assert level.docked
    assert level.time_s == pytest.approx(SITS * DT + LATCH_S)
    expected = 1.0 - TIME_SHARE * level.time_s / (STEPS * DT)
    assert QUALITY.compute(level) == pytest.approx(expected)


@pytest.mark.parametrize(
    "columns",
    [
        {"dock_ahead": 0.13},
        {"dock_side": -0.13},
        {"dock_below": -0.07},
        {"dock_turn": 0.16},
        {"roll": -0.16},
        {"pitch": 0.16},
        {"u": 0.06},
        {"w": -0.06},
    ],
)
def test_it_is_not_docked_while_it_is_off_its_seat_askew_or_moving(
    columns: dict[str, float],
) -> None:
    level = docking(rows_of(**columns))

    assert DOCKED.compute(level) == 0.0
    assert level.quality <= STAGES[-2].credit


def test_a_visit_that_is_shorter_than_the_latch_takes_is_no_docking() -> None:
    rows = rows_of()
    put(rows, slice(SITS + round(LATCH_S / DT) - 1, STEPS), u=0.2)

    assert not docking(rows).docked


def test_each_stage_counts_in_its_order_alone() -> None:
    whole = rows_of()
    above = rows_of(dock_below=-1.0)
    far = np.repeat(whole[:1], STEPS, axis=0)
    seated_at_once = whole[SITS:]

    assert len(reached(far, DT)) == 0
    assert len(reached(above, DT)) == 1
    assert len(reached(whole, DT)) == len(STAGES)
    assert reached(seated_at_once, DT)[0] >= round(1.0 / DT) - 1


def test_a_strike_halves_the_credit_and_two_quarter_it() -> None:
    once, twice = rows_of(), rows_of()
    put(once, slice(300, 302), contact_n=STRIKE_N + 1.0)
    put(twice, slice(300, 302), contact_n=STRIKE_N + 1.0)
    put(twice, slice(310, 311), contact_n=STRIKE_N + 1.0)

    assert (docking(once).strikes, docking(twice).strikes) == (1, 2)
    assert docking(twice).quality == pytest.approx(STRUCK * docking(once).quality)


def test_the_peak_force_costs_its_share_and_what_comes_after_the_latch_costs_nothing() -> None:
    soft, hard, late = rows_of(), rows_of(), rows_of()
    put(hard, slice(390, 391), contact_n=0.5 * STRIKE_N)
    put(late, slice(1000, 1001), contact_n=10.0 * STRIKE_N)

    assert docking(hard).quality == pytest.approx(docking(soft).quality - 0.5 * FORCE_SHARE)
    assert docking(hard).peak_n == 0.5 * STRIKE_N
    assert docking(late).quality == docking(soft).quality
    assert docking(late).strikes == 0


def test_an_approach_counts_again_only_after_the_vehicle_has_left_the_mouth() -> None:
    rows = rows_of(dock_below=-0.4)
    put(rows, slice(500, 520), dock_depth=0.0)  # within the mouth all the time
    put(rows, slice(600, 620), dock_depth=-0.3)  # above it
    put(rows, slice(700, 720), dock_ahead=2.0)  # beside it

    level = docking(rows)
    assert level.approaches == 3
    assert not level.docked


def test_of_a_part_of_a_level_time_is_a_share_of_the_whole() -> None:
    rows = rows_of()
    part = Docking(rows[:600], DT, STRIKE_N, whole=STEPS)

    assert part.quality == docking(rows).quality
