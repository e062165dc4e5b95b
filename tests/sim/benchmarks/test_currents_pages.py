"""docs/benchmarks.md says of currents-v3 and of currents-v2 what the code does."""

from pathlib import Path

import pytest

from seamark.sim import registry
from seamark.sim.metrics.tool_point import CIRCLES_M, POWER_WEIGHT, TOOL_AHEAD_M
from seamark.sim.settings.setting import group_of
from seamark.sim.settings.trial_spreads import GROUP

PAGE = (Path(__file__).parents[3] / "docs" / "benchmarks.md").read_text(encoding="utf-8")
NAMES = ("currents-v3", "currents-v2")


def section(name: str) -> str:
    return " ".join(PAGE.split(f"\n## {name}\n")[1].split("\n## ")[0].split())


def listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values[:-1]) + f" and {values[-1]:g}"


@pytest.mark.parametrize("name", NAMES)
def test_the_table_has_every_setting_that_is_drawn_with_its_default(name: str) -> None:
    said, fields = section(name), registry.benchmark(name).configuration.model_fields
    drawn = {
        key: str(field.default).lower() for key, field in fields.items() if group_of(field) == GROUP
    }

    assert len(drawn) == 20
    assert [key for key, value in drawn.items() if f"| `{key}` | {value} |" not in said] == []


@pytest.mark.parametrize("name", NAMES)
def test_levels_circles_and_trials_are_those_of_the_code(name: str) -> None:
    benchmark = registry.benchmark(name)
    said, config, protocol = section(name), benchmark.read({}), benchmark.protocol

    assert protocol is not None
    assert f"mean currents of {listed(config.levels)} m/s" in said
    assert f"levels of {config.level_duration_s:g} s" in said
    assert f"watch circles r of {listed(CIRCLES_M)} m" in said
    assert f"(1 − {POWER_WEIGHT:g} P)" in said
    assert f"{TOOL_AHEAD_M:g} m ahead of its camera" in said
    assert f"{protocol.reference_trials} *reference trials* on the public seed 2026" in said
    assert f"then {protocol.fresh_trials} *fresh trials*" in said
