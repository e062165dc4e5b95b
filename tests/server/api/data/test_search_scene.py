"""The scene of a run in which the right box has to be found first."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.server.runs.data.files import RunFiles
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.mission import MARK_M
from seamark.sim.recording.telemetry import INDEX, SEARCH_INDEX, WORK_INDEX, Rows
from tests.server.api.conftest import Site
from tests.server.api.test_api import problem_of

LEVELS = {"levels": [0.0], "loop1_values": [0.2, 1.0], "level_duration_s": 2.0}
SEED = 3


@pytest.fixture(scope="module")
def rows() -> list[Rows]:
    """The rows of two levels that really ran."""
    config: Any = registry.benchmark("mission-v1").read(LEVELS)
    found: list[Rows] = []
    chain = registry.benchmark("mission-v1").load().built_in("chain", config)
    run_trial("mission-v1", config, chain, seed=SEED, trial=0, on_rows=found.append)
    table = np.concatenate(found)
    return [table[table[:, INDEX["level"]] == level] for level in (0, 1)]


def in_time(rows: list[Rows]) -> list[Rows]:
    """Return levels in the order in which they ran."""
    return sorted(rows, key=lambda level: float(level[0, INDEX["t"]]))


def mission(site: Site, rows: list[Rows]) -> str:
    claim = site.running(benchmark="mission-v1", controller="chain", config=LEVELS, seed=SEED)
    files = RunFiles(site.settings.data, claim.run_id, 1)
    for level in in_time(rows):
        files.append_rows(level)
    assert site.finish(claim)
    return f"/api/v1/runs/{claim.run_id}"


def picture(site: Site, address: str) -> NDArray[np.uint8]:
    image = cv2.imdecode(np.frombuffer(site.call("owner", "GET", address).data, np.uint8), 1)
    assert image is not None
    return image.astype(np.uint8)


def test_the_scene_of_a_level_says_where_its_search_begins_and_what_is_told(
    site: Site, rows: list[Rows]
) -> None:
    run = mission(site, rows)
    config: Any = registry.benchmark("mission-v1").read(LEVELS)

    scenes = [site.call("owner", "GET", f"{run}/scene.json?level={n}").get_json() for n in (0, 1)]

    experiment = registry.benchmark("mission-v1").load()
    plan = experiment.plan(config, seed=SEED, trial=0)
    for level, (scene, of_level) in enumerate(zip(scenes, rows, strict=True)):
        search, drawn = scene["search"], plan.conditions["work"]["searches"][level]
        began = of_level[0, [INDEX["x"], INDEX["y"]]]
        assert search["start"] == pytest.approx(began.tolist(), abs=1e-9)
        off = np.subtract(search["told"], of_level[0, [WORK_INDEX[f"workpiece_{a}"] for a in "xy"]])
        tilted = 0.03  # the box stands a little beside the middle of its stone
        assert off.tolist() == pytest.approx(list(drawn["told_error_m"]), abs=tilted)
        assert search["error"] == config.told_error_m
        assert search["mark"] == MARK_M
    assert scenes[0]["search"] != scenes[1]["search"]


def test_the_decoy_of_the_scene_moves_with_its_own_columns(site: Site, rows: list[Rows]) -> None:
    scene = site.call("owner", "GET", f"{mission(site, rows)}/scene.json?level=1").get_json()

    box, stone, decoy, other_stone = scene["workpiece"]["things"]
    joints = [thing["links"][0]["joint"] for thing in (box, stone, decoy, other_stone)]
    assert joints == [{"kind": "free"}, None, {"kind": "free", "of": "decoy"}, None]
    columns = [SEARCH_INDEX[f"decoy_{axis}"] for axis in "xyz"]
    assert decoy["place"] == pytest.approx(rows[1][0, columns].tolist(), abs=1e-6)
    assert scene["target"] is not None
    assert scene["seabed"]["painted"] is True


def test_the_decoy_has_a_text_of_its_own(site: Site, rows: list[Rows]) -> None:
    run = mission(site, rows)
    texts = [
        picture(site, f"{run}/texture.jpg?part={part}&level={level}").astype(float)
        for part, level in (("target", 0), ("target", 1), ("decoy", 0), ("decoy", 1))
    ]

    right, again, wrong, other = texts
    assert np.array_equal(right, again)
    assert np.abs(right - wrong).mean() > 5.0
    assert np.abs(wrong - other).mean() > 5.0


def test_the_seabed_of_each_level_has_its_own_litter(site: Site, rows: list[Rows]) -> None:
    run = mission(site, rows)

    grounds = [picture(site, f"{run}/texture.jpg?part=seabed&level={n}") for n in (0, 1)]

    assert np.abs(np.subtract(*(each.astype(float) for each in grounds))).mean() > 1.0


def test_a_run_without_a_decoy_has_no_picture_of_one(site: Site) -> None:
    run = f"/api/v1/runs/{site.succeeded(controller='p')}"

    problem_of(site.call("owner", "GET", f"{run}/texture.jpg?part=decoy"), 404, "not-found")
    assert "search" not in site.call("owner", "GET", f"{run}/scene.json").get_json()


def test_the_last_answer_of_the_detector_is_drawn_until_it_is_asked_again(
    site: Site, rows: list[Rows]
) -> None:
    first, second = (level.copy() for level in in_time(rows))
    for level in (first, second):
        level[:, SEARCH_INDEX["looked"]] = 0.0
        level[:, INDEX["tracker_ok"]] = 0.0
        level[:, [SEARCH_INDEX[f"found_{axis}{n}"] for n in range(4) for axis in "xy"]] = np.nan
    corners = [100.0, 60.0, 180.0, 60.0, 180.0, 100.0, 100.0, 100.0]
    at = SEARCH_INDEX["found_x0"]
    first[4, SEARCH_INDEX["looked"]], first[12, SEARCH_INDEX["looked"]] = 1.0, 1.0
    first[4, at : at + 8], first[4, SEARCH_INDEX["found_confidence"]] = corners, 0.8
    times = [first[n, INDEX["t"]] for n in (3, 4, 11, 12)] + [second[3, INDEX["t"]]]
    run = mission(site, [first, second])

    images = [picture(site, f"{run}/camera.jpg?truth=false&t={t}") for t in times]

    drawn = [int(is_pink(image).sum()) > 500 for image in images]
    assert drawn == [False, True, True, False, False]
    ys, xs = np.nonzero(is_pink(images[2]))
    assert xs.min() == pytest.approx(100, abs=5)
    assert ys.max() == pytest.approx(100, abs=5)


def is_pink(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    blue, green, red = (image[..., channel].astype(int) for channel in range(3))
    pink: NDArray[np.bool_] = (red > green + 60) & (blue > green + 50)
    return pink
