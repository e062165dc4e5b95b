"""Charts over the levels of runs side by side."""

from types import SimpleNamespace
from typing import Any

from seamark.server.runs.showing.compared_curves import compared_curves


def _run(precisions: list[float | None], benchmark: str = "patterns-v1") -> Any:
    depths = [2.0 * at for at in range(len(precisions))]
    levels = [{"level": at, "ap_percent": value} for at, value in enumerate(precisions)]
    metrics = {"levels": levels} if precisions else None
    config = {"optical_depths": depths} if depths else {}
    return SimpleNamespace(benchmark=benchmark, config=config, metrics=metrics)


def test_each_run_has_a_line_over_its_own_levels() -> None:
    (chart,) = compared_curves([_run([90.0, 40.0]), _run([80.0, None, 10.0]), _run([])])

    assert chart["title"] == "Average precision over the optical depth"
    assert [line["x"] for line in chart["lines"]] == [[0.0, 2.0], [0.0, 4.0], []]
    assert [line["values"] for line in chart["lines"]] == [[90.0, 40.0], [80.0, 10.0], []]


def test_without_any_metrics_or_of_several_benchmarks_there_is_no_chart() -> None:
    assert compared_curves([_run([]), _run([])]) == []
    assert compared_curves([_run([90.0]), _run([90.0], "visibility-v2")]) == []
