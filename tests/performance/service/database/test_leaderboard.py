"""The table of pages of a large leaderboard."""

import pytest

from performance.service.database.leaderboard import rows


@pytest.mark.slow
def test_ranges_by_classes_of_scores_are_never_narrower_than_row_by_row() -> None:
    *times, width = rows(people=2500)  # more than are compared row by row

    assert all(row.value > 0.0 for row in times)
    assert width.baseline_value is not None
    assert 0 < width.baseline_value <= width.value <= 2.0 * width.baseline_value
