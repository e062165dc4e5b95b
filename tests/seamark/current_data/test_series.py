"""A record is made of a series: gaps are filled, cut or refused, and means are means."""

import numpy as np
import pytest

from seamark.current_data.series import GAP_MAX, Array, CurrentRefused, Series, record_of


def series(
    count: int = 200, levels: tuple[float, ...] = (1.0, 2.0), *, down: bool = False
) -> Series:
    times: Array = 10.0 * np.arange(count, dtype=np.float64)
    velocity = np.empty((len(levels), 3, count))
    velocity[:, 0] = 0.3 + 0.0001 * times
    velocity[:, 1] = 0.1 * np.array(levels)[:, None]
    velocity[:, 2] = 0.01
    return Series(times, np.array(levels), velocity, down, "a test")


def test_a_series_without_gaps_is_the_record() -> None:
    given = series()

    made = record_of(given)

    assert made.record.step_s == 10.0
    assert made.record.velocity == pytest.approx(given.velocity, rel=1e-4)
    assert made.gaps == (0.0, (), 0, 0)


def test_short_gaps_are_filled_linearly() -> None:
    given = series()
    given.velocity[0, 1, 50 : 50 + GAP_MAX] = np.nan

    made = record_of(given)

    assert made.gaps.filled == GAP_MAX
    assert made.record.velocity == pytest.approx(series().velocity, rel=1e-4)


def test_a_longer_gap_cuts_the_record_to_its_longest_part() -> None:
    given = series()
    given.velocity[0, 0, 60 : 61 + GAP_MAX] = np.nan

    made = record_of(given)

    assert made.gaps.cut == 61 + GAP_MAX
    assert made.record.velocity.shape[2] == 200 - 61 - GAP_MAX
    assert made.record.velocity[0, 0, 0] == pytest.approx(0.3 + 0.001 * (61 + GAP_MAX), rel=1e-4)


def test_a_level_with_too_much_missing_is_left_out() -> None:
    given = series()
    given.velocity[1, :, ::5] = np.nan

    made = record_of(given)

    assert made.record.heights.tolist() == [1.0]
    assert made.gaps.dropped == (2.0,)
    given.velocity[0, :, ::5] = np.nan
    with pytest.raises(CurrentRefused, match="more than 10% of the samples are missing"):
        record_of(given)


def test_depths_become_heights_above_the_bottom() -> None:
    made = record_of(series(levels=(4.0, 8.0), down=True), bottom_m=10.0)
    guessed = record_of(series(levels=(4.0, 8.0), down=True))

    assert made.record.heights.tolist() == [2.0, 6.0]
    assert made.record.velocity[0, 1, 0] == pytest.approx(0.8)  # of the deeper one
    assert guessed.record.heights.tolist() == [4.0, 8.0]
    assert "12 m deep" in guessed.said[0]
    with pytest.raises(CurrentRefused, match="below the bottom"):
        record_of(series(levels=(4.0, 8.0), down=True), bottom_m=6.0)


def test_a_longer_step_takes_means_so_that_nothing_is_aliased() -> None:
    given = series(1201)
    given.velocity[:, 0] = np.cos(np.pi * np.arange(1201))  # flips at every sample

    made = record_of(given, step_s=100.0)

    assert made.record.step_s == 100.0
    assert np.abs(made.record.velocity[:, 0, 1:-1]).max() < 0.06
    assert made.record.velocity[:, 1, :] == pytest.approx(given.velocity[:, 1, :121], rel=1e-4)


def test_a_record_is_small_enough_for_a_manifest_whatever_the_file_has() -> None:
    given = series(60_000, tuple(np.arange(1.0, 31.0).tolist()))
    given.velocity[:, 0] = 0.3

    made = record_of(given)

    assert made.record.velocity.size < 300_000
    assert made.record.step_s > 10.0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda one: one.times.__setitem__(5, one.times[4]), "do not increase"),
        (lambda one: one.velocity.__imul__(100.0), "Say the unit"),
        (lambda one: one.velocity.fill(np.nan), "no velocity that is a number"),
        (lambda one: one.levels.__setitem__(0, 2.0), "levels of the file must differ"),
        (lambda one: one.levels.__setitem__(0, -3.0), "lie above the bottom"),
    ],
)
def test_what_cannot_be_a_record_is_refused_with_a_sentence(change: object, sentence: str) -> None:
    given = series()
    assert callable(change)
    change(given)

    with pytest.raises(CurrentRefused, match=sentence):
        record_of(given)
