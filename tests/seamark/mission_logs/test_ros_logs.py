"""MCAP files and ROS bags, written by rosbags, are measured as the run that they came from."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from seamark.formats.recording import Recording
from seamark.formats.ros import mcap_file
from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.measuring import measure
from seamark.mission_logs.result import LogRefused, LogResult
from seamark.sim.recording.telemetry import INDEX, STEP_US
from tests.seamark.mission_logs.conftest import CORNERS, SETTINGS, Run

START_NS = 1_700_000_000_000_000_000  # since 1970
TOPICS = {"pose": "/nav/odometry", "corners": "/tracker/corners"}
Written = Mapping[str, tuple[str, Sequence[tuple[int, Any]]]]  # topic -> type, (ns, message)
POSE_TYPE, CORNERS_TYPE = "nav_msgs/msg/Odometry", "std_msgs/msg/Float64MultiArray"


def _header(types: Any, stamp_ns: int, *, old: bool) -> Any:
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 1_000_000_000))
    extra = {"seq": 0} if old else {}
    return types["std_msgs/msg/Header"](stamp=time, frame_id="world", **extra)


def _odometry(types: Any, row: Any, header: Any) -> Any:
    x, y, z, roll, pitch, yaw = row[INDEX["x"] : INDEX["yaw"] + 1].tolist()
    (sr, cr), (sp, cp), (sy, cy) = (
        (np.sin(0.5 * angle), np.cos(0.5 * angle)) for angle in (roll, pitch, yaw)
    )
    turn = types["geometry_msgs/msg/Quaternion"](
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )
    vector = types["geometry_msgs/msg/Vector3"]
    velocity = row[INDEX["u"] : INDEX["r"] + 1].tolist()
    pose = types["geometry_msgs/msg/Pose"](types["geometry_msgs/msg/Point"](x, y, z), turn)
    twist = types["geometry_msgs/msg/Twist"](vector(*velocity[:3]), vector(*velocity[3:]))
    nothing = np.zeros(36)
    return types[POSE_TYPE](
        header=header,
        child_frame_id="body",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose, nothing),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](twist, nothing),
    )


def _corners(types: Any, row: Any) -> Any:
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return types[CORNERS_TYPE](layout, row[INDEX["corner_0"] : INDEX["corner_7"] + 1])


def _messages(run: Run, *, old: bool, corners_late_ns: int = 0) -> Written:
    types: Any = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE).types
    stamps = [START_NS + 50_000_000 * at for at in range(len(run.rows))]
    poses = [
        (stamp, _odometry(types, row, _header(types, stamp, old=old)))
        for stamp, row in zip(stamps, run.rows, strict=True)
    ]
    corners = [
        (stamp + corners_late_ns, _corners(types, row))
        for stamp, row in zip(stamps, run.rows, strict=True)
    ]
    return {TOPICS["pose"]: (POSE_TYPE, poses), TOPICS["corners"]: (CORNERS_TYPE, corners)}


def ros1_bag(path: Path, written: Written) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    with rosbag1.Writer(path / "log.bag") as writer:
        for topic, (kind, messages) in written.items():
            connection = writer.add_connection(topic, kind, typestore=store)
            for stamp, message in messages:
                writer.write(connection, stamp, store.serialize_ros1(message, kind))
    return path / "log.bag"


def ros2_bag(path: Path, written: Written, plugin: StoragePlugin) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    with rosbag2.Writer(path / "log", version=8, storage_plugin=plugin) as writer:
        for topic, (kind, messages) in written.items():
            connection = writer.add_connection(topic, kind, typestore=store)
            for stamp, message in messages:
                writer.write(connection, stamp, store.serialize_cdr(message, kind))
    return path / "log"


def _mcap(path: Path, written: Written) -> Path:
    return next(ros2_bag(path, written, StoragePlugin.MCAP).glob("*.mcap"))


def _folder(path: Path, written: Written) -> Path:
    return ros2_bag(path, written, StoragePlugin.SQLITE3)


def _measured(path: Path, **mapping: Any) -> LogResult:
    document = {"settings": {"settle_s": 1.0}, "topics": TOPICS} | mapping
    return measure(path, LogMapping.model_validate(document), benchmark="currents-v1")


@pytest.mark.parametrize(("write", "old"), [(ros1_bag, True), (_mcap, False), (_folder, False)])
def test_a_bag_of_a_run_has_the_metrics_of_the_run(
    run: Run, tmp_path: Path, write: Callable[[Path, Written], Path], old: bool
) -> None:
    single = run.level(1)

    found = _measured(write(tmp_path, _messages(single, old=old)))

    # A quaternion is not the angles bit for bit; positions, corners and the period are.
    for name in ("x", "y", "z", *CORNERS, "tracked_x", "tracked_y"):
        assert np.array_equal(found.rows[:, INDEX[name]], single.column(name)), name
    assert found.manifest["period_s"] == 0.05
    level, own = found.metrics["levels"][0], run.metrics["levels"][1]
    for name in ("points", "rmse_m", "rmse_px", "heading_rmse_rad", "lost_percent", "held"):
        assert level[name] == pytest.approx(own[name], rel=1e-9), name


def test_the_mcap_file_of_a_run_has_the_rows_of_the_run_bit_for_bit(
    run: Run, tmp_path: Path
) -> None:
    recording = Recording(
        title="Run",
        benchmark="currents-v1",
        config={},
        width=run.rows.shape[1],
        row_count=len(run.rows),
        read=lambda start, stop: run.rows[start:stop],
    )
    with (tmp_path / "telemetry.mcap").open("wb") as file:
        mcap_file.write(recording, file)

    found = measure(
        tmp_path / "telemetry.mcap",
        LogMapping.model_validate({"settings": SETTINGS}),
        benchmark="currents-v1",
    )

    kept = np.delete(run.rows, STEP_US, axis=1)
    assert np.array_equal(np.delete(found.rows, STEP_US, axis=1), kept, equal_nan=True)
    assert found.metrics["levels"] == run.metrics["levels"]
    assert found.metrics["score"] == run.metrics["score"]


def test_topics_of_other_moments_are_joined_only_as_the_mapping_says(
    run: Run, tmp_path: Path
) -> None:
    single = run.level(1)
    path = ros1_bag(tmp_path, _messages(single, old=True, corners_late_ns=20_000_000))

    with pytest.raises(LogRefused, match="not of the same moments"):
        _measured(path)
    found = _measured(path, time={"max_gap_s": 0.1})

    assert found.manifest["resampled"] is True
    assert np.isnan(found.rows[0, INDEX["corner_0"]])  # there is none before the first pose
    assert found.rows[0, INDEX["tracker_ok"]] == 0.0
    assert np.array_equal(found.rows[1:, INDEX["corner_0"]], single.column("corner_0")[:-1])


def test_a_field_is_read_by_its_path(run: Run, tmp_path: Path) -> None:
    single = run.level(1)
    columns = {f"corner_{at}": f"/tracker/corners:data[{at}]" for at in range(8)} | {
        "z": {"name": "/nav/odometry:pose.pose.position.z", "unit": "cm"}
    }

    found = _measured(_mcap(tmp_path, _messages(single, old=False)), topics={}, columns=columns)

    assert np.array_equal(found.rows[:, INDEX["corner_5"]], single.column("corner_5"))
    assert found.rows[:, INDEX["z"]] == pytest.approx(0.01 * single.column("z"))


@pytest.mark.parametrize(
    ("mapping", "sentence"),
    [
        ({"topics": {"pose": "/odom"}}, "no topic '/odom'. It has: /nav/odometry"),
        ({"topics": {"corners": "/nav/odometry"}}, "corners is read from geometry_msgs"),
        ({"columns": {"x": "/nav/odometry:pose.__class__"}}, "name topic and field"),
        ({"columns": {"x": "/nav/odometry:pose.elsewhere"}}, "has no field pose.elsewhere"),
        ({"columns": {"x": "/tracker/corners:data[99]"}}, "cannot be read: index 99"),
    ],
)
def test_what_a_bag_does_not_have_is_named(
    run: Run, tmp_path: Path, mapping: dict[str, Any], sentence: str
) -> None:
    path = _mcap(tmp_path, _messages(run.level(0), old=False))

    with pytest.raises(LogRefused, match=sentence):
        _measured(path, **mapping)
