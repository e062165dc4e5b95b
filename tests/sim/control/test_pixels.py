"""The learned entry that looks: its networks, its memory of the target, and what it can see."""

import hashlib
import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.reference_results import PUBLIC_SEED
from seamark.sim.camera.optics import MOUNT_M
from seamark.sim.control.observation import Observation, empty
from seamark.sim.control.position import pixels
from seamark.sim.control.position.pixels.controller import WEIGHTS
from seamark.sim.control.position.pixels.eye import (
    CELL_PX,
    COLUMNS,
    HEIGHT,
    LAYERS,
    OUTPUTS,
    ROWS,
    WIDTH,
    Eye,
)
from seamark.sim.control.position.pixels.hand import Hand, layer
from seamark.sim.control.position.pixels.reckoning import BELOW_CAMERA_M, Reckoning
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import benchmark
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

FEATURES = Path(__file__).parents[3] / "examples" / "ppo" / "features.py"
SHORT = {
    "tracker": "truth",
    "images": "vehicle",
    "levels": [0.2],
    "level_duration_s": 20.0,
    "settle_s": 5.0,
}
BITS = """
import hashlib
import numpy as np
from seamark.sim.control.observation import Observation, empty
from seamark.sim.control.position.pixels.controller import WEIGHTS
from seamark.sim.control.position.pixels.eye import Eye
from seamark.sim.control.position.pixels.hand import Hand

with np.load(WEIGHTS) as stored:
    eye, hand = (
        {name[len(part):]: stored[name] for name in stored.files if name.startswith(part)}
        for part in ("eye_", "hand_")
    )
random = np.random.default_rng(1)
image = random.integers(90, 120, (480, 640)).astype(np.uint8)
image[200:240, 300:400] //= 3
image.flags.writeable = False  # as those that programs are given
total = hashlib.sha256(Eye(eye).output(image).tobytes())
steering = Hand(hand)
for thrusters in (5, 8):
    steering.reset()
    for _ in range(10):
        numbers = random.normal(scale=0.3, size=len(empty(thrusters)))
        command = steering.decide(Observation(numbers), (numbers[2], numbers[3]))
        total.update(np.array(command).tobytes())
print(total.hexdigest())
"""


def kept(part: str) -> dict[str, NDArray[Any]]:
    with np.load(WEIGHTS) as stored:
        return {
            name.removeprefix(part): stored[name] for name in stored.files if name.startswith(part)
        }


def scene(right_px: int = 0, down_px: int = 0) -> NDArray[np.uint8]:
    """Return a dark box with a bright middle on sand, away from the middle of the image."""
    image = np.random.default_rng(3).normal(107.0, 9.0, (480, 640))
    x, y = 320 + right_px, 240 + down_px
    image[y - 15 : y + 15, x - 48 : x + 48] = 40.0
    image[y - 6 : y + 6, x - 30 : x + 30] = 130.0
    return image.clip(0, 255).astype(np.uint8)


def moment(t: float, *, velocity: float = 0.0, yaw: float = 0.0, roll: float = 0.0) -> Observation:
    numbers = empty(5)
    seen = Observation(numbers)
    positions = {name: seen._positions[name] for name in ("t", "dt", "altitude")}
    numbers[positions["t"]], numbers[positions["dt"]] = t, 0.05
    numbers[positions["altitude"]] = BELOW_CAMERA_M + 2.0
    numbers[seen._positions["velocity"]] = velocity, 0.0, 0.0
    numbers[seen._positions["attitude"]] = roll, 0.0, yaw
    return Observation(numbers)


def trial(name: str = "pixels", **settings: Any) -> tuple[float, str]:
    """Return the quality of a level and the digest of its telemetry."""
    entry = benchmark("currents-v2")
    config = entry.read(SHORT | settings)
    total = hashlib.sha256()

    def take(rows: Rows) -> None:
        total.update(rows[:, :-1].tobytes())

    program = entry.load().built_in(name, config)
    result = run_trial("currents-v2", config, program, seed=6, trial=0, on_rows=take)
    return float(result.levels[0]["quality"]), total.hexdigest()


def test_the_eye_is_five_layers_of_convolutions() -> None:
    weights, image = kept("eye_"), scene(100, -60)
    means = image.reshape(HEIGHT, 8, WIDTH, 8).astype(np.float64).mean(axis=(1, 3))
    value = ((means - means.mean()) / means.std())[None]
    for number, (_, _, stride) in enumerate(LAYERS):
        framed = np.pad(value, ((0, 0), (1, 1), (1, 1)))
        windows = np.lib.stride_tricks.sliding_window_view(framed, (3, 3), axis=(1, 2))
        value = np.einsum(
            "cyxji,ocji->oyx", windows[:, ::stride, ::stride], weights[f"weights{number}"]
        )
        value += weights[f"biases{number}"][:, None, None]
        if number < len(LAYERS) - 1:
            value = np.maximum(value, 0.0)

    output = Eye(weights).output(image)

    assert output.shape == (OUTPUTS, ROWS, COLUMNS)
    np.testing.assert_allclose(output, value, atol=1e-3)


def test_the_eye_says_where_a_cell_has_the_target() -> None:
    weights = {name: np.zeros_like(array) for name, array in kept("eye_").items()}
    last = len(LAYERS) - 1
    weights[f"biases{last}"][:] = 1.0, 0.25, -0.5

    found = Eye(weights).find(scene())

    assert found == (CELL_PX * (0.75 - COLUMNS / 2), CELL_PX * (0.0 - ROWS / 2))


def test_the_eye_finds_nothing_in_an_image_of_one_grey() -> None:
    for grey in (0, 107, 255):
        assert Eye(kept("eye_")).find(np.full((480, 640), grey, np.uint8)) is None


def test_a_layer_of_the_hand_is_a_matrix_product_and_a_hyperbolic_tangent() -> None:
    random = np.random.default_rng(1)
    value, weights, biases = (
        random.normal(size=5),
        random.normal(size=(5, 7)),
        random.normal(size=7),
    )

    bent, straight = (layer(value, weights, biases, bends) for bends in (True, False))

    np.testing.assert_allclose(straight, value @ weights + biases, atol=1e-12)
    np.testing.assert_allclose(bent, np.tanh(value @ weights + biases), atol=1e-12)


def test_the_hand_does_what_the_policy_of_the_example_does() -> None:
    features = runpy.run_path(str(FEATURES))
    weights, random = kept("hand_"), np.random.default_rng(2)
    for thrusters in (5, 8):
        ours, theirs = Hand(weights), features["Features"](1)
        for _ in range(5):
            observation = Observation(random.normal(scale=0.3, size=len(empty(thrusters))))
            row = features["row"](observation)
            row[0, features["VISIBLE"]] = 1.0
            value = theirs.see(row, np.array([0]))[0]
            for number in range(3):
                value = value @ weights[f"weights{number}"] + weights[f"biases{number}"]
                value = np.tanh(value) if number < 2 else value
            expected = theirs.command(value[None])[0]

            command = ours.decide(observation, tuple(observation.error[:2].tolist()))

            np.testing.assert_allclose(command, expected, atol=1e-4)


def test_a_target_that_is_no_longer_seen_is_where_it_was() -> None:
    reckoning = Reckoning({"camera_focal_px": 500.0})
    assert reckoning.error() == (0.0, 0.0)
    reckoning.move(moment(0.0))
    reckoning.see(0.0, (100.0, -50.0))
    assert reckoning.error() == pytest.approx((0.2, 0.4))

    for step in range(1, 11):
        reckoning.move(moment(0.05 * step, velocity=0.3))
    assert reckoning.error() == pytest.approx((0.05, 0.4))

    reckoning.move(moment(0.55, yaw=math.pi / 2.0))
    ahead, side = 0.05 + MOUNT_M[0], 0.4 + MOUNT_M[1]
    assert reckoning.error() == pytest.approx((side - MOUNT_M[0], -ahead - MOUNT_M[1]))


def test_an_image_is_compared_with_the_place_where_it_was_taken() -> None:
    late, prompt = (Reckoning({"camera_focal_px": 500.0}) for _ in range(2))
    for step in range(5):
        for each in (late, prompt):
            each.move(moment(0.05 * step, velocity=0.4, roll=0.05 * step))
        if step == 2:
            prompt.see(0.1, (40.0, 30.0))

    late.see(0.1, (40.0, 30.0))

    assert late.error() == pytest.approx(prompt.error())


def test_networks_have_the_same_bits_on_the_oldest_processor() -> None:
    assert printed(BITS, on="oldest") == printed_here(BITS)


def test_it_asks_for_the_images_of_the_camera() -> None:
    with pytest.raises(ValueError, match="images=vehicle"):
        BuiltIn("pixels", benchmark("currents-v2").read({}))


def test_it_holds_better_than_blind_and_the_same_run_has_the_same_bits() -> None:
    quality, digest = trial()

    assert quality > trial("blind", images="none")[0] + 0.2
    assert trial() == (quality, digest)


def test_what_it_sees_is_all_it_knows_of_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    quality, _ = trial()
    find, random = Eye.find, np.random.default_rng(1)

    def mixed(eye: Eye, image: NDArray[np.uint8]) -> tuple[float, float] | None:
        return find(eye, random.permutation(image.reshape(-1)).reshape(image.shape))

    monkeypatch.setattr(Eye, "find", mixed)
    assert trial()[0] < quality - 0.2


def test_its_notes_say_how_it_was_trained() -> None:
    first, last = pixels.TRAINED["seeds"]
    assert not {PUBLIC_SEED, 777} & set(range(first, last + 1))
    assert sum(pixels.TRAINED["cpu_s"].values()) <= 3600

    notes = benchmark("currents-v2").baselines["pixels"].notes
    assert f"seeds {first} to {last}" in notes
