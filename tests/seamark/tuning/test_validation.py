"""Whether a tuned configuration is better, or was lucky."""

import pytest

from seamark.sim.engine.seeds import SEED_MAX
from seamark.tuning.candidates import Evaluated
from seamark.tuning.validation import compared, fresh_seed


def _run(*scores: float) -> Evaluated:
    return Evaluated(score=sum(scores) / len(scores), trial_scores=scores)


@pytest.mark.parametrize(
    ("best", "sentence"),
    [
        ((1.1, 2.2, 3.1, 4.2), "better than the defaults"),
        ((0.9, 1.8, 2.9, 3.8), "worse than the defaults"),
        ((1.1, 1.8, 3.1, 3.8), "may be luck"),
    ],
)
def test_only_a_difference_whose_interval_excludes_zero_is_called_one(
    best: tuple[float, ...], sentence: str
) -> None:
    found = compared(_run(*best), _run(1.0, 2.0, 3.0, 4.0), seed=2, trials=4, block=1)

    assert sentence in found.sentence()
    assert found.better is ("better" in sentence)


def test_trials_are_compared_in_pairs_and_by_blocks() -> None:
    best, defaults = _run(1.0, 9.0, 2.0, 8.0), _run(0.0, 8.1, 1.0, 6.9)

    single = compared(best, defaults, seed=2, trials=4, block=1)
    paired = compared(best, defaults, seed=2, trials=4, block=2)

    assert single.difference == pytest.approx(1.0)
    assert (single.high or 0) - (single.low or 0) < 0.3
    assert (paired.high or 0) - (paired.low or 0) > 0.9 > (single.high or 0) - (single.low or 0)


def test_one_trial_says_nothing_and_a_failed_run_says_why() -> None:
    alone = compared(_run(1.0), _run(0.5), seed=2, trials=1, block=1)
    failed = compared(_run(1.0), Evaluated(failure="It crashed."), seed=2, trials=1, block=1)

    assert "Too few trials" in alone.sentence()
    assert "It crashed." in failed.sentence()
    assert not alone.better
    assert not failed.better


@pytest.mark.parametrize("seed", [0, 1, SEED_MAX])
def test_fresh_water_has_another_seed_in_the_allowed_range(seed: int) -> None:
    assert 0 <= fresh_seed(seed) <= SEED_MAX
    assert fresh_seed(seed) != seed
