"""The scene of a run in which a route is followed."""

from typing import Any

import cv2
import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics.water_motion import records
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, Rows
from tests.server.api.conftest import Site
from tests.server.api.test_api import problem_of

LEVELS = {"levels": [0.0, 0.4], "level_duration_s": 4.0}
SEED = 3


@pytest.fixture(scope="module")
def rows() -> Rows:
    """The rows of two levels that really ran."""
    config: Any = registry.benchmark("track-v1").read(LEVELS)
    found: list[Rows] = []
    program = registry.benchmark("track-v1").load().built_in("ilos", config)
    run_trial("track-v1", config, program, seed=SEED, trial=0, on_rows=found.append)
    return np.concatenate(found)


def following(site: Site, rows: Rows, config: dict[str, Any] = LEVELS) -> str:
    claim = site.running(benchmark="track-v1", controller="ilos", config=config, seed=SEED)
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(rows)
    assert site.finish(claim)
    return f"/api/v1/runs/{claim.run_id}"


def test_the_scene_of_a_level_has_the_route_that_its_rows_follow(site: Site, rows: Rows) -> None:
    run = following(site, rows)
    config: Any = registry.benchmark("track-v1").read(LEVELS)

    scenes = [site.call("owner", "GET", f"{run}/scene.json?level={n}").get_json() for n in (0, 1)]

    plan = registry.benchmark("track-v1").load().plan(config, seed=SEED, trial=0)
    for level, scene in enumerate(scenes):
        of_level, route = rows[rows[:, INDEX["level"]] == level], scene["route"]
        points = np.array(route["points"])
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        assert length == pytest.approx(float(of_level[0, ROUTE_INDEX["route_length"]]), abs=1e-9)
        nearest = of_level[0, [ROUTE_INDEX[f"route_{axis}"] for axis in "xyz"]]
        assert np.linalg.norm(points[0] - nearest) < 0.5
        boat = of_level[0, [ROUTE_INDEX[f"boat_{axis}"] for axis in "xyz"]]
        assert route["boat"] == pytest.approx(boat.tolist(), abs=1e-9)
        assert route["told_error"] == list(plan.conditions["start_errors"][level])
        assert 0.0 < np.hypot(*route["told_error"]) <= route["error"] == config.start_error_m
    assert scenes[0]["route"] != scenes[1]["route"]


def test_a_run_without_a_route_has_none_in_its_scene(site: Site) -> None:
    scene = site.call("owner", "GET", f"/api/v1/runs/{site.succeeded(controller='p')}/scene.json")

    assert "route" not in scene.get_json()


def test_along_a_pipe_the_scene_has_it_and_the_image_the_piece_that_was_found(site: Site) -> None:
    config = {"levels": [0.0], "level_duration_s": 4.0, "route": "pipe"}
    settings: Any = registry.benchmark("track-v1").read(config)
    found: list[Rows] = []
    experiment: Any = registry.benchmark("track-v1").load()
    program = experiment.built_in("ilos", settings.for_trial(0))
    run_trial("track-v1", settings, program, seed=SEED, trial=0, on_rows=found.append)
    run = following(site, np.concatenate(found), config)

    route = site.call("owner", "GET", f"{run}/scene.json").get_json()["route"]
    shown, bare = (
        site.call("owner", "GET", f"{run}/camera.jpg?t=2{query}").data
        for query in ("", "&truth=false&tracked=false")
    )

    course = experiment.course(settings, seed=SEED, trial=0, level=0)
    assert route["pipe"]["axis"] == course.pipe.axis_m.tolist()
    assert route["pipe"]["covered"] == course.pipe.covered_m.tolist()
    assert len(route["pipe"]["covered"]) == settings.pipe_covered
    drawn, plain = (
        np.asarray(cv2.imdecode(np.frombuffer(one, np.uint8), cv2.IMREAD_COLOR), np.float64)
        for one in (shown, bare)
    )
    greener = (drawn - plain)[:, :, 1] > 60.0
    assert 50 < greener.sum() < 2000


def test_the_route_of_a_fresh_trial_is_held_back_until_its_rows_are_shown(
    site: Site, rows: Rows
) -> None:
    claim = site.running(kind="ranked", benchmark="track-v1", controller="ilos")
    protocol = registry.benchmark("track-v1").protocol
    assert protocol is not None
    fresh = protocol.reference_trials

    def answer(trial: int) -> Any:
        return site.call("owner", "GET", f"/api/v1/runs/{claim.run_id}/scene.json?trial={trial}")

    assert answer(fresh - 1).status_code == 200
    problem_of(answer(fresh), 404, "not-found")
    shown = rows[:5].copy()
    shown[:, INDEX["trial"]] = fresh
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(shown)
    assert len(answer(fresh).get_json()["route"]["points"]) > 2
    problem_of(answer(fresh + 1), 404, "not-found")


def test_nothing_is_drawn_into_the_camera_image_of_a_run_without_a_tracker(
    site: Site, rows: Rows
) -> None:
    run = following(site, rows)

    images = [
        site.call("owner", "GET", f"{run}/camera.jpg?t=0{query}").data
        for query in ("", "&truth=false&tracked=false")
    ]

    assert images[0] == images[1]
    image = cv2.imdecode(np.frombuffer(images[0], np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.std() > 1.0  # the weight is below the start


def test_moments_say_where_the_vehicle_was_farthest_from_its_route(site: Site, rows: Rows) -> None:
    far = rows.copy()
    far[10:20, ROUTE_INDEX["cross_track"]] = 3.0
    far[15, ROUTE_INDEX["cross_track"]] = 4.0

    found = site.call("owner", "GET", f"{following(site, far)}/moments.json").get_json()

    assert found["losses"] == [far[10, INDEX["t"]]]
    assert found["largest_error"]["column"] == "cross_track"
    assert found["largest_error"]["t"] == far[15, INDEX["t"]]


@pytest.mark.slow
def test_the_fan_of_the_sonar_is_shown_of_each_moment(site: Site, rows: Rows) -> None:
    claim = site.running(
        benchmark="track-v1", controller="ilos", config=LEVELS | {"sonar": "forward"}, seed=SEED
    )
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(rows)
    assert site.finish(claim)
    run = f"/api/v1/runs/{claim.run_id}"

    images = [
        site.call("owner", "GET", f"{run}/camera.jpg?{query}").data
        for query in ("camera=sonar&t=1", "camera=sonar&t=3", "t=1")
    ]
    fan = cv2.imdecode(np.frombuffer(images[0], np.uint8), 1)

    assert len(set(images)) == 3
    assert fan is not None
    assert fan.shape[:2] == (480, 833)
    seabed, water = fan[60:160, 300:500].mean(), fan[380:440, 380:450].mean()
    assert seabed > 3.0 * water


def test_a_run_without_a_sonar_has_no_fan(site: Site, rows: Rows) -> None:
    answer = site.call("owner", "GET", f"{following(site, rows)}/camera.jpg?camera=sonar")

    problem_of(answer, 404, "not-found")
    assert "no imaging sonar" in answer.get_json()["detail"]


def test_the_scene_of_a_run_in_a_users_record_needs_the_record(site: Site) -> None:
    record = site.store_record()
    config: dict[str, Any] = {**LEVELS, "current_record": record.name}
    sent: dict[str, Any] = {"benchmark": "track-v1", "controller": "ilos", "config": config}
    sent["files"] = (record,)
    scene = f"/api/v1/runs/{site.succeeded(**sent)}/scene.json"

    there = site.call("owner", "GET", scene)
    (site.settings.data / "programs" / record.sha256).unlink()
    gone = site.call("owner", "GET", scene)

    assert there.get_json()["route"]["points"]
    assert gone.status_code == 404
    assert not records.LIBRARY.is_known(record.name)
