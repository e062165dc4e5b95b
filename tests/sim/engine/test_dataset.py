"""Data sets: the benchmark's own pictures, with truth that fits them."""

import csv
import io
import json
import zipfile
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.camera import Camera, Effects, Optics, Target, Water
from seamark.sim.engine.dataset import COLUMNS, STARTS, Selection, archive
from seamark.sim.engine.replay import Replay
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.settings.configuration import Configuration
from seamark.sim.trackers import make

SEED = 4
EVERY = 13
NAMES = [name for name in registry.BENCHMARKS if registry.benchmark(name).has_data_sets]


@pytest.fixture(scope="module", params=NAMES)
def recorded(request: pytest.FixtureRequest) -> tuple[str, Configuration, Rows]:
    """A short trial of each benchmark."""
    entry = registry.benchmark(request.param)
    many_levels = "jump_levels" in entry.quick_settings
    brief = {"level_duration_s": 1.0} if many_levels else {}
    config = entry.read(entry.quick_settings | brief)
    return request.param, config, _rows(request.param, config)


def _rows(name: str, config: Configuration) -> Rows:
    entry = registry.benchmark(name)
    solution = entry.load().built_in(next(iter(entry.built_in)), config)
    kept: list[Rows] = []
    run_trial(
        name,
        config,
        solution,
        seed=SEED,
        trial=0,
        on_rows=lambda rows: kept.append(rows.copy()),
    )
    return np.concatenate(kept)


def test_a_trial_records_exactly_what_its_configuration_says(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    _, config, rows = recorded

    assert rows.shape == config.telemetry_shape()


def _archived(recorded: tuple[str, Configuration, Rows], choice: Selection) -> bytes:
    name, config, rows = recorded
    return b"".join(archive(name, config, rows, seed=SEED, selection=choice))


def _made(recorded: tuple[str, Configuration, Rows], choice: Selection) -> dict[str, bytes]:
    return _unpacked(_archived(recorded, choice))


def _unpacked(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        assert file.testzip() is None
        return {
            entry.removeprefix("seamark-dataset/"): file.read(entry) for entry in file.namelist()
        }


SPARSE = Selection(every=EVERY)


@pytest.fixture(scope="module")
def archived(recorded: tuple[str, Configuration, Rows]) -> bytes:
    """The data set of the trial with some of its pictures."""
    return _archived(recorded, SPARSE)


@pytest.fixture(scope="module")
def files(archived: bytes) -> dict[str, bytes]:
    return _unpacked(archived)


def _table(files: dict[str, bytes], name: str = "groundtruth.csv") -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(files[name].decode())))


def _picture(files: dict[str, bytes], name: str) -> NDArray[np.uint8]:
    data = np.frombuffer(files[name], np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), dtype=np.uint8)


def _corners(line: dict[str, str]) -> NDArray[np.float64]:
    corners = [float(line[f"corner_{axis}{k}"]) for k in range(4) for axis in "uv"]
    return np.array(corners).reshape(4, 2)


def test_every_picture_is_the_one_that_the_tracker_had(
    recorded: tuple[str, Configuration, Rows], files: dict[str, bytes]
) -> None:
    name, config, rows = recorded
    camera = registry.benchmark(name).load().camera(config, seed=SEED, trial=0, level=0)
    replay = Replay(name, config, lambda _trial: SEED)

    assert len(_table(files)) == len(rows[::EVERY])
    for number, row in enumerate(rows[::EVERY][:2]):  # of the first level
        stored = cv2.imdecode(
            np.frombuffer(files[f"images/{number:06d}.png"], np.uint8), cv2.IMREAD_UNCHANGED
        )
        assert np.array_equal(stored, camera.grey(replay.frame(row).motion, EVERY * number))


def test_the_true_corners_are_those_of_the_camera(
    recorded: tuple[str, Configuration, Rows], files: dict[str, bytes]
) -> None:
    name, config, rows = recorded
    table = _table(files)
    replay = Replay(name, config, lambda _trial: SEED)

    for line, row in zip(table, rows[::EVERY], strict=True):
        corners = [float(line[f"corner_{axis}{at}"]) for at in range(4) for axis in "uv"]
        assert corners == replay.frame(row).corners().ravel().tolist()
        assert float(line["x"]) == row[INDEX["x"]]


def test_intrinsics_and_pose_project_the_target_onto_its_corners(files: dict[str, bytes]) -> None:
    camera = json.loads(files["camera.json"])
    focal, target = camera["optics"]["focal_px"], camera["target"]
    first = _table(files)[0]

    across = np.hypot(
        float(first["corner_u1"]) - float(first["corner_u0"]),
        float(first["corner_v1"]) - float(first["corner_v0"]),
    )
    left, right, *_ = np.array(target["top_corners_m"])
    long, top = np.hypot(*(right - left)[:2]), 0.5 * (left + right)[2]
    expected = focal * long / (top - float(first["camera_z"]))
    assert across == pytest.approx(expected, rel=0.02)  # the camera looks straight down, about


@pytest.mark.slow
def test_the_same_configuration_and_seed_give_the_same_bytes(
    recorded: tuple[str, Configuration, Rows], archived: bytes
) -> None:
    assert _archived(recorded, SPARSE) == archived


@pytest.mark.slow
def test_time_and_colour_can_be_chosen(recorded: tuple[str, Configuration, Rows]) -> None:
    files = _made(recorded, Selection(begin_s=0.8, end_s=1.0, colour=True))

    times = [float(line["t"]) for line in _table(files)]
    assert (min(times), max(times)) == (pytest.approx(0.8), pytest.approx(0.95))
    picture = cv2.imdecode(
        np.frombuffer(files["images/000000.png"], np.uint8), cv2.IMREAD_UNCHANGED
    )
    assert picture.ndim == 3


@pytest.mark.slow
def test_a_tracker_that_works_on_the_data_set_is_as_good_as_in_the_benchmark(
    recorded: tuple[str, Configuration, Rows],
) -> None:
    """The starts are those that the benchmark's own tracker had: it does the same again."""
    _, config, rows = recorded
    files = _made(recorded, Selection())
    settings: Any = config
    tracker = make(settings.tracker, **settings.tracker_options())

    starts = _table(files, "starts.csv")
    assert starts
    table = _table(files)
    ends = [*(float(start["t"]) for start in starts[1:]), float("inf")]
    for start, end in zip(starts, ends, strict=True):
        begin = float(start["t"])
        tracker.start(_picture(files, f"starts/{start['file']}"), _corners(start))
        found = []
        for line in [line for line in table if begin < float(line["t"]) < end]:
            track = tracker.update(_picture(files, f"images/{line['file']}"))
            found.append([track.ok, *track.corners.ravel()])
        followed = rows[(rows[:, INDEX["t"]] > begin) & (rows[:, INDEX["t"]] < end)]
        columns = [INDEX["tracker_ok"], *(INDEX[f"corner_{k}"] for k in range(8))]
        assert np.array_equal(np.array(found, float), followed[:, columns])


def test_the_corners_of_a_start_have_the_configured_error() -> None:
    entry = registry.benchmark("currents-v1")
    config = entry.read({**entry.quick_settings, "start_error_px": 1.5})
    rows = _rows("currents-v1", config)
    files = _made(("currents-v1", config, rows), Selection(every=10))

    (start,) = _table(files, "starts.csv")[:1]
    off = _corners(start) - _corners(_table(files)[0])
    recorded_corners = rows[0, INDEX["corner_0"] : INDEX["corner_7"] + 1].reshape(4, 2)
    assert np.array_equal(_corners(start), recorded_corners)
    assert 0.1 < np.abs(off).max() < 6.0


def test_camera_json_has_all_that_a_camera_is_made_of() -> None:
    name, entry = "visibility-v1", registry.benchmark("visibility-v1")
    disturbed = {"light_level": 0.5, "lamp": 2.0, "snow_per_m3": 200.0, "scatter_mrad": 3.0}
    config = entry.read({**entry.quick_settings, **disturbed, "target": "plain"})
    rows = _rows(name, config)
    files = _made((name, config, rows), Selection(every=25))
    stored = json.loads(files["camera.json"])
    camera = registry.benchmark(name).load().camera(config, seed=SEED, trial=0, level=1)

    level, target, optics = stored["levels"][1], stored["target"], stored["optics"]
    assert level["value"] == 0.25
    corners = target.pop("top_corners_m")
    made = Camera(
        Optics(**{key: optics[key] for key in ("width", "height", "focal_px", "mount_m")}),
        Water(**level["water"]),
        Target(**target),
        noise_seed=0,
        effects=Effects(**level["effects"]),
    )
    assert (made.water.law, made.target, made.effects) == ("beer", camera.target, camera.effects)
    assert made.water.attenuation == list(camera.water.attenuation)
    assert made.effects.snow_per_m3 == 200.0
    assert np.array_equal(np.array(corners), camera.target.top_corners())


def test_the_readme_says_which_command_makes_the_same_again() -> None:
    chosen = Selection(every=4, begin_s=2.0, end_s=9.5, colour=True)

    assert chosen.options(3) == " --trial 3 --every 4 --from 2.0 --until 9.5 --colour"
    assert Selection().options(0) == ""


def test_the_readme_names_every_column(files: dict[str, bytes]) -> None:
    text = files["README.md"].decode()

    ranges = {f"corner_{axis}{at}" for axis in "uv" for at in range(4)}
    assert {
        name for name in {*COLUMNS, *STARTS} if name not in ranges and name not in text
    } == set()


def test_a_choice_without_a_picture_is_refused(recorded: tuple[str, Configuration, Rows]) -> None:
    name, config, rows = recorded

    with pytest.raises(ValueError, match="there are no images"):
        archive(name, config, rows, seed=SEED, selection=Selection(begin_s=1e6))
