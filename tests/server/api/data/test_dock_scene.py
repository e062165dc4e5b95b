"""The scene of a run in which a dock is entered."""

from typing import Any

import numpy as np

from seamark.sim import registry
from tests.server.api.conftest import Site

LEVELS = {"levels": [0.0], "level_duration_s": 4.0}
SEED = 3


def test_the_scene_has_the_tubes_of_the_dock_around_its_marker(site: Site) -> None:
    claim = site.running(benchmark="dock-v1", controller="straight", config=LEVELS, seed=SEED)
    assert site.finish(claim)

    scene = site.call("owner", "GET", f"/api/v1/runs/{claim.run_id}/scene.json").get_json()

    config: Any = registry.benchmark("dock-v1").read(LEVELS)
    experiment: Any = registry.benchmark("dock-v1").load()
    target = experiment.target(config, seed=SEED, trial=0)
    (cage,) = scene["workpiece"]["things"]
    shapes = [solid["shape"] for link in cage["links"] for solid in link["solids"]]
    assert shapes.count("capsule") > 20
    assert shapes.count("sphere") == 4
    assert all(link["joint"] is None for link in cage["links"])
    face = scene["workpiece"]["face"]
    assert face["link"] is None
    assert np.allclose(face["corners"], target.top_corners())
