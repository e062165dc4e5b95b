"""The registry is light, and every entry is complete."""

import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name

import pytest

from seamark import sim
from seamark.sim import registry, vehicles
from seamark.sim.engine.program import Controller
from seamark.sim.trackers import declaration, option_names

DOCS = Path(sim.__file__).resolve().parents[1] / "docs"


@pytest.mark.parametrize("name", registry.TRACKERS)
def test_every_option_of_a_tracker_is_a_setting_with_its_default_and_help(name: str) -> None:
    properties = registry.benchmark("currents-v1").schema()["properties"]

    assert set(option_names(name)) <= set(properties)
    for option in declaration(name).options:
        entry = properties[option.name]
        assert (entry["default"], entry["title"]) == (option.default, option.title)
        assert entry["description"]


@pytest.mark.parametrize("name", registry.TRACKERS)
def test_the_defaults_of_a_tracker_are_allowed(name: str) -> None:
    defaults = {option.name: option.default for option in declaration(name).options}

    assert {
        option.name for option in declaration(name).options if option.error(option.default)
    } == (set())
    assert len(defaults) == len(option_names(name))


@pytest.mark.parametrize("name", registry.TRACKERS)
def test_every_tracker_has_a_label_and_is_documented(name: str) -> None:
    assert declaration(name).label
    assert f"`{name}`" in DOCS.joinpath("trackers.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_a_benchmark_has_the_name_of_its_entry_and_says_what_it_is(name: str) -> None:
    benchmark = registry.benchmark(name)

    assert benchmark.name == name
    assert benchmark.title
    assert benchmark.summary
    assert benchmark.built_in
    assert benchmark.metric_groups


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_the_form_groups_of_a_benchmark_are_those_of_its_settings(name: str) -> None:
    benchmark = registry.benchmark(name)

    used = [entry["x-group"] for entry in benchmark.schema()["properties"].values()]

    assert list(dict.fromkeys(used)) == list(benchmark.groups)


@pytest.mark.parametrize("name", registry.VEHICLES)
def test_a_vehicle_has_the_name_of_its_entry_and_a_title(name: str) -> None:
    vehicle = vehicles.load(name)

    assert vehicle.name == name
    assert vehicle.title
    assert vehicle.summary


@pytest.mark.parametrize("name", [*registry.CONTROLLERS, *registry.REFERENCE_CONTROLLERS])
def test_a_controller_has_a_label_and_the_public_interface(name: str) -> None:
    controller: type[Controller] = resolve_name(registry.controller_path(name))

    assert controller.label
    assert callable(controller.reset)
    assert callable(controller.step)


def test_every_entry_loads() -> None:
    registry.load_all()


@pytest.mark.slow
def test_forms_need_neither_numba_nor_opencv() -> None:
    code = (
        "import sys; from seamark.sim.registry import BENCHMARKS, benchmark;"
        "[benchmark(name).schema() for name in BENCHMARKS];"
        "print([name for name in ('numba', 'cv2', 'pybullet', 'scipy') if name in sys.modules])"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "[]"


def test_an_unknown_benchmark_is_a_key_error() -> None:
    with pytest.raises(KeyError):
        registry.benchmark("currents-v0")


def test_the_newest_version_is_the_highest_number_of_the_same_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(registry, "BENCHMARKS", dict.fromkeys(("a-v9", "a-v10", "a-b-v11"), ""))

    assert [registry.newest_version(one) for one in ("a-v9", "a-v10", "a-b-v11")] == [
        "a-v10",
        "a-v10",
        "a-b-v11",
    ]
