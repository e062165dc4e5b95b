"""Redraw the contact sheets of docs/camera.md: `./run performance camera_figures [FOLDER]`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from performance import FIGURES
from performance.perception.arm_scene import arm_scene, cameras
from seamark.sim.camera import JERLOV, VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.camera.effects import Effects
from seamark.sim.settings.targets import TARGETS

Image = NDArray[np.uint8]

WINDOW = (slice(30, 210), slice(40, 280))  # crop of each image
COLUMNS = 4
WATER = Water.of_type("II")
MOVING = (0.6, 0.3, 0.0, 0.0, 0.0, 0.1)  # [m/s, rad/s]
EFFECTS: dict[str, dict[str, Any]] = {
    "no effect": {},
    "exposure 0.05 s": {"exposure_s": 0.05},
    "daylight 0.3": {"light_level": 0.3},
    "daylight 0.05, lamp 4": {"light_level": 0.05, "lamp": 4.0},
    "snow 800 / m3": {"snow_per_m3": 800.0},
    "scatter 10 mrad": {"scatter_rad": 0.010},
    "caustics 0.4": {"caustics": 0.4},
    "fish": {"fish_per_min": 20.0},
    "all": {
        **{"exposure_s": 0.05, "light_level": 0.4, "lamp": 2.0, "snow_per_m3": 400.0},
        **{"caustics": 0.3, "scatter_rad": 0.003, "fish_per_min": 20.0},
    },
}


def rendered(water: Water, target: Target, effects: dict[str, Any], frame: int = 40) -> Image:
    """Return a colour image (180, 240, 3), always from the same pose."""
    camera = Camera(VISIBILITY, water, target, noise_seed=3, effects=Effects(**effects))
    offset = np.array([0.04, -0.03, 0.0, 0.02, 0.01, 0.2])
    pose = start_pose(VISIBILITY, target, 1.27) + offset
    return camera.colour(np.concatenate([pose, MOVING]), frame)[WINDOW]


def sheet(images: dict[str, Image]) -> Image:
    """Return the images side by side, each with its caption."""
    tiles = []
    for name, image in images.items():
        tile = np.ascontiguousarray(image)
        tile[:22] //= 3  # dark band behind the white caption
        white = (255, 255, 255)
        cv2.putText(tile, name, (6, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.45, white, 1, cv2.LINE_AA)
        tiles.append(tile)
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % COLUMNS)
    rows = [np.hstack(tiles[k : k + COLUMNS]) for k in range(0, len(tiles), COLUMNS)]
    return np.vstack(rows)


def seen_with_an_arm() -> dict[str, Image]:
    """Return what the cameras of a vehicle and of its arm see, in clear and turbid water."""
    scene = arm_scene()
    views: dict[str, tuple[Water, dict[str, Any]]] = {
        "Jerlov I": (Water.of_type("I"), {}),
        "Jerlov 1C": (Water.of_type("1C"), {}),
        "Jerlov 5C": (Water.of_type("5C"), {}),
        "Jerlov 1C, dark, lamp, snow": (
            Water.of_type("1C"),
            {"light_level": 0.05, "lamp": 2.5, "snow_per_m3": 300.0},
        ),
    }
    pairs = {
        name: cameras(scene, water, effects=Effects(**effects))
        for name, (water, effects) in views.items()
    }
    return {
        f"{where}: {name}": pair[at].colour(scene.placed, 40)
        for at, where in enumerate(("vehicle", "arm"))
        for name, pair in pairs.items()
    }


def sheets() -> dict[str, Image]:
    """Return file name -> contact sheet."""
    target = Target()
    waters = {f"Jerlov {name}": Water.of_type(name) for name in JERLOV}
    waters |= {f"fog {density:g} / m": Water.grey(density, law="uwsim") for density in (0.5, 1.0)}
    boxes = {
        name: Target(
            length_m=box.length_m,
            width_m=box.width_m,
            height_m=box.height_m,
            lettered=box.lettered,
        )
        for name, box in TARGETS.items()
    }
    return {
        "camera-water.png": sheet({k: rendered(w, target, {}) for k, w in waters.items()}),
        "camera-effects.png": sheet({k: rendered(WATER, target, e) for k, e in EFFECTS.items()}),
        "camera-arm.png": sheet(seen_with_an_arm()),
        "camera-targets.png": sheet({k: rendered(WATER, box, {}) for k, box in boxes.items()}),
    }


def main(arguments: Sequence[str]) -> int:
    """Write the sheets."""
    folder = Path(*arguments) if arguments else FIGURES
    for name, image in sheets().items():
        coarse = image // 8 * 8 + 4  # without the low bits of the noise: a third of the size
        cv2.imwrite(str(folder / name), coarse, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    return 0
