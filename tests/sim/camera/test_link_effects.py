"""Effects in the images of cameras on links: what is lit, blurred, and behind what."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import Effects, Water
from seamark.sim.multibody.assembly import Frame
from tests.sim.camera.link_scenes import average, camera, look, placed, turned

Array = NDArray[np.float64]

DOWN = turned(0.0, -np.pi / 2, 0.0)
LEVEL = np.eye(3)
DARK = 1e-9  # as good as no daylight
AT_THE_CAMERA = Frame("camera", np.zeros(3), np.eye(3))


@pytest.mark.slow
def test_light_level_scales_bodies_seabed_and_veil_alike() -> None:
    looks = [look("sphere", (0.4, 0.4, 0.4), "#c0c0c0", at=(0.0, 0.0, 4.5))]
    links = placed((DOWN, (0.0, 0.0, 3.5)))

    bright, dim = (
        average(camera(looks, effects=Effects(light_level=level)), links) for level in (1.0, 0.5)
    )

    assert dim == pytest.approx(0.5 * bright, abs=1.5)


@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_the_lamp_lights_a_wall_by_distance_cone_slant_and_water(angle: float) -> None:
    """The wall is turned about the vertical; each pixel beside the middle is another angle."""
    effects = Effects(light_level=DARK, lamp=1.5, lamp_cone_rad=0.5)
    wall = look("box", (0.1, 9.0, 9.0), "#404040", link="first")
    away, c = 1.2, 0.4
    turn = turned(0.0, 0.0, angle)
    links = placed((LEVEL, (0.0, 0.0, 0.0)), (turn, tuple(away * LEVEL[0] + 0.05 * turn[:, 0])))
    scene = camera([wall], Water.grey(c), seabed_m=100.0, lamp=AT_THE_CAMERA, effects=effects)

    row = average(scene, links)[120]

    columns = np.arange(40, 280, 20)
    ray = np.stack([np.ones(columns.size), (columns - 159.5) / 220.0, 0.5 / 220.0 + 0.0 * columns])
    normal = -turn[:, 0]
    depth = (normal @ [away, 0.0, 0.0]) / (normal @ ray)
    distance = depth * np.linalg.norm(ray, axis=0)
    slant = -(normal @ ray) / np.linalg.norm(ray, axis=0)
    tangent = np.linalg.norm(ray[1:], axis=0)
    light = 1.5 / distance**2 / (1.0 + (tangent / np.tan(0.5)) ** 2) * slant * np.exp(-c * distance)
    expected = 64.0 * light * np.exp(-c * distance) + 255.0 * _scattered_back(ray, depth, c)
    assert row[columns] == pytest.approx(expected, abs=0.7)


def _scattered_back(ray: Array, depth: Array, c: float) -> Array:
    """Integral of a lamp at the camera along rays, by 2000 steps; 8 of them start in the dark."""
    total = np.zeros(ray.shape[1])
    stretch = np.linalg.norm(ray, axis=0)
    tangent = np.linalg.norm(ray[1:], axis=0)
    for k in range(8):
        z = (k + 0.5) * depth / 8
        light = 1.5 / (z * stretch) ** 2 / (1.0 + (tangent / np.tan(0.5)) ** 2)
        total += light * np.exp(-2 * c * z * stretch) * depth / 8 * stretch
    return 0.03 * c * total


def test_a_lamp_on_another_link_lights_from_there() -> None:
    effects = Effects(light_level=DARK, lamp=1.0)
    links = placed((DOWN, (0.0, 0.0, 3.0)), (DOWN, (0.0, 0.8, 3.5)))
    lamp = Frame("first", np.zeros(3), np.eye(3))

    image = average(camera([], Water.grey(0.0), effects=effects, lamp=lamp), links)

    columns = image.mean(axis=0)
    brightest = int(np.argmax(np.convolve(columns, np.ones(31) / 31, mode="valid"))) + 15
    assert brightest == pytest.approx(159.5 + 220.0 * 0.8 / 2.0, abs=15)


def test_there_is_less_backscatter_before_a_near_body_than_before_the_seabed() -> None:
    effects = Effects(light_level=DARK, lamp=4.0)
    black = look("box", (0.05, 0.1, 0.1), "#000000", link="camera", at=(0.5, 0.05, 0.0))
    links = placed((DOWN, (0.0, 0.0, 3.0)))

    image = average(camera([black], Water.grey(2.0), effects=effects), links)

    hidden = image[110:130, 175:190].mean()
    assert 0.5 < hidden < 0.75 * image[110:130, 125:140].mean()


def test_what_moves_with_the_camera_stays_sharp_while_the_rest_is_blurred() -> None:
    looks = [
        look("box", (0.02, 0.1, 0.1), "#ffffff", link="camera", at=(0.6, -0.15, 0.0)),
        look("box", (0.2, 0.2, 0.1), "#ffffff", at=(0.0, 0.2, 4.0)),
    ]
    links = placed((DOWN, (0.0, 0.0, 3.0)))
    links.twist[0] = [0.0, 0.8, 0.0, 0.0, 0.0, 0.0]
    water = Water(attenuation=(0.0,) * 3)

    sharp, blurred = (
        average(camera(looks, water, effects=Effects(exposure_s=time)), links)
        for time in (0.0, 0.05)
    )

    own, other = (slice(110, 130), slice(70, 140)), (slice(110, 130), slice(160, 260))
    steepest = [np.abs(np.diff(image[at], axis=1)).max() for image in (sharp, blurred)
                for at in (own, other)]  # fmt: skip
    assert steepest[2] > 0.9 * steepest[0]
    assert steepest[3] < 0.4 * steepest[1]


@pytest.mark.slow
def test_a_turning_link_is_blurred_over_the_arc_of_the_exposure() -> None:
    """The end of a bar that turns under a camera at rest: bright for a share of the time."""
    bar = look("box", (0.02, 0.8, 0.02), "#ffffff", link="first")
    links = placed((DOWN, (0.0, 0.0, 3.0)), (np.eye(3), (0.0, 0.0, 4.0)))
    links.twist[1] = [0.0, 0.0, 0.0, 0.0, 0.0, 4.0]
    water = Water(attenuation=(0.0,) * 3)

    still, turning = (
        average(camera([bar], water, effects=Effects(exposure_s=time)), links)
        for time in (0.0, 0.05)
    )

    bare = average(camera([], water), links)
    column = int(159.5 + 220.0 * 0.39)  # 0.39 m from the middle
    heights = [(np.abs(image - bare)[:, column] > 12).sum() for image in (still, turning)]
    assert heights[0] == pytest.approx(220.0 * 0.02, abs=2)
    assert heights[1] == pytest.approx(220.0 * 4.0 * 0.05 * 0.39, abs=6)


def test_snow_is_hidden_behind_bodies() -> None:
    wall = look("box", (0.02, 3.0, 3.0), "#808080", link="camera", at=(0.5, 0.0, 0.0))
    links = placed((DOWN, (0.0, 0.0, 2.0)))
    snow = Effects(snow_per_m3=2000.0)

    flakes = []
    for looks in ([], [wall]):
        clear = average(camera(looks), links)
        flakes.append((np.abs(camera(looks, effects=snow).grey(links, 0) - clear) > 15).sum())

    assert 10 < flakes[1] < 0.4 * flakes[0]


@pytest.mark.slow
def test_scatter_blurs_by_the_distance_of_what_is_ahead() -> None:
    effects = Effects(scatter_rad=0.01)
    near = look("box", (0.02, 0.4, 0.4), "#808080", link="camera", at=(0.3, 0.0, 0.0))
    links = placed((DOWN, (0.0, 0.0, 3.0)))
    water = Water.grey(1.0)

    far, close = (
        np.abs(np.diff(average(camera(looks, water, effects=effects), links)[:, 300:])).mean()
        for looks in ([], [near])
    )

    assert close > 1.3 * far


def test_fish_are_refused_with_a_sentence() -> None:
    with pytest.raises(ValueError, match="fish_per_min must be 0"):
        camera([], effects=Effects(fish_per_min=1.0))
