"""Plugging a connector: stages are facts of its pose, and depth counts that a hand gave it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.sim.metrics.attempts import STRIKE_N, STRUCK
from seamark.sim.metrics.connection import AWAY_S, METRICS, STAGES, TIP_M, Connection
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX, WORK_INDEX, Rows, width_for

DT = 0.05
CREDIT = {stage.name: stage.credit for stage in STAGES}
PARKED_M, FACE_M = 0.2, 4.4
GRIPPED = {"reach": 0.02, "arm": 600.0, "push": 10.0}


class Story:
    """Rows of an attempt, a phase after the other; in each the tip moves evenly."""

    def __init__(self) -> None:
        self._parts: list[Rows] = []
        self._tip = (PARKED_M, 0.0)  # [m] from the receptacle's axis, and below its face

    def then(
        self,
        seconds: float,
        to: tuple[float, float] | None = None,
        *,
        reach: float = 1.0,
        arm: float = 0.0,
        push: float = 0.0,
        hull: float = 0.0,
        blow: float = 0.0,
        wrist: float = 0.0,
        tilt: float = 0.0,
    ) -> "Story":
        count = round(seconds / DT)
        rows = np.zeros((count, width_for(8, arm=True, work=True)))
        share = np.arange(1, count + 1) / count
        goal = to or self._tip
        off, deep = (a + share * (b - a) for a, b in zip(self._tip, goal, strict=True))
        values = {
            "workpiece_x": off + TIP_M * np.sin(-tilt),
            "workpiece_z": FACE_M + deep - TIP_M * np.cos(tilt),
            "workpiece_pitch": tilt,
            "work_rest_n": 10.0 * (deep >= 0.0),
            "reach": reach,
            "work_arm_n": arm,
            "work_push_n": push,
            "work_hull_n": hull,
        }
        for name, value in values.items():
            rows[:, WORK_INDEX[name]] = value
        rows[:, INDEX["contact_n"]] = blow
        rows[:, ARM_INDEX["wrist_fx"]] = wrist
        self._tip = goal
        self._parts.append(rows)
        return self

    def told(self) -> Connection:
        return Connection(np.concatenate(self._parts), DT)


def gripped() -> Story:
    return Story().then(3.0).then(2.0, reach=0.03).then(2.0, **GRIPPED)


def over_the_mouth() -> Story:
    return gripped().then(3.0, (PARKED_M, -0.3), **GRIPPED).then(3.0, (0.0, -0.3), **GRIPPED)


def inserted(depth_m: float) -> Story:
    return over_the_mouth().then(6.0, (0.0, depth_m), **GRIPPED).then(1.0, **GRIPPED)


def credit(story: Story) -> float:
    return story.told().progress.credit


def test_each_stage_adds_its_credit() -> None:
    assert credit(Story().then(5.0)) == 0.0
    assert credit(Story().then(3.0).then(2.0, reach=0.03)) == CREDIT["reached"]
    assert credit(gripped()) == CREDIT["touched"]
    assert credit(over_the_mouth()) == CREDIT["unparked"]
    assert credit(inserted(-0.01)) == CREDIT["entered"]
    assert credit(inserted(0.06)) == CREDIT["halfway"]
    assert credit(inserted(0.09)) == CREDIT["seated"]
    assert credit(inserted(0.09).then(2.0, reach=0.1)) == CREDIT["released"]
    assert credit(inserted(0.09).then(2.0 + AWAY_S, reach=0.4)) == CREDIT["completed"] == 1.0


def test_a_connector_that_leans_is_as_deep_as_its_tip() -> None:
    story = inserted(0.09).then(2.0, tilt=0.1, **GRIPPED).told()

    assert story.depth_m[-1] == pytest.approx(0.09)
    assert story.off_m[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("tilt", [(0.14, 0.0), (-0.1, 0.09), (0.0, -0.14)])
def test_depth_is_along_the_axis_of_a_tilted_bore_and_not_along_the_vertical(
    tilt: tuple[float, float],
) -> None:
    panel = Rotation.from_rotvec([*tilt, 0.0])
    vertical = np.array([0.0, 0.0, 1.0])
    mouth, into = FACE_M * vertical, panel.apply(vertical)
    parked = mouth + panel.apply([PARKED_M, 0.0, 0.0])
    tips = np.array([parked, mouth, mouth + 0.08 * into, mouth + 0.08 * vertical])
    upright = Rotation.identity()
    attitudes = [panel, panel, panel, upright]
    rows = np.zeros((len(tips), width_for(8, arm=True, work=True)))
    for row, tip, attitude in zip(rows, tips, attitudes, strict=True):
        row[[WORK_INDEX[f"workpiece_{axis}"] for axis in "xyz"]] = tip - TIP_M * attitude.apply(
            vertical
        )
        row[[WORK_INDEX[f"workpiece_{axis}"] for axis in ("roll", "pitch", "yaw")]] = (
            attitude.as_euler("xyz")
        )

    attempt = Connection(rows, DT)

    angle = np.linalg.norm(tilt)
    assert attempt.depth_m == pytest.approx([0.0, 0.0, 0.08, 0.08 * np.cos(angle)], abs=1e-12)
    assert attempt.off_m == pytest.approx([PARKED_M, 0.0, 0.0, 0.08 * np.sin(angle)], abs=1e-12)


def test_one_that_is_dropped_into_the_receptacle_was_not_inserted() -> None:
    dropped = over_the_mouth().then(1.0, (0.0, 0.09)).then(3.0, reach=0.4)

    assert credit(dropped) == CREDIT["unparked"]
    assert dropped.told().inserted_m.max() == 0.0


def test_one_that_is_gripped_after_the_drop_is_at_the_mouth_and_no_farther() -> None:
    dropped = over_the_mouth().then(1.0, (0.0, 0.09)).then(3.0, **GRIPPED)

    assert credit(dropped.then(6.0, reach=0.4)) == CREDIT["entered"]


@pytest.mark.parametrize(
    "how",
    [
        {"reach": 0.02, "arm": 100.0, "push": 100.0},  # from one side
        {"reach": 0.2, "arm": 600.0, "push": 10.0},  # elsewhere than at the handle
        GRIPPED | {"hull": 5.0},
    ],
)
def test_depth_counts_only_while_a_hand_alone_holds_the_handle(how: dict[str, float]) -> None:
    pressed = over_the_mouth().then(4.0, (0.0, 0.01), **GRIPPED).then(4.0, (0.0, 0.09), **how)

    assert credit(pressed) == CREDIT["entered"]


def test_the_last_bit_may_be_its_own_weight() -> None:
    story = inserted(0.06).then(1.0, (0.0, 0.09), reach=0.1).then(2.0 + AWAY_S, reach=0.4)

    assert credit(story) == CREDIT["completed"]


def test_one_that_comes_out_again_is_neither_released_nor_withdrawn_from() -> None:
    story = inserted(0.09).then(1.0, (0.0, 0.03), **GRIPPED).then(2.0 + AWAY_S, reach=0.4)

    assert credit(story) == CREDIT["seated"]


def test_who_stays_in_touch_has_not_released_it() -> None:
    assert credit(inserted(0.09).then(9.0, reach=0.05, arm=0.5)) == CREDIT["seated"]


@pytest.mark.parametrize("how", [{"blow": STRIKE_N + 1.0}, {"wrist": -STRIKE_N - 1.0}])
def test_a_strike_halves_the_credit(how: dict[str, float]) -> None:
    story = inserted(0.06).then(DT, **GRIPPED | how)

    assert credit(story) == STRUCK * CREDIT["halfway"]
    assert story.told().strikes == 1


def test_the_metrics_of_an_attempt_are_numbers() -> None:
    story = inserted(0.07).told()

    values = {metric.name: metric.compute(story) for metric in METRICS}

    assert values["credit"] == CREDIT["halfway"]
    assert values["inserted_mm"] == pytest.approx(70.0, abs=1e-6)
    assert (values["seated"], values["halfway"], values["completed"]) == (0.0, 1.0, 0.0)
