"""The scene of a run and the pictures of its surfaces."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from seamark.server.runs.showing.scene import vehicle_shape
from seamark.sim.camera.seabed import TILE, texels
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
