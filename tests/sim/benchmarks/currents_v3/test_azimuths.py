"""currents-v3: the trials of a run divide the directions of the current among themselves."""

import math
from collections import Counter

import pytest

from seamark.server.runs.record.seeds import TrialSeeds
from seamark.sim.benchmarks.currents_v3.azimuths import STRATA, azimuth_share
from seamark.sim.benchmarks.currents_v3.definition import BENCHMARK
from seamark.sim.benchmarks.currents_v3.experiment import EXPERIMENT
from seamark.sim.benchmarks.currents_v3.settings import CurrentsConfiguration
from seamark.sim.settings.two_vehicles import MEASURED

VEHICLES = len(MEASURED)
SEEDS = range(40)


def stratum(share: float) -> int:
    return math.floor(0.5 * (share + 1.0) * STRATA)


def shares(seed: int, trials: range) -> list[float]:
    return [azimuth_share(seed, trial) for trial in trials]


def fresh_trials() -> range:
    protocol = BENCHMARK.protocol
    assert protocol is not None
    return range(protocol.reference_trials, protocol.trials)


@pytest.mark.parametrize("seed", SEEDS)
def test_each_vehicle_meets_each_sector_once_in_the_fresh_trials_of_a_run(seed: int) -> None:
    for vehicle in range(VEHICLES):
        own = [trial for trial in fresh_trials() if trial % VEHICLES == vehicle]
        sectors = Counter(stratum(azimuth_share(seed, trial)) for trial in own)

        assert sectors == dict.fromkeys(range(STRATA), 1)


@pytest.mark.parametrize("trial", [8, 9, 31])
def test_a_trial_by_itself_may_have_any_direction(trial: int) -> None:
    drawn = [azimuth_share(seed, trial) for seed in range(1200)]
    sectors = Counter(map(stratum, drawn))

    assert len(sectors) == STRATA
    assert max(sectors.values()) < 2 * min(sectors.values())
    within = [(0.5 * (share + 1.0) * STRATA) % 1.0 for share in drawn]
    assert sum(within) / len(within) == pytest.approx(0.5, abs=0.03)


def test_the_place_in_its_sector_does_not_follow_from_other_trials() -> None:
    places = [
        tuple(round((0.5 * (share + 1.0) * STRATA) % 1.0, 6) for share in shares(seed, range(8)))
        for seed in SEEDS
    ]

    assert len({place for places_of in places for place in places_of}) == 8 * len(SEEDS)


def test_the_vehicles_of_a_block_are_a_quarter_of_the_circle_apart() -> None:
    for seed in SEEDS:
        first, second = shares(seed, range(10, 12))

        assert (stratum(second) - stratum(first)) % STRATA == STRATA // 4


def test_a_trial_is_recomputed_from_its_seed_and_number_alone() -> None:
    config = CurrentsConfiguration.read({})
    once = EXPERIMENT.drawn(config.for_trial(13), seed=99, trial=13)

    assert EXPERIMENT.drawn(config, seed=99, trial=13) == once
    assert EXPERIMENT.drawn(config, seed=99, trial=15) != once


def test_the_azimuth_is_all_that_differs_from_independent_trials() -> None:
    config = CurrentsConfiguration.read({"azimuth_spread_rad": 0.0})
    drawn = EXPERIMENT.drawn(config, seed=4, trial=5)
    alone = super(type(EXPERIMENT), EXPERIMENT).drawn(config, seed=4, trial=5)

    assert drawn == alone


def test_the_fresh_trials_of_a_submission_share_one_seed_that_nobody_else_has() -> None:
    seeds = [
        TrialSeeds(benchmark="currents-v3", seed=None, submission=of, secret=b"secret")
        for of in ("ab" * 32, "cd" * 32)
    ]
    first, second = ({each(trial) for trial in fresh_trials()} for each in seeds)

    assert len(first) == len(second) == 1
    assert first != second
    assert 2026 not in first | second


def test_a_verification_draws_other_fresh_trials() -> None:
    own, again = (
        TrialSeeds(
            benchmark="currents-v3", seed=None, submission="ab" * 32, draw=draw, secret=b"secret"
        )
        for draw in (None, 1)
    )

    assert own(8) != again(8)
