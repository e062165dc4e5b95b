"""The headroom of visibility-v2: the page has what was measured, and the entries are spread."""

from performance import DOCS
from performance.statistics.headroom.marks import (
    OTHER_TRIALS,
    REFERENCE_TRIALS,
    known_entries,
    mark_steps,
    stability,
)
from performance.statistics.headroom.visibility import DISHONEST, NAME, report
from seamark.sim.registry import benchmark

PAGE = DOCS / "benchmarks.md"


def test_the_page_has_the_table_and_the_stability_of_what_was_measured() -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert report(known_entries(NAME)) in page
    assert (
        stability(known_entries(NAME), dishonest=DISHONEST).split("order: ")[1].rstrip(".") in page
    )


def test_what_does_not_look_is_at_the_bottom_and_the_oracle_far_above_every_tracker() -> None:
    found = known_entries(NAME)
    scores = {key: one.other[0] for key, one in found.items()}
    order = sorted(scores, key=lambda key: float(scores[key]))

    assert set(order[:3]) == {"nothing", "playback", "blind"}
    assert scores["oracle"] - max(scores[key] for key in order[:-1]) > 0.1 * scores["oracle"]
    assert all(len(one.scores) == REFERENCE_TRIALS + OTHER_TRIALS for one in found.values())


def test_neither_playback_nor_memory_gains_anything_in_fresh_water() -> None:
    found = known_entries(NAME)
    nothing, honest = (found[key].other for key in ("nothing", "zncc-homography"))

    assert found["playback"].reference == 7.0
    assert found["playback"].other[0] <= nothing[1]
    assert found["remembers"].other[0] <= honest[1]


def test_each_mark_is_better_than_the_one_below_it_by_more_than_the_interval() -> None:
    steps = mark_steps(known_entries(NAME), benchmark(NAME).baselines)
    below = {name: steps[name] for name in benchmark(NAME).baselines if name != "nothing"}

    assert all(step is not None and step[0] > 0.0 for step in below.values()), below
