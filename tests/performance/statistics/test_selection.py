"""What the best of many equally good submissions gains."""

import numpy as np
import pytest

from performance.statistics.selection import Population, gain, passes, populations
from seamark.sim.benchmarks.benchmark import RankedProtocol


@pytest.fixture
def population() -> Population:
    """Normal scores: 24 trials in blocks of 2, so a score has a standard error of 1."""
    means = np.random.default_rng(1).normal(50.0, np.sqrt(12.0), 4000)
    protocol = RankedProtocol(reference_trials=2, fresh_trials=24, block=2)
    return Population(name="b", solution="s", protocol=protocol, unit="m", means=means)


def test_the_error_of_a_score_is_that_of_its_blocks(population: Population) -> None:
    assert population.error == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize(
    ("submissions", "expected"),
    [(1, 0.0), (5, 1.163), (35, 2.107)],
)
def test_the_gain_is_the_mean_of_the_largest_of_n_normal_values(
    population: Population, submissions: int, expected: float
) -> None:
    """Order statistics of the normal distribution, by quadrature of n x pdf x cdf^(n-1)."""
    found = gain(population, submissions, repeats=1000)

    assert found == pytest.approx(expected * population.error, abs=0.12)


@pytest.mark.slow
@pytest.mark.parametrize("repeats", [500, pytest.param(1000, marks=pytest.mark.long)])
def test_one_submission_passes_as_better_in_a_fortieth_of_the_cases(
    population: Population, repeats: int
) -> None:
    """The 95 % interval of a difference misses 0 on one side in 2.5 %."""
    assert passes(population, 1, repeats=repeats) == pytest.approx(0.025, abs=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("repeats", [100, pytest.param(300, marks=pytest.mark.long)])
def test_the_best_of_many_passes_more_often(population: Population, repeats: int) -> None:
    assert passes(population, 35, repeats=repeats) > 0.15


def test_every_measured_population_belongs_to_a_benchmark_with_fresh_trials() -> None:
    found = populations()

    assert {entry.name for entry in found} == {"currents-v2", "visibility-v2"}
    assert all(len(entry.means) >= 2 * entry.blocks for entry in found)
