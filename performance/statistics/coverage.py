"""How often the 95 % intervals contain what they should.

Runs are drawn from populations of which the mean is known: synthetic ones, shaped like scores, and
the measured trials of real benchmarks (`population`). The first table has the share
of runs whose interval contains the mean, for Student's t, which the service uses, and for two
bootstraps. The second has the share of ranges of ranks that contain the true rank, the third how
often a board tells an entry from 24 others that are a fifth worse, by the spread of a measured one.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy  # its parts are loaded when they are used

from performance.statistics.population import stored
from performance.tables import markdown_table
from seamark.server.runs.record.trial_scores import block_of
from seamark.sim.benchmarks.currents_v3.azimuths import QUARTER, STRATA, STRIDE
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.ranking import Estimate, Population
from seamark.sim.numerics.statistics import mean_interval
from seamark.sim.settings.two_vehicles import MEASURED

# The boards of the third table: one row is a fifth better than the others. Score and standard
# deviation of LQG's blocks: of 24 in docs/headroom.json, of 15 with the seeds 777 and 2026.
OTHERS, BETTER, BLOCKS = 24, 1.2, 12
SEPARATED = (("currents-v2", 0.504, 0.0624), ("currents-v3", 0.467, 0.0395))
RUNS = 4000
BOOTSTRAP_RUNS = 1000
RESAMPLES = 1000
CHUNK = 50  # runs that are resampled at once
SEED = 11
Draw = Callable[[np.random.Generator, int, int], Array]  # runs, trials -> (runs, trials)


@dataclass(frozen=True, slots=True)
class Scores:
    """A population of scores of trials; `block` as in RankedProtocol."""

    name: str
    mean: float
    draw: Draw
    block: int = 1


def _normal(generator: np.random.Generator, runs: int, trials: int) -> Array:
    return generator.normal(50.0, 5.0, (runs, trials))


def _skewed(generator: np.random.Generator, runs: int, trials: int) -> Array:
    return 6.0 - generator.gamma(4.0, 0.2, (runs, trials))


def _unlucky(generator: np.random.Generator, runs: int, trials: int) -> Array:
    luck = generator.random((runs, trials)) < 0.1
    return generator.normal(5.4, 0.1, (runs, trials)) - luck * 0.5


def _vehicles(generator: np.random.Generator, runs: int, trials: int) -> Array:
    means = np.where(np.arange(trials) % 2, 0.1, 0.3)
    return generator.normal(means, 0.05, (runs, trials))


def _sectors(generator: np.random.Generator, runs: int, trials: int) -> Array:
    """Two vehicles in directions as those of currents-v3, to which one is more sensitive."""
    trial = np.arange(trials)
    turn, vehicle = trial // len(MEASURED), trial % len(MEASURED)
    first = generator.integers(STRATA, size=(runs, 1))
    sector = first + STRIDE * turn + QUARTER * vehicle + generator.random((runs, trials))
    effect = np.array([0.08, 0.04])[vehicle] * np.cos(4.0 * np.pi * sector / STRATA)
    return generator.normal(0.45 + effect, 0.05)


SYNTHETIC = (
    Scores("normal", 50.0, _normal),
    Scores("skewed (gamma, skewness -1)", 5.2, _skewed),
    Scores("one trial in ten is unlucky", 5.35, _unlucky),
    Scores("two vehicles in turn", 0.2, _vehicles, block=2),
    Scores("the same, in sectors of directions", 0.45, _sectors, block=2),
)


def measured(name: str, scores: Sequence[float]) -> Scores:
    """Return a measured population: blocks of its trials are drawn with replacement."""
    block = block_of(name.split(maxsplit=1)[0])
    values = np.array(scores[: len(scores) // block * block]).reshape(-1, block)

    def draw(generator: np.random.Generator, runs: int, trials: int) -> Array:
        picks = generator.integers(len(values), size=(runs, trials // block))
        return values[picks].reshape(runs, -1)

    return Scores(f"{name}, {values.size} trials", float(np.mean(values)), draw, block)


def coverage(scores: Scores, trials: int, runs: int = RUNS) -> float:
    """Return the share [%] of runs whose interval by `mean_interval` contains the mean."""
    drawn = scores.draw(np.random.default_rng(SEED), runs, trials)
    hits = 0
    for run in drawn.tolist():
        interval = mean_interval(run, block=scores.block)
        hits += interval is not None and interval[0] <= scores.mean <= interval[1]
    return 100.0 * hits / runs


def bootstrap_coverage(scores: Scores, trials: int, method: str) -> float:
    """Return the same for a bootstrap of SciPy, "percentile" or "BCa", on fewer runs."""
    generator = np.random.default_rng(SEED)
    hits = 0
    for _ in range(0, BOOTSTRAP_RUNS, CHUNK):
        drawn = scores.draw(generator, CHUNK, trials)
        means = np.mean(drawn.reshape(CHUNK, -1, scores.block), axis=2)
        interval = scipy.stats.bootstrap(
            (means,), np.mean, axis=1, n_resamples=RESAMPLES, method=method, rng=generator
        ).confidence_interval
        hits += int(np.sum((interval.low <= scores.mean) & (scores.mean <= interval.high)))
    return 100.0 * hits / BOOTSTRAP_RUNS


@dataclass(frozen=True, slots=True)
class Board:
    """True scores of a leaderboard's rows and the standard deviation of their trials."""

    name: str
    truth: Array
    spread: Array
    trials: int = 24


def _board(name: str, truth: Iterable[float], spread: Iterable[float]) -> Board:
    return Board(name, np.array([*truth]), np.array([*spread]))


BOARDS = (
    _board("25 rows, 0.3 apart, +-0.22", (50.0 - 0.3 * at for at in range(25)), [0.52] * 25),
    _board("25 equal rows", [50.0] * 25, [1.0] * 25),
    _board("12 rows, spreads 0.3 to 2.5", range(12), (0.3 + 0.2 * at for at in range(12))),
    _board("100 rows", (50.0 + (0.04 * at - 2.0) ** 3 for at in range(100)), [1.5] * 100),
)


def rank_coverage(board: Board, runs: int) -> tuple[float, float, float]:
    """Return the coverage [%] of the ranges of ranks and their mean width.

    Returns
    -------
    (float, float, float)
        Mean over the rows, the row that is covered least, ranks in a range.
    """
    generator = np.random.default_rng(SEED)
    rows = len(board.truth)
    first = np.array([1 + np.sum(board.truth > own) for own in board.truth])
    last = np.array([np.sum(board.truth >= own) for own in board.truth])  # equal rows share ranks
    covered, width = np.zeros(rows), 0.0
    for _ in range(runs):
        spread = board.spread[:, None]
        ranges = _ranges(generator.normal(board.truth[:, None], spread, (rows, board.trials)))
        covered += (ranges[:, 0] <= first) & (last <= ranges[:, 1])
        width += float(np.mean(ranges[:, 1] - ranges[:, 0])) + 1.0
    shares = 100.0 * covered / runs
    return float(np.mean(shares)), float(np.min(shares)), width / runs


def _ranges(trials: Array) -> Array:
    rows, count = trials.shape
    score, error = np.mean(trials, axis=1), np.std(trials, axis=1, ddof=1) / np.sqrt(count)
    people = Population(
        low=score,
        high=score,
        standard_error=error,
        degrees=np.full(rows, count - 1.0),
        counts=np.ones(rows, dtype=np.int64),
    )
    return np.array(
        [
            people.rank_range(Estimate(score=own, standard_error=its, degrees=count - 1))
            for own, its in zip(score.tolist(), error.tolist(), strict=True)
        ]
    )


def max_statistic_width(board: Board, runs: int) -> float:
    """Return the mean number of ranks in a range by the bootstrap of the largest difference.

    The single-step method of Mogstad, Romano, Shaikh & Wilhelm (2024) with normal errors: what
    Bonferroni's correction costs beside it.
    """
    generator = np.random.default_rng(SEED)
    rows, width = len(board.truth), 0.0
    for _ in range(runs):
        spread = board.spread[:, None]
        trials = generator.normal(board.truth[:, None], spread, (rows, board.trials))
        score = np.mean(trials, axis=1)
        error = np.std(trials, axis=1, ddof=1) / np.sqrt(board.trials)
        noise = generator.normal(0.0, error, (RESAMPLES, rows))
        for own in range(rows):
            others = np.arange(rows) != own
            scale = np.hypot(error[others], error[own])
            largest = np.max(np.abs(noise[:, others] - noise[:, own, None]) / scale, axis=1)
            margin = np.quantile(largest, 0.95) * scale
            width += 1.0 + float(np.sum(np.abs(score[others] - score[own]) <= margin))
    return width / runs / rows


def intervals() -> str:
    """Return the table of the coverage of intervals."""
    real = [measured(name, scores) for name, scores in stored().items()]
    rows = []
    for scores in (*SYNTHETIC, *real):
        for trials in (10, 24):
            shares = [coverage(scores, trials)]
            shares += [bootstrap_coverage(scores, trials, name) for name in ("percentile", "BCa")]
            rows.append((scores.name, trials, *(f"{share:.1f}" for share in shares)))
    header = ("population", "trials", "Student's t [%]", "percentile bootstrap [%]", "BCa [%]")
    return markdown_table(header, rows)


def ranks(runs: int = 200) -> str:
    """Return the table of the coverage of ranges of ranks."""
    rows = []
    for board in BOARDS:
        average, least, width = rank_coverage(board, runs)
        other = max_statistic_width(board, runs // 10)
        rows.append((board.name, f"{average:.1f}", f"{least:.1f}", f"{width:.1f}", f"{other:.1f}"))
    header = ("leaderboard", "rows that are covered [%]", "the least covered row [%]")
    return markdown_table((*header, "ranks in a range", "by the largest difference"), rows)


def separated(board: Board, runs: int = RUNS // 10) -> tuple[float, float]:
    """Return how often [%] the last, best row is told from another, and from all at once."""
    generator = np.random.default_rng(SEED)
    rows, alone, beside = len(board.truth), 0, 0
    for _ in range(runs):
        spread = board.spread[:, None]
        drawn = generator.normal(board.truth[:, None], spread, (rows, board.trials))
        worst = int(_ranges(drawn)[-1][1])
        alone += worst == 1
        beside += worst - 1
    return 100.0 * (1.0 - beside / (runs * (rows - 1))), 100.0 * alone / runs


def separations() -> str:
    """Return the table of how often an entry is told from 24 that are a fifth worse."""
    rows = []
    for name, centre, spread in SEPARATED:
        truth, spreads = [centre] * OTHERS, [spread] * OTHERS
        board = _board(name, [*truth, BETTER * centre], [*spreads, BETTER * spread])
        told, alone = separated(replace(board, trials=BLOCKS))
        error = spread / math.sqrt(BLOCKS)
        shares = f"{told:.0f}", f"{alone:.0f}"
        rows.append((name, f"{centre:.3f}", f"{spread:.3f}", f"{error:.4f}", *shares))
    header = ("24 entries like LQG in", "score", "standard deviation of blocks", "standard error")
    return markdown_table((*header, "others told apart [%]", "all of them at once [%]"), rows)


def main(_arguments: Sequence[str]) -> int:
    """Print the tables."""
    print(intervals(), flush=True)
    print()
    print(ranks())
    print()
    print(separations())
    return 0
