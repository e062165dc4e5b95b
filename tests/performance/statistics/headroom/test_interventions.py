"""The tables of the reference entries of benchmarks with an arm."""

import pytest

from performance.statistics.headroom.interventions import columns, main, published_table
from performance.statistics.headroom.over_current import Measured


def test_a_row_has_how_often_the_work_was_done_at_each_speed_and_both_halves() -> None:
    done = (1.0, 0.75, 0.5, 0.25, 0.125, 0.0)
    one = Measured(seed=1, scores=(0.1, 0.2, 0.3, 0.4), levels={"completed": done})

    cells = columns((0.0, 0.1, 0.2, 0.3, 0.4, 0.5), one)

    assert [*cells.values()][: len(done)] == ["100", "75", "50", "25", "12", "0"]
    assert [*cells][1] == "done at 0.1 m/s, %"
    assert (cells["first half"], cells["second half"]) == ("0.150", "0.350")


def test_our_entries_stand_beside_what_others_published_at_the_same_speeds() -> None:
    done = (1.0, 0.75, 0.5, 0.25, 0.125, 0.0)
    one = Measured(seed=1, scores=(), levels={"completed": done})

    entries = {"scripted": one, "resolved-rate": one, "oracle": one}
    head, _, *rows = published_table("valve-v1", entries).splitlines()

    assert head == "| entry | success [%] at 0 m/s | 0.1 m/s | 0.2 m/s |"
    assert rows[0].endswith("| 87.8 | 64.4 | 68.9 |")
    assert len(rows) == 4
    assert all(row.endswith("| 100.0 | 75.0 | 50.0 |") for row in rows[1:])


@pytest.mark.parametrize("arguments", [(), ("currents-v2",)])
def test_a_benchmark_without_an_arm_is_refused_with_the_names_of_those_that_have_one(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert "valve-v1" in capsys.readouterr().out
