"""`seamark dataset --format`: what COCO's, YOLO's and TUM's programs read is the truth."""

import csv
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from seamark.cli.main import cli
from seamark.sim.engine.dataset import LAYOUTS
from seamark.sim.engine.dataset_layouts import Coco, Yolo

SHORT = ("--set", "levels=0.6", "--set", "level_duration_s=4", "--set", "settle_s=1", "--seed", "3")
Array = NDArray[np.float64]


class Archive:
    """A data set that the command has written."""

    def __init__(self, path: Path) -> None:
        self._file = zipfile.ZipFile(path)
        self.names = [name.removeprefix("seamark-dataset/") for name in self._file.namelist()]

    def read(self, name: str) -> str:
        return self._file.read(f"seamark-dataset/{name}").decode()

    def image(self, name: str) -> Any:
        data = np.frombuffer(self._file.read(f"seamark-dataset/{name}"), np.uint8)
        return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)


@pytest.fixture(scope="module")
def archives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Archive]:
    folder, found = tmp_path_factory.mktemp("datasets"), {}
    for layout in LAYOUTS:
        out = folder / f"{layout}.zip"
        options = ("--every", "20", "--out", str(out), "--format", layout)
        answer = CliRunner().invoke(cli, ["dataset", "currents-v1", *SHORT, *options])
        assert answer.exit_code == 0, answer.output
        found[layout] = Archive(out)
    return found


@pytest.fixture(scope="module")
def truth(archives: dict[str, Archive]) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(archives["seamark"].read("groundtruth.csv"))))


def corners(line: dict[str, str]) -> Array:
    """Return the true corners from the upper left corner of the image, (4, 2) [px]."""
    values = [float(line[f"corner_{axis}{i}"]) for i in range(4) for axis in "uv"]
    return np.array(values).reshape(4, 2) + 0.5


@pytest.mark.slow
def test_coco_has_an_image_and_an_annotation_for_each_that_shows_the_target(
    archives: dict[str, Archive], truth: list[dict[str, str]]
) -> None:
    """The fields are those of https://cocodataset.org/#format-data."""
    document = json.loads(archives["coco"].read("annotations/instances.json"))

    (category,) = document["categories"]
    assert {"id", "name", "supercategory", "keypoints", "skeleton"} <= category.keys()
    for image, line in zip(document["images"], truth, strict=True):
        pixels = archives["coco"].image(f"images/{image['file_name']}")
        assert pixels.shape == (image["height"], image["width"])
        found = [one for one in document["annotations"] if one["image_id"] == image["id"]]
        if line["in_view"] == "1":
            (one,) = found
            expected = corners(line)
            np.testing.assert_allclose(np.reshape(one["segmentation"][0], (4, 2)), expected)
            np.testing.assert_allclose(np.reshape(one["keypoints"], (4, 3))[:, :2], expected)
            x, y, width, height = one["bbox"]
            np.testing.assert_allclose([x, y], expected.min(axis=0))
            np.testing.assert_allclose([x + width, y + height], expected.max(axis=0))
            assert one["area"] == pytest.approx(cv2.contourArea(expected.astype(np.float32)))
            assert (one["category_id"], one["iscrowd"], one["num_keypoints"]) == (1, 0, 4)
    assert [one["id"] for one in document["annotations"]] == [
        at + 1 for at in range(len(document["annotations"]))
    ]


@pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")
def test_pycocotools_reads_the_annotations(archives: dict[str, Archive], tmp_path: Path) -> None:
    from pycocotools.coco import COCO

    path = tmp_path / "instances.json"
    path.write_text(archives["coco"].read("annotations/instances.json"))

    read = COCO(str(path))

    for one in read.loadAnns(read.getAnnIds()):
        assert read.annToMask(one).sum() == pytest.approx(one["area"], rel=0.05)


def test_yolo_has_a_label_for_each_image_with_the_corners_in_shares(
    archives: dict[str, Archive], truth: list[dict[str, str]]
) -> None:
    yolo = archives["yolo"]
    images = [name for name in yolo.names if name.startswith("images/")]

    assert "names:\n  0: target" in yolo.read("data.yaml")
    for name, line in zip(images, truth, strict=True):
        label = yolo.read(name.replace("images/", "labels/").replace(".png", ".txt"))
        height, width = yolo.image(name).shape
        if line["in_view"] == "1":
            number, *shares = label.split()
            assert number == "0"
            found = np.reshape([float(share) for share in shares], (4, 2)) * (width, height)
            np.testing.assert_allclose(found, corners(line), atol=1e-5)


def test_tum_has_the_pose_of_the_camera_from_which_the_corners_are_seen(
    archives: dict[str, Archive], truth: list[dict[str, str]]
) -> None:
    tum = archives["tum"]
    camera = json.loads(tum.read("camera.json"))
    places = np.array(camera["target"]["top_corners_m"])
    matrix = np.array(camera["optics"]["matrix"])
    listed = [line.split() for line in tum.read("rgb.txt").splitlines() if line[0] != "#"]
    poses = [line.split() for line in tum.read("groundtruth.txt").splitlines() if line[0] != "#"]

    assert [time for time, _ in listed] == [time for time, *_ in poses]
    for (time, name), (_, *pose), line in zip(listed, poses, truth, strict=True):
        assert tum.image(name) is not None
        assert float(time) == pytest.approx(float(line["t"]))
        tx, ty, tz, qx, qy, qz, qw = map(float, pose)
        axis = np.array([qx, qy, qz])
        off = places - (tx, ty, tz)
        across = 2.0 * np.cross(-axis, off)  # by the inverse: into the camera
        seen = off + qw * across + np.cross(-axis, across)
        image = seen @ matrix.T
        np.testing.assert_allclose(image[:, :2] / image[:, 2:] + 0.5, corners(line), atol=1e-4)


class _Frame:
    """A frame of which only the corners and the size of the image are asked."""

    class camera:  # noqa: N801  # as the attribute of a frame
        class optics:  # noqa: N801
            width, height = 320, 240

    def __init__(self, points: Any) -> None:
        self._points = np.array(points, dtype=np.float64)

    def corners(self) -> Array:
        return self._points - 0.5


@pytest.mark.parametrize(
    ("points", "box"),
    [
        ([[-20, 10], [40, 10], [40, 60], [-20, 60]], [0, 10, 40, 50]),
        ([[300, 200], [400, 200], [400, 300], [300, 300]], [300, 200, 20, 40]),
        ([[-90, 10], [-40, 10], [-40, 60], [-90, 60]], None),
        ([[np.nan, 10], [40, 10], [40, 60], [-20, 60]], None),
    ],
)
def test_a_target_at_the_border_is_cut_there(points: Any, box: list[float] | None) -> None:
    frame: Any = _Frame(points)
    coco, yolo = Coco(), Yolo()

    assert list(coco.add("a.png", np.zeros(0), frame)) == []
    ((_, label),) = yolo.add("a.png", np.zeros(0), frame)
    ((_, text),) = coco.end()

    annotations = json.loads(text)["annotations"]
    assert [one["bbox"] for one in annotations] == ([] if box is None else [pytest.approx(box)])
    shares = [float(share) for share in label.split()[1:]]
    assert len(shares) == (0 if box is None else 8)
    assert all(0.0 <= share <= 1.0 for share in shares)


def test_the_readme_has_the_command_that_makes_the_data_set_again(
    archives: dict[str, Archive],
) -> None:
    for layout, archive in archives.items():
        command = archive.read("README.md").partition("seamark dataset ")[2].partition("`")[0]
        assert (f"--format {layout}" in command) is (layout != "seamark")
        assert {"camera.json", "configuration.json", "manifest.json"} <= set(archive.names)
