"""The scene of a run and the pictures of its surfaces."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.server.pages.run.player_data import player_data
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.scene import vehicle_shape, work_shape
from seamark.sim import registry
from seamark.sim.benchmarks.intervention.box import RAISED_M, BoxDraw, workpiece
from seamark.sim.camera.seabed import TILE, texels
from seamark.sim.files import target_pictures
from seamark.sim.metrics import recovery
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX, WORK_INDEX, Rows, width_for
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage
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


@pytest.mark.parametrize(
    "benchmark", ["currents-v1", "visibility-v1", "visibility-v2", "visibility-v3"]
)
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


def test_the_scene_has_the_path_of_a_target_that_moves_by_itself(site: Site) -> None:
    run_id = site.succeeded(benchmark="visibility-v3", controller="built-in")
    config: Any = registry.benchmark("visibility-v3").read({})

    scenes = [
        site.call("owner", "GET", f"/api/v1/runs/{run_id}/scene.json?level={level}").get_json()
        for level in (0, 1, 15)
    ]

    paths = [scene["target"]["path"] for scene in scenes]
    assert [len(path["places"]) for path in paths] == [config.control_steps_per_level] * 3
    assert [path["start"] for path in paths] == [0.0, 2.0, 30.0]
    assert paths[0]["places"] == paths[1]["places"] != paths[2]["places"]
    assert np.ptp(paths[0]["places"], axis=0).max() < 0.4
    assert np.ptp(paths[0]["places"], axis=0).min() > 0.0


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


def test_the_scene_of_a_fresh_trial_is_held_back_until_its_rows_are_shown(site: Site) -> None:
    claim = site.running(kind="ranked", benchmark="recover-v1", controller="scripted")
    protocol = registry.benchmark("recover-v1").protocol
    assert protocol is not None
    reference, fresh = protocol.reference_trials - 1, protocol.reference_trials

    def answer(trial: int, name: str = "scene.json") -> Any:
        address = f"/api/v1/runs/{claim.run_id}/{name}?trial={trial}"
        return site.call("owner", "GET", address)

    assert answer(reference).status_code == 200
    for name in ("scene.json", "texture.jpg"):
        problem_of(answer(fresh, name), 404, "not-found")
    rows = lifted(0.6)
    rows[:, INDEX["trial"]] = fresh
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(rows)
    assert answer(fresh).status_code == 200


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


@pytest.mark.slow
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


RECOVER = {"levels": [0.1], "level_duration_s": 20.0, "turbidity_spread": 0.0}


def recovered(site: Site, rows: Rows) -> str:
    claim = site.running(benchmark="recover-v1", controller="scripted", trials=2, config=RECOVER)
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(rows)
    assert site.finish(claim)
    return f"/api/v1/runs/{claim.run_id}"


def lifted(lift_m: float) -> Rows:
    """Rows of a run whose box is carried from the fifth second on, at this height."""
    rows = np.zeros((400, width_for(8, arm=True, work=True)))
    rows[:, INDEX["t"]] = 0.05 * np.arange(400)
    rows[:, WORK_INDEX["workpiece_z"]] = 4.9
    rows[:, [INDEX["x"], INDEX["y"], INDEX["z"]]] = (-1.25, 0.35, 3.3)  # its camera above the box
    rows[100:, WORK_INDEX["workpiece_z"]] -= lift_m
    rows[100:, WORK_INDEX["work_arm_n"]] = 20.0
    rows[:100, WORK_INDEX["work_rest_n"]] = 20.0
    return rows


def pixels(image: bytes) -> NDArray[np.int64]:
    decoded = cv2.imdecode(np.frombuffer(image, np.uint8), 1)
    assert decoded is not None
    return decoded.astype(np.int64)


def test_the_box_of_a_trial_lies_in_its_scene_on_a_stone_as_it_is_tilted(site: Site) -> None:
    run = recovered(site, lifted(0.6))

    scenes = [
        site.call("owner", "GET", f"{run}/scene.json?trial={trial}").get_json() for trial in (0, 1)
    ]

    turns = []
    for scene in scenes:
        thing, stone = scene["workpiece"]["things"]
        (box,) = thing["links"]
        assert box["joint"] == {"kind": "free"}
        assert [solid.get("lettered", False) for solid in box["solids"]] == [True, *[False] * 3]
        assert stone["links"][0]["joint"] is None
        assert stone["place"][2] == pytest.approx(scene["seabed"]["depth"] - RAISED_M)
        assert np.linalg.norm(np.subtract(thing["place"], stone["place"])) == pytest.approx(0.1)
        assert thing["turn"] == stone["turn"]
        assert max(map(abs, thing["turn"][:2])) > 0.0
        turns.append(thing["turn"])
    assert all(one != other for one, other in zip(*turns, strict=True))
    assert scenes[0]["workpiece"]["face"]["link"] == [0, 0]


def test_letters_are_in_the_colour_of_the_box_that_the_arm_takes(site: Site) -> None:
    run, plain = recovered(site, lifted(0.6)), site.succeeded(controller="p")
    pictures = [
        pixels(site.call("owner", "GET", f"{of}/texture.jpg?part=target").data)
        for of in (run, f"/api/v1/runs/{plain}")
    ]

    yellow, black = (each[..., 2].mean() / each[..., 0].mean() for each in pictures)

    assert yellow > 2.0
    assert black < 1.5


def test_the_target_shows_the_picture_of_its_organiser(site: Site) -> None:
    picture = site.store_picture()
    config = {"target_texture": picture.name}
    sent: dict[str, Any] = {"benchmark": "visibility-v2", "controller": "built-in"}
    run_id = site.succeeded(**sent, config=config, files=(picture,))
    texture = f"/api/v1/runs/{run_id}/texture.jpg?part=target"
    shown = pixels(site.call("owner", "GET", texture).data).mean(axis=2)
    grey = cv2.resize(target_pictures.read(picture.content), shown.shape[::-1])

    assert np.corrcoef(shown.ravel(), grey.ravel())[0, 1] > 0.9
    assert not target_pictures.LIBRARY.is_known(picture.name)


def test_the_vehicles_camera_sees_the_box_rise(site: Site) -> None:
    run = recovered(site, lifted(0.6))

    sights = [
        pixels(site.call("owner", "GET", f"{run}/camera.jpg?truth=false&tracked=false&t={t}").data)
        for t in (4.0, 6.0)
    ]

    small, large = ((each[..., 2] - each[..., 0] > 60).sum() for each in sights)
    assert large > 1.3 * small > 0, "it is nearer"


def test_a_link_on_a_joint_moves_with_it_and_the_rest_of_its_thing_stands() -> None:
    valve, box = load_linkage("roof-valve"), workpiece(BoxDraw())
    place = box.things[0].place
    thing = Mounting(linkage=valve, place=place, prefix="a: ")

    shape = work_shape(replace(box, things=(*box.things, thing), link="a: handle"))

    lying, _stone, (panel, handle) = (each["links"] for each in shape["things"])
    assert lying[0]["joint"] is None, "no column moves it"
    assert panel["joint"] is None
    assert handle["joint"] == {"kind": "revolute", "axis": valve.links[1].joint.axis, "ratio": 1.0}
    assert handle["parent"] == 0


def test_moments_say_when_each_stage_was_reached(site: Site) -> None:
    rows = lifted(0.6)
    rows[90:, WORK_INDEX["reach"]], rows[:90, WORK_INDEX["reach"]] = 0.02, 1.0
    run = recovered(site, rows)

    found = site.call("owner", "GET", f"{run}/moments.json").get_json()
    plain = site.call("owner", "GET", f"/api/v1/runs/{site.recorded()}/moments.json").get_json()

    times = [(one["level"], one["stage"], one["t"]) for one in found["stages"]]
    expected = [
        (0, stage, rows[at, INDEX["t"]]) for stage, at in enumerate(recovery.reached(rows, 0.05))
    ]
    assert times == expected
    assert len(times) == 5
    assert "stages" not in plain


def test_a_page_that_is_opened_before_the_first_row_knows_the_columns_of_the_work(
    site: Site,
) -> None:
    claim = site.running(benchmark="recover-v1", controller="scripted", config=RECOVER)

    with site.app.test_request_context():
        files = RunFiles(site.settings.data, claim.run_id, 1)
        data = player_data(site.show(claim.run_id), files)

    names = [column["name"] for column in data["columns"]]
    assert {"joint_0", "workpiece_x", "work_fz"} <= {*names}
    assert data["stages"][0] == "Reached the handle"
