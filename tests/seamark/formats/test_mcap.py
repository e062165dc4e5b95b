"""MCAP: the official reader accepts it, and the frames of ROS say the same as the simulator's."""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from io import BytesIO
from typing import Any

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from seamark.formats.recording import Recording
from seamark.formats.registry import FORMATS
from seamark.formats.ros import frames, images, layout, mcap_file
from seamark.sim import registry
from seamark.sim.engine.replay import Replay
from seamark.sim.recording.telemetry import COLUMNS, INDEX, NAMES, Rows
from tests.seamark.formats.conftest import SEED, SETTINGS

Messages = Mapping[str, list[tuple[int, Any]]]  # topic -> time [ns], message
IMAGES_EVERY = 20  # rows


@pytest.fixture(scope="module")
def contents() -> dict[str, Any]:
    """What a file had once, for all tests that only look at it."""
    return {}


@pytest.fixture
def file(written: Callable[[str], BytesIO], contents: dict[str, Any]) -> BytesIO:
    if "file" not in contents:
        contents["file"] = written("mcap").getvalue()
    return BytesIO(contents["file"])


@pytest.fixture
def messages(file: BytesIO, contents: dict[str, Any]) -> Messages:
    if "messages" not in contents:
        found = defaultdict(list)
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((message.log_time, decoded))
        contents["messages"] = found
    known: Messages = contents["messages"]
    return known


@pytest.fixture
def replay() -> Replay:
    config = registry.benchmark("currents-v1").read(SETTINGS)
    return Replay("currents-v1", config, lambda _trial: SEED)


def array(message: Any) -> NDArray[np.float64]:
    return np.array([getattr(message, name) for name in "xyzw" if hasattr(message, name)])


def rotated(quaternion: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn a vector by a quaternion x, y, z, w."""
    axis, w = quaternion[:3], quaternion[3]
    across = 2.0 * np.cross(axis, vector)
    turned: NDArray[np.float64] = vector + w * across + np.cross(axis, across)
    return turned


def seen_from(frame: Any, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a point of the parent in the frame of a geometry_msgs/Transform."""
    back = array(frame.rotation) * [-1, -1, -1, 1]
    return rotated(back, point - array(frame.translation))


@pytest.mark.slow
def test_every_column_of_every_row_is_there_bit_for_bit(messages: Messages, rows: Rows) -> None:
    found = [[getattr(message, name) for name in NAMES] for _, message in messages["/telemetry"]]

    assert np.array(found, "<f8").tobytes() == rows.tobytes()


@pytest.mark.slow
def test_a_second_reader_of_ros_messages_finds_the_same_values(file: BytesIO, rows: Rows) -> None:
    store = get_typestore(Stores.EMPTY)
    known: set[str] = set()
    found = []
    for schema, channel, message in make_reader(file).iter_messages():
        assert schema is not None
        if schema.name not in known:
            store.register(get_types_from_msg(schema.data.decode(), schema.name))
            known.add(schema.name)
        decoded: Any = store.deserialize_cdr(message.data, schema.name)
        if channel.topic == "/telemetry":
            found.append([getattr(decoded, name) for name in NAMES])

    assert known == set(mcap_file.TOPICS.values())
    assert np.array(found, "<f8").tobytes() == rows.tobytes()


def test_the_definition_of_the_telemetry_names_the_unit_of_each_column(file: BytesIO) -> None:
    summary = make_reader(file).get_summary()
    assert summary is not None
    text = next(one for one in summary.schemas.values() if "Telemetry" in one.name).data.decode()

    units = dict(re.findall(r"^float64 (\w+)  # \[(\S+)\]", text, re.MULTILINE))
    assert units == {column.name: column.unit or "1" for column in COLUMNS}


def test_time_in_the_file_never_goes_back_and_agrees_with_the_header(messages: Messages) -> None:
    times = [time for time, _ in messages["/telemetry"]]
    stamps = [one.header.stamp for _, one in messages["/telemetry"]]

    assert times == sorted(set(times))
    assert times == [stamp.sec * 10**9 + stamp.nanosec for stamp in stamps]
    assert times[0] == 0


def test_a_vehicle_that_looks_north_looks_along_y_in_ros() -> None:
    north, east, down = 3.0, 2.0, 4.5
    quaternion = frames.orientation(np.array([0.0, 0.0, 0.0]))

    np.testing.assert_array_equal(
        frames.to_enu(np.array([north, east, down])), [east, north, -down]
    )
    np.testing.assert_allclose(rotated(quaternion, np.array([1.0, 0, 0])), [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(rotated(quaternion, np.array([0, 1.0, 0])), [-1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(rotated(quaternion, np.array([0, 0, 1.0])), [0, 0, 1], atol=1e-15)


def test_a_turn_to_starboard_turns_clockwise_seen_from_above() -> None:
    east = frames.orientation(np.array([0.0, 0.0, np.pi / 2]))
    nose_up = frames.orientation(np.array([0.0, np.pi / 2, 0.0]))
    heeled = frames.orientation(np.array([np.pi / 2, 0.0, 0.0]))  # to starboard

    np.testing.assert_allclose(rotated(east, np.array([1.0, 0, 0])), [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(rotated(nose_up, np.array([1.0, 0, 0])), [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(rotated(heeled, np.array([0, 1.0, 0])), [0, 0, 1], atol=1e-15)


def test_positions_keep_every_bit(messages: Messages, rows: Rows) -> None:
    found = np.array([array(one.pose.position) for _, one in messages["/vehicle/pose"]])

    assert found[:, 1].tobytes() == rows[:, INDEX["x"]].tobytes()
    assert found[:, 0].tobytes() == rows[:, INDEX["y"]].tobytes()
    assert (-found[:, 2]).tobytes() == rows[:, INDEX["z"]].tobytes()


def test_the_frames_and_the_pinhole_project_the_target_where_the_simulator_does(
    messages: Messages, rows: Rows, replay: Replay
) -> None:
    """The whole chain of frames, from the world to the image, by values."""
    moved = {time: one.transforms[0] for time, one in reversed(messages["/tf"])}
    ((_, static),) = messages["/tf_static"]
    camera = next(one for one in static.transforms if one.child_frame_id == frames.CAMERA).transform
    numbered = [time for time, _ in messages["/telemetry"]]

    assert len(messages["/camera/camera_info"]) == -(-len(rows) // IMAGES_EVERY)
    for time, info in messages["/camera/camera_info"]:
        frame = replay.frame(np.ascontiguousarray(rows[numbered.index(time)]))
        corners = frames.to_enu(frame.camera.target.top_corners())
        base = moved[time].transform
        focal, u0, v0 = info.k[0], info.k[2], info.k[5]
        for corner, expected in zip(corners, frame.corners(), strict=True):
            in_base = seen_from(base, corner)
            in_camera = seen_from(camera, in_base)
            u, v = focal * in_camera[:2] / in_camera[2] + [u0, v0]
            np.testing.assert_allclose([u, v], expected, atol=1e-6)


def test_images_are_those_of_the_simulator_with_both_outlines(
    messages: Messages, rows: Rows, replay: Replay
) -> None:
    pictures = messages["/camera/image/compressed"]
    image = cv2.imdecode(np.frombuffer(bytes(pictures[1][1].data), np.uint8), cv2.IMREAD_COLOR)
    frame = replay.frame(np.ascontiguousarray(rows[IMAGES_EVERY]))
    tracked, true = messages["/camera/annotations"][1][1].points

    assert image is not None
    assert np.abs(image.astype(float) - frame.colour()).mean() < 5.0
    drawn = np.array([[point.x, point.y] for point in true.points])
    np.testing.assert_array_equal(drawn, frame.corners() + 0.5)
    row = rows[IMAGES_EVERY]
    assert [tracked.points[0].x, tracked.points[0].y] == [
        row[INDEX["corner_0"]] + 0.5,
        row[INDEX["corner_1"]] + 0.5,
    ]


def test_a_long_run_has_no_more_images_than_a_file_may(recording: Recording) -> None:
    long = replace(recording, row_count=2_000_000)
    pictures = images.pictures_of(long)

    assert pictures is not None
    assert -(-long.row_count // pictures.every) <= images.IMAGES_MAX


def test_without_seeds_there_is_all_but_the_images_and_the_target(
    recording: Recording, rows: Rows
) -> None:
    file = BytesIO()
    FORMATS["mcap"].write(replace(recording, seeds=None), file)

    summary = make_reader(BytesIO(file.getvalue())).get_summary()
    assert summary is not None
    topics = {channel.topic for channel in summary.channels.values()}
    assert topics == {name for name in mcap_file.TOPICS if not name.startswith(("/cam", "/target"))}


def test_all_that_the_layout_shows_is_in_the_file(messages: Messages, file: BytesIO) -> None:
    shown = json.loads(layout.TEXT)
    panels = shown["configById"]
    paths = [p["value"] for panel in panels.values() for p in panel.get("paths", [])]
    mode = panels["Image!seamark"]["imageMode"]
    topics = [*panels["3D!seamark"]["topics"], mode["imageTopic"], mode["calibrationTopic"]]
    topics += mode["annotations"]

    attached = next(iter(make_reader(file).iter_attachments()))
    assert (attached.name, attached.data) == (layout.FILE, layout.TEXT)
    assert len(paths) > 5
    for path in paths:
        topic, _, field = path.partition(".")
        assert hasattr(messages[topic][0][1], field)
    assert set(topics) <= set(messages)
    assert set(re.findall(r"\w+!\w+", json.dumps(shown["layout"]))) == set(panels)


def test_the_same_run_gives_the_same_bytes(
    file: BytesIO, written: Callable[[str], BytesIO]
) -> None:
    assert written("mcap").getvalue() == file.getvalue()
