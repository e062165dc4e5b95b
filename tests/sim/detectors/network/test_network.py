"""The learned detector: its arithmetic has one order, and it is the network that is submitted."""

import hashlib
import runpy
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest

from seamark.sim.benchmarks.patterns_v1.scenario import draw_scenario
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.detectors import make, network
from seamark.sim.detectors.network.convolution import Layer, add_doubled, convolve, plane
from seamark.sim.detectors.network.detector import WEIGHTS, Network
from seamark.sim.detectors.network.reading import (
    CELLS,
    LABELS,
    OUTPUTS,
    VIEWS,
    answers,
    corners_of,
    views,
)
from seamark.sim.registry import benchmark
from seamark.sim.vehicles.patterns import CLASSES
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

EXAMPLE = Path(__file__).parents[4] / "examples" / "detector"
CONFIG = PatternsConfiguration(optical_depths=(0.0, 3.0))
# Without wide vectors and fused operations a whole network takes five seconds.
BITS = """
import hashlib
import numpy as np
from seamark.sim.detectors.network.detector import Network
from seamark.sim.detectors.network.reading import answers, views

image = np.random.default_rng(1).integers(0, 200, (240, 320)).astype(np.uint8)
image[60:140, 80:200] //= 3
seen = views(image)
output = Network().output(seen)
total = hashlib.sha256(seen.tobytes() + output.tobytes())
answered = answers(output)
for _, corners, confidence in answered:
    total.update(corners.tobytes() + confidence.hex().encode())
print(total.hexdigest(), len(answered))
"""
BITS_OF_PARTS = """
import hashlib
import numpy as np
from seamark.sim.detectors.network.convolution import add_doubled, convolve, plane
from seamark.sim.detectors.network.detector import Network
from seamark.sim.detectors.network.reading import CELLS, OUTPUTS, answers, views

random = np.random.default_rng(1)
total = hashlib.sha256(views(random.integers(0, 200, (240, 320)).astype(np.uint8)).tobytes())
for layer in Network()._layers.values():
    inputs, outputs = len(layer.weights) // 9, layer.weights.shape[1]
    small = layer._replace(width=5, output=plane(2, 5, outputs))
    pixels = (2 * layer.stride + 2) * (5 * layer.stride + 2)
    convolve(random.normal(size=(pixels, inputs)).astype(np.float32), small)
    total.update(small.output.tobytes())
doubled = plane(4, 6, 16)
add_doubled(random.normal(size=(4 * 5, 16)).astype(np.float32), 6, doubled)
total.update(doubled.tobytes())
answered = answers(random.normal(size=(OUTPUTS, *CELLS)).astype(np.float32))
for _, corners, confidence in answered:
    total.update(corners.tobytes() + confidence.hex().encode())
print(total.hexdigest(), len(answered))
"""


def image_of(level: int, step: int = 0) -> np.ndarray:
    scenario = draw_scenario(CONFIG, 11, 0, level)
    motion = np.concatenate(scenario.path.pose_and_velocity(0.5 * step))
    return scenario.camera.grey(motion, step)


def kept_layers() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    with np.load(WEIGHTS) as stored:
        names = {name.partition(".")[0] for name in stored.files}
        return {
            name: (
                stored[f"{name}.weights"].astype(np.float32),
                stored[f"{name}.biases"].astype(np.float32),
            )
            for name in names
        }


@pytest.fixture(scope="module")
def packing() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE / "packing.py"))


def convolved(
    image: np.ndarray, weights: np.ndarray, biases: np.ndarray, stride: int
) -> np.ndarray:
    """Return a convolution (O, H / stride, W / stride) in float64."""
    framed = np.pad(image.astype(np.float64), ((0, 0), (1, 1), (1, 1)))
    windows = np.lib.stride_tricks.sliding_window_view(framed, (3, 3), axis=(1, 2))
    sums = np.einsum("cyxji,ocji->oyx", windows[:, ::stride, ::stride], weights.astype(np.float64))
    return sums + biases[:, None, None]


@pytest.mark.parametrize(("stride", "rectified"), [(1, True), (2, True), (1, False)])
def test_a_layer_is_a_convolution(stride: int, rectified: bool) -> None:
    random = np.random.default_rng(2)
    image = random.normal(size=(6, 12, 20)).astype(np.float32)
    weights = random.normal(size=(32, 6, 3, 3)).astype(np.float32)
    biases = random.normal(size=32).astype(np.float32)
    framed = np.pad(image.transpose(1, 2, 0), ((1, 1), (1, 1), (0, 0))).reshape(-1, 6)
    height, width = 12 // stride, 20 // stride
    layer = Layer(
        np.ascontiguousarray(weights.transpose(2, 3, 1, 0).reshape(54, 32)),
        biases[None],
        width,
        stride,
        rectified,
        plane(height, width, 32),
    )

    convolve(np.ascontiguousarray(framed), layer)

    whole = layer.output.reshape(height + 2, width + 2, 32)
    expected = convolved(image, weights, biases, stride)
    if rectified:
        expected = np.maximum(expected, 0.0)
    np.testing.assert_allclose(whole[1:-1, 1:-1].transpose(2, 0, 1), expected, atol=2e-5)
    assert (expected < 0.0).any() != rectified
    frame = np.ones(whole.shape[:2], bool)
    frame[1:-1, 1:-1] = False
    assert not whole[frame].any()


def test_a_layer_adds_from_the_bias_on_in_the_order_of_the_window() -> None:
    large = 2.0**24  # to which adding 1 changes nothing in float32
    weights = np.zeros((9, 16), np.float32)
    weights[[0, 1, 2, 3], 0] = large, 1.0, -large, 3.0
    framed = np.ones((3 * 7, 1), np.float32)
    layer = Layer(weights, np.ones((1, 16), np.float32), 5, 1, True, plane(1, 5, 16))

    convolve(framed, layer)

    assert layer.output[8, 0] == 3.0  # in another order it is 5 or 4
    assert layer.output[8, 1] == 1.0


def test_each_pixel_of_the_small_image_is_added_to_four_of_the_large_one() -> None:
    small, large = plane(2, 3, 16), plane(4, 6, 16)
    inner = small.reshape(4, 5, 16)[1:-1, 1:-1]
    inner[:] = np.arange(6.0).reshape(2, 3, 1)
    large.reshape(6, 8, 16)[1:-1, 1:-1] = 10.0

    add_doubled(small, 6, large)

    expected = 10.0 + np.arange(6.0).reshape(2, 3).repeat(2, axis=0).repeat(2, axis=1)
    np.testing.assert_array_equal(large.reshape(6, 8, 16)[1:-1, 1:-1, 7], expected)
    assert large.reshape(6, 8, 16)[0].max() == 0.0


def test_views_know_neither_brightness_nor_contrast() -> None:
    image = image_of(0).astype(np.int64) // 4

    np.testing.assert_allclose(
        views((image * 3 + 20).astype(np.uint8)), views(image.astype(np.uint8)), atol=2e-3
    )


def test_a_flat_image_has_views_without_contrast() -> None:
    seen = views(np.full((240, 320), 90, np.uint8))

    assert seen.shape == (VIEWS, 120, 160)
    np.testing.assert_allclose(seen, 0.0, atol=1e-9)


def test_corners_are_those_of_a_parallelogram_in_its_upright_box() -> None:
    corners = corners_of(10, 20, [0.25, -0.5, np.log(2.0), 0.0, 0.0, 50.0])

    u, v = 20.25 * 8 + 3.5, 9.5 * 8 + 3.5
    expected = [[u, v - 16], [u + 32, v + 16], [u, v + 16], [u - 32, v - 16]]
    np.testing.assert_allclose(corners, expected, atol=1e-9)


def test_answers_are_the_two_highest_cells_of_a_class_without_their_neighbours() -> None:
    output = np.full((OUTPUTS, *CELLS), -9.0, np.float32)
    output[len(LABELS) :] = 0.0
    output[2, 5, 7], output[2, 5, 8], output[2, 20, 30], output[2, 28, 3] = 2.0, 1.9, 1.0, 0.5
    output[6, 0, 0] = 3.0

    found = answers(output)

    assert [one[0] for one in found] == ["aruco", "pipe", "pipe"]
    assert [one[2] for one in found] == pytest.approx(
        [1.0 / (1.0 + np.exp(-score)) for score in (3.0, 2.0, 1.0)]
    )
    np.testing.assert_allclose(found[1][1].mean(axis=0), [7 * 8 + 3.5, 5 * 8 + 3.5])


def test_the_network_has_the_classes_of_the_benchmark_in_their_order() -> None:
    assert tuple(CLASSES) == LABELS


@pytest.mark.slow
@pytest.mark.parametrize(
    "bits",
    [
        pytest.param(BITS_OF_PARTS, id="of parts"),
        pytest.param(BITS, id="of all", marks=pytest.mark.long),
    ],
)
def test_the_network_has_the_same_bits_in_two_processes_and_on_the_oldest_processor(
    bits: str,
) -> None:
    here = printed_here(bits)

    assert len(here.split()[0]) == 64
    assert int(here.split()[1]) > 0
    assert here == printed(bits, on="oldest")


def test_the_weights_are_those_that_the_note_on_the_leaderboard_is_about() -> None:
    assert hashlib.sha256(WEIGHTS.read_bytes()).hexdigest() == network.TRAINED["weights_sha256"]
    assert str(network.TRAINED["images"]["images"]) in network.notes()


@pytest.mark.parametrize("level", [0, 1])
def test_onnx_runtime_computes_the_same_network(packing: dict[str, Any], level: int) -> None:
    model = packing["exported"](kept_layers())
    onnx.checker.check_model(onnx.load_from_string(model))
    session = onnxruntime.InferenceSession(model)
    seen = views(image_of(level))

    [expected] = session.run(None, {"views": seen[None]})

    np.testing.assert_allclose(Network().output(seen), expected[0], atol=2e-4)
    assert len(model) < 2**20


def test_the_archive_of_the_example_answers_as_the_entry(
    packing: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packing["pack"](packing["exported"](kept_layers()), tmp_path / "detector.zip")
    zipfile.ZipFile(tmp_path / "detector.zip").extractall(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    image = image_of(0)

    found = runpy.run_path(str(tmp_path / "main.py"))["Detector"]({}).detect(image)

    expected = make("network").detect(image)
    assert [one[0] for one in found] == [one.label for one in expected]
    assert len(found) > 0
    for (_, corners, confidence), one in zip(found, expected, strict=True):
        np.testing.assert_allclose(corners, one.corners, atol=0.01)
        assert confidence == pytest.approx(one.confidence, abs=1e-4)


def test_colour_images_are_answered_by_their_green_channel() -> None:
    image = image_of(0)
    colour = np.stack([image // 2, image, image // 3], axis=2)

    for one, other in zip(
        make("network").detect(colour), make("network").detect(image), strict=True
    ):
        np.testing.assert_array_equal(one.corners, other.corners)


@pytest.mark.slow
def test_the_network_recognises_more_than_random_boxes_and_less_than_the_truth() -> None:
    patterns = benchmark("patterns-v1")
    experiment = patterns.load()
    config = patterns.read({"optical_depths": [1.0], "level_duration_s": 12.0})
    precision = {}
    for name in ("random", "network", "oracle"):
        rows: list[np.ndarray] = []
        level = experiment.level(
            config, experiment.built_in(name, config), seed=5, trial=0, level=0
        )
        level.run(lambda some, rows=rows: rows.append(some.copy()))
        precision[name] = experiment.metrics(config, 0, np.concatenate(rows))["ap_percent"]

    assert precision["random"] < 5.0
    assert 20.0 < precision["network"] < precision["oracle"] == 100.0
