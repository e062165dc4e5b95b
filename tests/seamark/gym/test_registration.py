"""The environments follow from the registry of benchmarks; their names stay."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import seamark.gym
from seamark.sim import registry
from tests.additions.things import BENCHMARK

NAMES = """
import json, sys
from seamark.sim import registry
registry.BENCHMARKS["harbour-v1"] = "harbour_v1.definition:BENCHMARK"
import seamark.gym, gymnasium
print(json.dumps([gymnasium.spec("seamark/Harbour-v1").kwargs, "numba" in sys.modules]))
"""


def test_the_names_of_the_environments_are_those_of_the_guide() -> None:
    assert {
        "seamark/StationKeeping-v1": "currents-v1",
        "seamark/StationKeeping-v2": "currents-v2",
        "seamark/StationKeeping-v3": "currents-v3",
        "seamark/VisualTracking-v1": "visibility-v1",
        "seamark/VisualTracking-v2": "visibility-v2",
        "seamark/VisualTracking-v3": "visibility-v3",
        "seamark/Mission-v1": "mission-v1",
        "seamark/Track-v1": "track-v1",
        "seamark/Dock-v1": "dock-v1",
        "seamark/Recover-v1": "recover-v1",
        "seamark/Valve-v1": "valve-v1",
        "seamark/Connect-v1": "connect-v1",
    }.items() <= seamark.gym.BENCHMARKS.items()
    with_one = {name for name in registry.BENCHMARKS if registry.benchmark(name).role != "detector"}
    assert set(seamark.gym.BENCHMARKS.values()) == with_one


@pytest.mark.slow
def test_an_added_benchmark_has_an_environment_before_numba_is_loaded(tmp_path: Path) -> None:
    for name, text in BENCHMARK.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, "utf-8")

    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", NAMES],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert json.loads(done.stdout) == [{"benchmark": "harbour-v1"}, False]
