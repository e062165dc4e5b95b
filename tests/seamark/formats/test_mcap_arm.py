"""MCAP: the arm of a vehicle as ROS programs read it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from seamark.formats.recording import Recording
from seamark.formats.ros import arm as arm_messages
from seamark.sim import registry
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.posture import Posture
from seamark.sim.recording import telemetry
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import ARM_INDEX, Rows
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage
from tests.seamark.formats.test_mcap_motion import Messages, Vector, array, content, read, turned
from tests.sim.engine.test_arm import BENCHMARK, SEED, SHORT, Moving, run

COMMAND = (0.0, 0.0, 0.0, 0.0, 0.3, -0.2, 0.1, 0.2, -0.1)


@pytest.fixture(scope="module")
def rows() -> Rows:
    return run(Moving(COMMAND))


def recording_of(
    rows: Rows, benchmark: str, settings: Mapping[str, object], *, seed: int
) -> Recording:
    """Return the recording of a run with one trial."""
    config, digest = registry.benchmark(benchmark).read(settings), telemetry.digest(rows)
    described = manifest(benchmark, config, seed=seed, trials=1, controller="pi", digest=digest)
    return Recording(
        title="Run 12",
        benchmark=benchmark,
        config=described["configuration"],
        width=rows.shape[1],
        row_count=len(rows),
        read=lambda start, stop: rows[start:stop],
        seeds=[seed],
        comments=[],
        manifest=described,
        metrics={"score": 0.1},
    )


@pytest.fixture(scope="module")
def messages(rows: Rows) -> Messages:
    return read(content(recording_of(rows, BENCHMARK, SHORT, seed=SEED)))


def test_joint_states_have_the_columns_of_the_rows(messages: Messages, rows: Rows) -> None:
    states = messages["/joint_states"]

    assert len(states) == len(rows)
    assert states[0].name == ["shoulder", "upper arm", "forearm", "wrist", "jaw port"]
    for field, column in (("position", "joint_0"), ("velocity", "joint_speed_0")):
        recorded = rows[:, ARM_INDEX[column] : ARM_INDEX[column] + 5]
        assert np.array([getattr(one, field) for one in states]).tobytes() == recorded.tobytes()


def test_the_wrench_is_that_of_the_force_sensor(messages: Messages, rows: Rows) -> None:
    last = messages["/arm/wrench"][-1]

    assert last.header.frame_id == arm_messages.SENSOR
    assert array(last.wrench.force).tolist() == rows[-1, ARM_INDEX["wrist_fx"] :][:3].tolist()


def test_the_chain_of_transforms_leads_to_where_the_simulator_has_the_hand(
    messages: Messages, rows: Rows
) -> None:
    last: dict[str, Any] = {}
    for message in (*messages["/tf_static"], *messages["/tf"]):
        last |= {one.child_frame_id: one for one in message.transforms}

    def in_vehicle(frame: str, point: Vector) -> Vector:
        while frame != "base_link_frd":
            one = last[frame]
            rotation = array(one.transform.rotation)
            point = array(one.transform.translation) + turned(rotation, point)
            frame = one.header.frame_id
        return point

    vehicle, arm = load("bluerov2-heavy-v2"), load_linkage("alpha-like")
    mounting = Mounting(linkage=arm, place=vehicle.mounts[arm.name], on_vehicle=True)
    assembly = assemble(vehicle, [mounting], bottom=False)
    joints = rows[-1, ARM_INDEX["joint_0"] : ARM_INDEX["joint_0"] + 8]
    motion = np.concatenate([np.zeros(12), joints, np.zeros(8)])
    turns, places, _ = Posture(assembly).place(motion)
    for name in ("forearm", "jaw port", "jaw starboard"):
        at = assembly.mechanism.number(name)
        tip = np.array([0.07, 0.0, 0.0])
        assert in_vehicle(f"arm/{name.replace(' ', '_')}", tip) == pytest.approx(
            places[at] + turns[at] @ tip, abs=1e-12
        )


def test_a_vehicle_without_an_arm_has_none_of_these_topics(recording: Recording) -> None:
    assert not {*read(content(recording))} & {*arm_messages.TOPICS}
