"""Cameras on links: bodies, occlusion, the horizon, and places in the image."""

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.camera import Effects, Target, Water, start_pose
from seamark.sim.camera.bodies import Bodies
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.link_camera import LinkCamera, downward
from seamark.sim.multibody.assembly import Look, Mounting, assemble
from seamark.sim.trackers import make
from seamark.sim.vehicles import Quantity
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.model import Place
from tests.services.prepared import printed
from tests.sim.camera import link_scenes as scenes
from tests.sim.camera.conftest import bilinear
from tests.sim.camera.link_scenes import SlowRenderer, average, camera, look, placed, turned
from tests.sim.oldest_processor import printed_here

Array = NDArray[np.float64]

DOWN = turned(0.0, -np.pi / 2, 0.0)  # x down, z against north: image up is north
OBLIQUE = turned(0.1, -0.6, 0.4)
LEVEL = turned(0.0, 0.0, 0.3)
ZERO = Quantity(meaning="zero", value=(0.0, 0.0, 0.0), unit="m", tag="E", source="a test")
HERE = Place(point=ZERO, turn=ZERO)
WHITE, GREY, BLACK = "#e0e0e0", "#808080", "#202020"


def crowd() -> list[Look]:
    """Bodies of every shape before the camera, some through each other, some behind others."""
    return [
        look("box", (0.3, 0.2, 0.2), "#b0b0b0", at=(1.2, 0.0, 4.9), lettered=True),
        look("box", (0.016, 0.15, 0.016), WHITE, at=(1.2, 0.0, 4.73)),
        look("capsule", (0.5, 0.08, 0.08), BLACK, link="first"),
        look("cylinder", (0.3, 0.1, 0.1), GREY, link="first", at=(0.3, 0.05, 0.0)),
        look("sphere", (0.2, 0.2, 0.2), WHITE, link="second"),
        look("box", (0.07, 0.01, 0.3), "#9fb0ba", link="second", turn=turned(0.4, 0.8, -0.3)),
    ]


SIGHTS = {
    "down": placed(
        (DOWN, (1.1, 0.1, 3.6)),
        (turned(0.2, 0.5, 0.7), (1.0, -0.2, 4.5)),
        (turned(0.0, 0.3, 0.0), (1.3, 0.4, 4.6)),
    ),
    "oblique": placed(
        (OBLIQUE, (0.0, -0.3, 4.3)),
        (turned(0.2, -0.5, 0.7), (1.0, -0.2, 4.6)),
        (turned(0.0, 0.3, 0.0), (1.3, 0.4, 4.95)),
    ),
    "level": placed(
        (LEVEL, (-0.2, -0.3, 4.5)),
        (turned(0.0, 0.2, 0.3), (0.4, -0.2, 4.55)),
        (turned(0.0, 0.3, 0.0), (1.3, 0.4, 4.3)),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("sight", SIGHTS)
def test_images_agree_with_a_slow_renderer(sight: str) -> None:
    links, looks = SIGHTS[sight], crowd()
    waters = Water.grey(0.3), Water.grey(0.5, law="uwsim")

    truths = SlowRenderer(looks, waters[0], bilinear).greys(links, waters)

    for water, truth in zip(waters, truths, strict=True):
        difference = average(camera(looks, water), links) - truth
        # What is left are letters on faces that are seen at a flat angle, and strips below a pixel.
        assert abs(difference.mean()) < 0.1
        assert difference.std() < 1.5
        assert np.percentile(np.abs(difference), 99) < 4.5
        assert np.percentile(np.abs(difference), 99.9) < 20.0


def test_seabed_looks_as_from_the_vehicles_camera() -> None:
    pose = start_pose(scenes.OPTICS, Target(), 1.0)
    away = pose + np.array([2.0, 1.0, 0.0, 0.1, -0.1, 0.4])  # no box in view
    vehicle = Camera(scenes.OPTICS, Water(), Target(), noise_seed=3)
    links = placed((turned(*away[3:]), tuple(away[:3])))
    mount = downward(scenes.OPTICS)
    bodies = Bodies([], ("vehicle", "first", "second"))
    ours = LinkCamera(scenes.OPTICS, Water(), bodies, mount=mount, seabed_m=5.0, noise_seed=3)

    difference = ours.grey(links, 5).astype(float) - vehicle.grey(away, 5)

    assert np.abs(difference).max() <= 2
    assert (difference != 0).mean() < 0.1


def test_target_looks_as_from_the_vehicles_camera_but_for_its_shades() -> None:
    target = Target(heading_rad=0.3, north_m=1.0, east_m=-2.0)
    pose = start_pose(scenes.OPTICS, target, 0.9) + np.array([0.0, 0.0, 0.0, 0.03, -0.02, 0.2])
    vehicle = Camera(scenes.OPTICS, Water(), target, noise_seed=3)
    links = placed((turned(*pose[3:]), tuple(pose[:3])))
    bodies = Bodies([], ("vehicle", "first", "second"), target=target)
    ours = LinkCamera(
        scenes.OPTICS, Water(), bodies, mount=downward(scenes.OPTICS), seabed_m=5.0, noise_seed=3
    )

    corners = ours.project(links, target.top_corners())
    images = [ours.grey(links, 5).astype(float), vehicle.grey(pose, 5).astype(float)]

    (x0, y0), (x1, y1) = corners.min(axis=0).astype(int) + 8, corners.max(axis=0).astype(int) - 8
    top = [image[y0:y1, x0:x1] for image in images]
    assert corners == pytest.approx(vehicle.corners(pose), abs=1e-9)
    assert np.corrcoef(top[0].ravel(), top[1].ravel())[0, 1] > 0.999
    assert np.abs(top[0] - top[1]).mean() < 0.5


@pytest.mark.parametrize("size", [(0.2, 0.4, 0.3), (0.02, 0.5, 0.1)])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.3, 0.2, 0.5), (1.0, 0.5, 2.0)])
def test_outline_of_a_box_is_the_hull_of_its_projected_corners(
    size: tuple[float, float, float], turn: tuple[float, float, float]
) -> None:
    links = placed((DOWN, (0.0, 0.0, 3.0)), (turned(*turn), (0.05, -0.1, 4.2)))
    water = Water(attenuation=(0.0,) * 3)
    with_box = average(camera([look("box", size, "#000000", link="first")], water), links)
    without = average(camera([], water), links)
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    corners = links.position[1] + 0.5 * signs * size @ links.rotation[1].T

    points = camera([]).project(links, corners)

    hull = _hull(points)
    changed = without - with_box > 15.0
    v, u = np.nonzero(changed)
    area = 0.5 * abs(_shoelace(hull))
    outside = _distance_outside(hull, u, v)
    assert outside.max() < 0.71  # [px] half the diagonal of a pixel
    assert changed.sum() == pytest.approx(area, abs=0.5 * _perimeter(hull))
    rows, columns = np.indices(changed.shape)
    deep = _distance_outside(hull, columns.ravel(), rows.ravel()).reshape(changed.shape) < -0.71
    assert changed[deep].all()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("shape", ["capsule", "cylinder", "sphere"])
def test_round_bodies_are_drawn_where_rays_meet_them_and_nowhere_else(
    shape: str, seed: int
) -> None:
    random = np.random.Generator(np.random.PCG64(seed))
    size = (0.5, 0.08, 0.08) if shape != "sphere" else (0.2, 0.2, 0.2)
    there = random.uniform([-0.4, -0.4, 3.05], [0.4, 0.4, 4.5])
    links = placed((DOWN, (0.0, 0.0, 3.0)), (turned(*random.uniform(-2.0, 2.0, 3)), tuple(there)))
    water, looks = Water(attenuation=(0.0,) * 3), [look(shape, size, "#000000", link="first")]
    v, u = (grid.ravel().astype(float) for grid in np.indices((240, 320)))

    image = camera(looks, water).grey(links, 0)

    met = SlowRenderer(looks, water, bilinear).sampled(links, u, v).reshape(240, 320) < 1.0
    around = np.ones((3, 3), np.uint8)
    surely = cv2.erode(met.astype(np.uint8), around, borderValue=1) > 0
    perhaps = cv2.dilate(met.astype(np.uint8), around) > 0
    assert image[surely].max(initial=0) < 12 < image[~perhaps].min(initial=255)


def test_nothing_of_a_body_behind_others_is_in_the_image() -> None:
    """Of bodies side by side, too, which hide it together."""
    near = [look("box", (0.2, 0.5, 0.5), GREY, at=(x, 0.0, 4.0)) for x in (-0.1, 0.1)]
    far = look("cylinder", (0.3, 0.1, 0.1), BLACK, at=(0.0, 0.0, 4.5), turn=turned(0.0, 0.3, 0.4))
    links = placed((DOWN, (0.0, 0.0, 3.0)))

    assert np.array_equal(camera(near).grey(links, 0), camera([far, *near]).grey(links, 0))
    assert np.array_equal(camera(near).grey(links, 0), camera([*near, far]).grey(links, 0))


def _hull(points: Array) -> Array:
    return cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)


def _shoelace(polygon: Array) -> float:
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _perimeter(polygon: Array) -> float:
    return float(np.linalg.norm(polygon - np.roll(polygon, -1, axis=0), axis=1).sum())


def _distance_outside(polygon: Array, u: Array, v: Array) -> Array:
    """Distance of points outside a convex polygon [px], negative inside."""
    turn = np.sign(_shoelace(polygon))
    along = np.roll(polygon, -1, axis=0) - polygon
    normal = turn * np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return (normal[:, :1] * (u - polygon[:, :1]) + normal[:, 1:] * (v - polygon[:, 1:])).max(axis=0)


def test_a_pixel_at_an_edge_has_the_brightness_of_its_covered_share() -> None:
    """A face whose edge crosses the columns slowly: shares from none to all."""
    slope = 0.02
    turn = DOWN @ turned(np.arctan(slope), 0.0, 0.0)
    links = placed((DOWN, (0.0, 0.0, 3.0)), (turn, (0.0, 0.5, 4.0)))
    water = Water(attenuation=(0.0,) * 3, shot_gain=0.0)
    image = average(camera([look("box", (1e-3, 1.0, 2.0), "#ffffff", link="first")], water), links)
    below = average(camera([], water), links)

    share = (image - below) / (image[:, 200:220].mean() - below)

    rows = np.arange(60, 180)
    edge = np.array([320 - share[r].sum() for r in rows])
    line = np.polyfit(rows, edge, 1)
    assert abs(line[0]) == pytest.approx(slope, rel=0.05)
    assert np.abs(edge - np.polyval(line, rows)).max() < 0.1  # [px]


def test_the_nearer_of_two_bodies_hides_the_other_whatever_their_order() -> None:
    near = look("sphere", (0.2, 0.2, 0.2), WHITE, at=(0.0, 0.0, 4.0))
    far = look("box", (0.4, 0.4, 0.1), BLACK, at=(0.0, 0.0, 4.6))
    links = placed((DOWN, (0.0, 0.0, 3.0)))

    images = [camera(order).grey(links, 0) for order in ([near, far], [far, near])]

    assert np.array_equal(*images)
    assert images[0][115:125, 155:165].mean() > 120
    assert images[0][119, 134] < 80  # beside the ball, the box


def test_a_body_that_is_half_in_the_seabed_ends_where_it_goes_in() -> None:
    links = placed((turned(0.0, -0.5, 0.0), (0.0, 0.0, 4.0)), (np.eye(3), (1.8, 0.0, 5.0)))
    scene = camera([look("box", (0.2, 0.4, 0.4), "#ffffff", link="first")])

    image, bare = average(scene, links), average(camera([]), links)
    ((_, v),) = scene.project(links, np.array([[1.7, 0.0, 5.0]]))

    changed = np.abs(image - bare)[:, 155:165].mean(axis=1) > 5
    assert np.nonzero(changed)[0].max() == pytest.approx(v, abs=1.0)


@pytest.mark.parametrize("pitch_deg", [0.0, 0.1, -0.1, 45.0, 90.0, 89.9, -0.001])
def test_at_the_horizon_and_above_it_there_is_only_the_veil(pitch_deg: float) -> None:
    pitch = np.radians(pitch_deg)
    links = placed((turned(0.0, pitch, 0.7), (30.0, -20.0, 4.2)))
    water = Water.grey(0.3)

    image = average(camera([], water), links)

    veil = 255 * water.veil[1]
    row = 119.5 + 220.0 * np.tan(min(pitch, np.radians(80.0)))
    above = image[: max(min(int(row), 240), 0)]
    assert above.size == 0 or np.abs(above - veil).max() < 1.5
    assert (above.size == image.size) or np.abs(np.diff(image, axis=0)).max() < 60


@pytest.mark.parametrize("down_m", [4.999, 5.0, 5.5, -300.0])
def test_a_camera_in_the_seabed_or_far_above_it_still_gives_an_image(down_m: float) -> None:
    for turn in (DOWN, LEVEL, turned(0.0, np.pi / 2, 0.0)):
        image = camera(crowd()).grey(placed((turn, (0.0, 0.0, down_m))), 0)

        assert image.shape == (240, 320)


def test_a_body_that_the_camera_almost_touches_fills_the_image() -> None:
    wall = look("box", (0.1, 5.0, 5.0), "#ffffff", link="first")
    links = placed(
        (LEVEL, (0.0, 0.0, 3.0)), (LEVEL, tuple(np.array([0, 0, 3]) + LEVEL[:, 0] * 0.053))
    )

    image = camera([wall], Water.grey(0.0)).grey(links, 0)

    assert image.std() < 4.0
    assert image.mean() == pytest.approx(255 * 0.6 / 0.9625, rel=0.35)


def test_a_body_around_the_camera_or_behind_it_is_not_drawn() -> None:
    looks = [
        look("box", (0.2, 0.2, 0.2), WHITE, link="camera"),
        look("capsule", (0.2, 0.1, 0.1), WHITE, link="camera", at=(-0.2, 0.0, 0.0)),
    ]
    links = placed((OBLIQUE, (0.0, 0.0, 4.0)))

    assert np.array_equal(camera(looks).grey(links, 1), camera([]).grey(links, 1))


def test_a_body_beside_the_camera_reaches_from_the_edge_of_the_image_into_it() -> None:
    """It goes through the near plane: the camera's own arm."""
    arm = look("capsule", (0.6, 0.04, 0.04), "#ffffff", link="camera", at=(0.1, 0.0, 0.035))
    links = placed((LEVEL, (0.0, 0.0, 3.0)))
    water = Water.grey(0.0)

    changed = np.abs(average(camera([arm], water), links) - average(camera([], water), links)) > 5

    truth = SlowRenderer([arm], water, bilinear, samples=1).grey(links)
    covered = np.abs(truth - SlowRenderer([], water, bilinear, samples=1).grey(links)) > 5
    assert covered[230:].sum() > 1000
    assert (changed != covered).sum() < 0.04 * covered.sum()


EFFECTS = {
    "none": Effects(),
    "blur": Effects(exposure_s=0.04),
    "lamp": Effects(light_level=0.2, lamp=2.0),
    "all": Effects(
        exposure_s=0.03,
        light_level=0.4,
        lamp=1.0,
        snow_per_m3=300.0,
        scatter_rad=0.004,
        caustics=0.3,
    ),
}
DISTURBED = [camera(crowd(), Water.of_type("3C"), effects=effects) for effects in EFFECTS.values()]


@pytest.mark.slow
@given(
    number=st.integers(0, len(DISTURBED) - 1),
    sight=st.sampled_from(list(SIGHTS)),
    corner=st.tuples(st.integers(-20, 310), st.integers(-20, 230)),
    size=st.tuples(st.integers(1, 330), st.integers(1, 250)),
    twist=st.tuples(*[st.floats(-0.5, 0.5)] * 18),
)
@settings(max_examples=25, deadline=None)
def test_region_has_the_bytes_of_the_whole_image(
    number: int,
    sight: str,
    corner: tuple[int, int],
    size: tuple[int, int],
    twist: tuple[float, ...],
) -> None:
    links = SIGHTS[sight]._replace(twist=np.array(twist).reshape(3, 6))
    whole = DISTURBED[number].grey(links, 7)

    (x0, y0), (width, height) = corner, size
    part = DISTURBED[number].region(links, 7, (x0, y0, x0 + width, y0 + height))

    rows, columns = slice(max(y0, 0), max(y0 + height, 0)), slice(max(x0, 0), max(x0 + width, 0))
    assert np.array_equal(part[rows, columns], whole[rows, columns])


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(EFFECTS)), ids=list(EFFECTS))
def test_grey_image_is_the_green_channel_of_the_coloured_one(number: int) -> None:
    links = SIGHTS["oblique"]

    coloured = DISTURBED[number].colour(links, 3)

    assert np.array_equal(coloured[:, :, 1], DISTURBED[number].grey(links, 3))


def test_cameras_in_several_threads_render_the_bytes_of_one() -> None:
    def rendered(_: int) -> list[bytes]:
        scene = camera(crowd(), Water.of_type("3C"), effects=EFFECTS["all"])
        return [scene.grey(links, 4).tobytes() for links in SIGHTS.values()]

    with ThreadPoolExecutor(3) as threads:
        images = list(threads.map(rendered, range(3)))

    assert images == [rendered(0)] * 3


PROGRAM = """
import hashlib
from seamark.sim.camera import Effects, Water
from tests.sim.camera.link_scenes import camera
from tests.sim.camera.test_link_camera import EFFECTS, SIGHTS, crowd
digest = hashlib.sha256()
for effects in (EFFECTS["none"], EFFECTS["all"]):
    scene = camera(crowd(), Water.of_type("II"), effects=effects)
    for links in SIGHTS.values():
        digest.update(scene.colour(links, 77).tobytes())
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_another_process_and_the_oldest_processor_give_the_same_bytes() -> None:
    here = printed_here(PROGRAM)

    assert len(here.strip()) == 64
    assert here == printed(PROGRAM, on="oldest")


def test_points_are_projected_as_pixels_are_rendered() -> None:
    links = SIGHTS["oblique"]
    points = np.array([[1.5, 0.2, 4.9], [2.0, -0.4, 5.0], [-1.0, 0.0, 4.0]])

    images = camera([]).project(links, points)

    local = (points - links.position[0]) @ links.rotation[0]
    assert images[:2] == pytest.approx(
        np.array([159.5, 119.5]) + 220.0 * local[:2, 1:] / local[:2, :1]
    )
    assert np.isnan(images[2]).all()  # behind the camera


@pytest.mark.slow
def test_points_are_shown_unless_something_is_before_them() -> None:
    ball = look("sphere", (0.2, 0.2, 0.2), WHITE, at=(0.0, 0.0, 4.0))
    links = placed((DOWN, (0.0, 0.0, 3.0)))
    places = {
        "above the ball": (0.0, 0.0, 3.5),
        "on it": (0.0, 0.0, 3.9),
        "in it": (0.0, 0.0, 4.0),
        "below it": (0.0, 0.0, 4.9),
        "beside it": (0.0, 0.2, 4.9),
        "below the seabed": (0.0, 0.2, 5.1),
        "out of the image": (0.0, 3.0, 4.9),
        "behind the camera": (0.0, 0.0, 2.0),
    }

    shown = camera([ball]).shown(links, np.array(list(places.values())))

    assert [name for name, seen in zip(places, shown, strict=True) if seen] == [
        "above the ball",
        "on it",
        "beside it",
    ]


@pytest.mark.slow
def test_the_template_tracker_follows_the_lettered_top_of_the_black_box() -> None:
    thing = assemble(None, [Mounting(linkage=load_linkage("black-box"), place=HERE)])
    bodies = Bodies(thing.looks, ("camera", "box"))
    water = Water.of_type("II")
    scene = LinkCamera(scenes.OPTICS, water, bodies, mount=scenes.EYE, seabed_m=5.0, noise_seed=3)
    top = np.array([[-0.15, -0.1, -0.1], [0.15, -0.1, -0.1], [0.15, 0.1, -0.1], [-0.15, 0.1, -0.1]])
    follower, errors = make("esm"), []

    for frame in range(60):
        sway = 0.002 * frame
        turn = DOWN @ turned(0.3 + 0.004 * frame, 0.05, -0.05)
        rotation = np.stack([turn, turned(0.0, 0.0, 0.2)])
        position = np.array([[0.05 - sway, sway, 4.0], [0.0, 0.0, 4.9]])
        links = scenes.Placed(rotation, position, np.zeros((2, 6)))
        truth = scene.project(links, top @ rotation[1].T + position[1])
        if frame == 0:
            follower.start(scene.grey(links, 0), truth)
            continue
        track = follower.update(scene.region(links, frame, follower.window()))
        assert track.ok
        errors.append(np.linalg.norm(track.corners - truth, axis=1).mean())

    assert max(errors) < 1.0  # [px] under a handle that moves before it
