"""The seconds of training that docs/training.md tells are those that were measured."""

import json

from performance import FIGURES
from performance.figures.seconds_to_score import PAGE, RESULTS, SEEDS, table


def test_the_page_has_the_table_of_the_stored_results() -> None:
    results = json.loads(RESULTS.read_text("utf-8"))

    assert table(results) in PAGE.read_text("utf-8")
    assert [run["seed"] for run in results["runs"]] == [*SEEDS]
    assert (FIGURES / "seconds-to-score.png").exists()


def test_a_seed_that_never_beats_an_entry_is_in_the_median_and_in_the_range() -> None:
    curve = [[2.0, 3.0, 0.1], [40.0, 70.0, 0.5]]
    runs = [
        {"curve": curve, "beaten": {"pi": [2.5, 4.0, 0.2], "lqr": lqr}, "score": 0.5}
        for lqr in ([20.0, 35.0, 0.51], None, None)
    ]

    lines = table({"entries": {"pi": 0.15, "lqr": 0.5}, "runs": runs}).splitlines()

    assert "it beats the published PI (0.150 m/s) | 2.5 | 2.5 to 2.5 | 4.0 | 4.0 to 4.0" in lines[2]
    assert "it beats LQG (0.500 m/s) | never | 20.0 to never | never | 35.0 to never" in lines[3]
    assert "holds 0.500 m/s (0.500 to 0.500) | 40.0 | 40.0 to 40.0 | 70.0 | 70.0 to" in lines[4]
