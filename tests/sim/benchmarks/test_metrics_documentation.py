"""docs/measures.md documents every metric of every benchmark."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark import sim
from seamark.sim.benchmarks.metrics_documentation import markdown, metric_groups
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics import station_keeping
from seamark.sim.metrics.metric import MetricGroup, over_run
from seamark.sim.metrics.windows import LevelFacts
from seamark.sim.recording.telemetry import INDEX, WIDTH
from seamark.sim.registry import BENCHMARKS, benchmark

PAGE = (
    Path(sim.__file__)
    .resolve()
    .parents[1]
    .joinpath("docs", "measures.md")
    .read_text(encoding="utf-8")
)
DECLARATION = """
from seamark.sim.metrics.metric import SUM, LevelMetric

METRIC = LevelMetric(
    name="outside_s",
    label="Time outside 1 m",
    unit="s",
    better="lower",
    formula="control steps with d > 1 m, times dt",
    over=SUM,
    compute=lambda window: sum(d > 1.0 for d in window.distance_m) * window.dt,
)
"""


def test_the_tables_of_the_page_are_generated_from_the_declarations() -> None:
    assert PAGE.endswith(f"\n\n{markdown(metric_groups())}\n")


def test_no_two_metrics_have_the_same_name() -> None:
    names = [metric.name for group in metric_groups() for metric in group.metrics]

    assert len(names) > 45
    assert len(names) == len(set(names))


def test_every_metric_has_a_label_a_formula_and_an_aggregation() -> None:
    incomplete = [
        metric.name
        for group in metric_groups()
        for metric in group.metrics
        if not (metric.label and metric.formula and metric.over.description)
    ]

    assert incomplete == []


def names_in(value: Any) -> set[str]:
    if isinstance(value, dict):
        return set(value).union(*map(names_in, value.values()))
    return set().union(*map(names_in, value)) if isinstance(value, list) else set()


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_name_in_metrics_json_is_documented(name: str) -> None:
    entry = benchmark(name)
    values: dict[str, object] = {**entry.quick_settings, "score": "2 * distance"}
    if "loop1" in entry.configuration.model_fields:
        values |= {"loop1": "repeat", "loop1_values": [1]}
    config = entry.read(values)
    solution = entry.load().built_in(next(iter(entry.built_in)), config.for_trial(0))
    result = run_trial(name, config, solution, seed=0, trial=0, on_rows=lambda _rows: None)

    trials = 1 if entry.protocol is None else entry.protocol.trials
    summary = summarise(name, config, [result] * trials, ranked=True)
    names = names_in(summary) - {"benchmark", "current_speed", "repeat"}

    assert ("gap" in names) == (entry.protocol is not None)
    assert len(names) > 20
    assert [name for name in names if f"`{name.removeprefix('whole_')}`" not in PAGE] == []


def test_a_new_metric_is_one_declaration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tmp_path.joinpath("outside.py").write_text(DECLARATION)
    monkeypatch.syspath_prepend(tmp_path)
    metrics = (*station_keeping.METRICS, importlib.import_module("outside").METRIC)
    facts = LevelFacts(level=0, speed=0.1, dt=0.5, settle_s=1.0, limits_n=(100.0, 100.0))
    rows = np.zeros((4, WIDTH))
    rows[:, INDEX["distance"]] = [2.0, 2.0, 2.0, 0.5]

    level = station_keeping.level_metrics(rows, facts, metrics)
    run = over_run(station_keeping.overall(metrics), [level, level])
    page = markdown([MetricGroup("Position controllers", metrics)])

    assert (level["outside_s"], level["whole_outside_s"]) == (0.5, 1.5)
    assert (run["outside_s"], run["whole_outside_s"]) == (1.0, 3.0)
    row = "| `outside_s` | Time outside 1 m | s | control steps with d > 1 m, times dt "
    assert f"{row}| sum of the levels |" in page
