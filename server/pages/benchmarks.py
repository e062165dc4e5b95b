"""The pages of the benchmarks: what each measures and how, then all its parameters."""

from pathlib import Path

from flask import Blueprint, abort, render_template
from flask.typing import ResponseReturnValue

from seamark import templates
from seamark.server.pages import form_fields, guides, link_previews, plots
from seamark.server.pages.plots import OnAxis
from seamark.server.runs.leaderboard import leaderboard, reference_entries, score_counts
from seamark.server.runs.submission import submission
from seamark.server.web.services import services
from seamark.sim import registry, vehicles
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.physics import constants

page = Blueprint("benchmark", __name__, url_prefix="/benchmarks")
_PICTURES = Path(templates.__file__).parent / "static" / "benchmarks"
GUIDE = "benchmarks.md"  # a section for each benchmark


@page.get("/")
def index() -> ResponseReturnValue:
    """Show all benchmarks with their questions and leaders."""
    every = [registry.benchmark(name) for name in registry.BENCHMARKS]
    with services().database.reading() as session:
        leaders = leaderboard.leaders_of(session, every, 1)
        people = score_counts.sizes(session)
    found = [
        {
            "benchmark": benchmark,
            "picture": has_picture(benchmark.name),
            "leader": next(iter(leaders[benchmark.name]), None),
            "people": people.get(benchmark.name, 0),
        }
        for benchmark in every
    ]
    return render_template("benchmark/index.html", found=found)


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show what a benchmark measures, and its parameters with unit, tag and source."""
    benchmark = by_name(name)
    config = benchmark.read({})
    explanation, contents = guides.section(GUIDE, name)
    with services().database.reading() as session:
        leader = next(iter(leaderboard.leaders(session, benchmark, 1)), None)
        people = score_counts.size(session, name)
        marks = reference_entries.entries(session, benchmark)
        pending = reference_entries.are_pending(session, benchmark, marks)
    rows: list[OnAxis] = sorted([*marks, *([leader] if leader else [])], key=lambda row: -row.score)
    return render_template(
        "benchmark/show.html",
        benchmark=benchmark,
        picture=has_picture(name),
        ranked_trials=submission.ranked_trials(benchmark, services().settings),
        benchmarks=labels(),
        sections=guides.folded(explanation),
        leader=leader,
        people=people,
        rows=rows,
        pending=pending,
        axis=plots.score_axis(rows, (), whole=True),
        contents=contents,
        levels=len(config.level_values()),
        duration_s=config.trial_duration_s(),
        groups=form_fields.groups(benchmark.schema(), {}, {}, order=benchmark.groups),
        tags=vehicles.TAGS,
        vehicles=[vehicles.load(entry) for entry in registry.VEHICLES],
        constants_of=constants.GROUPS,
        preview=link_previews.of_benchmark(benchmark),
    )


def first() -> Benchmark:
    """Return the default benchmark."""
    return registry.benchmark(next(iter(registry.BENCHMARKS)))


def by_name(name: str) -> Benchmark:
    """Return a benchmark, or end the request with 404."""
    if name not in registry.BENCHMARKS:
        abort(404)
    return registry.benchmark(name)


def has_picture(name: str) -> bool:
    """Return whether `./run performance benchmark_pictures` has drawn a benchmark."""
    return (_PICTURES / f"{name}.jpg").exists()


def labels() -> dict[str, str]:
    """Return name -> title of all benchmarks."""
    return {name: registry.benchmark(name).title for name in registry.BENCHMARKS}
