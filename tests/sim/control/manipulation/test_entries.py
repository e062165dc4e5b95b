"""What the built-in entries of benchmarks with an arm do with what they know, step by step."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.connect_v1 import scene
from seamark.sim.benchmarks.intervention.tilt import Tilt
from seamark.sim.camera import Camera, Optics, Target, Water
from seamark.sim.control.manipulation import connector, recover, valve
from seamark.sim.control.manipulation.connector_oracle import ConnectorOracle
from seamark.sim.control.manipulation.oracle import AHEAD_S, RecoverOracle, ValveOracle
from seamark.sim.control.manipulation.sight import Pinhole
from seamark.sim.control.velocity_law import AXIS, MEASURED
from seamark.sim.registry import benchmark
from tests.sim.control.manipulation.pinhole import projected

DT_S = 0.05
LATER = {"index": 3, "count": 6, "duration_s": 90.0, "dt": DT_S, "t": 270.0}  # a level of a trial
WATCHED = (-1.2, 0.3, 3.3, 0.0, 0.0, 0.5)  # a pose from which the camera has its target


def told(name: str) -> dict[str, Any]:
    """What a program of a benchmark is told."""
    return dict(benchmark(name).read({}).for_program())


def corners(config: dict[str, Any], pose: tuple[float, ...]) -> NDArray[np.float64]:
    """Corners of the benchmark's face in the camera at a pose, (8,) [px]."""
    length, width = config["face_m"]
    optics = Optics(
        width=config["camera_width_px"],
        height=config["camera_height_px"],
        focal_px=config["camera_focal_px"],
        mount_m=tuple(config["camera_mount_m"]),
    )
    target = Target(length_m=length, width_m=width, height_m=0.3, heading_rad=0.7)
    return np.asarray(
        Camera(optics, Water.grey(0.2), target, noise_seed=1).corners(np.array(pose))
    ).ravel()


def observed(**changes: Any) -> Any:
    """An observation of a vehicle at rest that sees nothing and touches nothing."""
    rest = {
        "t": LATER["t"],
        "attitude": np.zeros(3),
        "rates": np.zeros(3),
        "velocity": np.zeros(3),
        "depth": 3.0,
        "joints": np.zeros(5),
        "touch": np.zeros(3),
        "target_visible": False,
        "corners": np.zeros(8),
        "wrist_force": np.zeros(3),
        "wrist_torque": np.zeros(3),
    }
    return SimpleNamespace(**rest | changes)


@pytest.mark.parametrize(
    ("name", "blind"), [("recover-v1", recover.Blind), ("valve-v1", valve.Blind)]
)
def test_a_blind_entry_sees_at_the_start_of_each_level_and_no_longer(name: str, blind: Any) -> None:
    config = told(name)
    entry = blind(config)
    here, elsewhere = (corners(config, (WATCHED[0] + off, *WATCHED[1:])) for off in (0.0, 0.1))

    entry.reset(LATER)
    entry.step(observed(target_visible=True, corners=here))
    first = entry.work
    late = LATER["t"] + blind.LOOK_S + DT_S
    entry.step(observed(t=late, target_visible=True, corners=elsewhere))

    assert first is not None
    assert entry.work == first


class StillPlant:
    """A vehicle at rest, in water that moves as it is told."""

    grip_m = (0.0, 0.0, 0.0)

    def __init__(self, water: tuple[float, float] = (0.0, 0.0), yaw: float = 0.0) -> None:
        self.water, self.yaw = water, yaw
        self.asked: list[float] = []
        self.work = np.array([0.5, 0.0, 4.0, *np.zeros(18)])

    def pose(self) -> NDArray[np.float64]:
        return np.array([0.0, 0.0, 3.0, 0.0, 0.0, self.yaw])

    def velocity(self) -> NDArray[np.float64]:
        return np.zeros(6)

    def joints(self) -> NDArray[np.float64]:
        return np.zeros(5)

    def measure_work(self) -> None:
        """Leave the work where it is."""

    def current_world(self, ahead_s: float = 0.0) -> NDArray[np.float64]:
        self.asked.append(ahead_s)
        return np.array([*self.water, 0.0])


class Law:
    """What oracles use of a velocity controller."""

    def __init__(self) -> None:
        self.axes = np.zeros(3, AXIS)
        self.axes["quadratic"] = (100.0, 600.0, 600.0)
        self.measured = np.zeros(1, MEASURED)

    def reset(self) -> None:
        """Forget nothing."""

    def records(self) -> tuple[Any, Any, Any]:
        return None, self.axes, None

    def step(self, command: Any, dt: float) -> NDArray[np.float64]:
        return np.zeros(5)


ORACLES = [
    ("recover-v1", RecoverOracle),
    ("valve-v1", ValveOracle),
    ("connect-v1", ConnectorOracle),
]


def oracle_in(name: str, oracle: Any, plant: StillPlant) -> Any:
    """An oracle at the start of a level that is not the first of its trial."""
    entry = oracle(told(name))
    entry._plant, entry._law, entry._grip_m = plant, Law(), plant.grip_m
    entry.reset(LATER)
    return entry


@pytest.mark.parametrize(("name", "oracle"), ORACLES)
def test_an_oracle_looks_ahead_in_each_level_but_not_beyond_its_end(name: str, oracle: Any) -> None:
    plant = StillPlant()
    entry = oracle_in(name, oracle, plant)

    entry.step(observed())
    at_first, plant.asked = max(plant.asked), []
    entry.step(observed(t=LATER["t"] + LATER["duration_s"]))

    assert at_first == pytest.approx(AHEAD_S)
    assert max(plant.asked) == 0.0


@pytest.mark.parametrize(("name", "oracle"), ORACLES[1:])
@pytest.mark.parametrize(("comes_from", "sign"), [(1.0, 1), (-1.0, -1), (2.2, -1), (-2.2, 1)])
def test_an_oracle_turns_the_nearer_end_into_the_current(
    name: str, oracle: Any, comes_from: float, sign: int
) -> None:
    water = (-0.4 * np.cos(comes_from), -0.4 * np.sin(comes_from))
    entry = oracle_in(name, oracle, StillPlant(water))

    entry.step(observed())

    assert np.sign(entry._off_the_bow()) == sign
    assert abs(entry._off_the_bow()) < 0.5 * np.pi


@pytest.mark.parametrize(("name", "oracle"), ORACLES[1:])
def test_an_oracle_tells_the_velocity_controller_how_the_force_of_the_current_changes(
    name: str, oracle: Any
) -> None:
    plant = StillPlant((0.0, 0.2))
    entry = oracle_in(name, oracle, plant)
    entry._law.axes["disturbance"] = 5.0  # of something else, which it has learnt

    for east in (0.2, 0.3):
        plant.water = (0.0, east)
        entry.step(observed())
        entry.commands()

    surge, sway, heave = entry._law.axes["disturbance"].tolist()
    assert (surge, heave) == (5.0, 5.0)
    assert sway == pytest.approx(5.0 + 600.0 * 0.3 * 0.3)


@pytest.fixture
def resolved_rate() -> connector.ResolvedRate:
    entry = connector.ResolvedRate(told("connect-v1"))
    entry.reset(LATER)
    return entry


def test_a_vehicle_that_moves_as_its_goal_does_leaves_nothing_to_the_arm(
    resolved_rate: connector.ResolvedRate,
) -> None:
    resolved_rate.drift, resolved_rate.falling = [0.01, -0.005], 0.06

    left = resolved_rate._from_the_goal((0.01, -0.005, 0.06))

    assert left == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("touch", "sign"), [((0, 1, 0), -1), ((0, 0, 1), 1), ((0, 1, 1), 0)])
def test_a_closing_hand_goes_to_the_side_of_the_jaw_that_touches_alone(
    resolved_rate: connector.ResolvedRate, touch: tuple[int, ...], sign: int
) -> None:
    joints = [0.0, 0.45, 0.6, 0.0, 0.3]
    resolved_rate._go(connector.CLOSE)

    north, east = resolved_rate._to_the_bar(observed(touch=np.array(touch, float)), joints)

    assert np.sign(east) == sign  # without a turn of the wrist, the jaws are to port and starboard
    assert abs(north) < 1e-9


def test_the_drift_is_learnt_before_the_work_and_not_from_a_swinging_view(
    resolved_rate: connector.ResolvedRate,
) -> None:
    resolved_rate.work = (1.0, 0.0, 4.0)
    drifts = []

    for phase in (connector.CARRY - 5, connector.CARRY):
        resolved_rate.phase, resolved_rate.drift = phase, [0.0, 0.0]
        resolved_rate._correct((0.02, 0.0, 0.0))
        drifts.append(resolved_rate.drift[0])

    assert drifts[0] > 0.0
    assert drifts[1] == 0.0


def test_a_blind_hand_that_closed_on_nothing_goes_where_another_drift_would_have_brought_it() -> (
    None
):
    entry = connector.Blind(told("connect-v1"))
    entry.reset(LATER)
    for _ in range(round(20.0 / DT_S)):
        entry._reckon((0.0, 0.0, 0.0), 0.0)
    before = [*entry.place]

    entry.phase = connector.LIFT
    entry._again()

    drifted = 20.0 * connector.DVL_ERROR_M_S
    assert before == pytest.approx([-drifted, -drifted])
    assert entry.place == pytest.approx([drifted, drifted])


@pytest.mark.parametrize("axis_rad", [0.4, -2.0])
def test_a_connector_is_looked_for_where_it_stands_on_a_tilted_panel(axis_rad: float) -> None:
    config = told("connect-v1")
    entry = connector.Scripted(config)
    work = scene.workpiece(scene.ConnectorDraw(tilt=Tilt(angle_rad=0.14, axis_rad=axis_rad)))
    parked = np.array(work.things[1].place.point.value)
    pose = (-1.2, 0.3, parked[2] - 1.4, 0.0, 0.0, 1.3)
    seen = projected(Pinhole.told(config), pose[3:], work.corners() - pose[:3])

    entry.reset(LATER)
    for _ in range(3):
        entry.step(
            observed(
                attitude=np.array(pose[3:]),
                depth=pose[2],
                target_visible=True,
                corners=np.array(seen),
            )
        )

    assert entry.work is not None
    handle = np.array([*pose[:2], 0.0]) + entry.work + entry._parked()
    assert handle == pytest.approx(parked, abs=1e-3)


def test_an_oracle_knows_where_the_mouth_of_a_tilted_receptacle_is() -> None:
    drawn = scene.ConnectorDraw(tilt=Tilt(angle_rad=0.14, axis_rad=1.0))
    receptacle, parked = scene.workpiece(drawn).things
    plant = StillPlant()
    plant.work[:6] = *parked.place.point.value, *parked.place.turn.value

    entry = oracle_in("connect-v1", ConnectorOracle, plant)

    assert entry.mouth_m == pytest.approx(receptacle.place.point.value[2])
