"""The scene of a run and the pictures of its surfaces."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.scene import vehicle_shape
from seamark.sim.camera.seabed import TILE, texels
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX, Rows, width_for
from seamark.sim.vehicles import load
from tests.server.api.conftest import Site
from tests.server.api.test_api import problem_of


def test_the_scene_has_the_thrusters_of_the_trials_vehicle(site: Site) -> None:
    run_id = site.succeeded(benchmark="currents-v2", trials=2, controller="p")
    path = f"/api/v1/runs/{run_id}/scene.json?level=2&trial="

    scenes = [site.call("owner", "GET", f"{path}{trial}").get_json() for trial in (0, 1)]

    assert [scene["vehicle"]["name"] for scene in scenes] == ["girona500", "bluerov2-heavy"]
    for scene in scenes:
        vehicle = load(scene["vehicle"]["name"])
        shown = [tuple(one["position"]) for one in scene["vehicle"]["thrusters"]]
        assert shown == [thruster.position.value for thruster in vehicle.thrusters]


@pytest.mark.parametrize("benchmark", ["currents-v1", "visibility-v1", "visibility-v2"])
def test_turbidity_and_target_of_a_level_are_those_of_its_camera(
    site: Site, benchmark: str
) -> None:
    run_id = site.succeeded(
        benchmark=benchmark, controller="built-in" if "vis" in benchmark else "p"
    )

    scene = site.call("owner", "GET", f"/api/v1/runs/{run_id}/scene.json?level=1").get_json()

    assert scene["target"]["centre"][2] == pytest.approx(
        scene["seabed"]["depth"] - scene["target"]["size"][2] / 2
    )
    assert len(scene["water"]["attenuation"]) == 3
    assert scene["camera"]["width"] in (320, 640)


def test_the_scene_has_daylight_and_lamp_of_the_run(site: Site) -> None:
    config = {"light_level": 0.4, "lamp": 1.5, "lamp_cone_rad": 0.5}
    lit = site.succeeded(benchmark="visibility-v1", controller="built-in", config=config)
    plain = site.succeeded(controller="p")

    lights = [
        site.call("owner", "GET", f"/api/v1/runs/{run_id}/scene.json").get_json()["light"]
        for run_id in (lit, plain)
    ]

    assert lights[0] == {"level": 0.4, "lamp": 1.5, "cone": 0.5, "forward": 0.4}
    assert (lights[1]["level"], lights[1]["lamp"]) == (1.0, 0.0)


@pytest.mark.slow
def test_the_seabed_is_the_texture_of_the_camera_and_the_target_has_its_letters(
    site: Site,
) -> None:
    path = f"/api/v1/runs/{site.succeeded(controller='p')}/texture.jpg?part="

    seabed, target = (
        cv2.imdecode(np.frombuffer(site.call("owner", "GET", path + part).data, np.uint8), 1)
        for part in ("seabed", "target")
    )

    assert seabed is not None
    assert target is not None
    green = texels(7, 1).reshape(512, TILE // 512, 512, TILE // 512).mean(axis=(1, 3))
    assert np.abs(seabed[:, :, 1].astype(float) - green).mean() < 4.0
    assert target.shape[1] / target.shape[0] == pytest.approx(0.42 / 0.13, rel=0.02)
    assert np.ptp(target) > 100


def test_a_level_that_the_run_does_not_have_is_not_found(site: Site) -> None:
    run_id = site.succeeded(controller="p")
    for query in ("level=99", "trial=1"):
        for name in ("scene.json", "texture.jpg"):
            answer = site.call("owner", "GET", f"/api/v1/runs/{run_id}/{name}?{query}")
            problem_of(answer, 404, "not-found")


def test_the_camera_image_without_outlines_is_the_bare_image(site: Site) -> None:
    run_id = site.recorded()
    path = f"/api/v1/runs/{run_id}/camera.jpg?t=1"

    images = {
        query: site.call("owner", "GET", path + query).data
        for query in ("", "&truth=false", "&tracked=false", "&truth=false&tracked=false")
    }

    assert len(set(images.values())) >= 3  # this recording has no tracked outline
    bare = images["&truth=false&tracked=false"]
    image = cv2.imdecode(np.frombuffer(bare, np.uint8), 1)
    assert image is not None
    assert not (image == 255).all(axis=2).any()


def test_a_vehicle_without_solids_of_its_own_is_drawn_as_its_hull() -> None:
    plain = replace(load("bluerov2-heavy"), solids=())

    (frame,) = vehicle_shape(plain)["solids"]

    assert (frame["shape"], frame["size"]) == ("box", plain.hull[0].size.value)


WITH_ARM = {
    "arm": "alpha-like",
    "vehicle": "bluerov2-heavy-v2",
    "levels": [0.1],
    "level_duration_s": 2.0,
    "settle_s": 1.0,
}


def reached(bow: float) -> Rows:
    """Rows of a run with an arm whose second joint has this coordinate."""
    rows = np.zeros((40, width_for(8, arm=True)))
    rows[:, INDEX["t"]] = 0.05 * np.arange(40)
    rows[:, INDEX["z"]] = 1.6
    for name, value in (("joint_1", bow), ("joint_2", 2.5), ("joint_4", 0.3)):
        rows[:, ARM_INDEX[name]] = value
    return rows


def with_arm(site: Site, rows: Rows) -> str:
    claim = site.running(benchmark="currents-v2", controller="p", config=WITH_ARM)
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(rows)
    assert site.finish(claim)
    return f"/api/v1/runs/{claim.run_id}"


def test_the_scene_has_the_links_of_an_arm_and_the_columns_that_move_them(site: Site) -> None:
    scene = site.call("owner", "GET", f"{with_arm(site, reached(1.0))}/scene.json").get_json()
    plain = site.succeeded(controller="p")

    arm = scene["vehicle"]["arm"]
    joints = [link["joint"] for link in arm["links"]]
    assert [joint and joint["column"] for joint in joints] == [None, 0, 1, 2, 3, 4, 4]
    assert [link["parent"] for link in arm["links"]] == [None, 0, 1, 2, 3, 4, 4]
    assert [link["touch"] for link in arm["links"]][-3:] == [[0], [1], [2]]
    assert arm["place"] == list(load("bluerov2-heavy-v2").mounts["alpha-like"].point.value)
    bare = site.call("owner", "GET", f"/api/v1/runs/{plain}/scene.json").get_json()
    assert bare["vehicle"]["arm"] is None


def test_the_camera_on_the_arm_shows_what_lies_before_it_and_moves_with_the_joints(
    site: Site,
) -> None:
    stretched, lowered = with_arm(site, reached(1.0)), with_arm(site, reached(0.2))

    images = [
        site.call("owner", "GET", f"{run}/camera.jpg?camera={camera}&t=1").data
        for run in (stretched, lowered)
        for camera in ("arm", "vehicle")
    ]
    sights = [cv2.imdecode(np.frombuffer(image, np.uint8), 1) for image in images]

    assert len(set(images)) == 4
    assert sights[0] is not None
    assert sights[1] is not None
    assert sights[0].shape[:2] == (240, 320)
    assert sights[1].shape[:2] == (480, 640)


def test_a_vehicle_without_an_arm_has_no_camera_on_one(site: Site) -> None:
    answer = site.call("owner", "GET", f"/api/v1/runs/{site.recorded()}/camera.jpg?camera=arm")

    problem_of(answer, 404, "not-found")
    assert "no camera on an arm" in answer.get_json()["detail"]
