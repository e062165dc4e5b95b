"""Vehicles against measurements: the page has the numbers of today's simulator."""

import pytest

from performance import DOCS
from performance.simulator.validation import entries, versions


def test_the_page_is_what_the_command_writes() -> None:
    assert (DOCS / versions.PAGE).read_text(encoding="utf-8") == versions.text() + "\n"


@pytest.mark.parametrize(
    ("second", "tau"), [([1.0, 2.0, 3.0], 1.0), ([3.0, 2.0, 1.0], -1.0), ([2.0, 1.0, 3.0], 1 / 3)]
)
def test_kendall_counts_pairs_in_the_same_order(second: list[float], tau: float) -> None:
    assert entries.kendall([1.0, 2.0, 3.0], second) == pytest.approx(tau)


def test_the_entry_that_holds_most_is_first() -> None:
    assert entries.ranks({"weak": [0.1, 0.2], "strong": [0.5, 0.6]}) == {"strong": 1, "weak": 2}


@pytest.mark.parametrize("motion", list(versions.STEPS))
def test_the_second_version_is_no_faster_to_its_speed_than_the_first(motion: str) -> None:
    first, second = (versions.step_response(one, motion)[1] for one in versions.vehicles())

    assert (second[10] / second[-1]) < (first[10] / first[-1]) + 0.02
    assert second[-1] > 0.0
