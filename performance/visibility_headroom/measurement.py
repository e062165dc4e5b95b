"""Trials of the entries of visibility-v2, in parallel processes."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

from performance.visibility_attacks import Path as CornerPath
from performance.visibility_attacks import Playback, Remembering, stored_paths
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.registry import benchmark
from seamark.sim.trackers import declaration, make

NAME = "visibility-v2"
FILE = Path(__file__).parents[1] / "visibility_headroom.json"
REFERENCE_TRIALS = 8
OTHER_TRIALS = 24  # each of the eight textures three times
OTHER_SEED = 770_001  # trial i has this seed plus i


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A solution: its title, settings, and what makes it if it is not the built-in tracker."""

    title: str
    config: dict[str, object]
    make: Callable[[Any], Any]  # configuration -> solution


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What an entry scored."""

    title: str
    reference: dict[str, Any]  # of metrics.json of the reference trials: see `_kept`
    other: dict[str, Any]  # and of those with other seeds
    scores: Sequence[float]  # of all trials, the reference trials first


def _reference(name: str) -> Callable[[Any], Any]:
    return lambda config: benchmark(NAME).load().built_in(name, config)


def _remembering(config: Any) -> Remembering:
    return Remembering(make(config.tracker, truth=None, **config.tracker_options()))


def reference_seed() -> int:
    """Return the seed of the reference trials."""
    protocol = benchmark(NAME).protocol
    return 0 if protocol is None else protocol.reference_seed


@cache  # once per process
def _reference_paths() -> dict[bytes, CornerPath]:
    return stored_paths(NAME, seed=reference_seed(), trials=REFERENCE_TRIALS)


def _playback(_config: Any) -> Playback:
    return Playback(_reference_paths())


def entries() -> dict[str, Entry]:
    """Return the marks of the leaderboard, and what else is compared with them, by short names."""
    found = {
        name: Entry(title=mark.title, config=dict(mark.config), make=_reference(mark.built_in))
        for name, mark in benchmark(NAME).baselines.items()
    }
    built_in = _reference("built-in")
    found["playback"] = Entry(title="Playback of the reference trials", config={}, make=_playback)
    found["remembers"] = Entry(
        title="ZNCC, homography, remembers the path", config={}, make=_remembering
    )
    found["kcf"] = Entry(title="KCF", config={"tracker": "kcf"}, make=built_in)
    found["ssd-homography"] = Entry(
        title="Template tracker, SSD, homography", config={"criterion": "ssd"}, make=built_in
    )
    found["mi-srt"] = Entry(
        title="Template tracker, MI, SRT", config={"criterion": "mi", "warp": "srt"}, make=built_in
    )
    if not declaration("visp").unavailable():
        found["visp"] = Entry(
            title="ViSP, ZNCC, homography", config={"tracker": "visp"}, make=built_in
        )
    return found


class _Job(NamedTuple):
    """One trial of one entry."""

    entry: str
    trial: int
    seed: int


def measure(name: str, processes: int) -> Measured:
    """Run an entry on the reference trials and on others; results do not depend on `processes`."""
    entry = entries()[name]
    known = [_Job(name, trial, reference_seed()) for trial in range(REFERENCE_TRIALS)]
    other = [_Job(name, trial, OTHER_SEED + trial) for trial in range(OTHER_TRIALS)]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        results = pool.map(_run, [*known, *other], chunksize=1)
    config = benchmark(NAME).read(entry.config)
    return Measured(
        title=entry.title,
        reference=_kept(summarise(NAME, config, results[:REFERENCE_TRIALS])),
        other=_kept(summarise(NAME, config, results[REFERENCE_TRIALS:])),
        scores=[result.score for result in results],
    )


def _run(job: _Job) -> TrialResult:
    entry = entries()[job.entry]
    config = benchmark(NAME).read(entry.config)
    solution = entry.make(config)
    return run_trial(
        NAME, config, solution, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )


def _kept(metrics: dict[str, Any]) -> dict[str, Any]:
    """Return the part of metrics.json that table and figures show."""
    names = ("axis", "value", "p5_percent", "p1_percent")
    levels = [{name: level[name] for name in names} for level in metrics["levels"]]
    kept = {name: metrics[name] for name in ("score", "score_low", "score_high", "overall")}
    return kept | {"levels": levels}


def stored() -> dict[str, Measured]:
    """Return what was measured, by the short names of the entries."""
    found = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    return {key: Measured(**one) for key, one in found.items()}
