"""The fitted midpoint, against psignifit 4.3 and with unlucky trials."""

import numpy as np
import pytest

from seamark.sim.numerics.psychometric import psychometric_midpoint

DEPTHS = [0.25 * index for index in range(29)]
SPEEDS = [0.2 * index for index in range(11)]

# Numbers of successes; midpoint, 95 % interval and lapse rate that psignifit 4.3 gives for them
# (sigmoid "logistic", guess rate fixed to 0, overdispersion to 1e-8, the levels negated).
PSIGNIFIT = [
    (24, [24, 24, 24, 22, 22, 12, 4, 0, 0, 0, 0], 1.000, (0.952, 1.078), 0.000),
    (24, [22, 22, 20, 22, 19, 8, 2, 0, 0, 0, 0], 0.962, (0.895, 1.036), 0.091),
    (12, [12, 7, 4, 0, 0, 0, 0, 0, 0, 0, 0], 0.282, (0.209, 0.403), 0.000),
    (24, [24, 24, 24, 24, 24, 24, 24, 20, 13, 9, 2], 1.673, (1.613, 1.761), 0.000),
    (100, [76, 80, 80, 77, 83, 31, 2, 0, 0, 0, 0], 0.979, (0.954, 1.010), 0.200),
]

# p@5 [%] of ViSP's ZNCC tracker with a similarity over the optical depths 0 to 7, ten trials, each
# level on another path (docs/visibility.json). The first unlucky level of each trial gave 2.50.
VISP_P5 = [
    *(88.205, 90.256, 94.872, 79.231, 89.744, 88.974, 96.923, 99.231, 93.590, 95.641),
    *(78.462, 79.231, 87.179, 88.974, 90.769, 86.410, 83.590, 90.256, 81.282, 92.821),
    *(72.308, 51.795, 55.385, 26.923, 22.821, 9.744, 3.077, 2.821, 1.538),
]


@pytest.mark.parametrize(("trials", "successes", "midpoint", "interval", "lapse_rate"), PSIGNIFIT)
def test_the_fit_is_that_of_psignifit(
    trials: int,
    successes: list[int],
    midpoint: float,
    interval: tuple[float, float],
    lapse_rate: float,
) -> None:
    fit = psychometric_midpoint(SPEEDS, successes, [trials] * len(SPEEDS))

    assert fit is not None
    assert fit.midpoint == pytest.approx(midpoint, abs=0.005)
    assert (fit.low, fit.high) == pytest.approx(interval, abs=0.013)  # a point of its own grid
    assert fit.lapse_rate == pytest.approx(lapse_rate, abs=0.005)


def test_the_fit_recovers_a_function_that_was_sampled_without_noise() -> None:
    shares = [0.9 / (1.0 + np.exp((x - 3.1) / 1.2 * 5.8889)) for x in DEPTHS]

    fit = psychometric_midpoint(DEPTHS, [1000 * share for share in shares], [1000] * len(shares))

    assert fit is not None
    assert (fit.midpoint, fit.width) == pytest.approx((3.1, 1.2), abs=0.02)
    assert fit.lapse_rate == pytest.approx(0.1, abs=0.005)


def test_unlucky_trials_at_easy_levels_do_not_decide_the_midpoint() -> None:
    fit = psychometric_midpoint(DEPTHS, [0.1 * p5 for p5 in VISP_P5], [10] * len(DEPTHS))

    assert fit is not None
    assert fit.midpoint == pytest.approx(5.54, abs=0.05)


def test_one_lost_level_hardly_moves_the_midpoint() -> None:
    held = [10.0] * 12 + [6.0, 1.0] + [0.0] * 15
    unlucky = [10.0] * 3 + [7.0] + held[4:]

    fits = [psychometric_midpoint(DEPTHS, each, [10] * len(DEPTHS)) for each in (held, unlucky)]

    assert fits[0] is not None
    assert fits[1] is not None
    assert abs(fits[0].midpoint - fits[1].midpoint) < 0.05
    assert fits[1].lapse_rate > 0.0


def test_the_order_of_the_levels_does_not_matter() -> None:
    successes, order = [24.0, 24.0, 23.0, 15.0, 9.0, 2.0, 0.0], [3, 0, 6, 1, 5, 2, 4]
    speeds = SPEEDS[:7]

    sorted_fit = psychometric_midpoint(speeds, successes, [24] * 7)
    fit = psychometric_midpoint(
        [speeds[at] for at in order], [successes[at] for at in order], [24] * 7
    )

    assert fit == sorted_fit


@pytest.mark.parametrize("successes", [[10.0] * 5, [0.0] * 5])
def test_without_a_fall_the_midpoint_lies_beyond_the_levels(successes: list[float]) -> None:
    fit = psychometric_midpoint([0.0, 1.0, 2.0, 3.0, 4.0], successes, [10] * 5)

    assert fit is not None
    assert fit.midpoint < 0.1 or fit.midpoint > 3.9
    assert -2.0 <= fit.low <= fit.midpoint <= fit.high <= 6.0


def test_a_single_level_has_no_midpoint() -> None:
    assert psychometric_midpoint([1.0], [5.0], [10]) is None
