"""A program behind a bridge gets the images that an uploaded controller gets."""

import base64
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera.arm_camera import ON_ARM
from seamark.sim.engine.program import Command
from tests.seamark.bridge.conftest import Running
from tests.seamark.bridge.rosbridge.conftest import WITH_ARM, Open
from tests.seamark.bridge.rosbridge.test_arm import SPEEDS, SURGE, moved
from tests.sim.engine import test_vehicle_sonar
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
        assert base64.b64decode(one["data"]) == image.tobytes()
        assert unpacked(packed) == image.tobytes()
        shape = one["height"], one["width"], one["step"], one["encoding"]
        assert shape == (*image.shape, image.shape[1], "mono8")
    assert got[f"{ARM}/camera_info"][0]["K"][0] == ON_ARM.focal_px
    assert got[f"{ARM}/camera_info"][0]["width"] == ON_ARM.width
    assert bool(got[f"{VEHICLE}/image"]) is (images == "both")
    for one in got[f"{VEHICLE}/image"]:
        assert base64.b64decode(one["data"]) == taken[stamp_of(one)]["vehicle"].tobytes()


@pytest.mark.slow
def test_a_sonar_is_heard_when_its_image_is_new_with_its_pixels(open_bridge: Open) -> None:
    settings: dict[str, Any] = {
        **{"benchmark": "track-v1", "sonar": "forward", "vehicle": "bluerov2-heavy-v2"},
        **{"levels": [0.1], "level_duration_s": 2.0},
    }
    program = Listening()
    direct = Running(program, **settings).outcome()
    bridged = open_bridge()
    client = bridged.client()

    outcome = bridged.steered(client, SONAR_TOPICS, surge=SURGE, **settings)

    assert (direct.failure, outcome.failure, outcome.digest) == (None, None, direct.digest)
    taken = {round(image_t * 1e9): image for _t, image_t, image in program.kept}
    raw, packed = (
        [one["msg"] for one in client.others if one.get("topic") == topic] for topic in SONAR_TOPICS
    )
    assert [stamp_of(one) for one in raw] == [stamp_of(one) for one in packed] == list(taken)
    assert len(taken) == 19  # ten a second; the last one is on its way at the end
    for plain, png, image in zip(raw, packed, taken.values(), strict=True):
        assert (plain["height"], plain["width"], plain["encoding"]) == (*image.shape, "mono8")
        assert base64.b64decode(plain["data"]) == image.tobytes()
        assert unpacked(png) == image.tobytes()


SONAR_TOPICS = ("/seamark/sonar/image", "/seamark/sonar/image/compressed")


class Listening(test_vehicle_sonar.Looking):
    """A program that goes ahead, and keeps the images of its sonar."""

    def step(self, values: NDArray[np.float64]) -> Command:
        super().step(values)
        return SURGE, 0.0, 0.0, 0.0


def unpacked(message: Any) -> bytes:
    data = np.frombuffer(base64.b64decode(message["data"]), np.uint8)
    decoded = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    return decoded.tobytes()


def stamp_of(message: Any) -> int:
    stamp = message["header"]["stamp"]
    return int(10**9 * stamp["secs"] + stamp["nsecs"])
