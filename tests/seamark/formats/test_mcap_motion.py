"""MCAP: what ROS programs read of the vehicle's motion, in the frames that its messages name."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from numpy.typing import NDArray
from rosbags.interfaces import QosDurability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from seamark.formats.recording import Recording
from seamark.formats.registry import FORMATS
from seamark.formats.ros import mcap_file, schemas
from seamark.sim.recording.telemetry import COLUMNS, INDEX, Rows

Messages = Mapping[str, list[Any]]
Vector = NDArray[np.float64]
NOT_OF_ROS = ("seamark_msgs/msg/Telemetry", "foxglove_msgs/msg/ImageAnnotations")
STEP_S = 0.05


def content(recording: Recording) -> bytes:
    file = BytesIO()
    FORMATS["mcap"].write(replace(recording, seeds=None), file)
    return file.getvalue()


def read(data: bytes) -> Messages:
    found = defaultdict(list)
    reader = make_reader(BytesIO(data), decoder_factories=[DecoderFactory()])
    for _, channel, _, decoded in reader.iter_decoded_messages():
        found[channel.topic].append(decoded)
    return found


@pytest.fixture
def messages(recording: Recording) -> Messages:
    return read(content(recording))


def array(message: Any) -> Vector:
    return np.array([getattr(message, name) for name in "xyzw" if hasattr(message, name)])


def arrays(found: list[Any]) -> Vector:
    return np.array([array(one) for one in found])


def turned(quaternion: Vector, vectors: Vector) -> Vector:
    """Turn vectors (..., 3) by quaternions (..., 4) of x, y, z, w."""
    axis, w = quaternion[..., :3], quaternion[..., 3:]
    across = 2.0 * np.cross(axis, vectors)
    result: Vector = vectors + w * across + np.cross(axis, across)
    return result


def columns(rows: Rows, names: str) -> Vector:
    found: Vector = rows[:, [INDEX[name] for name in names.split()]]
    return found


@pytest.mark.slow
def test_the_telemetry_names_the_frame_that_its_numbers_are_in(messages: Messages) -> None:
    assert {one.header.frame_id for one in messages["/telemetry"]} == {"map_ned"}


def test_static_transforms_turn_the_simulators_numbers_into_those_of_ros(
    messages: Messages, rows: Rows
) -> None:
    (static,) = messages["/tf_static"]
    found = {one.child_frame_id: one for one in static.transforms}
    world, body = found["map_ned"], found["base_link_frd"]

    assert (world.header.frame_id, body.header.frame_id) == ("map", "base_link")
    np.testing.assert_allclose(
        turned(array(world.transform.rotation), columns(rows, "x y z")),
        arrays([one.pose.position for one in messages["/vehicle/pose"]]),
        atol=1e-12,
    )
    np.testing.assert_allclose(
        turned(array(body.transform.rotation), columns(rows, "u v w")),
        arrays([one.twist.linear for one in messages["/vehicle/velocity"]]),
        atol=1e-12,
    )


@pytest.mark.slow
def test_no_frame_has_a_static_and_a_moving_parent(recording: Recording) -> None:
    file = BytesIO()
    FORMATS["mcap"].write(recording, file)
    messages = read(file.getvalue())

    fixed = {one.child_frame_id for sent in messages["/tf_static"] for one in sent.transforms}
    moving = {one.child_frame_id for sent in messages["/tf"] for one in sent.transforms}
    assert fixed == {"map_ned", "base_link_frd", "camera_optical"}
    assert moving == {"base_link", "target"}


def test_the_velocity_of_the_odometry_moves_its_position(messages: Messages, rows: Rows) -> None:
    """A mirrored axis of position, attitude or velocity would show here."""
    odometry = messages["/vehicle/odometry"]
    positions = arrays([one.pose.pose.position for one in odometry])
    attitudes = arrays([one.pose.pose.orientation for one in odometry])
    velocities = arrays([one.twist.twist.linear for one in odometry])
    same_level = (np.diff(rows[:, INDEX["level"]]) == 0) & (np.diff(rows[:, INDEX["trial"]]) == 0)

    assert {(one.header.frame_id, one.child_frame_id) for one in odometry} == {("map", "base_link")}
    over_ground = turned(attitudes, velocities)
    moved = np.diff(positions, axis=0)[same_level]
    mean = 0.5 * (over_ground[1:] + over_ground[:-1])[same_level]
    np.testing.assert_allclose(moved, STEP_S * mean, atol=2e-4)
    assert np.abs(moved).max(axis=0).min() > 5e-4


@pytest.mark.slow
def test_turn_rates_of_odometry_and_imu_turn_the_attitude(messages: Messages, rows: Rows) -> None:
    imu = messages["/imu/data"]
    attitudes = arrays([one.orientation for one in imu])
    rates = arrays([one.angular_velocity for one in imu])
    same_level = (np.diff(rows[:, INDEX["level"]]) == 0) & (np.diff(rows[:, INDEX["trial"]]) == 0)

    back = attitudes[:-1] * [-1, -1, -1, 1]
    axis, w = back[:, :3], back[:, 3:]
    other, other_w = attitudes[1:, :3], attitudes[1:, 3:]
    half_turn = w * other + other_w * axis + np.cross(axis, other)
    half_turn *= np.sign(w * other_w - (axis * other).sum(axis=1, keepdims=True))
    mean = 0.5 * (rates[1:] + rates[:-1])
    np.testing.assert_allclose(2.0 * half_turn[same_level], STEP_S * mean[same_level], atol=2e-4)
    assert {one.header.frame_id for one in imu} == {"base_link"}
    assert {one.linear_acceleration_covariance[0] for one in imu} == {-1.0}
    angular = arrays([one.twist.twist.angular for one in messages["/vehicle/odometry"]])
    assert angular.tobytes() == rates.tobytes()


def test_the_dvl_speaks_once_for_each_measurement(messages: Messages, rows: Rows) -> None:
    measured = columns(rows, "dvl_u dvl_v dvl_w")
    found = arrays([one.twist.twist.linear for one in messages["/dvl/twist"]])
    begins = np.append(True, (np.diff(measured, axis=0) != 0.0).any(axis=1))

    assert 0.2 < len(found) / len(rows) < 0.3  # 5 Hz among rows of 20 Hz
    np.testing.assert_array_equal(found, measured[begins] * [1, -1, -1])
    first = messages["/dvl/twist"][0]
    assert first.header.frame_id == "base_link"
    np.testing.assert_allclose(np.diag(np.reshape(first.twist.covariance, (6, 6)))[:3], 0.0015**2)


def test_reference_and_thrust_are_those_of_the_rows(messages: Messages, rows: Rows) -> None:
    reference = messages["/cmd_vel"]
    linear = arrays([one.twist.linear for one in reference])
    thrust = np.array([one.data for one in messages["/vehicle/thrust"]])

    assert {one.header.frame_id for one in reference} == {"base_link"}
    np.testing.assert_array_equal(linear, columns(rows, "ref_u ref_v ref_w") * [1, -1, -1])
    np.testing.assert_array_equal(
        [one.twist.angular.z for one in reference], -rows[:, INDEX["ref_r"]]
    )
    assert thrust.shape == (len(rows), 5)  # the Girona 500 has five thrusters
    np.testing.assert_array_equal(thrust, rows[:, INDEX["thrust_0"] : INDEX["thrust_4"] + 1])


def test_what_a_log_did_not_measure_has_no_message(recording: Recording, rows: Rows) -> None:
    log = rows.copy()
    for name in ("u", "p", "ref_u", "dvl_u", "thrust_0"):
        log[:, INDEX[name]] = np.nan
    log[7, INDEX["yaw"]] = np.nan

    found = read(content(replace(recording, read=lambda start, stop: log[start:stop])))

    assert set(found) == {"/telemetry", "/vehicle/pose", "/tf", "/tf_static"}
    assert len(found["/vehicle/pose"]) == len(found["/tf"]) == len(rows) - 1


def test_a_run_of_a_tracker_has_no_topics_of_a_controller(recording: Recording) -> None:
    tracking = replace(recording, benchmark="visibility-v1", config={})

    found = read(content(tracking))

    assert not {"/cmd_vel", "/vehicle/thrust", "/dvl/twist"} & set(found)
    assert "/vehicle/odometry" in found


def test_the_definitions_are_those_of_ros() -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    for name in set(mcap_file.TOPICS.values()) - set(NOT_OF_ROS):
        written = get_typestore(Stores.EMPTY)
        written.register(get_types_from_msg(schemas.definition(name, COLUMNS), name))
        assert written.hash_rihs01(name) == store.hash_rihs01(name), name


def test_a_player_of_bags_keeps_the_static_transforms_for_those_who_come_later(
    recording: Recording, tmp_path: Path
) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(content(recording))

    with Reader(path) as reader:
        (static,) = (one for one in reader.connections if one.topic == "/tf_static")
        store = get_typestore(Stores.ROS2_JAZZY)
        counts: dict[str, int] = defaultdict(int)
        for connection, _, data in reader.messages():
            if connection.msgtype not in NOT_OF_ROS:
                store.deserialize_cdr(data, connection.msgtype)
                counts[connection.topic] += 1

    (profile,) = static.ext.offered_qos_profiles  # type: ignore[union-attr]
    assert profile.durability is QosDurability.TRANSIENT_LOCAL
    assert counts["/tf_static"] == 1
