"""The pictures of link previews: of a run, of a comparison, of a leaderboard.

Each takes some tens of milliseconds; the last ones are kept. Loads OpenCV: import it late.
"""

import textwrap
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path

import cv2
import numpy as np

from seamark import templates
from seamark.sandbox.printable_text import printable_text
from seamark.server.programs import own_files
from seamark.server.runs.data import stored_files
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.record.solutions import entry_name, team
from seamark.server.runs.showing import camera_view, overlaid_series
from seamark.server.runs.showing.compared_curves import compared_curves
from seamark.server.runs.showing.overlaid_series import Part
from seamark.server.runs.showing.picture_canvas import MUTED, RUNS, Box, Canvas, Line
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

KEPT = 64  # pictures of about 100 KB in each process
POINTS = 800  # of a line: one for each pixel or so
MOMENT = 0.9  # share of a run whose camera image is shown: the levels are hardest at the end
CLEAR_MOMENT = 0.08  # likewise of a detector: at the end there is nothing to be seen
_MARGIN = 48  # [px]
_LINE_CHARACTERS = 30  # that fit beside a picture
_STATIC = Path(templates.__file__).parent / "static"
_kept: OrderedDict[Hashable, bytes] = OrderedDict()
# The canvas has a font that threads cannot share, and drawing should not take all cores.
_lock = threading.Lock()


def of_run(settings: Settings, run: RunView) -> bytes:
    """Return the picture of a run: its camera, its error over time, its score."""
    return _once(("run", run.id, run.version), lambda: _draw_run(settings, run))


def of_comparison(settings: Settings, runs: Sequence[RunView]) -> bytes:
    """Return the picture of a comparison: the error of each run over time, and the scores."""
    key = ("comparison", *((run.id, run.version) for run in runs))
    return _once(key, lambda: _draw_comparison(settings, runs))


def of_leaderboard(benchmark: Benchmark, ranks: Sequence[Rank]) -> bytes:
    """Return the picture of a leaderboard: up to six rows as bars."""
    key = ("leaderboard", benchmark.name, *((rank.run_id, rank.rank, rank.user) for rank in ranks))
    return _once(key, lambda: _draw_leaderboard(benchmark, ranks))


def of_benchmark(benchmark: Benchmark) -> bytes:
    """Return the picture of a benchmark: what its camera sees, and its question."""
    picture = _STATIC / "benchmarks" / f"{benchmark.name}.jpg"
    texts = (benchmark.title, benchmark.name, benchmark.question)
    return _once(("benchmark", benchmark.name), lambda: _draw_illustrated(*texts, picture))


def of_home(title: str, sentence: str) -> bytes:
    """Return the picture of the home page: the scene of the recorded run, and what Seamark is."""
    picture = _STATIC / "demo" / "still.webp"
    return _once(("home",), lambda: _draw_illustrated(title, "", sentence, picture))


def _once(key: Hashable, draw: Callable[[], bytes]) -> bytes:
    """Return a kept picture, or draw it; one at a time."""
    with _lock:
        if key not in _kept:
            _kept[key] = draw()
        _kept.move_to_end(key)
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
        return _kept[key]


def _draw_run(settings: Settings, run: RunView) -> bytes:
    canvas, width = Canvas(), 500
    _head(
        canvas,
        f"Run {run.id}: {entry_name(run)}",
        registry.benchmark(run.benchmark).title,
    )
    picture = _camera(settings, run)
    if picture is not None:
        canvas.paste(picture, Box(_MARGIN, 190, 560, 392))
    chart = Box(1200 - _MARGIN - width, 330, width, 252)
    canvas.text(team(run), (chart.x, 230), 34, width=width, bold=True)
    canvas.text(_score(run), (chart.x, 280), 30, width=width)
    title, lines = _lines(settings, [run])
    canvas.chart(chart, lines)
    canvas.text(title, (chart.x, 318), 20, width=width, colour=MUTED)
    return canvas.jpeg()


def _draw_comparison(settings: Settings, runs: Sequence[RunView]) -> bytes:
    canvas = Canvas()
    _head(canvas, f"{len(runs)} runs side by side", registry.benchmark(runs[0].benchmark).title)
    chart, legend = Box(_MARGIN, 220, 700, 362), 800
    title, lines = _lines(settings, runs)
    canvas.chart(chart, lines)
    canvas.text(title, (chart.x, 206), 20, width=chart.width, colour=MUTED)
    for index, run in enumerate(runs):
        y = 240 + 74 * index
        canvas.panel(Box(legend - 26, y - 20, 14, 44), RUNS[index])
        name = f"#{run.id} {entry_name(run)}"
        canvas.text(name, (legend, y), 26, width=1200 - legend - _MARGIN, bold=True)
        canvas.text(_score(run), (legend, y + 28), 20, width=350, colour=MUTED)
    return canvas.jpeg()


def _draw_leaderboard(benchmark: Benchmark, ranks: Sequence[Rank]) -> bytes:
    canvas = Canvas()
    _head(canvas, "Leaderboard", benchmark.title)
    name, bar = _MARGIN, Box(560, 0, 470, 34)
    scale = bar.width / max([benchmark.score_bar_max, *(rank.score for rank in ranks)])
    for index, rank in enumerate(ranks):
        y = 236 + 62 * index
        place = f"{rank.rank}. {rank.user}" if rank.rank else rank.title
        canvas.text(place, (name, y), 28, width=bar.x - name - 24, bold=rank.rank is not None)
        canvas.panel(Box(bar.x, y - 25, bar.width, bar.height))
        length = max(round(rank.score * scale), 2)
        canvas.panel(Box(bar.x, y - 25, length, bar.height), RUNS[0] if rank.rank else MUTED)
        canvas.text(f"{rank.score:.4g}", (bar.x + bar.width + 20, y), 28, width=110)
    if not ranks:
        canvas.text("No entries yet: be the first.", (name, 236), 30, width=900)
    return canvas.jpeg()


def _draw_illustrated(title: str, subtitle: str, sentence: str, file: Path) -> bytes:
    canvas, text = Canvas(), Box(672, 222, 1200 - 672 - _MARGIN, 44)
    _head(canvas, title, subtitle)
    if file.exists():
        picture = np.asarray(cv2.imread(str(file)), np.uint8)
        canvas.paste(picture, Box(_MARGIN, 190, 588, 392))
    for line, words in enumerate(textwrap.wrap(sentence, _LINE_CHARACTERS)):
        canvas.text(words, (text.x, text.y + line * text.height), 30, width=text.width)
    return canvas.jpeg()


def _head(canvas: Canvas, title: str, subtitle: str) -> None:
    canvas.panel(Box(0, 0, 1200, 8), RUNS[0])
    shown = printable_text(title)
    canvas.text(shown, (_MARGIN, 90), 50, width=1200 - 2 * _MARGIN, bold=True)
    canvas.text(subtitle, (_MARGIN, 142), 28, width=860, colour=MUTED)
    canvas.text("Seamark", (1200 - _MARGIN - 150, 142), 32, width=170, bold=True)


def _score(run: RunView) -> str:
    if run.score is None:
        return f"No score: {run.state.value}"
    benchmark = registry.benchmark(run.benchmark)
    headline = benchmark.headline_of(benchmark.restore(run.config))
    return f"{headline.label} {run.score:.4g} {headline.unit}"


def _camera(settings: Settings, run: RunView) -> camera_view.Image | None:
    benchmark = registry.benchmark(run.benchmark)
    share = CLEAR_MOMENT if benchmark.error_column is None else MOMENT
    t = share * benchmark.trial_duration_s(benchmark.restore(run.config))
    encoded = camera_view.render(settings, run, trial=0, t=t)
    if encoded is None:
        return None
    decoded = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR)
    return None if decoded is None else decoded.astype(np.uint8, copy=False)


def _lines(settings: Settings, runs: Sequence[RunView]) -> tuple[str, list[tuple[Line, Line]]]:
    """Return the title of the first chart of the first run, and its lines in the first trial.

    Where no column of the telemetry is the error, the chart is that over the levels, if there is
    one.
    """
    benchmark = registry.benchmark(runs[0].benchmark)
    curves = compared_curves(runs) if benchmark.error_column is None else []
    for curve in curves[:1]:
        lines = [(np.array(line["x"]), np.array(line["values"])) for line in curve["lines"]]
        return f"{curve['title']} [{curve['unit']}]", lines
    with own_files.lent_to(settings, runs[0]):
        chart = benchmark.charts_of(benchmark.restore(runs[0].config))[0]
    lines = []
    for run in runs:
        files = stored_files.of_run(settings, run)
        overlaid = overlaid_series.series(run, files, chart.columns[:1], Part(), POINTS)
        lines.append((overlaid.t, overlaid.values[:, 0]))
    return f"{chart.title} [{chart.unit}] over time, trial 1", lines
