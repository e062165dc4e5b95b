"""A program behind a bridge gets the images that an uploaded controller gets."""

import base64
from typing import Any

import cv2
import numpy as np
import pytest

from seamark.sim.camera.arm_camera import ON_ARM
from tests.seamark.bridge.conftest import Running
from tests.seamark.bridge.rosbridge.conftest import WITH_ARM, Open
from tests.seamark.bridge.rosbridge.test_arm import SPEEDS, SURGE, moved
from tests.sim.engine.test_images import Looking

ARM, VEHICLE = "/seamark/arm_camera", "/seamark/vehicle_camera"
TOPICS = (f"{ARM}/image", f"{ARM}/image/compressed", f"{ARM}/camera_info", f"{VEHICLE}/image")


@pytest.mark.slow
@pytest.mark.parametrize("images", ["both", "arm"])
def test_images_come_when_they_are_new_with_their_time_and_their_pixels(
    open_bridge: Open, images: str
) -> None:
    settings = WITH_ARM | {"images": images, "level_duration_s": 2.0}
    program = Looking()
    program.command = (SURGE, 0.0, 0.0, 0.0, *SPEEDS)
    direct = Running(program, **settings).outcome()

    outcome, messages = moved(open_bridge, TOPICS, **settings)

    assert (outcome.failure, outcome.digest) == (None, direct.digest)
    got: dict[str, list[Any]] = {topic: [] for topic in TOPICS}
    for message in messages:
        if message.get("topic") in got:
            got[message["topic"]].append(message["msg"])
    taken = {round(seen.image_t * 1e9): seen.images for seen in program.kept}
    assert [stamp_of(one) for one in got[f"{ARM}/image"]] == list(taken)
    for one, packed in zip(got[f"{ARM}/image"], got[f"{ARM}/image/compressed"], strict=True):
        image = taken[stamp_of(one)]["arm"]
        png = np.frombuffer(base64.b64decode(packed["data"]), np.uint8)
        assert base64.b64decode(one["data"]) == image.tobytes()
        decoded = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
        assert decoded is not None
        assert decoded.tobytes() == image.tobytes()
        shape = one["height"], one["width"], one["step"], one["encoding"]
        assert shape == (*image.shape, image.shape[1], "mono8")
    assert got[f"{ARM}/camera_info"][0]["K"][0] == ON_ARM.focal_px
    assert got[f"{ARM}/camera_info"][0]["width"] == ON_ARM.width
    assert bool(got[f"{VEHICLE}/image"]) is (images == "both")
    for one in got[f"{VEHICLE}/image"]:
        assert base64.b64decode(one["data"]) == taken[stamp_of(one)]["vehicle"].tobytes()


def stamp_of(message: Any) -> int:
    stamp = message["header"]["stamp"]
    return int(10**9 * stamp["secs"] + stamp["nsecs"])
