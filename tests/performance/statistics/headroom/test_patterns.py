"""The headroom of patterns-v1: the page has what was measured, and the entries are spread."""

from performance import DOCS
from performance.statistics.headroom.marks import (
    OTHER_TRIALS,
    REFERENCE_TRIALS,
    known_entries,
    mark_steps,
    stability,
)
from performance.statistics.headroom.patterns import NAME, report
from seamark.sim.registry import benchmark

PAGE = DOCS / "benchmarks.md"
MOST_OF_THE_SCALE = 0.8  # that a built-in detector may reach


def test_the_page_has_the_table_and_the_stability_of_what_was_measured() -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert report(known_entries(NAME)) in page
    assert stability(known_entries(NAME), dishonest=()).split("order: ")[1].rstrip(".") in page


def test_what_does_not_look_is_at_the_bottom_and_the_oracle_far_above_every_detector() -> None:
    found = known_entries(NAME)
    scores = {key: one.other[0] for key, one in found.items()}
    order = sorted(scores, key=lambda key: float(scores[key]))

    assert order[:2] == ["nothing", "random"]
    assert max(scores[key] for key in order[:-1]) < MOST_OF_THE_SCALE * scores["oracle"]
    assert set(found) == set(benchmark(NAME).baselines)
    assert all(len(one.scores) == REFERENCE_TRIALS + OTHER_TRIALS for one in found.values())


def test_each_mark_is_better_than_the_one_below_it_by_more_than_the_interval() -> None:
    steps = mark_steps(known_entries(NAME), benchmark(NAME).baselines)
    below = {name: steps[name] for name in benchmark(NAME).baselines if name != "nothing"}

    assert all(step is not None and step[0] > 0.0 for step in below.values()), below
