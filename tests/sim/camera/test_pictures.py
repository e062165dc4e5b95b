"""Pictures on targets and seabeds: of one size and contrast, seamless, the same everywhere."""

import hashlib
from itertools import pairwise

import numpy as np
import pytest

from seamark.sim.camera import pictures
from seamark.sim.camera.camera import SAND, Camera
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pictures import PAINTED, PICTURES, SIDE, Cutout
from seamark.sim.camera.seabed import TILE
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import Water

OPTICS = Optics(width=320, height=240, focal_px=257.3)
CLEAR = Water.grey(0.0)


def view(picture: str = "brick", row: int = 0, ground: str = SAND) -> np.ndarray:
    target = Target(picture=Cutout(picture, row, 0))
    camera = Camera(OPTICS, CLEAR, target, noise_seed=1, ground=ground)
    return camera.grey(start_pose(OPTICS, target, 1.27), 0).astype(float)


@pytest.mark.parametrize("name", PICTURES)
def test_every_picture_has_the_same_size_brightness_and_contrast(name) -> None:
    image = pictures.picture(name)

    assert (image.shape, image.dtype) == ((SIDE, SIDE), np.uint8)
    assert image.mean() == pytest.approx(pictures.MEAN, abs=2.0)
    assert image.std() == pytest.approx(pictures.SPREAD, abs=3.0)


@pytest.mark.parametrize("name", PICTURES)
def test_a_tile_has_no_seam(name) -> None:
    tile = pictures.tile(name)

    assert tile.shape == (TILE, TILE)
    assert np.array_equal(tile[:, 0], tile[:, -1])
    assert np.array_equal(tile[0], tile[-1])
    assert np.array_equal(tile[:, SIDE - 1], tile[:, SIDE])


def test_painted_pictures_are_the_same_bytes_everywhere() -> None:
    digests = {
        name: hashlib.sha256(pictures.picture(name).tobytes()).hexdigest() for name in PAINTED
    }

    assert {name: digest[:16] for name, digest in digests.items()} == {
        "mosaic": "c0da52a50192324c",
        "mottle": "32a11f6a9b098bc9",
    }


def test_the_faces_of_a_box_show_different_parts_of_the_picture() -> None:
    faces = [pictures.face(Cutout("grass", 0, 0), 62, 62, number=k) for k in range(5)]

    assert {face.shape for face in faces} == {(62, 62)}
    assert all(abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.2 for a, b in pairwise(faces))


@pytest.mark.parametrize("row", [0, 333, 700])
@pytest.mark.parametrize("name", PICTURES)
def test_every_cutout_has_the_same_brightness_and_contrast(name, row) -> None:
    face = 255.0 * pictures.face(Cutout(name, row, 100 + row), 200, 62, number=0)

    assert face.mean() == pytest.approx(pictures.MEAN, abs=6.0)
    assert face.std() == pytest.approx(pictures.SPREAD, abs=12.0)  # clipped where it is extreme


def test_target_and_seabed_show_the_pictures_that_were_chosen() -> None:
    box = np.s_[110:130, 125:195]

    assert np.abs(view("brick") - view("coffee"))[box].mean() > 20.0
    assert np.abs(view("brick") - view("brick", row=60))[box].mean() > 20.0
    assert np.abs(view(ground="gravel") - view())[:60].mean() > 10.0
    assert np.array_equal(view(ground="gravel")[box], view()[box])
