"""Seeds of ranked runs: the same for the same submission, and not to be guessed."""

import pytest

from seamark.sim.engine.seeds import fresh_seed, hidden_seed


def test_hidden_seeds_differ_in_each_argument() -> None:
    cases = [(b"a", "x-v1", 0), (b"b", "x-v1", 0), (b"a", "x-v2", 0), (b"a", "x-v1", 1)]
    seeds = {hidden_seed(*case) for case in cases}

    assert len(seeds) == len(cases)
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_a_hidden_seed_never_changes() -> None:
    """Or the results of earlier runs could no longer be compared."""
    assert hidden_seed(b"secret", "currents-v1", 3) == 4360213739676080182


def test_fresh_seeds_differ_in_each_argument() -> None:
    first = (b"a", "x-v2", "00", 0)
    others = [(b"b", *first[1:]), (b"a", "x-v3", "00", 0), (b"a", "x-v2", "01", 0)]
    cases = [first, *others, (*first[:3], 1)]
    seeds = {fresh_seed(*case) for case in cases}

    assert len(seeds) == len(cases)
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_a_fresh_seed_never_changes() -> None:
    """Or the images of earlier runs could no longer be rendered."""
    assert fresh_seed(b"secret", "currents-v2", "ab" * 32, 8) == 3871778281076459835


@pytest.mark.parametrize(("secret", "trial"), [(b"", 0), (b"secret", -1)])
def test_an_empty_secret_or_a_negative_trial_is_an_error(secret: bytes, trial: int) -> None:
    with pytest.raises(ValueError, match=r"secret|negative"):
        hidden_seed(secret, "currents-v1", trial)
    with pytest.raises(ValueError, match=r"secret|negative"):
        fresh_seed(secret, "currents-v2", "ab" * 32, trial)


def test_a_fresh_seed_needs_a_submission() -> None:
    with pytest.raises(ValueError, match="digest"):
        fresh_seed(b"secret", "currents-v2", "", 8)
