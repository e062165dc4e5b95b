"""MCAP: what an arm works on, and its tool, as ROS programs read them."""

from io import BytesIO
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.formats.registry import FORMATS
from seamark.formats.ros.arm import TOOL, WORKPIECE
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, WORK_INDEX, Rows
from tests.seamark.formats.test_mcap_arm import recording_of
from tests.seamark.formats.test_mcap_motion import Messages, array, read, turned

BENCHMARK, SEED = "recover-v1", 2026
CONFIG = {"levels": [0.1], "level_duration_s": 3.0}


@pytest.fixture(scope="module")
def rows() -> Rows:
    config, kept = registry.benchmark(BENCHMARK).read(CONFIG), list[Rows]()
    experiment = registry.benchmark(BENCHMARK).load()
    program = experiment.built_in("scripted", config)
    run_trial(BENCHMARK, config, program, seed=SEED, trial=0, on_rows=kept.append)
    return np.concatenate(kept)


@pytest.fixture(scope="module")
def messages(rows: Rows) -> Messages:
    file = BytesIO()
    FORMATS["mcap"].write(recording_of(rows, BENCHMARK, CONFIG, seed=SEED), file)
    return read(file.getvalue())


def last_of(messages: Messages) -> dict[str, Any]:
    """Return the last transform of each frame."""
    found: dict[str, Any] = {}
    for message in (*messages["/tf_static"], *messages["/tf"]):
        found |= {one.child_frame_id: one for one in message.transforms}
    return found


@pytest.mark.slow
def test_the_workpiece_is_placed_in_the_world_as_the_rows_have_it(
    messages: Messages, rows: Rows
) -> None:
    work = last_of(messages)[WORKPIECE]

    first = WORK_INDEX["workpiece_x"]
    assert work.header.frame_id == "map_ned"
    assert array(work.transform.translation).tolist() == rows[-1, first : first + 3].tolist()
    x_axis = turned(array(work.transform.rotation), np.array([1.0, 0.0, 0.0]))
    attitude = [rows[-1, WORK_INDEX[f"workpiece_{axis}"]] for axis in ("roll", "pitch", "yaw")]
    assert np.abs(attitude[:2]).max() > 0.01
    assert x_axis == pytest.approx(Rotation.from_euler("xyz", attitude).apply([1, 0, 0]), abs=1e-9)


def test_the_chain_of_transforms_leads_to_the_tool_centre_point(
    messages: Messages, rows: Rows
) -> None:
    last, frame, point = last_of(messages), TOOL, np.zeros(3)

    while frame != "base_link_frd":
        one = last[frame]
        point = array(one.transform.translation) + turned(array(one.transform.rotation), point)
        frame = one.header.frame_id

    x, roll, tool = INDEX["x"], INDEX["roll"], WORK_INDEX["tool_x"]
    body = Rotation.from_euler("xyz", rows[-1, roll : roll + 3])
    world = rows[-1, x : x + 3] + body.apply(point)
    assert world == pytest.approx(rows[-1, tool : tool + 3], abs=1e-9)


def test_a_target_that_moves_is_not_told_as_one_that_stands(messages: Messages) -> None:
    assert messages["/camera/image/compressed"]
    assert "/target/pose" not in messages
    assert "target" not in last_of(messages)
