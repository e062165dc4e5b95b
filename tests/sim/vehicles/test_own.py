"""A user's own vehicle: chosen by its file, named by its content, refused where it is unknown."""

import hashlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from seamark.sim.recording.manifest import manifest
from seamark.sim.registry import BENCHMARKS, VEHICLES, benchmark
from seamark.sim.settings.arm import NO_ARM
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles import added, is_known, load, own
from seamark.sim.vehicles.reading import VehicleInvalid

MINE = """
format = 1
name = "mine"
title = "Mine"
summary = "A BlueROV2 Heavy with a title of its own."
extends = "bluerov2-heavy"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(MINE, encoding="utf-8")
    return path


def test_a_vehicle_is_named_by_its_name_and_the_hash_of_its_file(file: Path) -> None:
    settings = own.resolved({"vehicle": str(file), "kp": 0.3})

    name = f"mine@{hashlib.sha256(MINE.encode()).hexdigest()[:16]}"
    assert settings == {"vehicle": name, "kp": 0.3}
    assert load(name).title == "Mine"
    assert own.file_of(name) == (hashlib.sha256(MINE.encode()).hexdigest(), MINE)


def test_a_changed_file_is_another_vehicle(file: Path) -> None:
    first = own.resolved({"vehicle": file})
    file.write_text(MINE.replace('"Mine"', '"Yours"'), encoding="utf-8")

    second = own.resolved({"vehicle": file})

    assert first != second
    assert [load(str(one["vehicle"])).title for one in (first, second)] == ["Mine", "Yours"]


@pytest.mark.parametrize("value", [*VEHICLES, "both", "", 3, None])
def test_settings_without_a_file_are_as_they_were(value: object) -> None:
    assert own.resolved({"vehicle": value, "kp": 1}) == {"vehicle": value, "kp": 1}
    assert own.resolved({"kp": 1}) == {"kp": 1}


WITH_VEHICLE = [
    name
    for name in BENCHMARKS
    if "vehicle" in (fields := benchmark(name).configuration.model_fields)
    and ("arm" not in fields or fields["arm"].default == NO_ARM)  # this one carries none
]


@pytest.mark.parametrize("name", WITH_VEHICLE)
def test_every_benchmark_with_a_vehicle_accepts_one_that_was_read(name: str, file: Path) -> None:
    chosen = own.resolved({"vehicle": file})
    config: Any = benchmark(name).read(chosen)

    assert config.for_trial(1).vehicle == chosen["vehicle"]
    assert chosen["vehicle"] not in str(benchmark(name).schema())


def test_the_defaults_of_a_vehicle_come_with_it_where_a_benchmark_has_them(file: Path) -> None:
    with_more = f"{MINE}\n[defaults]\ntilt_hold = true\nkp = 0.7\nno_such_setting = 1\n"
    file.write_text(with_more, encoding="utf-8")

    config: Any = benchmark("currents-v1").read(own.resolved({"vehicle": file, "ki": 0.01}))

    assert (config.tilt_hold, config.kp, config.ki) == (True, 0.7, 0.01)


@pytest.mark.parametrize("value", ["mine@0123456789abcdef", "mine.toml", "/etc/passwd.toml"])
def test_a_vehicle_that_was_not_read_is_refused_with_what_is_possible(value: str) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        benchmark("currents-v2").read({"vehicle": value})

    assert "must be one of both, girona500" in refused.value.errors["vehicle"]
    assert "A vehicle of your own is chosen by its file" in refused.value.errors["vehicle"]


def test_an_unknown_name_is_refused_without_that_hint() -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        benchmark("currents-v2").read({"vehicle": "submarine"})

    assert "of your own" not in refused.value.errors["vehicle"]


@pytest.mark.parametrize("name", VEHICLES)
def test_a_vehicle_cannot_take_the_name_of_one_of_ours(name: str) -> None:
    with pytest.raises(VehicleInvalid, match=f"name: {name} is a vehicle of Seamark"):
        own.add(VEHICLES[name].read_bytes())


def test_a_body_that_cannot_exist_is_not_added() -> None:
    inertia = '[body]\ninertia = { value = [9, 1, 1], unit = "kg m²", tag = "E", reason = "wrong" }'

    with pytest.raises(VehicleInvalid, match="triangle inequality"):
        own.add(f"{MINE}{inertia}".encode())


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "missing.toml", tmp_path):
        with pytest.raises(VehicleInvalid, match="The file cannot be read"):
            own.content_of(path)


def test_the_manifest_of_a_run_has_the_file_and_others_have_none(file: Path) -> None:
    entry = benchmark("currents-v1")
    facts: dict[str, Any] = {"seed": 1, "trials": 1, "controller": "pi", "digest": "0" * 64}

    mine = manifest("currents-v1", entry.read(own.resolved({"vehicle": file})), **facts)
    ours = manifest("currents-v1", entry.read({"vehicle": "girona500"}), **facts)

    sha256 = hashlib.sha256(MINE.encode()).hexdigest()
    assert mine["vehicle_file"] == {"sha256": sha256, "text": MINE}
    assert "vehicle_file" not in ours


def test_a_lent_vehicle_is_known_only_where_it_is_lent(file: Path) -> None:
    content = file.read_text("utf-8").replace('"mine"', '"lent"').encode()
    name = f"lent@{hashlib.sha256(content).hexdigest()[:16]}"
    with ThreadPoolExecutor(1) as another, own.lending(content) as lent:
        assert lent == name
        assert load(name).title == "Mine"
        assert benchmark("currents-v2").read({"vehicle": name})
        assert not another.submit(is_known, name).result()

    assert not is_known(name)
    with pytest.raises(LookupError):
        load(name)
    with pytest.raises(ConfigurationInvalid):
        benchmark("currents-v2").read({"vehicle": name})


def test_lent_vehicles_do_not_fill_the_memory_of_a_process(file: Path) -> None:
    for number in range(100):
        with own.lending(MINE.replace('"Mine"', f'"Mine {number}"').encode()):
            pass

    assert own.usable.cache_info().currsize <= 16
    assert not [name for name in added if name.startswith("mine@") and "Mine 9" in load(name).title]
