"""The example that trains an eye: what it learns from, and what its archive does in a box."""

import runpy
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium  # noqa: F401  # sets filters of warnings, which come before those of a test
import numpy as np
import onnxruntime
import pytest
from numpy.typing import NDArray

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sim.control.position.pixels.controller import WEIGHTS
from seamark.sim.control.position.pixels.eye import HEIGHT_PX, WIDTH_PX, Eye, normalise

EXAMPLES = Path(__file__).parents[3] / "examples"
EXAMPLE = EXAMPLES / "eye"
NEIGHBOURS = ("features", "looking", "packing", "reckoning", "simulator")
KINDS = ("girona500", "bluerov2-heavy")
SEED = 700_000  # of vehicles that no training has seen
OLDER = pytest.mark.filterwarnings("ignore:.*out of date:DeprecationWarning")  # currents-v2 is
Array = NDArray[Any]


def run(file: Path) -> dict[str, Any]:
    """Return the names of a file that imports neighbours by names that others have, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(file.parent)
        for name in NEIGHBOURS:
            patch.delitem(sys.modules, name, raising=False)
        found = runpy.run_path(str(file))
        for name in NEIGHBOURS:
            sys.modules.pop(name, None)
    return found


@pytest.fixture(scope="module")
def weights() -> dict[str, Array]:
    """Those of the reference entry, which this example has trained."""
    with np.load(WEIGHTS) as stored:
        return dict(stored)


@pytest.fixture(scope="module")
def hand(weights: dict[str, Array], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The entry's hand, packed as `examples/ppo` packs it."""
    out = tmp_path_factory.mktemp("hand") / "hand.zip"
    layers = [(weights[f"hand_weights{n}"], weights[f"hand_biases{n}"]) for n in range(3)]
    run(EXAMPLES / "ppo" / "packing.py")["pack"](layers, out)
    return out


@pytest.fixture(scope="module")
def packing() -> dict[str, Any]:
    return run(EXAMPLE / "packing.py")


@pytest.fixture(scope="module")
def looking() -> dict[str, Any]:
    return run(EXAMPLE / "looking.py")


@pytest.fixture(scope="module")
def archive(packing: dict[str, Any], weights: dict[str, Array], hand: Path) -> Path:
    out = hand.with_name("eye.zip")
    packing["pack"](weights, hand, out)
    return out


@pytest.fixture(scope="module")
def program(archive: Path) -> dict[str, Any]:
    """The names of the program in the archive, here and not in a box."""
    folder = archive.with_name("unpacked")
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(folder)
    return run(folder / "main.py")


@pytest.fixture(scope="module")
def eye(archive: Path) -> onnxruntime.InferenceSession:
    with zipfile.ZipFile(archive) as packed:
        return onnxruntime.InferenceSession(packed.read("eye.onnx"))


def scenes() -> Iterator[Array]:
    """Yield images with a target in some place, and two without one."""
    random = np.random.default_rng(3)
    for right, down in ((0, 0), (100, -60), (-250, 190)):
        image = random.normal(107.0, 9.0, (HEIGHT_PX, WIDTH_PX))
        x, y = WIDTH_PX // 2 + right, HEIGHT_PX // 2 + down
        image[y - 15 : y + 15, x - 48 : x + 48] = 40.0
        image[y - 6 : y + 6, x - 30 : x + 30] = 130.0
        yield image.clip(0, 255).astype(np.uint8)
    yield np.full((HEIGHT_PX, WIDTH_PX), 107, np.uint8)
    yield random.normal(107.0, 1.2, (HEIGHT_PX, WIDTH_PX)).astype(np.uint8)  # noise alone


def test_the_program_makes_of_an_image_what_the_eye_has_learned_from(
    program: dict[str, Any],
) -> None:
    for image in scenes():
        framed = np.zeros((62 * 82, 1), np.float32)
        normalise(image, framed)

        pooled = program["pooled"](image, 60, 80)

        assert pooled.dtype == np.float32
        np.testing.assert_allclose(pooled, framed.reshape(62, 82)[1:-1, 1:-1], rtol=1e-6, atol=1e-6)


def test_the_program_finds_the_target_where_the_entry_finds_it(
    program: dict[str, Any], eye: onnxruntime.InferenceSession, weights: dict[str, Array]
) -> None:
    of_entry = Eye({name[4:]: array for name, array in weights.items() if name[:4] == "eye_"})
    found = 0
    for image in scenes():
        [output] = eye.run(None, {"image": program["pooled"](image, 60, 80)[None, None]})
        np.testing.assert_allclose(output[0], of_entry.output(image), rtol=1e-5, atol=1e-4)

        ours, theirs = program["sight"](output[0], *image.shape), of_entry.find(image)

        assert (ours is None) == (theirs is None)
        if theirs is not None:
            assert ours == pytest.approx(theirs, abs=1e-3)
            found += 1
    assert found == 3


def test_the_program_says_that_it_needs_images(program: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="set images to vehicle"):
        program["Controller"]({"images": "none"})


@pytest.mark.slow
@OLDER
@pytest.mark.parametrize("kind", KINDS)
def test_images_have_the_place_of_the_target_in_them_as_their_label(
    looking: dict[str, Any], program: dict[str, Any], eye: onnxruntime.InferenceSession, kind: str
) -> None:
    shown, wanderer = looking["Shown"](), looking["Wanderer"](8, np.random.default_rng(1))

    looking["look"](shown, kind, wanderer, seed=SEED, count=8, seconds=10.0)

    off, wrong = [], 0
    for image, (visible, *place) in zip(shown.images, shown.labels, strict=True):
        [output] = eye.run(None, {"image": image.astype(np.float32)[None, None]})
        found = program["sight"](output[0], HEIGHT_PX, WIDTH_PX)
        wrong += (found is None) == bool(visible)
        if found is not None and visible:
            off.append(np.hypot(*np.subtract(found, place)))
    assert len(shown.images) == 8 * 20 - 1  # one of five, ten a second; the first ones stay
    assert 0.3 < len(off) / len(shown.images) < 0.7
    assert wrong <= 0.05 * len(shown.images)
    assert np.median(off) < 2.5  # [px]; in the image before or after it was elsewhere


@pytest.mark.slow
@OLDER
def test_a_pupil_steers_by_what_its_eye_has_learned(
    looking: dict[str, Any], weights: dict[str, Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    find, looks = Eye.find, [0]

    def counted(eye: Eye, image: Array) -> Any:
        looks[0] += 1
        return find(eye, image)

    monkeypatch.setattr(Eye, "find", counted)
    unseen = np.array([-1000.0, 0.0, 0.0], np.float32)  # no cell has the target
    blind = weights | {"eye_biases4": weights["eye_biases4"] + unseen}
    off = []
    for each in (weights, blind):
        shown, pupil = looking["Shown"](), looking["Pupil"](4, KINDS[0], each)

        looking["look"](shown, KINDS[0], pupil, seed=SEED, count=4, seconds=15.0)

        labels = np.array(shown.labels)[len(shown.labels) // 2 :]
        off.append(np.median(np.hypot(*labels[labels[:, 0] > 0, 1:].T)))
    assert off[0] < 0.5 * off[1]
    assert 149 <= looks[0] / 8 <= 150  # at each image once, ten a second


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize("kind", KINDS)
def test_the_archive_in_its_box_acts_as_the_entry_does(
    isolation: IsolationLevel,
    packing: dict[str, Any],
    weights: dict[str, Array],
    archive: Path,
    kind: str,
) -> None:
    short = {"levels": [0.3], "level_duration_s": 10.0, "settle_s": 2.5, "tracker": "truth"}

    boxed, entry = packing["beside"](archive, weights, kind, **short)

    assert len(boxed) == 200
    np.testing.assert_allclose(boxed, entry, rtol=0.0, atol=1e-5)  # [m/s, rad/s] in float32
    assert np.ptp(boxed, axis=0)[[0, 1, 3]].min() > 0.1


@pytest.mark.slow
@pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
def test_a_short_training_packs_what_it_has_learned(hand: Path, tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLE / "train.py"), str(hand), "--vehicles", "4"]

    done = subprocess.run(
        [*command, "--seconds", "3", "--out", "eye.zip", "--keep", str(tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert "In its box it acts as in training" in done.stdout
    with np.load(tmp_path / "weights.npz") as kept, np.load(WEIGHTS) as entry:
        assert {name: kept[name].shape for name in kept} == {
            name: entry[name].shape for name in entry
        }
    with zipfile.ZipFile(tmp_path / "eye.zip") as packed:
        assert {*packed.namelist()} == {
            *("main.py", "features.py", "reckoning.py", "simulator.py", "eye.onnx", "policy.onnx")
        }
