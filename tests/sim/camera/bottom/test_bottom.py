"""The painted bottom: its bytes, what its markers say, what covers what, and where the truth is."""

import dataclasses

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import seabed
from seamark.sim.camera.bottom.bottom import GROUNDS, STRIP_M, Bottom, draw_bottom
from seamark.sim.camera.bottom.camera import BottomCamera
from seamark.sim.camera.bottom.painter import Sun, packed_tile, paint
from seamark.sim.camera.bottom.things import KINDS, NAMES, OBJECTS, Thing, draw_thing
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.seabed import TILE
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.vehicles.patterns import CLASSES, DECOYS
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

NO_SUN = Sun(0.0, 0.0)
MIDDLE_M = 0.5 * STRIP_M
GREY = 90
TEXEL_PX = 2.2  # of the test with true corners
CLOSE = Optics(width=640, height=480, focal_px=514.7, mount_m=(0.0, 0.0, 0.0))
PROGRAM = """
import hashlib
import numpy as np
from seamark.sim.camera.bottom.bottom import draw_bottom
from seamark.sim.camera.bottom.camera import BottomCamera
from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.camera.water import Water

digest = hashlib.sha256()
for seed in range(4):
    bottom = draw_bottom(np.random.Generator(np.random.PCG64(seed)))
    digest.update(bottom.tiles.tobytes() + np.array(bottom.visible).tobytes())
    camera = BottomCamera(VISIBILITY, Water(), bottom, noise_seed=3)
    pose = np.array([1.0, bottom.east_m, 2.5, 0.1, -0.2, 0.3 + seed])
    for one in camera.seen(pose):
        digest.update(one.corners.tobytes() + np.array([one.distance, one.angle]).tobytes())
    digest.update(camera.colour(pose, 5).tobytes())
print(digest.hexdigest())
"""


def generator(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def clean(name: str, seed: int, *, heading: float = 0.0) -> Thing:
    """Return a thing in the middle of the tile, free and without growth."""
    thing = draw_thing(name, MIDDLE_M, MIDDLE_M, generator(seed), burial=0.0)
    place = thing.place._replace(
        burial=0.0, growth=0.0, dust=0.0, cosine=np.cos(heading), sine=np.sin(heading)
    )
    return Thing(name=name, shape=thing.shape, place=place, text=thing.text, code=thing.code)


def bottom_with(*things: Thing) -> Bottom:
    """Return an even bottom with things on it, and no shadows."""
    tiles, owners = np.full((3, TILE, TILE), GREY, np.uint8), np.zeros((TILE, TILE), np.uint8)
    for thing in things:
        paint(tiles, owners, thing.shape, thing.place, NO_SUN, thing.number)
    return Bottom(
        ground="even",
        east_m=MIDDLE_M,
        objects=things,
        decoys=(),
        visible=(1.0,) * len(things),
        tiles=tiles,
    )


def seen_from_above(bottom: Bottom, altitude_m: float = 1.0) -> NDArray[np.uint8]:
    camera = BottomCamera(CLOSE, Water(read_sigma_grey=0.8), bottom, noise_seed=1)
    return camera.grey(above(camera, altitude_m), 0)


def above(camera: BottomCamera, altitude_m: float) -> NDArray[np.float64]:
    down = camera.target.seabed_m - altitude_m
    return np.array([MIDDLE_M, MIDDLE_M, down, 0.0, 0.0, 0.0])


def read(image: NDArray[np.uint8], dictionary: int) -> list[int]:
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary))
    _, found, _ = detector.detectMarkers(image)
    return [] if found is None else np.asarray(found).ravel().tolist()


def test_kinds_are_the_classes_and_then_the_decoys() -> None:
    assert NAMES == (*CLASSES, *DECOYS)
    assert OBJECTS == len(CLASSES)


def test_a_bottom_is_the_same_bytes_in_each_process_and_on_the_oldest_processor() -> None:
    here = printed_here(PROGRAM)

    assert len(here.strip()) == 64
    assert here == printed(PROGRAM, on="oldest")


def test_bottoms_of_two_seeds_have_nothing_drawn_alike() -> None:
    first, second = draw_bottom(generator(1)), draw_bottom(generator(2))

    for one, other in zip(
        (*first.objects, *first.decoys), (*second.objects, *second.decoys), strict=True
    ):
        assert one.shape.length != other.shape.length
        assert one.place.north != other.place.north
        assert one.shape.base != other.shape.base


def test_a_tile_is_packed_as_the_seabed_is() -> None:
    texels = generator(1).integers(256, size=(TILE, TILE)).astype(np.uint8)

    assert np.array_equal(packed_tile(texels), seabed.padded(seabed.packed(texels, wrap=True)))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    ("name", "dictionary"),
    [("aruco", cv2.aruco.DICT_4X4_50), ("apriltag", cv2.aruco.DICT_APRILTAG_36h11)],
)
def test_a_marker_that_lies_free_is_read_as_what_was_drawn(
    name: str, dictionary: int, seed: int
) -> None:
    thing = clean(name, seed, heading=0.3 + seed)

    assert read(seen_from_above(bottom_with(thing), altitude_m=0.6), dictionary) == [thing.code]


@pytest.mark.parametrize("seed", range(6))
def test_a_false_marker_is_read_by_nobody(seed: int) -> None:
    image = seen_from_above(bottom_with(clean("false-marker", seed)), altitude_m=0.6)

    assert read(image, cv2.aruco.DICT_4X4_50) == []
    assert read(image, cv2.aruco.DICT_APRILTAG_36h11) == []


@pytest.mark.parametrize("heading", [0.0, 0.7, 3.6])
@pytest.mark.parametrize("name", ["box", "pipe", "panel", "anode", "aruco", "slab", "bottle"])
def test_the_true_corners_are_those_of_what_is_seen(name: str, heading: float) -> None:
    thing = clean(name, 5, heading=heading)
    bottom = bottom_with(thing)
    camera = BottomCamera(CLOSE, Water(read_sigma_grey=0.8), bottom, noise_seed=1)
    pose = above(camera, 1.2)
    empty = BottomCamera(CLOSE, Water(read_sigma_grey=0.8), bottom_with(), noise_seed=1)

    (seen,) = camera.seen(pose)
    difference = camera.colour(pose, 0).astype(int) - empty.colour(pose, 0)
    changed = np.abs(difference).max(axis=2) > 12

    rows, columns = np.nonzero(changed)
    points = np.stack([columns, rows], axis=1).astype(np.float64)
    origin, along, across = seen.corners[0], *(seen.corners[k] - seen.corners[0] for k in (1, 3))
    for edge in (along, across):
        length = float(np.sqrt(edge @ edge))
        position = (points - origin) @ edge / length
        assert position.min() == pytest.approx(0.0, abs=TEXEL_PX + 1.0)
        assert position.max() == pytest.approx(length, abs=TEXEL_PX + 1.0)


def test_deeper_burial_shows_less_of_things() -> None:
    shares = [
        np.mean([draw_bottom(generator(seed), burial=burial).visible for seed in range(6)])
        for burial in (0.0, 0.5, 1.0)
    ]

    assert shares[0] > shares[1] > shares[2]
    assert shares[0] > 0.95  # only neighbours hide something
    assert shares[2] > 0.5


def test_what_is_painted_last_covers_what_lies_below_it() -> None:
    slab, tag = clean("slab", 1), clean("aruco", 2)
    owners = np.zeros((TILE, TILE), np.uint8)
    tiles = np.full((3, TILE, TILE), GREY, np.uint8)
    outlines = [
        paint(tiles, owners, one.shape, one.place, NO_SUN, number)
        for number, one in ((1, slab), (2, tag))
    ]

    shown = np.bincount(owners.ravel(), minlength=3)

    assert shown[2] == outlines[1]
    assert 0 < shown[1] < outlines[0]


def test_every_kind_and_ground_is_drawn_in_time() -> None:
    bottoms = [draw_bottom(generator(seed)) for seed in range(12)]

    assert {bottom.ground for bottom in bottoms} == set(GROUNDS)
    assert {thing.name for thing in (*bottoms[0].objects, *bottoms[0].decoys)} == set(KINDS)


def test_the_copy_of_a_thing_nearest_to_the_image_is_the_true_one() -> None:
    thing = clean("panel", 3)
    camera = BottomCamera(CLOSE, Water(), bottom_with(thing), noise_seed=1)
    pose = above(camera, 1.5)

    (here,) = camera.seen(pose)
    (next_tile,) = camera.seen(pose + np.array([STRIP_M, -STRIP_M, 0.0, 0.0, 0.0, 0.0]))

    assert next_tile.corners == pytest.approx(here.corners, abs=1e-6)


def test_the_angle_of_a_thing_is_that_of_the_line_of_sight() -> None:
    camera = BottomCamera(CLOSE, Water(), bottom_with(clean("panel", 3)), noise_seed=1)
    pose = above(camera, 1.5) + np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0])

    (seen,) = camera.seen(pose)

    assert seen.angle == pytest.approx(np.pi / 4)
    assert seen.distance == pytest.approx(1.5 * np.sqrt(2.0))


def test_no_fish_swims_where_there_is_no_box() -> None:
    """What lies in memory behind a scene without faces once told a fish where to swim."""
    box = Target(length_m=0.5, width_m=0.5, height_m=1.0)
    bottom, sun = bottom_with(), Effects(caustics=0.2, frame_s=0.1)
    fish = dataclasses.replace(sun, fish_per_min=60.0, fish_length_m=0.5)
    with_fish, without = (
        BottomCamera(CLOSE, Water(), bottom, noise_seed=1, effects=effects)
        for effects in (fish, sun)
    )
    faces = box.faces()
    with_fish._scene = with_fish._scene._replace(faces=faces[:0])
    pose = np.array([faces[0, 0], faces[0, 1], faces[0, 2] - 1.0, 0.0, 0.0, 0.0])

    for frame in range(0, 30, 3):
        assert np.array_equal(with_fish.grey(pose, frame), without.grey(pose, frame))
