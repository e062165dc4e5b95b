"""The pages of the benchmarks: what each measures and how, then all its parameters."""

from flask import Blueprint, abort, redirect, render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.server.pages import form_fields, guides
from seamark.server.runs import submission
from seamark.server.web.services import services
from seamark.sim import registry, vehicles
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.physics import constants

page = Blueprint("benchmark", __name__, url_prefix="/benchmarks")
_GUIDE = "benchmarks.md"  # a section for each benchmark


@page.get("/")
def index() -> ResponseReturnValue:
    """Redirect to the first benchmark."""
    return redirect(url_for("benchmark.show", name=first().name))


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show what a benchmark measures, and its parameters with unit, tag and source."""
    benchmark = by_name(name)
    config = benchmark.read({})
    explanation, contents = guides.section(_GUIDE, name)
    return render_template(
        "benchmark/show.html",
        benchmark=benchmark,
        ranked_trials=submission.ranked_trials(benchmark, services().settings),
        benchmarks=labels(),
        explanation=explanation,
        contents=contents,
        levels=len(config.level_values()),
        duration_s=config.trial_duration_s(),
        groups=form_fields.groups(benchmark.schema(), {}, {}, order=benchmark.groups),
        tags=vehicles.TAGS,
        vehicles=[vehicles.load(entry) for entry in registry.VEHICLES],
        constants_of=constants.GROUPS,
    )


def first() -> Benchmark:
    """Return the default benchmark."""
    return registry.benchmark(next(iter(registry.BENCHMARKS)))


def by_name(name: str) -> Benchmark:
    """Return a benchmark, or end the request with 404."""
    if name not in registry.BENCHMARKS:
        abort(404)
    return registry.benchmark(name)


def labels() -> dict[str, str]:
    """Return name -> title of all benchmarks."""
    return {name: registry.benchmark(name).title for name in registry.BENCHMARKS}
