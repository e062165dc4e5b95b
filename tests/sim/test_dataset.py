"""Data sets: the benchmark's own pictures, with truth that fits them."""

import csv
import io
import json
import zipfile

import cv2
import numpy as np
import pytest

from sim import registry
from sim.configuration import Configuration
from sim.dataset import COLUMNS, Choice, archive
from sim.replay import Replay
from sim.telemetry import INDEX, Rows
from sim.trial import run_trial

SEED = 4
NAMES = list(registry.BENCHMARKS)


@pytest.fixture(scope="module", params=NAMES)
def recorded(request: pytest.FixtureRequest) -> tuple[str, Configuration, Rows]:
    """A short trial of each benchmark."""
    entry = registry.benchmark(request.param)
    config = entry.read(entry.shortest)
    solution = entry.load().built_in(next(iter(entry.built_in)), config)
    kept: list[Rows] = []
    run_trial(
        request.param,
        config,
        solution,
        seed=SEED,
        trial=0,
        on_rows=lambda rows: kept.append(rows.copy()),
    )
    return request.param, config, np.concatenate(kept)


def _made(recorded: tuple[str, Configuration, Rows], choice: Choice) -> dict[str, bytes]:
    name, config, rows = recorded
    data = b"".join(archive(name, config, rows, seed=SEED, choice=choice))
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        assert file.testzip() is None
        return {
            entry.removeprefix("seamark-dataset/"): file.read(entry) for entry in file.namelist()
        }


def _table(files: dict[str, bytes]) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(files["groundtruth.csv"].decode())))


def test_every_picture_is_the_one_that_the_tracker_had(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    name, config, rows = recorded
    files = _made(recorded, Choice(every=7))
    camera = registry.benchmark(name).load().camera(config, seed=SEED, trial=0, level=0)

    assert len(_table(files)) == len(rows[::7])
    for number, row in enumerate(rows[::7][:3]):
        stored = cv2.imdecode(
            np.frombuffer(files[f"images/{number:06d}.png"], np.uint8), cv2.IMREAD_UNCHANGED
        )
        pose = row[INDEX["x"] : INDEX["yaw"] + 1].copy()
        assert np.array_equal(stored, camera.grey(pose, 7 * number))


def test_the_true_corners_are_those_of_the_camera(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    name, config, rows = recorded
    table = _table(_made(recorded, Choice(every=11)))
    replay = Replay(name, config, lambda _trial: SEED)

    for line, row in zip(table, rows[::11], strict=True):
        told = [float(line[f"corner_{axis}{at}"]) for at in range(4) for axis in "uv"]
        assert told == replay.shot(row).corners().ravel().tolist()
        assert float(line["x"]) == row[INDEX["x"]]


def test_intrinsics_and_pose_project_the_target_onto_its_corners(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    files = _made(recorded, Choice(every=13))
    camera = json.loads(files["camera.json"])
    focal, target = camera["optics"]["focal_px"], camera["target"]
    first = _table(files)[0]

    across = np.hypot(
        float(first["corner_u1"]) - float(first["corner_u0"]),
        float(first["corner_v1"]) - float(first["corner_v0"]),
    )
    top = target["seabed_m"] - target["height_m"]
    expected = focal * target["length_m"] / (top - float(first["camera_z"]))
    assert across == pytest.approx(expected, rel=0.02)  # the camera looks straight down, about


def test_the_same_configuration_and_seed_give_the_same_bytes(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    name, config, rows = recorded
    first, second = (
        b"".join(archive(name, config, rows, seed=SEED, choice=Choice(every=20))) for _ in range(2)
    )

    assert first == second


def test_time_and_colour_can_be_chosen(recorded: tuple[str, Configuration, Rows]) -> None:
    files = _made(recorded, Choice(begin_s=0.5, end_s=1.0, colour=True))

    times = [float(line["t"]) for line in _table(files)]
    assert (min(times), max(times)) == (pytest.approx(0.5), pytest.approx(0.95))
    picture = cv2.imdecode(
        np.frombuffer(files["images/000000.png"], np.uint8), cv2.IMREAD_UNCHANGED
    )
    assert picture.ndim == 3


def test_the_readme_names_every_column(recorded: tuple[str, Configuration, Rows]) -> None:
    text = _made(recorded, Choice(every=50))["README.md"].decode()

    ranges = {f"corner_{axis}{at}" for axis in "uv" for at in range(4)}
    assert {name for name in COLUMNS if name not in ranges and name not in text} == set()


def test_a_choice_without_a_picture_is_refused(recorded: tuple[str, Configuration, Rows]) -> None:
    name, config, rows = recorded

    with pytest.raises(ValueError, match="no picture is left"):
        archive(name, config, rows, seed=SEED, choice=Choice(begin_s=1e6))
