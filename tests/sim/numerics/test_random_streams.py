"""Random streams: one per component, independent of each other and of the order of use."""

import numpy as np
import pytest

from seamark.sim.numerics.random_streams import NAMES, PER_TRIAL, streams


def test_the_same_numbers_give_the_same_streams() -> None:
    first = streams(7, 1, 2)
    second = streams(7, 1, 2)

    for name in NAMES:
        assert getattr(first, name).random() == getattr(second, name).random()


def test_every_seed_trial_level_and_name_has_its_own_stream() -> None:
    keys = [(seed, trial, level) for seed in (0, 1) for trial in (0, 1) for level in (0, 1)]

    names = set(NAMES) - PER_TRIAL
    draws = [getattr(streams(*key), name).random() for key in keys for name in names]

    assert len(set(draws)) == len(draws)


@pytest.mark.parametrize("name", sorted(PER_TRIAL))
def test_what_belongs_to_the_trial_is_the_same_in_all_levels(name: str) -> None:
    draws = [getattr(streams(*key), name).random() for key in ((3, 0, 0), (3, 0, 4), (3, 1, 0))]

    assert draws[0] == draws[1] != draws[2]


def test_using_one_stream_does_not_move_another() -> None:
    untouched = streams(3, 0, 0).gust.standard_normal(8)

    used = streams(3, 0, 0)
    used.dvl.standard_normal(1000)
    used.camera.standard_normal(1000)

    assert np.array_equal(used.gust.standard_normal(8), untouched)


def test_the_index_of_the_published_streams_never_changes() -> None:
    """A new component goes to the end, or every published result would change."""
    assert NAMES[:5] == ("gust", "dvl", "depth", "ahrs", "camera")
    first = streams(2026, 0, 0)
    sequence = np.random.SeedSequence(entropy=2026, spawn_key=(0, 0, 1))
    expected = np.random.Generator(np.random.PCG64(sequence)).random()

    assert first.dvl.random() == expected


def test_negative_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="must not be negative"):
        streams(-1, 0, 0)
