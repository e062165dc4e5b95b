"""The shipped results of the reference entries are what the simulator computes."""

import pytest

from performance.statistics.reference_results import Job, measure
from seamark.sim.benchmarks import reference_results
from seamark.sim.registry import BENCHMARKS, benchmark

ENTRIES = [
    (name, entry)
    for name in BENCHMARKS
    for entry in reference_results.of_benchmark(benchmark(name))
]


@pytest.mark.parametrize(("name", "entry"), ENTRIES)
def test_a_shipped_result_is_of_the_entry_as_it_is_now(name: str, entry: str) -> None:
    definition = benchmark(name)
    seed, trials = reference_results.trials_of(definition)

    result = reference_results.of_benchmark(definition)[entry]

    assert result.configuration == reference_results.configuration_digest(definition, entry)
    assert (result.seed, len(result.scores)) == (seed, trials)
    low, high = result.interval(definition)
    assert low <= result.score <= high


@pytest.mark.parametrize("name", BENCHMARKS)
def test_all_entries_of_all_versions_are_shipped(name: str) -> None:
    definition = benchmark(name)

    assert set(reference_results.of_benchmark(definition)) == set(definition.baselines)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("visibility-v3", "nothing"),
        ("visibility-v2", "nothing"),
        pytest.param("currents-v2", "nothing", marks=pytest.mark.long),
    ],
)
def test_the_simulator_computes_the_shipped_score_to_the_bit(name: str, entry: str) -> None:
    shipped = reference_results.of_benchmark(benchmark(name))[entry]

    assert measure(Job(name, entry, 0)).score == shipped.scores[0]
