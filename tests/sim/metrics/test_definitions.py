"""The page about measures names all that a run ends with."""

from pathlib import Path
from typing import Any

import pytest

from seamark import sim
from seamark.sim.engine.trial import run_trial, summarise
from seamark.sim.metrics import definitions
from seamark.sim.metrics.definitions import FORMULAS, TABLES
from seamark.sim.registry import BENCHMARKS, benchmark

PAGE = (
    Path(sim.__file__)
    .resolve()
    .parents[1]
    .joinpath("docs", "measures.md")
    .read_text(encoding="utf-8")
)


def test_the_tables_of_the_page_are_those_that_the_code_makes() -> None:
    assert definitions.markdown() in PAGE


def test_every_metric_has_one_formula_and_no_formula_is_left_over() -> None:
    names = [metric.name for table in TABLES.values() for metric in table]

    assert sorted(names) == sorted(FORMULAS)


def named_in(value: Any) -> set[str]:
    if isinstance(value, dict):
        return set(value).union(*map(named_in, value.values()))
    return set().union(*map(named_in, value)) if isinstance(value, list) else set()


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_name_in_metrics_json_stands_on_the_page(name: str) -> None:
    entry = benchmark(name)
    values: dict[str, object] = {**entry.quick_settings, "score": "2 * distance"}
    if name == "currents-v1":
        values |= {"loop1": "repeat", "loop1_values": [1]}
    config = entry.read(values)
    solution = entry.load().built_in(next(iter(entry.built_in)), config)
    result = run_trial(name, config, solution, seed=0, trial=0, on_rows=lambda _rows: None)

    names = named_in(summarise(name, config, [result])) - {"benchmark", "current_speed", "repeat"}

    assert [name for name in names if f"`{name.removeprefix('whole_')}`" not in PAGE] == []
