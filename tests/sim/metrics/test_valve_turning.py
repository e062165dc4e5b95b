"""Turning a valve: angles count that the arm turned, with its tool at the handle."""

import numpy as np
import pytest

from seamark.sim.metrics.attempts import SIDES_S, STRIKE_N, STRUCK
from seamark.sim.metrics.valve_turning import GRASP_M, METRICS, STAGES, Turning
from seamark.sim.numerics.libm import PI
from seamark.sim.recording.telemetry import INDEX, WORK_INDEX, Rows, width_for

DT = 0.05
CREDIT = {stage.name: stage.credit for stage in STAGES}


class Story:
    """Rows of an attempt, a phase after the other; in each the handle turns evenly."""

    def __init__(self) -> None:
        self._parts: list[Rows] = []
        self._angle = 0.0

    def then(
        self,
        seconds: float,
        *,
        turn_deg: float = 0.0,
        reach: float = 1.0,
        arm: float = 0.0,
        hull: float = 0.0,
        push: float = 0.0,
        blow: float = 0.0,
    ) -> "Story":
        count = round(seconds / DT)
        rows = np.zeros((count, width_for(8, arm=True, work=True)))
        values = {"reach": reach, "work_arm_n": arm, "work_hull_n": hull, "work_push_n": push}
        for name, value in values.items():
            rows[:, WORK_INDEX[name]] = value
        rows[:, INDEX["contact_n"]] = blow
        turned = self._angle + turn_deg * PI / 180.0 * np.arange(1, count + 1) / count
        rows[:, WORK_INDEX["workpiece_joint"]] = turned
        self._angle = float(turned[-1])
        self._parts.append(rows)
        return self

    def told(self) -> Turning:
        return Turning(np.concatenate(self._parts), DT)


def touched() -> Story:
    return Story().then(3.0).then(2.0, reach=0.03).then(0.5, reach=0.03, arm=50.0)


def turned(angle_deg: float) -> Story:
    return touched().then(5.0, turn_deg=angle_deg, reach=0.03, arm=50.0).then(2.0, reach=0.3)


def credit(story: Story) -> float:
    return story.told().progress.credit


def test_each_stage_adds_its_credit() -> None:
    assert credit(Story().then(5.0)) == 0.0
    assert credit(Story().then(3.0).then(2.0, reach=0.03)) == CREDIT["reached"]
    assert credit(touched()) == CREDIT["touched"]
    assert credit(turned(30.01)) == pytest.approx(CREDIT["started"], abs=1e-3)
    assert credit(turned(90.01)) == pytest.approx(CREDIT["halved"], abs=1e-3)
    assert credit(turned(170.01)) == CREDIT["completed"] == 1.0


def test_half_of_the_way_to_the_next_angle_gives_half_of_its_credit() -> None:
    assert credit(turned(60.0)) == pytest.approx(0.5 * (CREDIT["started"] + CREDIT["halved"]))
    assert credit(turned(15.0)) == pytest.approx(0.5 * (CREDIT["touched"] + CREDIT["started"]))


def test_a_handle_that_was_turned_the_wrong_way_gives_no_more_than_a_touch() -> None:
    assert credit(turned(-180.0)) == CREDIT["touched"]


def test_an_angle_that_is_not_held_for_a_second_does_not_count() -> None:
    story = touched().then(0.4, turn_deg=175.0, reach=0.03, arm=50.0)
    story.then(0.4, turn_deg=-175.0, reach=0.03, arm=50.0).then(5.0, reach=0.3)

    assert credit(story) == CREDIT["touched"]


@pytest.mark.parametrize(
    "how",
    [
        {"hull": 20.0},
        {"arm": 0.0},
        {"reach": GRASP_M + 0.01},
        {"push": 50.0},
        {"push": 49.0},
    ],
    ids=[
        "the hull touches",
        "the arm does not",
        "the tool is elsewhere",
        "the arm pushes with one side",
        "the other side only brushes it",
    ],
)
def test_rotation_does_not_count(how: dict[str, float]) -> None:
    held = {"reach": 0.03, "arm": 50.0} | how
    story = touched().then(SIDES_S, **held).then(5.0, turn_deg=175.0, **held).then(2.0)

    assert credit(story) == CREDIT["touched"]


def test_two_sides_that_do_not_push_alike_turn_a_handle() -> None:
    story = touched().then(5.0, turn_deg=175.0, reach=0.03, arm=50.0, push=40.0).then(2.0)

    assert credit(story) == CREDIT["completed"]


def test_a_side_that_lets_go_for_a_moment_does_not_end_a_turn() -> None:
    story = touched()
    for _ in range(5):
        story.then(0.9, turn_deg=32.0, reach=0.03, arm=50.0, push=10.0)
        story.then(0.1, turn_deg=3.0, reach=0.03, arm=50.0, push=50.0)

    assert credit(story.then(2.0)) == CREDIT["completed"]


def test_turning_to_and_fro_adds_up_to_nothing() -> None:
    story = touched()
    for _ in range(20):
        story.then(1.0, turn_deg=20.0, reach=0.03, arm=50.0)
        story.then(1.0, turn_deg=-20.0, reach=0.03, arm=50.0)

    assert story.told().held_deg() <= 20.0
    assert credit(story) < CREDIT["started"]


def test_what_others_turned_back_counts_against_the_arm() -> None:
    story = touched().then(5.0, turn_deg=-90.0).then(3.0, turn_deg=90.0, reach=0.03, arm=50.0)

    assert credit(story.then(3.0, reach=0.03, arm=50.0)) == CREDIT["touched"]


@pytest.mark.parametrize("blow", [{"blow": STRIKE_N + 1.0}, {"push": STRIKE_N + 1.0}])
def test_a_strike_at_any_time_halves_the_credit(blow: dict[str, float]) -> None:
    story = turned(170.01).then(0.1, **blow).then(0.1).then(0.1, **blow).then(1.0)

    assert credit(story) == STRUCK * CREDIT["completed"]
    assert story.told().strikes == 2


def test_a_tool_that_drifts_past_has_not_reached_the_handle() -> None:
    assert credit(Story().then(0.5, reach=0.03).then(5.0)) == 0.0


def test_every_metric_of_an_attempt_in_which_nothing_happens_is_a_number() -> None:
    values = {metric.name: metric.compute(Story().then(0.5).told()) for metric in METRICS}

    assert values["credit"] == values["turned_deg"] == values["strikes"] == 0.0
    assert values["time_s"] == 0.5
    assert all(value is not None and np.isfinite(value) for value in values.values())
