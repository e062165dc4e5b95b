"""Stages of a recovery are physical facts in their order; pushes and throws give little."""

import numpy as np
import pytest

from seamark.sim.metrics.recovery import HOLD_S, LIFT_M, METRICS, STAGES, STRIKE_N, STRUCK, Recovery
from seamark.sim.metrics.stages import first_run, longest_run
from seamark.sim.recording.telemetry import INDEX, WORK_INDEX, Rows, width_for

DT = 0.05
CREDIT = {stage.name: stage.credit for stage in STAGES}


class Story:
    """Rows of an attempt, a phase after the other."""

    def __init__(self) -> None:
        self._parts: list[Rows] = []

    def then(
        self,
        seconds: float,
        *,
        lift: float = 0.0,
        reach: float = 1.0,
        arm: float = 0.0,
        hull: float = 0.0,
        rest: float = 20.0,
        push: float = 0.0,
        blow: float = 0.0,
    ) -> "Story":
        rows = np.zeros((round(seconds / DT), width_for(8, arm=True, work=True)))
        values = {
            "workpiece_z": 4.9 - lift,
            "reach": reach,
            "work_arm_n": arm,
            "work_hull_n": hull,
            "work_rest_n": rest,
            "work_push_n": push,
        }
        for name, value in values.items():
            rows[:, WORK_INDEX[name]] = value
        rows[:, INDEX["contact_n"]] = blow
        self._parts.append(rows)
        return self

    def told(self) -> Recovery:
        return Recovery(np.concatenate(self._parts), DT)


def reached() -> Story:
    return Story().then(5.0).then(2.0, reach=0.05)


def gripped() -> Story:
    return reached().then(2.0, reach=0.03, arm=300.0)


def carried(lift: float, seconds: float) -> Story:
    free = {"reach": 0.03, "arm": 300.0, "rest": 0.0}
    return gripped().then(1.0, lift=0.5 * lift, **free).then(seconds, lift=lift, **free)


def credit(story: Story) -> float:
    return story.told().progress.credit


def test_each_stage_adds_its_credit() -> None:
    assert credit(Story().then(5.0)) == 0.0
    assert credit(reached()) == CREDIT["reached"]
    assert credit(gripped()) == CREDIT["touched"]
    assert credit(carried(0.3, 2.0)) == CREDIT["taken"]
    assert credit(carried(LIFT_M + 0.01, HOLD_S + 1.0)) == CREDIT["completed"] == 1.0


@pytest.mark.parametrize("more_s", [0.0, 0.2, 0.4, 0.6])
def test_no_credit_is_more_than_that_of_all_stages(more_s: float) -> None:
    assert credit(carried(LIFT_M + 0.01, HOLD_S + more_s)) == pytest.approx(1.0)
    assert credit(carried(LIFT_M + 0.01, HOLD_S + more_s)) <= CREDIT["completed"]


def test_half_of_the_time_in_which_to_hold_it_gives_half_of_the_rest() -> None:
    half = 0.5 * (CREDIT["lifted"] + CREDIT["completed"])

    assert credit(carried(LIFT_M + 0.01, 0.5 * HOLD_S)) == pytest.approx(half)


def test_a_tool_that_drifts_past_has_not_reached_the_handle() -> None:
    assert credit(Story().then(0.5, reach=0.05).then(5.0)) == 0.0


def test_a_box_that_is_pushed_along_the_seabed_counts_as_touched() -> None:
    assert credit(reached().then(20.0, reach=0.05, arm=30.0, push=30.0)) == CREDIT["touched"]


def test_a_box_on_the_hull_is_not_taken() -> None:
    story = gripped().then(15.0, lift=0.8, arm=5.0, hull=20.0, rest=0.0)

    assert credit(story) == CREDIT["touched"]


def test_a_box_that_leans_on_something_is_not_taken() -> None:
    assert credit(gripped().then(15.0, lift=0.8, arm=300.0, rest=1.0)) == CREDIT["touched"]


def test_a_box_that_is_thrown_is_not_taken() -> None:
    assert credit(gripped().then(15.0, lift=0.8, arm=0.0, rest=0.0)) == CREDIT["touched"]


def test_holds_with_a_break_are_not_added_up() -> None:
    free = {"reach": 0.03, "arm": 300.0, "rest": 0.0}
    story = carried(LIFT_M + 0.01, 6.0).then(1.0, lift=0.2, **free).then(6.0, lift=0.6, **free)

    assert credit(story) < CREDIT["completed"]
    assert story.told().progress.reached(3)
    assert not story.told().progress.reached(4)


@pytest.mark.parametrize("blow", [{"blow": STRIKE_N + 1.0}, {"push": STRIKE_N + 1.0}])
def test_a_strike_before_it_is_carried_halves_the_credit(blow: dict[str, float]) -> None:
    free = {"reach": 0.03, "arm": 300.0, "rest": 0.0}
    story = reached().then(0.1, reach=0.05, arm=10.0, **blow).then(1.0, lift=0.3, **free)
    story.then(HOLD_S + 1.0, lift=0.6, **free)

    assert credit(story) == STRUCK * CREDIT["completed"]


def test_the_weight_of_the_box_on_the_arm_is_no_strike() -> None:
    free = {"reach": 0.03, "arm": 900.0, "rest": 0.0, "push": STRIKE_N + 50.0}
    story = gripped().then(1.0, lift=0.3, **free).then(HOLD_S + 1.0, lift=0.6, **free)

    assert credit(story) == CREDIT["completed"]


def test_every_metric_of_an_attempt_in_which_nothing_happens_is_a_number() -> None:
    values = {metric.name: metric.compute(Story().then(3.0).told()) for metric in METRICS}

    assert values["credit"] == 0.0
    assert values["time_s"] == 3.0
    assert all(value is not None and np.isfinite(value) for value in values.values())


def test_runs_of_steps_are_counted_in_a_row_and_from_the_start() -> None:
    holds = np.array([True, True, False, True, True, True])

    assert first_run(holds, 2) == 1
    assert first_run(holds, 3) == 5
    assert first_run(holds, 2, start=1) == 4
    assert first_run(holds, 4) is None
    assert longest_run(holds) == 3
    assert longest_run(holds, start=4) == 2
