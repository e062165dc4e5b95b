"""Link previews: what other sites show of a page that somebody links to (Open Graph)."""

from collections.abc import Sequence
from dataclasses import dataclass

from flask import url_for

from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.solutions import entry_name
from seamark.server.runs.showing.views import RunView
from seamark.server.web.services import services
from seamark.server.web.template_filters import score, score_unit
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

HOME_TITLE = "Benchmarks for underwater robots"
HOME_SENTENCE = (
    "How well does your controller hold an underwater robot in a current? Upload it: it runs in a "
    "simulated sea that is the same for everyone, and others can reproduce its score bit for bit."
)


@dataclass(frozen=True, slots=True)
class LinkPreview:
    """Title and sentence of a page, its path and that of its picture."""

    title: str
    description: str
    path: str
    picture: str

    def absolute(self, path: str) -> str:
        """Return an address on the host of the settings; empty without one.

        Never on the host that a client sent, which may be anything.
        """
        return f"{services().settings.url}{path}" if services().settings.url else ""


def of_run(run: RunView) -> LinkPreview:
    """Return the preview of a run."""
    title = registry.benchmark(run.benchmark).title
    kind = f", {words}" if (words := qualifier(run)) else ""
    return LinkPreview(
        title=f"Run {run.id}: {entry_name(run)}",
        description=f"{title} ({run.benchmark}){kind}: {_result(run)}.",
        path=url_for("run.show", run_id=run.id),
        picture=url_for("link_preview_pictures.run_picture", run_id=run.id),
    )


def of_comparison(runs: Sequence[RunView], path: str) -> LinkPreview:
    """Return the preview of a comparison with its address."""
    shown = "; ".join(f"#{run.id} {entry_name(run)}, {_result(run)}" for run in runs)
    ids = ",".join(str(run.id) for run in runs)
    return LinkPreview(
        title=f"{len(runs)} runs side by side",
        description=f"{shown}.",
        path=path,
        picture=f"{url_for('link_preview_pictures.comparison_picture')}?runs={ids}",
    )


def of_benchmark(benchmark: Benchmark) -> LinkPreview:
    """Return the preview of the page of a benchmark."""
    return LinkPreview(
        title=f"Benchmark: {benchmark.title}",
        description=f"{benchmark.question} {benchmark.summary}",
        path=url_for("benchmark.show", name=benchmark.name),
        picture=url_for("link_preview_pictures.benchmark_picture", name=benchmark.name),
    )


def of_home() -> LinkPreview:
    """Return the preview of the home page."""
    return LinkPreview(
        title=HOME_TITLE,
        description=HOME_SENTENCE,
        path=url_for("home.show"),
        picture=url_for("link_preview_pictures.home_picture"),
    )


def of_leaderboard(benchmark: Benchmark, ranks: Sequence[Rank]) -> LinkPreview:
    """Return the preview of a leaderboard whose first rows are `ranks`."""
    best = next((rank for rank in ranks if not rank.is_baseline), None)
    unit = benchmark.headline.unit
    leader = f" {best.user} leads with {score(best.score)} {unit}." if best is not None else ""
    return LinkPreview(
        title=f"Leaderboard: {benchmark.title}",
        description=f"{benchmark.summary}{leader}",
        path=url_for("leaderboard.show", name=benchmark.name),
        picture=url_for("link_preview_pictures.leaderboard_picture", name=benchmark.name),
    )


def _result(run: RunView) -> str:
    if run.score is None:
        return run.state.value
    interval = ""
    if run.score_low is not None and run.score_high is not None:
        interval = f" ({score(run.score_low)} to {score(run.score_high)})"
    return f"{score(run.score)} {score_unit(run)}{interval}"
