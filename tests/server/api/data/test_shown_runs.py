"""What the page of a run asks for, of a short run of every benchmark that really ran."""

from functools import cache
from typing import Any

import cv2
import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.maps import map_of
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import Rows
from tests.server.api.conftest import Site

SEED = 3


def _built_in(entry: Benchmark) -> str:
    return next(iter(entry.built_in))


@cache
def _rows(name: str) -> Rows:
    entry = registry.benchmark(name)
    config: Any = entry.read(entry.quick_settings)
    program = entry.load().built_in(_built_in(entry), config.for_trial(0))
    parts: list[Rows] = []
    run_trial(
        *(name, config, program),
        seed=SEED,
        trial=0,
        on_rows=lambda rows: parts.append(rows.copy()),
    )
    return np.concatenate(parts)


@pytest.fixture(params=registry.BENCHMARKS)
def shown(request: pytest.FixtureRequest, site: Site) -> tuple[Benchmark, str]:
    """A benchmark, and the address of a run of it."""
    entry = registry.benchmark(request.param)
    claim = site.running(
        benchmark=entry.name,
        controller=_built_in(entry),
        config=dict(entry.quick_settings),
        seed=SEED,
    )
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(_rows(entry.name))
    assert site.finish(claim)
    return entry, f"/api/v1/runs/{claim.run_id}"


def test_all_columns_of_its_charts_are_given(shown: tuple[Benchmark, str], site: Site) -> None:
    entry, run = shown
    charts = entry.charts_of(entry.read(entry.quick_settings))
    columns = {column for chart in charts for column in chart.columns}

    answer = site.call("owner", "GET", f"{run}/series.json?columns={','.join(sorted(columns))}")

    assert answer.status_code == 200, answer.text
    assert {*answer.get_json()["columns"]} >= columns


def test_the_camera_shows_more_than_one_brightness(
    shown: tuple[Benchmark, str], site: Site
) -> None:
    _entry, run = shown

    answer = site.call("owner", "GET", f"{run}/camera.jpg?t=1")

    assert answer.status_code == 200, answer.text
    image = cv2.imdecode(np.frombuffer(answer.data, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    assert int(image.max()) - int(image.min()) > 10


def test_the_scene_is_given(shown: tuple[Benchmark, str], site: Site) -> None:
    _entry, run = shown

    answer = site.call("owner", "GET", f"{run}/scene.json")

    assert answer.status_code == 200, answer.text


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_only_a_search_and_a_route_have_a_map(name: str) -> None:
    columns = telemetry.names(_rows(name).shape[1])

    assert map_of(columns) == {"mission-v1": "search", "track-v1": "route"}.get(name)
