"""What programs score that do not look: constant, saturated, oscillating and random ones.

    ./run performance adversaries [BENCHMARK ...] [--trials N] [--seed S]

Prints a Markdown table for each benchmark, by default one of controllers and one of trackers, with
the ranked scenario. None of these may come near an honest entry; the built-in solutions are there
to compare with.
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from performance.tables import markdown_table
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.program import Command
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial
from seamark.sim.registry import benchmark
from seamark.sim.trackers.interface import Corners, Track, Window

LIMIT_M_S = 5.0  # far above what any vehicle can do
SEED = 1001  # not the reference seed, so that public water is not what is measured
TRIALS = 4
Image = NDArray[np.uint8]


class Timed:
    """A controller that knows the time since the level's start and nothing else."""

    def __init__(self, command: Callable[[float], Command]) -> None:
        self._command, self._step, self._dt = command, 0, 0.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Start the clock."""
        self._step, self._dt = 0, float(level["dt"])

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return the command for the present time; the observation is ignored."""
        self._step += 1
        return self._command(self._step * self._dt)


def oscillating(period_s: float) -> Callable[[float], Command]:
    """Return full commands on all axes that change their sign every half period."""

    def command(t_s: float) -> Command:
        size = LIMIT_M_S if t_s % period_s < 0.5 * period_s else -LIMIT_M_S
        return size, size, 0.0, size

    return command


def random_commands(hold_s: float) -> Callable[[float], Command]:
    """Return commands that are drawn anew every `hold_s`, the same in every level."""
    drawn = np.random.default_rng(SEED).uniform(-0.5, 0.5, (10_000, 4))

    def command(t_s: float) -> Command:
        surge, sway, heave, yaw = drawn[int(t_s / hold_s) % len(drawn)]
        return float(surge), float(sway), 0.2 * float(heave), float(yaw)

    return command


CONTROLLERS: Mapping[str, Callable[[float], Command]] = {
    "constant 0.1 m/s ahead": lambda _t: (0.1, 0.0, 0.0, 0.0),
    "saturated ahead": lambda _t: (LIMIT_M_S, 0.0, 0.0, 0.0),
    "saturated on all axes": lambda _t: (LIMIT_M_S, LIMIT_M_S, LIMIT_M_S, LIMIT_M_S),
    "oscillating, 2 s": oscillating(2.0),
    "oscillating, 30 s": oscillating(30.0),
    "random": random_commands(1.0),
}


class Unseeing:
    """A tracker that answers the corners of its start, moved by `shift`, and never looks."""

    def __init__(self, shift: Callable[[int], NDArray[np.float64]], *, ok: bool = True) -> None:
        self._shift, self._ok, self._count = shift, ok, 0
        self._corners: Corners = np.zeros((4, 2))

    def start(self, image: Image, corners: Corners) -> None:
        """Remember the corners."""
        self._corners, self._count = np.array(corners, dtype=np.float64), 0

    def window(self) -> Window:
        """Return an empty part of the image."""
        return 0, 0, 0, 0

    def update(self, image: Image) -> Track:
        """Return the moved corners."""
        self._count += 1
        return Track(self._corners + self._shift(self._count), self._ok, 0.0, 0)


def _random_shift() -> Callable[[int], NDArray[np.float64]]:
    drawn = np.random.default_rng(SEED).normal(0.0, 5.0, (10_000, 2))
    return lambda count: np.asarray(drawn[count % len(drawn)])


TRACKERS: Mapping[str, Callable[[], Unseeing]] = {
    "start corners for ever": lambda: Unseeing(lambda _count: np.zeros(2)),
    "start corners, reported as lost": lambda: Unseeing(lambda _count: np.zeros(2), ok=False),
    "random around the start, 5 px": lambda: Unseeing(_random_shift()),
    "circle of 20 px": lambda: Unseeing(
        lambda count: 20.0 * np.array([np.cos(0.1 * count) - 1.0, np.sin(0.1 * count)])
    ),
}


def solutions(entry: Benchmark) -> dict[str, Callable[[Any], Any]]:
    """Return name -> how to make the solution for a configuration: adversaries, then built-ins."""
    makers: dict[str, Callable[[Any], Any]] = {}
    if entry.role == "controller":
        makers |= {name: partial(_timed, command) for name, command in CONTROLLERS.items()}
    else:
        makers |= {name: partial(_unseeing, make) for name, make in TRACKERS.items()}
    for name, label in {**entry.reference_built_in, **entry.built_in}.items():
        makers[f"built-in: {label}"] = partial(entry.load().built_in, name)
    return makers


def _timed(command: Callable[[float], Command], _config: Any) -> Timed:
    return Timed(command)


def _unseeing(make: Callable[[], Unseeing], _config: Any) -> Unseeing:
    return make()


def measured(
    entry: Benchmark, make: Callable[[Any], Any], *, trials: int, seed: int
) -> dict[str, Any]:
    """Return the summary of a few trials of one solution in the ranked scenario."""
    config = entry.ranked(entry.read({}))
    results = []
    for trial in range(trials):
        solution = make(config.for_trial(trial))
        results.append(
            run_trial(
                entry.name, config, solution, seed=seed, trial=trial, on_rows=lambda _rows: None
            )
        )
    return summarise(entry.name, config, results)


def text(name: str, *, trials: int, seed: int) -> str:
    """Return the table of one benchmark."""
    entry = benchmark(name)
    rows = []
    for label, make in solutions(entry).items():
        summary = measured(entry, make, trials=trials, seed=seed)
        low, high = summary["score_low"], summary["score_high"]
        interval = "" if low is None else f"{low:.3f} to {high:.3f}"
        ranks = "yes" if summary["rankable"] else "no"
        rows.append((label, f"{summary['score']:.3f}", interval, ranks))
    unit = entry.headline.unit or entry.headline.label
    header = ("program", f"score [{unit}]", "95 % interval", "ranks")
    return f"{name}: {trials} trials, seed {seed}\n\n{markdown_table(header, rows)}"


def main(arguments: Sequence[str]) -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("benchmarks", nargs="*", default=["currents-v3", "visibility-v3"])
    parser.add_argument("--trials", type=int, default=TRIALS)
    parser.add_argument("--seed", type=int, default=SEED)
    options = parser.parse_args(arguments)
    for name in options.benchmarks:
        print(text(name, trials=options.trials, seed=options.seed), flush=True)
    return 0
