"""docs/benchmarks.md says of currents-v3 what the code does."""

from pathlib import Path

from seamark.sim.benchmarks.currents_v3.definition import BENCHMARK
from seamark.sim.benchmarks.currents_v3.settings import CurrentsConfiguration
from seamark.sim.metrics.tool_point import CIRCLES_M, POWER_WEIGHT, TOOL_AHEAD_M
from seamark.sim.settings.setting import group_of
from seamark.sim.settings.trial_spreads import GROUP

PAGE = (Path(__file__).parents[4] / "docs" / "benchmarks.md").read_text(encoding="utf-8")
SECTION = " ".join(PAGE.split("\n## currents-v3\n")[1].split("\n## ")[0].split())


def listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values[:-1]) + f" and {values[-1]:g}"


def test_the_table_has_every_setting_that_is_drawn_with_its_default() -> None:
    fields = CurrentsConfiguration.model_fields
    drawn = {
        name: str(field.default).lower()
        for name, field in fields.items()
        if group_of(field) == GROUP
    }

    assert len(drawn) == 20
    assert [name for name, value in drawn.items() if f"| `{name}` | {value} |" not in SECTION] == []


def test_levels_circles_and_trials_are_those_of_the_code() -> None:
    config, protocol = CurrentsConfiguration.read({}), BENCHMARK.protocol

    assert protocol is not None
    assert f"mean currents of {listed(config.levels)} m/s" in SECTION
    assert f"levels of {config.level_duration_s:g} s" in SECTION
    assert f"watch circles r of {listed(CIRCLES_M)} m" in SECTION
    assert f"(1 − {POWER_WEIGHT:g} P)" in SECTION
    assert f"{TOOL_AHEAD_M:g} m ahead of its camera" in SECTION
    assert f"{protocol.reference_trials} *reference trials* on the public seed 2026" in SECTION
    assert f"then {protocol.fresh_trials} *fresh trials*" in SECTION
