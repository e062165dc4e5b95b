"""Of which seeds the trials of a population are."""

from performance.statistics.population import FIRST_SEED, score, seed_and_trial, stored
from seamark.sim.registry import benchmark


def test_each_trial_has_a_seed_of_its_own_or_that_of_a_whole_run() -> None:
    of_own = [seed_and_trial(benchmark("currents-v2").protocol, trial) for trial in (0, 1, 24)]
    of_run = [seed_and_trial(benchmark("currents-v3").protocol, trial) for trial in (0, 23, 24)]

    assert of_own == [(FIRST_SEED, 0), (FIRST_SEED + 1, 1), (FIRST_SEED + 24, 24)]
    assert of_run == [(FIRST_SEED, 0), (FIRST_SEED, 23), (FIRST_SEED + 1, 0)]


def test_a_trial_has_the_score_that_is_stored() -> None:
    assert round(score("visibility-v2", "esm", 1), 6) == stored()["visibility-v2 esm"][1]
