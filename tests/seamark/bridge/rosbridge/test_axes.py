"""A program may speak in the axes of ROS: nothing is mirrored, and no digest changes."""

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.bridge.rosbridge.axes import Axes
from seamark.sim.recording.telemetry import INDEX, Rows
from tests.seamark.bridge.conftest import built_in
from tests.seamark.bridge.rosbridge.conftest import Client, Open

EXAMPLE = Path(__file__).parents[4] / "examples" / "rosbridge" / "pi.py"
REFERENCE = {"x": 0.2, "y": 0.1, "z": -0.05}
TURN = 0.3
QUIET = {"levels": [0.0], "level_duration_s": 3, "dvl_rate_hz": 20, "dvl_sigma_m_s": 0.0}


def xyz(message: Any) -> NDArray[np.float64]:
    return np.array([message[name] for name in "xyzw" if name in message])


def turned(quaternion: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn a vector by a quaternion x, y, z, w."""
    across = 2.0 * np.cross(quaternion[:3], vector)
    result: NDArray[np.float64] = vector + quaternion[3] * across
    return result + np.cross(quaternion[:3], across)


def steer(client: Client, twist: dict[str, Any]) -> dict[str, list[Any]]:
    """Answer each position error with the same reference; return what came on each topic."""
    found: dict[str, list[Any]] = {}
    for topic in ("odometry", "pose", "velocity", "error"):
        client.subscribe(f"/seamark/{topic}")
    client.subscribe("/seamark/result")
    while True:
        message = client.receive(op="publish")
        if message["topic"] == "/seamark/result":
            return found
        found.setdefault(message["topic"], []).append(message["msg"])
        if message["topic"] == "/seamark/error":
            client.send(op="publish", topic="/cmd_vel", msg=twist)


def run(open_bridge: Open, axes: Axes, twist: dict[str, Any]) -> tuple[dict[str, list[Any]], Rows]:
    bridged, parts, found = open_bridge(axes=axes), list[Rows](), dict[str, list[Any]]()
    running = bridged.start(rows=parts.append, **QUIET)
    client = bridged.client()
    thread = threading.Thread(target=lambda: found.update(steer(client, twist)))
    thread.start()
    outcome = running.outcome()
    bridged.bridge.publish_result("{}")
    thread.join()
    assert outcome.failure is None
    return found, np.concatenate(parts)


@pytest.mark.slow
@pytest.mark.parametrize("axes", Axes)
def test_the_same_pi_has_the_digest_of_the_built_in_one_in_both_axes(
    open_bridge: Open, axes: Axes
) -> None:
    bridged = open_bridge(axes=axes)
    running = bridged.start()
    address = ("127.0.0.1", str(bridged.bridge.port))

    program = subprocess.Popen([sys.executable, str(EXAMPLE), *address], stdout=subprocess.PIPE)
    outcome = running.outcome()
    bridged.bridge.publish_result("over")
    program.communicate(timeout=60)

    assert outcome.failure is None
    assert outcome.digest == built_in("pi").digest


@pytest.mark.parametrize("axes", Axes)
def test_odometry_moves_as_its_velocity_says_in_both_axes(open_bridge: Open, axes: Axes) -> None:
    """A mirrored axis of position, attitude or velocity would show here."""
    twist = {"linear": REFERENCE, "angular": {"x": 0.0, "y": 0.0, "z": TURN}}

    found, _ = run(open_bridge, axes, twist)

    odometry = found["/seamark/odometry"]
    places = np.array([xyz(one["pose"]["pose"]["position"]) for one in odometry])
    quaternions = [xyz(one["pose"]["pose"]["orientation"]) for one in odometry]
    velocities = [xyz(one["twist"]["twist"]["linear"]) for one in odometry]
    moves = np.array([turned(*pair) for pair in zip(quaternions, velocities, strict=True)])
    steps = np.diff(places, axis=0)
    # North and east; the depth is measured by another sensor, a few times a second.
    np.testing.assert_allclose(steps[:, :2], 0.05 * moves[:-1, :2], atol=1e-9)
    assert np.corrcoef(places[:, 2], 0.05 * np.cumsum(moves[:, 2]))[0, 1] > 0.5
    assert np.abs(places[-1]).min() > 0.02


def test_a_command_in_the_axes_of_ros_is_the_mirrored_one_of_the_simulator(
    open_bridge: Open,
) -> None:
    twist = {"linear": REFERENCE, "angular": {"x": 0.0, "y": 0.0, "z": TURN}}

    found, rows = run(open_bridge, Axes.ENU, twist)

    columns = [INDEX[name] for name in ("ref_u", "ref_v", "ref_w", "ref_r")]
    np.testing.assert_array_equal(rows[0, columns], [0.2, -0.1, 0.05, -TURN])
    assert np.diff(rows[[0, -1], INDEX["yaw"]])[0] < -0.1  # to port
    errors = np.array([xyz(one["vector"]) for one in found["/seamark/error"]])
    mirrored = rows[:, INDEX["error_x"] : INDEX["error_z"] + 1] * [1, -1, -1]
    np.testing.assert_array_equal(errors, mirrored)
    assert {one["header"]["frame_id"] for one in found["/seamark/error"]} == {"base_link"}
    assert {one["header"]["frame_id"] for one in found["/seamark/pose"]} == {"odom"}


def test_zero_stays_the_same_zero() -> None:
    """-0.0 in the telemetry would be another digest."""
    assert str(Axes.ENU.command((0.0, 0.0, 0.0, 0.0))) == "(0.0, 0.0, 0.0, 0.0)"


@pytest.mark.parametrize("axes", Axes)
def test_a_reference_in_the_frame_of_the_other_axes_is_refused(
    open_bridge: Open, axes: Axes
) -> None:
    bridged = open_bridge(axes=axes, one_client=True)
    running = bridged.start(levels=[0.3])
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    header = {"frame_id": axes.other.body}
    client.send(
        op="publish", topic="/cmd_vel", msg={"header": header, "twist": {"linear": REFERENCE}}
    )

    refusal = client.receive(op="status")["msg"]

    assert f"is in {axes.other.body}, but" in refusal
    assert f"--axes {axes.other}" in refusal
    client.socket.close()
    running.outcome()


def test_a_program_may_choose_its_axes_by_a_message(open_bridge: Open) -> None:
    bridged = open_bridge(one_client=True)
    running = bridged.start(levels=[0.3])
    client = bridged.client()
    client.send(op="set_axes", axes="enu")
    client.subscribe("/seamark/error")

    assert client.receive(op="publish")["msg"]["header"]["frame_id"] == "base_link"
    client.send(op="set_axes", axes="up")
    assert "axes" in client.receive(op="status")["msg"]
    client.socket.close()
    running.outcome()
