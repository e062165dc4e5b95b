"""The pages of the benchmarks: what each measures and how, then all its parameters."""

from pathlib import Path

from flask import Blueprint, render_template
from flask.typing import ResponseReturnValue

from seamark import templates
from seamark.server.pages.benchmark import form_fields
from seamark.server.pages.charts import plots
from seamark.server.pages.charts.plots import OnAxis
from seamark.server.pages.docs import guides
from seamark.server.pages.previews import link_previews
from seamark.server.runs.leaderboard import leaderboard, reference_entries, score_counts
from seamark.server.web import known_benchmarks
from seamark.server.web.services import services
from seamark.sim import registry, vehicles
from seamark.sim.physics import constants

page = Blueprint("benchmark", __name__, url_prefix="/benchmarks")
_PICTURES = Path(templates.__file__).parent / "static" / "benchmarks"


@page.get("/")
def index() -> ResponseReturnValue:
    """Show all benchmarks with their questions and leaders."""
    every = [registry.benchmark(name) for name in registry.BENCHMARKS]
    with services().database.reading() as session:
        leaders = leaderboard.leaders_of(session, every, 1)
        people = score_counts.sizes(session)
    entries = [
        {
            "benchmark": benchmark,
            "picture": has_picture(benchmark.name),
            "leader": next(iter(leaders[benchmark.name]), None),
            "people": people.get(benchmark.name, 0),
            "newer": known_benchmarks.newer_than(benchmark.name),
        }
        for benchmark in every
    ]
    return render_template("benchmark/index.html", entries=entries)


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show what a benchmark measures, and its parameters with unit, tag and source."""
    benchmark = known_benchmarks.by_name(name)
    config = benchmark.read({})
    explanation, contents = guides.section(guides.BENCHMARKS, name)
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
        newer=known_benchmarks.newer_than(name),
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


def has_picture(name: str) -> bool:
    """Return whether `./run performance benchmark_pictures` has drawn a benchmark."""
    return (_PICTURES / f"{name}.jpg").exists()
