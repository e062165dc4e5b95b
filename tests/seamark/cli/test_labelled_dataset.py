"""`seamark dataset patterns-v1`: images to train a detector with, as other programs read them."""

import csv
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray

from seamark.cli.main import cli
from seamark.sim.benchmarks.patterns_v1.training import IMAGES
from seamark.sim.engine import labelled_layouts
from seamark.sim.engine.labelled_dataset import MOST_IMAGES
from seamark.sim.engine.labelled_layouts import LABELLED_LAYOUTS
from seamark.sim.vehicles.patterns import CLASSES

COUNT = 2 * IMAGES + 1
NAMES = list(CLASSES)
Array = NDArray[np.float64]


def _dataset(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["dataset", "patterns-v1", *arguments])


class Archive:
    """A data set that the command has written."""

    def __init__(self, path: Path) -> None:
        self._file = zipfile.ZipFile(path)
        assert self._file.testzip() is None
        self.names = [name.removeprefix("seamark-dataset/") for name in self._file.namelist()]

    def read(self, name: str) -> str:
        return self._file.read(f"seamark-dataset/{name}").decode()

    def image(self, name: str) -> Any:
        data = np.frombuffer(self._file.read(f"seamark-dataset/{name}"), np.uint8)
        return cv2.imdecode(data, cv2.IMREAD_UNCHANGED)

    def table(self, name: str) -> list[dict[str, str]]:
        return list(csv.DictReader(io.StringIO(self.read(name))))


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Archive]:
    folder, found = tmp_path_factory.mktemp("labelled"), {}
    for layout in LABELLED_LAYOUTS:
        out = folder / f"{layout}.zip"
        options = ("--images", str(COUNT), "--seed", "4", "--format", layout, "--out", str(out))
        answer = _dataset(*options)
        assert answer.exit_code == 0, answer.output
        found[layout] = Archive(out)
    return found


def corners(line: dict[str, str]) -> Array:
    """Return the corners of a line of objects.csv, (4, 2) [px]."""
    values = [float(line[f"corner_{axis}{k}"]) for k in range(4) for axis in "uv"]
    return np.array(values).reshape(4, 2)


def clipped(points: Array) -> Array:
    return np.clip(points + 0.5, 0.0, (320, 240))


def test_every_layout_has_all_images_and_says_how_to_make_them_again(
    archives: dict[str, Archive],
) -> None:
    for layout, archive in archives.items():
        images = [name for name in archive.names if name.endswith(".png")]
        assert images == [f"images/{number:06d}.png" for number in range(COUNT)]
        assert archive.image(images[-1]).shape == (240, 320)
        assert f"--images {COUNT} --seed 4 --format {layout}`" in archive.read("README.md")
        assert f"serves {IMAGES} images" in archive.read("README.md")
        assert json.loads(archive.read("manifest.json"))["seed"] == 4


def test_csv_has_a_line_for_each_image_and_for_each_object(archives: dict[str, Archive]) -> None:
    images, objects = (archives["csv"].table(name) for name in ("images.csv", "objects.csv"))

    assert [one["file"] for one in images] == [f"{number:06d}.png" for number in range(COUNT)]
    assert [int(one["scene"]) for one in images] == [n // IMAGES for n in range(COUNT)]
    for one in images:
        mine = [line for line in objects if line["file"] == one["file"]]
        assert len(mine) == int(one["objects"])
        assert len({line["class"] for line in mine}) == len(mine)
    assert {line["class"] for line in objects} == set(NAMES)
    assert {line["counts"] for line in objects} == {"0", "1"}
    for line in objects:
        box = [float(line[side]) for side in ("left", "upper", "right", "lower")]
        expected = clipped(corners(line)) - 0.5
        assert box == pytest.approx([*expected.min(axis=0), *expected.max(axis=0)])
        if line["counts"] == "1":
            assert float(line["visible"]) >= 0.4


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")
def test_pycocotools_reads_each_object_with_its_class_and_box(
    archives: dict[str, Archive], tmp_path: Path
) -> None:
    from pycocotools.coco import COCO

    objects = archives["csv"].table("objects.csv")
    path = tmp_path / "instances.json"
    path.write_text(archives["coco"].read("annotations/instances.json"))

    read = COCO(str(path))

    assert [one["name"] for one in read.loadCats(read.getCatIds())] == NAMES
    assert sorted(read.getImgIds()) == list(range(1, COUNT + 1))
    counted = 0
    for image in read.loadImgs(read.getImgIds()):
        lines = {one["class"]: one for one in objects if one["file"] == image["file_name"]}
        for one in read.loadAnns(read.getAnnIds(imgIds=[image["id"]])):
            line = lines[NAMES[one["category_id"] - 1]]
            box = clipped(corners(line))
            assert one["bbox"] == pytest.approx([*box.min(axis=0), *np.ptp(box, axis=0)])
            assert one["iscrowd"] == (line["counts"] == "0")
            assert one["visible"] == pytest.approx(float(line["visible"]))
            if one["area"] > 200:
                assert read.annToMask(one).sum() == pytest.approx(one["area"], rel=0.1)
            points = np.reshape(one["keypoints"], (4, 3))
            seen = points[:, 2] > 0
            np.testing.assert_allclose(points[seen, :2], corners(line)[seen] + 0.5)
            assert one["num_keypoints"] == seen.sum()
            counted += line["counts"] == "1"
    assert counted == sum(line["counts"] == "1" for line in objects) > 50


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")
def test_the_evaluation_of_coco_gives_the_truth_full_marks_and_ignores_what_is_ignored(
    archives: dict[str, Archive], tmp_path: Path
) -> None:
    from pycocotools.coco import COCO
    from pycocotools.cocoeval import COCOeval

    path = tmp_path / "instances.json"
    path.write_text(archives["coco"].read("annotations/instances.json"))
    truth = COCO(str(path))
    answers = [
        {**{key: one[key] for key in ("image_id", "category_id", "bbox")}, "score": 0.9}
        for one in truth.loadAnns(truth.getAnnIds())
    ]

    evaluation = COCOeval(truth, truth.loadRes(answers), "bbox")
    evaluation.evaluate()
    evaluation.accumulate()
    evaluation.summarize()

    assert evaluation.stats[1] == pytest.approx(1.0)


def test_yolo_has_the_objects_that_count_with_the_corners_in_shares(
    archives: dict[str, Archive],
) -> None:
    objects, archive = archives["csv"].table("objects.csv"), archives["yolo"]
    cut = 0

    for number in range(COUNT):
        lines = archive.read(f"labels/{number:06d}.txt").splitlines()
        expected = [
            one for one in objects if one["file"] == f"{number:06d}.png" and one["counts"] == "1"
        ]
        for text, line in zip(lines, expected, strict=True):
            label, *shares = text.split()
            assert NAMES[int(label)] == line["class"]
            points, true = (
                np.reshape(shares, (4, 2)).astype(float) * (320, 240),
                corners(line) + 0.5,
            )
            box = clipped(corners(line))
            np.testing.assert_allclose(points.min(axis=0), box.min(axis=0), atol=1e-5)
            np.testing.assert_allclose(points.max(axis=0), box.max(axis=0), atol=1e-5)
            if (true == box).all():
                np.testing.assert_allclose(points, true, atol=1e-5)
            else:
                cut += 1
    assert cut > 0
    names = archive.read("data.yaml")
    assert all(f"  {number}: {name}\n" in names for number, name in enumerate(NAMES))


@pytest.mark.parametrize("layout", LABELLED_LAYOUTS)
def test_the_configuration_in_the_archive_reproduces_its_bytes(tmp_path: Path, layout: str) -> None:
    first, second = tmp_path / "first.zip", tmp_path / "second.zip"
    options = ("--images", "3", "--seed", "6", "--format", layout)
    assert _dataset(*options, "--colour", "--out", str(first)).exit_code == 0
    with zipfile.ZipFile(first) as file:
        settings = file.extract("seamark-dataset/configuration.json", tmp_path)

    again = _dataset(*options, "--config", settings, "--out", str(second))

    assert again.exit_code == 0
    assert first.read_bytes() == second.read_bytes()
    assert Archive(first).image("images/000000.png").shape == (240, 320, 3)


def test_many_annotations_are_in_a_file_until_they_are_written_in_pieces() -> None:
    growing = labelled_layouts._Growing()
    line = bytes(range(256)) * 1024

    for _ in range(20):
        growing.add(line)

    assert growing._file._rolled  # type: ignore[attr-defined]
    pieces = list(growing.pieces())
    assert b"".join(pieces) == 20 * line
    assert max(map(len, pieces)) <= 2**20


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "Say with --images how many"),
        (("--images", "0"), "0 is not in the range"),
        (("--images", str(MOST_IMAGES + 1)), f"at most {MOST_IMAGES} images"),
        (("--images", "3", "--trial", "1"), "--trial selects images of a trial"),
        (("--images", "3", "--every", "2", "--until", "4"), "--every, --until selects"),
        (("--images", "3", "--format", "tum"), "has no format tum. Available: coco, csv, yolo"),
    ],
)
def test_options_that_do_not_apply_are_refused_without_a_file(
    tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    refused = _dataset("--out", str(tmp_path / "dataset.zip"), *arguments)

    assert refused.exit_code == 2
    assert says in refused.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("arguments", [("--images", "3"), ("--format", "csv")])
def test_a_benchmark_of_trackers_refuses_what_is_for_detectors(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    out = tmp_path / "dataset.zip"

    refused = CliRunner().invoke(cli, ["dataset", "currents-v1", "--out", str(out), *arguments])

    assert refused.exit_code == 2
    assert "are for detectors: currents-v1 has none" in refused.output
