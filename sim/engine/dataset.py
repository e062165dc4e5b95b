"""Data sets: images with ground truth, to work on elsewhere.

The images are exactly those that the benchmark's tracker gets, re-rendered from the telemetry of a
run. The bytes of the archive depend on configuration, seed and rows alone: there is no date in it,
and the compression level is fixed.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.archive_writing import Line, csv_lines, json_file, png, zipped
from seamark.sim.engine.dataset_layouts import Coco, Layout, Tum, Yolo
from seamark.sim.engine.replay import CameraFrame, Replay, Row, starts_of, trial_and_level
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import INDEX, Digest, Rows
from seamark.sim.settings.configuration import Configuration

SEAMARK = "seamark"  # the layout that has everything
_STATE = ("x", "y", "z", "roll", "pitch", "yaw", "u", "v", "w", "p", "q", "r")
_CORNERS = tuple(f"{axis}{corner}" for corner in range(4) for axis in ("corner_u", "corner_v"))
COLUMNS = (
    *("picture", "file", "trial", "level", "t", *_STATE, *_CORNERS),
    *("centroid_u", "centroid_v", "origin_u", "origin_v"),
    *("camera_x", "camera_y", "camera_z", "in_view"),
)
STARTS = ("trial", "level", "value", "t", "file", *_CORNERS)
README = """\
# Seamark data set: {benchmark}

Images of the vehicle's downward camera, with ground truth. {count}

| file | holds |
|---|---|
| images/*.png | {colours} images, 8 bit, noise included |
| groundtruth.csv | one line per image, see below |
| starts/*.png, starts.csv | what a tracker is given at the start of each level |
| camera.json | intrinsics, mount on the vehicle, target; water and effects of each level |
| configuration.json | all settings |
| manifest.json | seed, versions, digest of the telemetry that the images were rendered from |

The grey image that trackers get is the green channel of the colour image, noise included.

The same version makes the same bytes again from the same configuration and seed:
`{command}`. If a solution other than the benchmark's default moved the vehicle, name it with
`--solution`; the path of an uploaded program can only be taken from its run.

## groundtruth.csv
SI units, angles in rad; world NED (x north, y east, z down), body frame x forward, y starboard,
z down. Image points in px: u to the right, v down, pixel centres at whole numbers.

| column | meaning |
|---|---|
| picture, file | number of the image from 0, file name in images/ |
| trial, level, t | simulated time [s] since the trial began |
| x, y, z, roll, pitch, yaw | pose of the vehicle's origin; rotation is yaw, then pitch, then roll |
| u, v, w, p, q, r | its velocity over ground, body frame [m/s, rad/s] |
| corner_u0 ... corner_v3 | true corners of the top face, clockwise from its letters' upper left |
| centroid_u, centroid_v | where the diagonals of the top face cross |
| origin_u, origin_v | projected centre of the box: UWSim's convention |
| camera_x, camera_y, camera_z | position of the camera in the world frame [m] |
| in_view | 1 if all four corners are inside the image |

## starts.csv
One line per level: `value` is what the benchmark changes from level to level, `file` the image in
starts/ from which a tracker learns the target (in visibility-v1 rendered in the water of the first
level), the corners those it is given: the true ones plus the configured start error. The image
belongs to the first step of the level; a tracker's results count from the second one. Where the
target has to be found first, there is a line for each time that a tracker took over what the
detector had found, with its corners.

## camera.json
- `optics`: `matrix` is the pinhole's; no distortion. `mount_m` is the position of the camera in
  the body frame [m]; it looks along the body's z axis, u points to starboard, v aft.
- `target`: box on the seabed; `heading_rad` is where the tops of its letters point, clockwise from
  north; `top_corners_m` (4, 3) are the corners of groundtruth.csv in the world frame: where an arm
  works on the box or panel, as it lies in the first image.
- `levels`: for each level its `value`; `water` (channels red, green, blue; `beer`: attenuation c
  [1/m] over the slant range; `uwsim`: density rho [1/m], exp(-(rho z)^2) over the depth; `veil` as
  a share of full scale; noise variance read_sigma_grey^2 + shot_gain * grey) and `effects`
  (exposure, light, lamp, snow, scatter, fish; all off if they are 0 and light_level is 1).
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """Which images of a run, and in which colours."""

    every: int = 1  # control steps from one image to the next
    begin_s: float = 0.0
    end_s: float = float("inf")
    colour: bool = False

    def of(self, rows: Rows) -> Rows:
        """Return the rows of the selected images."""
        t = rows[:, INDEX["t"]]
        selected: Rows = rows[(t >= self.begin_s) & (t < self.end_s)][:: self.every]
        return selected

    def options(self, trial: int) -> str:
        """Return the options of `seamark dataset` for this selection."""
        options = {
            "trial": (trial, 0),
            "every": (self.every, 1),
            "from": (self.begin_s, 0.0),
            "until": (self.end_s, float("inf")),
        }
        text = "".join(
            f" --{name} {value}" for name, (value, default) in options.items() if value != default
        )
        return text + " --colour" * self.colour


def archive(
    benchmark: str,
    config: Configuration,
    rows: Rows,
    *,
    seed: int,
    selection: Selection,
    program_sha256: str | None = None,
    layout: str = SEAMARK,
) -> Iterator[bytes]:
    """Return a ZIP archive in pieces, at most one for each file in it.

    Parameters
    ----------
    rows
        Telemetry of one trial with this configuration and seed.
    program_sha256
        Of the uploaded program that moved the vehicle; None for a built-in solution.
    layout
        One of `LAYOUTS`: whose programs are to read it.

    Raises
    ------
    ValueError
        At once, if the selection has no images.
    """
    selected = selection.of(rows)
    if not len(selected):
        raise ValueError("there are no images: the run has no rows in the selected time")
    members = _members(
        *(benchmark, config, rows, selected),
        seed=seed,
        selection=selection,
        program_sha256=program_sha256,
        layout=layout,
    )
    return zipped(members)


def _members(
    benchmark: str,
    config: Configuration,
    rows: Rows,
    selected: Rows,
    *,
    seed: int,
    selection: Selection,
    program_sha256: str | None,
    layout: str,
) -> Iterator[tuple[str, bytes]]:
    written, replay = LAYOUTS[layout](), Replay(benchmark, config, lambda _trial: seed)
    colours = "colour" if selection.colour else "grey"
    count = f"{len(selected)} images."
    trial, _ = trial_and_level(selected[0])
    command = f"seamark dataset {benchmark} --config configuration.json --seed {seed}"
    command += selection.options(trial) + (f" --format {layout}" if layout != SEAMARK else "")
    text = written.readme.format(benchmark=benchmark, count=count, colours=colours, command=command)
    yield "README.md", text.encode()
    yield "configuration.json", json_file(config.model_dump(mode="json"))
    yield "camera.json", json_file(_cameras(replay, selected, config))
    digest = Digest()
    digest.add(rows)
    manifest_ = manifest(
        benchmark,
        config,
        seed=seed,
        trials=1,
        controller="see the run",
        program_sha256=program_sha256,
        digest=digest.hexdigest(),
        pictures=asdict(selection)
        | {"end_s": None if selection.end_s > 1e300 else selection.end_s},
    )
    yield "manifest.json", json_file(manifest_)
    if layout == SEAMARK:
        yield from _starts(replay, config, rows, selected, colour=selection.colour)
    for number, row in enumerate(selected):
        frame, name = replay.frame(row), f"{number:06d}.png"
        yield f"{written.images}/{name}", _image(frame, colour=selection.colour)
        yield from written.add(name, row, frame)
    yield from written.end()


class _Seamark:
    """The layout that has everything."""

    readme, images = README, "images"

    def __init__(self) -> None:
        self._lines: list[Line] = []

    def add(self, name: str, row: Row, frame: CameraFrame) -> Iterator[tuple[str, bytes]]:
        """Note the truth about an image."""
        self._lines.append(_line(len(self._lines), name, row, frame))
        yield from ()

    def end(self) -> Iterator[tuple[str, bytes]]:
        """Yield the truth."""
        yield "groundtruth.csv", csv_lines([COLUMNS, *self._lines])


LAYOUTS: Mapping[str, Callable[[], Layout]] = {
    SEAMARK: _Seamark,
    "coco": Coco,
    "yolo": Yolo,
    "tum": Tum,
}


def _starts(
    replay: Replay, config: Any, rows: Rows, selected: Rows, *, colour: bool
) -> Iterator[tuple[str, bytes]]:
    """Return what a tracker is given whenever it is started in a level among the images."""
    values = config.level_values()
    lines: list[Line] = []
    for trial, level in _levels(selected):
        here = rows[(rows[:, INDEX["trial"]] == trial) & (rows[:, INDEX["level"]] == level)]
        for number, row in enumerate(starts_of(here, config.images_per_start(level))):
            frame, corners = replay.start(row)
            name = f"{level:03d}-{number:02d}.png" if number else f"{level:03d}.png"
            given = [float(value) for value in corners.ravel()]
            lines.append([trial, level, float(values[level]), float(row[INDEX["t"]]), name, *given])
            yield f"starts/{name}", _image(frame, colour=colour)
    yield "starts.csv", csv_lines([STARTS, *lines])


def _levels(selected: Rows) -> list[tuple[int, int]]:
    """Return trial and level of all levels among the images."""
    return sorted({trial_and_level(row) for row in selected})


def _cameras(replay: Replay, selected: Rows, config: Any) -> dict[str, Any]:
    """Return optics and target, and water and effects of every level among the images."""
    values = config.level_values()
    cameras = {level: replay.camera(*level) for level in _levels(selected)}
    first = replay.frame(selected[0])
    return {
        "optics": _optics(first.camera),
        "target": asdict(first.camera.target) | {"top_corners_m": first.top_corners().tolist()},
        "levels": [
            {
                "trial": trial,
                "level": level,
                "value": float(values[level]),
                "water": asdict(camera.water),
                "effects": asdict(camera.effects),
            }
            for (trial, level), camera in cameras.items()
        ],
    }


def _optics(camera: Camera) -> dict[str, Any]:
    focal, u0, v0 = map(float, camera.optics.intrinsics())
    matrix = [[focal, 0.0, u0], [0.0, focal, v0], [0.0, 0.0, 1.0]]
    return asdict(camera.optics) | {"matrix": matrix, "distortion": [0.0] * 5}


def _line(number: int, name: str, row: Row, frame: CameraFrame) -> Line:
    truth = frame.camera.truth(frame.motion)
    corners, optics = truth[:8], frame.camera.optics
    inside = all(
        -0.5 <= u <= optics.width - 0.5 and -0.5 <= v <= optics.height - 0.5
        for u, v in zip(corners[::2], corners[1::2], strict=True)
    )
    state = [float(row[INDEX[column]]) for column in ("t", *_STATE)]
    return [number, name, *trial_and_level(row), *state, *truth, int(inside)]


def _image(frame: CameraFrame, *, colour: bool) -> bytes:
    return png(frame.colour() if colour else frame.grey())
