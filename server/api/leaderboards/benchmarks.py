"""Benchmarks, each with the JSON Schema of its configuration."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import BenchmarkPath, BenchmarkResponse, BenchmarksResponse
from seamark.server.web.problems import Problem
from seamark.sim import registry

api = APIBlueprint(
    "api_benchmarks",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Benchmarks", description="The benchmarks and their settings.")],
)


@api.get("/benchmarks", responses={200: BenchmarksResponse})
def list_all() -> dict[str, Any]:
    """List the benchmarks."""
    return {"benchmarks": [_summary(name) for name in registry.BENCHMARKS]}


@api.get("/benchmarks/<string:benchmark>", responses={200: BenchmarkResponse})
def show(path: BenchmarkPath) -> dict[str, Any]:
    """Return a benchmark with the JSON Schema of its configuration."""
    check(path.benchmark)
    benchmark = registry.benchmark(path.benchmark)
    metric = benchmark.headline
    return _summary(path.benchmark) | {
        "compares": benchmark.participants,
        "headline": {
            "name": metric.name,
            "label": metric.label,
            "unit": metric.unit,
            "better": metric.better,
        },
        "charts": [
            {"title": chart.title, "unit": chart.unit, "columns": list(chart.columns)}
            for chart in benchmark.charts
        ],
        "role": benchmark.role,
        "starting_points": {
            name: asdict(point) for name, point in benchmark.starting_points.items()
        },
        "controllers": dict(benchmark.built_in),
        "ranked_trials": benchmark.ranked_trials,
        "protocol": None if benchmark.protocol is None else asdict(benchmark.protocol),
        "schema": benchmark.schema(),
    }


def check(name: str) -> None:
    """Raise Problem if there is no such benchmark."""
    if name not in registry.BENCHMARKS:
        known = ", ".join(registry.BENCHMARKS)
        raise Problem("not-found", f"There is no benchmark of that name; choose one of {known}.")


def _summary(name: str) -> dict[str, Any]:
    benchmark = registry.benchmark(name)
    links = {"self": f"/api/v1/benchmarks/{name}", "leaderboard": f"/api/v1/leaderboards/{name}"}
    return {"name": name, "title": benchmark.title, "summary": benchmark.summary, "links": links}
