from types import SimpleNamespace

import pytest

from seamark.server.runs.seeds import trial_seeds
from seamark.server.settings import Settings
from seamark.sim.engine.seeds import hidden_seed


def test_all_trials_of_a_practice_run_use_its_seed(settings: Settings) -> None:
    seeds = trial_seeds(SimpleNamespace(benchmark="currents-v1", seed=7), settings)

    assert [seeds(trial) for trial in range(3)] == [7, 7, 7]


def test_each_trial_of_a_ranked_run_has_a_hidden_seed_of_its_own(settings: Settings) -> None:
    seeds = trial_seeds(SimpleNamespace(benchmark="currents-v1", seed=None), settings)

    drawn = [seeds(trial) for trial in range(3)]
    secret = settings.secret_key.encode()
    assert drawn == [hidden_seed(secret, "currents-v1", trial) for trial in range(3)]
    assert len(set(drawn)) == 3


@pytest.mark.parametrize("seed", [None, 7])
def test_the_secret_is_not_in_the_repr_of_the_seeds(settings: Settings, seed: int | None) -> None:
    seeds = trial_seeds(SimpleNamespace(benchmark="currents-v1", seed=seed), settings)

    assert settings.secret_key not in repr(seeds)
