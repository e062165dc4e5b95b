"""Stages of a mission are physical facts in their order; the wrong box counts against it."""

import numpy as np
import pytest

from seamark.sim.metrics.mission import (
    ABOVE_S,
    MARK_M,
    METRICS,
    STAGES,
    WRONG,
    Mission,
    reached,
)
from seamark.sim.metrics.recovery import LIFT_M
from seamark.sim.recording.telemetry import INDEX, SEARCH_INDEX, WORK_INDEX, Rows, width_for

DT = 0.05
CREDIT = {stage.name: stage.credit for stage in STAGES}
FAR_M = 4.0  # of the box from the start, which is the world's origin
_COLUMNS = {**INDEX, **WORK_INDEX, **SEARCH_INDEX}


class Story:
    """Rows of a mission, a phase after the other; the vehicle starts at the world's origin."""

    def __init__(self) -> None:
        self._parts: list[Rows] = []

    def then(self, seconds: float, **values: float) -> "Story":
        """Go on for some time, with these values in the columns."""
        rows = np.zeros((round(seconds / DT), width_for(8, arm=True, work=True, search=True)))
        usual = {
            "workpiece_x": FAR_M,
            "workpiece_z": 4.9,
            "reach": 3.0,
            "work_rest_n": 20.0,
            "decoy_rest_n": 20.0,
        }
        for name, value in (usual | values).items():
            rows[:, _COLUMNS[name]] = value
        self._parts.append(rows)
        return self

    def told(self) -> Mission:
        return Mission(np.concatenate(self._parts), DT)


CARRIED = {"reach": 0.02, "work_arm_n": 300.0, "work_rest_n": 0.0}


def searched() -> Story:
    return Story().then(5.0).then(2.0, tool_x=FAR_M - 0.8)


def held() -> Story:
    return searched().then(ABOVE_S + 1.0, tool_x=FAR_M - 0.3)


def gripped() -> Story:
    return held().then(2.0, tool_x=FAR_M, reach=0.05)


def lifted() -> Story:
    there = {"tool_x": FAR_M, **CARRIED}
    up = 4.9 - LIFT_M - 0.1
    return gripped().then(1.0, workpiece_z=4.7, **there).then(1.0, workpiece_z=up, **there)


def brought(to_m: float, seconds: float = 3.0, **others: float) -> Story:
    up = 4.9 - LIFT_M - 0.1
    return lifted().then(seconds, workpiece_x=to_m, workpiece_z=up, **CARRIED, **others)


def credit(story: Story) -> float:
    return story.told().progress.credit


def test_each_stage_adds_its_credit() -> None:
    assert credit(Story().then(9.0)) == 0.0
    assert credit(searched()) == CREDIT["found"]
    assert credit(held()) == CREDIT["recognised"]
    assert credit(gripped()) == CREDIT["reached"]
    there = {"tool_x": FAR_M, **CARRIED}
    assert credit(gripped().then(1.0, workpiece_z=4.7, **there)) == CREDIT["taken"]
    assert credit(lifted()) == CREDIT["lifted"]
    assert credit(brought(MARK_M - 0.1)) == CREDIT["completed"] == 1.0


def test_half_of_the_way_home_gives_half_of_the_rest() -> None:
    half_way = FAR_M - 0.5 * (FAR_M - MARK_M)

    expected = CREDIT["lifted"] + 0.5 * (CREDIT["completed"] - CREDIT["lifted"])
    assert credit(brought(half_way)) == pytest.approx(expected)


def test_a_box_that_does_not_stay_at_the_start_is_not_yet_brought() -> None:
    passing = brought(0.5, seconds=1.0)

    assert len(passing.told().progress.steps) == len(STAGES) - 1
    assert credit(passing) == pytest.approx(CREDIT["completed"])  # all of the way, not the stage
    assert not passing.told().reached("completed")


def test_a_passage_over_the_box_is_no_hold() -> None:
    assert credit(searched().then(ABOVE_S - 1.0, tool_x=FAR_M).then(5.0)) == CREDIT["found"]


def test_the_hand_passes_the_box_by_far_without_finding_it() -> None:
    assert credit(Story().then(20.0, tool_x=FAR_M - 1.2)) == 0.0


def test_the_wrong_box_costs_credit_whenever_it_was_carried() -> None:
    wrong = {"decoy_arm_n": 300.0, "decoy_rest_n": 0.0}

    assert credit(Story().then(3.0, **wrong)) == -WRONG
    assert credit(brought(0.5, **wrong)) == pytest.approx(1.0 - WRONG)


@pytest.mark.parametrize(
    "almost",
    [
        {"decoy_arm_n": 300.0},  # gripped where it lies
        {"decoy_arm_n": 300.0, "decoy_rest_n": 0.0, "decoy_hull_n": 5.0},
        {"decoy_rest_n": 0.0},
    ],
)
def test_the_wrong_box_that_is_touched_or_pushed_costs_nothing(almost: dict[str, float]) -> None:
    assert credit(Story().then(3.0, **almost)) == 0.0


def test_stages_are_found_in_rows_as_they_come() -> None:
    story = brought(0.5).told()

    steps = reached(story.rows, DT)
    assert len(steps) == len(STAGES)
    assert list(steps) == sorted(steps)
    assert reached(story.rows[: steps[2]], DT) == steps[:2]


def test_every_metric_of_a_mission_in_which_nothing_happens_is_a_number() -> None:
    values = {metric.name: metric.compute(Story().then(3.0).told()) for metric in METRICS}

    assert values["search_s"] == values["time_s"] == 3.0
    assert all(value is not None and np.isfinite(value) for value in values.values())
