"""Hidden seeds: the same for everybody, another for each trial, and not to be guessed."""

import pytest

from seamark.sim.engine.seeds import hidden_seed


def test_each_trial_benchmark_and_secret_has_its_own_seed() -> None:
    cases = [(b"a", "currents-v1", 0), (b"a", "currents-v1", 1), (b"a", "x", 0), (b"b", "x", 0)]

    seeds = {hidden_seed(*case) for case in cases}

    assert len(seeds) == len(cases)
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_a_hidden_seed_never_changes() -> None:
    # Of RFC 2104 as any HMAC-SHA256 computes it; another number would move every leaderboard.
    assert hidden_seed(b"secret", "currents-v1", 3) == 4360213739676080182


def test_an_empty_secret_is_rejected() -> None:
    with pytest.raises(ValueError, match="secret"):
        hidden_seed(b"", "currents-v1", 0)


def test_a_negative_trial_is_rejected() -> None:
    with pytest.raises(ValueError, match="negative"):
        hidden_seed(b"secret", "currents-v1", -1)
