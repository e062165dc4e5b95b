"""The headroom of both versions: the page has what was measured, and the entries are spread."""

import pytest

from performance import DOCS
from performance.statistics.headroom.marks import (
    OTHER_TRIALS,
    REFERENCE_TRIALS,
    known_entries,
    mark_steps,
    stability,
)
from performance.statistics.headroom.visibility import DISHONEST, SECOND, THIRD, report
from seamark.sim.registry import benchmark

PAGE = DOCS / "benchmarks.md"
each = pytest.mark.parametrize("name", [SECOND, THIRD])


@each
def test_the_page_has_the_table_and_the_stability_of_what_was_measured(name: str) -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert report(name, known_entries(name)) in page
    assert (
        stability(known_entries(name), dishonest=DISHONEST).split("order: ")[1].rstrip(".") in page
    )


@each
def test_what_does_not_look_is_at_the_bottom_and_the_oracle_far_above_every_tracker(
    name: str,
) -> None:
    found = known_entries(name)
    scores = {key: one.other[0] for key, one in found.items()}
    order = sorted(scores, key=lambda key: float(scores[key]))

    assert set(order[:3]) == {"nothing", "playback", "blind"}
    assert scores["oracle"] - max(scores[key] for key in order[:-1]) > 0.1 * scores["oracle"]
    assert all(len(one.scores) == REFERENCE_TRIALS + OTHER_TRIALS for one in found.values())


@pytest.mark.parametrize(("name", "full"), [(SECOND, 7.0), (THIRD, 9.0)])
def test_neither_playback_nor_memory_gains_anything_in_fresh_water(name: str, full: float) -> None:
    found = known_entries(name)
    nothing, honest = (found[key].other for key in ("nothing", "zncc-homography"))

    assert found["playback"].reference == full
    assert found["playback"].other[0] <= nothing[1]
    assert found["remembers"].other[0] <= honest[1]


@each
def test_each_mark_is_better_than_the_one_below_it_by_more_than_the_interval(name: str) -> None:
    steps = mark_steps(known_entries(name), benchmark(name).baselines)
    below = {mark: steps[mark] for mark in benchmark(name).baselines if mark != "nothing"}

    assert all(step is not None and step[0] > 0.0 for step in below.values()), below
