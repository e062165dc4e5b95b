"""Runs with an arm: the program moves it, and its sensors, rows and results say what happened."""

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.control.observation import Observation, arm_size, empty, layout
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import ARM_FEELERS, ARM_INDEX, ARM_JOINTS, ARM_WIDTH, INDEX
from seamark.sim.registry import ARMS
from seamark.sim.sensors import arm as sensors
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.reading import THRUSTERS_MAX

BENCHMARK, SEED = "currents-v3", 3
ALPHA = arm_size(load_linkage("alpha-like"))
SHORT = {
    "arm": "alpha-like",
    "vehicle": "bluerov2-heavy-v2",
    "levels": [0.1],
    "level_duration_s": 4.0,
    "settle_s": 1.0,
    "tracker": "truth",
}


class Moving:
    """A program that gives the same command at each step, and keeps what it saw."""

    def __init__(self, command: tuple[float, ...]) -> None:
        self.command = command
        self.seen: list[NDArray[np.float64]] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, values: NDArray[np.float64]) -> tuple[float, ...]:
        self.seen.append(values.copy())
        return self.command


def run(program: object, **settings: object) -> telemetry.Rows:
    config = registry.benchmark(BENCHMARK).read(SHORT | settings)
    kept: list[telemetry.Rows] = []
    run_trial(BENCHMARK, config, program, seed=SEED, trial=0, on_rows=kept.append)
    return np.concatenate(kept)


def column(rows: telemetry.Rows, name: str) -> NDArray[np.float64]:
    return rows[:, telemetry.names(rows.shape[1]).index(name)]


def test_an_arm_s_columns_are_more_than_the_thrusters_that_a_vehicle_can_have() -> None:
    assert ARM_WIDTH > THRUSTERS_MAX - telemetry.COMMON_THRUSTERS


@pytest.mark.parametrize("name", ARMS)
def test_every_arm_fits_the_columns(name: str) -> None:
    motors, feelers = arm_size(load_linkage(name))

    assert 0 < motors <= ARM_JOINTS
    assert 0 < feelers <= ARM_FEELERS


def test_the_joints_move_as_the_program_says_and_rows_have_it() -> None:
    rows = run(Moving((0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, -0.1)))

    assert column(rows, "joint_ref_0") == pytest.approx(0.3)
    assert column(rows, "joint_0")[-1] == pytest.approx(0.3 * 79 * 0.05, rel=0.05)
    assert column(rows, "joint_4")[-1] < column(rows, "joint_4")[0]
    assert column(rows, "joint_speed_0")[-1] == pytest.approx(0.3, abs=1e-3)
    assert column(rows, "joint_5") == pytest.approx(0.0), "there is none"


def test_a_program_that_gives_four_numbers_leaves_the_joints_at_rest() -> None:
    rows = run(Moving((0.0, 0.0, 0.0, 0.0)))

    for joint in range(ALPHA.motors):
        assert np.ptp(column(rows, f"joint_{joint}")) < 1e-3


def test_built_in_controllers_run_with_an_arm_and_see_the_thrusts_alone_as_thrust() -> None:
    config = registry.benchmark(BENCHMARK).read(SHORT)
    program = registry.benchmark(BENCHMARK).load().built_in("pi", config)
    rows = run(program)
    seen = Observation(empty(8, ALPHA), ALPHA)

    assert np.isfinite(rows[:, : INDEX["step_us"]]).all()
    assert len(seen.thrust) == 8
    assert len(seen.joints) == len(seen.joint_speeds) == len(seen.joint_efforts) == ALPHA.motors
    assert len(seen.touch) == ALPHA.feelers
    assert list(seen)[-6:] == [
        *("joints", "joint_speeds", "joint_efforts", "wrist_force", "wrist_torque", "touch")
    ]


def test_the_layout_has_the_numbers_that_a_program_gets() -> None:
    program = Moving((0.0, 0.0, 0.0, 0.0))
    run(program)
    packed = layout("bluerov2-heavy-v2", load_linkage("alpha-like"))

    assert sum(count or 1 for _name, count in packed["observation"]) == len(program.seen[0])
    assert packed["command"][4:] == ["shoulder", "upper arm", "forearm", "wrist", "jaw port"]
    assert packed["joint_limits"] == [0.5] * 5


def test_without_noise_the_sensors_read_what_rows_have_and_with_noise_about_that() -> None:
    exact, noisy = Moving((0.0,) * 4 + (0.3,)), Moving((0.0,) * 4 + (0.3,))
    rows = run(exact, arm_noise=0.0)
    run(noisy)
    true = rows[:, ARM_INDEX["joint_0"] : ARM_INDEX["joint_0"] + ALPHA.motors]

    joints = np.array([Observation(values, ALPHA).joints for values in exact.seen])
    read = np.array([Observation(values, ALPHA).joints for values in noisy.seen])
    forces = np.array([Observation(values, ALPHA).wrist_force for values in noisy.seen])
    assert joints.tobytes() == np.ascontiguousarray(true).tobytes()
    assert 0.5 < (read - true).std() / sensors.ENCODER_SIGMA < 2.0
    assert 0.5 < forces[20:, 1].std() / sensors.FORCE_SIGMA_N < 2.0


def test_commands_to_joints_are_as_late_as_those_to_the_vehicle() -> None:
    def first_row_with_speed(late: int) -> int:
        rows = run(Moving((0.0,) * 4 + (0.3,)), command_delay_steps=late, camera_delay_steps=late)
        return int(np.argmax(column(rows, "joint_speed_0") > 0.1))

    assert first_row_with_speed(0) == 1
    assert first_row_with_speed(3) in range(2, 5), "up to three are drawn"


def test_the_same_run_has_the_same_bytes_and_other_joint_commands_other_ones() -> None:
    one, same = run(Moving((0.0,) * 4 + (0.3,))), run(Moving((0.0,) * 4 + (0.3,)))
    other = run(Moving((0.0,) * 4 + (0.2,)))

    assert telemetry.digest(one) == telemetry.digest(same)
    assert telemetry.digest(one) != telemetry.digest(other)
    assert np.abs(column(one, "roll") - column(other, "roll")).max() > 0.0, "the arm acts on it"


@pytest.mark.parametrize(
    ("settings", "name", "words"),
    [
        ({"arm": "arm-5e-like"}, "arm", "no place for"),
        ({"current_law": "force"}, "current_law", "with an arm"),
        ({"arm": "tentacle"}, "arm", "tentacle"),
        ({"arm_noise": -1.0}, "arm_noise", "0"),
    ],
)
def test_settings_that_do_not_go_with_the_arm_are_refused(
    settings: dict[str, object], name: str, words: str
) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        registry.benchmark(BENCHMARK).read(SHORT | settings)

    assert words in refused.value.errors[name]


def test_a_ranked_run_has_no_arm() -> None:
    entry = registry.benchmark(BENCHMARK)

    assert entry.ranked(entry.read(SHORT | {"tracker": "esm"})).chosen_arm() is None


def test_a_vehicle_that_carries_no_arm_has_the_rows_of_before() -> None:
    rows = run(Moving((0.0, 0.0, 0.0, 0.0)), arm="none")

    assert rows.shape[1] == telemetry.width_for(len(load("bluerov2-heavy-v2").thrusters))
