"""Pictures with their truth, as a data set to work on elsewhere.

Exactly the pictures that the benchmark's tracker gets, made again from the telemetry of a run. The
archive's bytes depend on configuration, seed and rows alone: no time of day, no compression level
of the machine.
"""

import csv
import io
import json
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import cv2
import numpy as np

from seamark.sim.camera.camera import Camera
from seamark.sim.engine.replay import Replay, Row, Shot, place_of
from seamark.sim.recording.manifest import manifest
from seamark.sim.recording.telemetry import INDEX, Digest, Rows
from seamark.sim.settings.configuration import Configuration

Line = list[object]

FOLDER = "seamark-dataset"
_PNG_LEVEL = 1  # noise does not compress; quicker
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

Pictures of the vehicle's downward camera, with the truth about them. {count}

| file | holds |
|---|---|
| images/*.png | {kind} pictures, 8 bit, noise included |
| groundtruth.csv | one line per picture, see below |
| starts/*.png, starts.csv | what a tracker is told at the start of each level |
| camera.json | intrinsics, mount on the vehicle, target; water and effects of each level |
| configuration.json | all settings |
| manifest.json | seed, versions, digest of the telemetry behind the pictures |

The trackers' grey picture is the green channel of the coloured one, noise included.

The same configuration and seed give the same bytes again with the same version:
`{command}`. If another solution than the benchmark's own moved the vehicle, `--solution` names it;
the way of a program that somebody sent is known from its run alone.

## groundtruth.csv
SI units, angles in rad; world NED (x north, y east, z down), body frame x forward, y starboard,
z down. Image points in px: u to the right, v down, pixel centres at whole numbers.

| column | is |
|---|---|
| picture, file | number from 0, name below images/ |
| trial, level, t | simulated time [s] since the trial began |
| x, y, z, roll, pitch, yaw | pose of the vehicle's origin; rotation is yaw, then pitch, then roll |
| u, v, w, p, q, r | its velocity over ground, body frame [m/s, rad/s] |
| corner_u0 ... corner_v3 | true corners of the top face, clockwise from its letters' upper left |
| centroid_u, centroid_v | where the diagonals of the top face cross |
| origin_u, origin_v | projected middle of the box: UWSim's convention |
| camera_x, camera_y, camera_z | place of the camera in the world [m] |
| in_view | 1 if all four corners are inside the picture |

## starts.csv
One line per level: `value` is what the benchmark changes from level to level, `file` the picture
below starts/ from which a tracker learns the target (in visibility-v1 in the water of the first
level), the corners those that it is told: the true ones and the configured error of the start. It
is the level's first picture; a tracker is asked from the second one on.

## camera.json
- `optics`: `matrix` is the pinhole's; no distortion. `mount_m` is the camera's place in the body
  frame [m]; it looks along the body's z axis, u runs to starboard, v aft.
- `target`: box on the seabed; `heading_rad` is where its letters' tops point, from north to east;
  `top_corners_m` (4, 3) are the corners of groundtruth.csv in the world.
- `levels`: of each level its `value`; `water` (channels red, green, blue; `beer`: attenuation c
  [1/m] over the slant range; `uwsim`: density rho [1/m], exp(-(rho z)^2) over the depth; `veil` as
  a share of full scale; noise variance read_sigma_grey^2 + shot_gain * grey) and `effects`
  (exposure, light, lamp, snow, scatter, fish; off where they are 0 and light_level is 1).
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Which pictures, and how."""

    every: int = 1  # control ticks from one picture to the next
    begin_s: float = 0.0
    end_s: float = float("inf")
    colour: bool = False

    def of(self, rows: Rows) -> Rows:
        """Return the rows (n, WIDTH) of the wanted pictures."""
        t = rows[:, INDEX["t"]]
        wanted: Rows = rows[(t >= self.begin_s) & (t < self.end_s)][:: self.every]
        return wanted

    def options(self, trial: int) -> str:
        """Return the options of `seamark dataset` that make this choice."""
        given = {
            "trial": (trial, 0),
            "every": (self.every, 1),
            "from": (self.begin_s, 0.0),
            "until": (self.end_s, float("inf")),
        }
        text = "".join(
            f" --{name} {value}" for name, (value, usual) in given.items() if value != usual
        )
        return text + " --colour" * self.colour


def archive(
    benchmark: str, config: Configuration, rows: Rows, *, seed: int, choice: Choice
) -> Iterator[bytes]:
    """Return a ZIP archive in pieces, one or less than one for each file in it.

    Parameters
    ----------
    rows : (n, WIDTH)
        Telemetry of one trial with this configuration and seed.

    Raises
    ------
    ValueError
        At once, when the choice leaves no picture.
    """
    wanted = choice.of(rows)
    if not len(wanted):
        raise ValueError("no picture is left: the run has no rows in the chosen time")
    return _zipped(_members(benchmark, config, rows, wanted, seed=seed, choice=choice))


def _members(
    benchmark: str,
    config: Configuration,
    rows: Rows,
    wanted: Rows,
    *,
    seed: int,
    choice: Choice,
) -> Iterator[tuple[str, bytes]]:
    replay = Replay(benchmark, config, lambda _trial: seed)
    kind = "colour" if choice.colour else "grey"
    count = f"{len(wanted)} pictures."
    trial, _ = place_of(wanted[0])
    command = f"seamark dataset {benchmark} --config configuration.json --seed {seed}"
    command += choice.options(trial)
    text = README.format(benchmark=benchmark, count=count, kind=kind, command=command)
    yield "README.md", text.encode()
    yield "configuration.json", _json(config.model_dump(mode="json"))
    yield "camera.json", _json(_cameras(replay, wanted, config))
    digest = Digest()
    digest.add(rows)
    whole = manifest(
        benchmark,
        config,
        seed=seed,
        trials=1,
        controller="see the run",
        digest=digest.hexdigest(),
        pictures=asdict(choice) | {"end_s": None if choice.end_s > 1e300 else choice.end_s},
    )
    yield "manifest.json", _json(whole)
    yield from _starts(replay, config, rows, wanted, colour=choice.colour)
    lines: list[Line] = []
    for number, row in enumerate(wanted):
        shot, name = replay.shot(row), f"{number:06d}.png"
        lines.append(_line(number, name, row, shot))
        yield f"images/{name}", _png(shot, colour=choice.colour)
    yield "groundtruth.csv", _csv(COLUMNS, lines)


def _starts(
    replay: Replay, config: Any, rows: Rows, wanted: Rows, *, colour: bool
) -> Iterator[tuple[str, bytes]]:
    """Return what a tracker is told at the start of every level in the pictures."""
    values, places = config.level_values(), _places(wanted)
    lines: list[Line] = []
    for trial, level in places:
        here = (rows[:, INDEX["trial"]] == trial) & (rows[:, INDEX["level"]] == level)
        row = rows[here][0]
        shot, corners = replay.first(row)
        name = f"{level:03d}.png"
        told = [float(value) for value in corners.ravel()]
        lines.append([trial, level, float(values[level]), float(row[INDEX["t"]]), name, *told])
        yield f"starts/{name}", _png(shot, colour=colour)
    yield "starts.csv", _csv(STARTS, lines)


def _places(wanted: Rows) -> list[tuple[int, int]]:
    """Return trial and level of all levels in the pictures."""
    return sorted({place_of(row) for row in wanted})


def _cameras(replay: Replay, wanted: Rows, config: Any) -> dict[str, Any]:
    """Return optics and target, and what is in the way of light at every level in the pictures."""
    values = config.level_values()
    cameras = {place: replay.camera(*place) for place in _places(wanted)}
    first = next(iter(cameras.values()))
    return {
        "optics": _optics(first),
        "target": asdict(first.target) | {"top_corners_m": first.target.top_corners().tolist()},
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


def _csv(head: tuple[str, ...], lines: Iterable[Line]) -> bytes:
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(lines)
    return table.getvalue().encode()


def _optics(camera: Camera) -> dict[str, Any]:
    focal, u0, v0 = map(float, camera.optics.intrinsics())
    matrix = [[focal, 0.0, u0], [0.0, focal, v0], [0.0, 0.0, 1.0]]
    return asdict(camera.optics) | {"matrix": matrix, "distortion": [0.0] * 5}


def _line(number: int, name: str, row: Row, shot: Shot) -> Line:
    truth = shot.camera.truth(shot.pose)
    corners, optics = truth[:8], shot.camera.optics
    inside = all(
        -0.5 <= u <= optics.width - 0.5 and -0.5 <= v <= optics.height - 0.5
        for u, v in zip(corners[::2], corners[1::2], strict=True)
    )
    state = [float(row[INDEX[column]]) for column in ("t", *_STATE)]
    return [number, name, *place_of(row), *state, *truth, int(inside)]


def _png(shot: Shot, *, colour: bool) -> bytes:
    picture = shot.colour() if colour else shot.grey()
    done, encoded = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, _PNG_LEVEL])
    if not done:
        raise RuntimeError("OpenCV could not encode a picture")
    return bytes(np.asarray(encoded).tobytes())


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=2, allow_nan=False) + "\n").encode()


class _Sink(io.RawIOBase):
    """Where the archive is written to: pieces that wait to be taken."""

    def __init__(self) -> None:
        self.pending = bytearray()

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:  # anything with a buffer
        self.pending += data
        return len(data)

    def take(self) -> bytes:
        piece = bytes(self.pending)
        self.pending.clear()
        return piece


def _zipped(members: Iterable[tuple[str, bytes]]) -> Iterator[bytes]:
    sink = _Sink()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_STORED) as file:
        for name, data in members:
            entry = zipfile.ZipInfo(f"{FOLDER}/{name}")  # its date is 1980: the same bytes always
            entry.external_attr = 0o644 << 16
            file.writestr(entry, data)
            yield sink.take()
    yield sink.take()
