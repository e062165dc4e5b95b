"""The headroom of visibility-v2: the page has what was measured, and the entries are spread."""

from pathlib import Path

import performance
from performance.visibility_headroom import TRIALS, report, stability, stored

PAGE = Path(performance.__file__).resolve().parents[1].joinpath("docs", "benchmarks.md")


def test_the_page_has_the_table_and_the_stability_of_what_was_measured() -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert report(stored()) in page
    assert stability(stored()).split("order: ")[1].rstrip(".") in page


def test_what_does_not_look_is_at_the_bottom_and_the_oracle_far_above_every_tracker() -> None:
    found = stored()
    scores = {key: one.other["score"] for key, one in found.items()}
    order = sorted(scores, key=lambda key: float(scores[key]))

    assert set(order[:3]) == {"nothing", "playback", "blind"}
    assert scores["oracle"] - max(scores[key] for key in order[:-1]) > 0.1 * scores["oracle"]
    assert all(len(one.scores) == 2 * TRIALS for one in found.values())


def test_neither_playback_nor_memory_gains_anything_in_fresh_water() -> None:
    found = stored()
    nothing, honest = (found[key].other for key in ("nothing", "esm"))

    assert found["playback"].reference["score"] == 7.0
    assert found["playback"].other["score"] <= nothing["score_high"]
    assert found["remembers"].other["score"] <= honest["score_high"]
