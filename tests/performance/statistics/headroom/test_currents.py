"""The table of the reference entries."""

from itertools import pairwise
from pathlib import Path

import pytest

from performance import DOCS
from performance.statistics.headroom.currents import BEFORE, PLAN
from performance.statistics.headroom.over_current import (
    Headroom,
    Measured,
    insert,
    ordered,
    reference_table,
    share_of_scale,
)
from seamark.sim.numerics.statistics import mean, paired_interval

TITLES = {"nothing": "Nothing", "pi": "PI", "oracle": "Oracle"}


def trials(*scores: float) -> Measured:
    return Measured(seed=1, scores=scores, levels={})


ENTRIES = {
    "oracle": trials(0.6, 0.8, 0.6, 0.8),
    "nothing": trials(0.0, 0.02, 0.0, 0.02),
    "pi": trials(0.2, 0.4, 0.21, 0.41),
}


def test_entries_are_ordered_from_the_worst_to_the_best() -> None:
    assert ordered(ENTRIES) == ["nothing", "pi", "oracle"]


def test_the_scale_goes_from_doing_nothing_to_the_oracle() -> None:
    assert [share_of_scale(score, (0.1, 0.9)) for score in (0.1, 0.5, 0.9)] == pytest.approx(
        [0.0, 50.0, 100.0]
    )


def test_a_row_has_score_interval_share_of_the_scale_step_and_parts() -> None:
    rows = reference_table(BEFORE, ENTRIES, TITLES).splitlines()[2:]
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]

    assert [row[0] for row in cells] == ["Nothing", "PI", "Oracle"]
    assert [row[2] for row in cells] == ["0.0", "42.8", "100.0"]
    assert cells[1][1].startswith("0.305 (0.2")
    assert cells[1][4:] == ["0.205", "0.405", "0.300", "0.310"]
    low, high = map(float, cells[1][3].split(" to "))
    assert low < 0.295 < high


def test_only_the_table_of_a_page_changes(tmp_path: Path) -> None:
    path = tmp_path / "page.md"
    other = "| entry | points |\n|---|---|\n| PI | 84.7 |\n"
    old = "| entry | current held [m/s] |\n|---|---|\n| PI | 1 |\n"
    path.write_text(f"{other}\nbefore\n\n{old}\nafter\n")

    insert(path, reference_table(BEFORE, ENTRIES, TITLES))

    text = path.read_text()
    assert text.startswith(f"{other}\nbefore\n\n| entry | current held [m/s], 95 % interval |")
    assert text.endswith("|\n\nafter\n")
    assert "| PI | 1 |" not in text


@pytest.mark.parametrize("plan", [BEFORE, PLAN], ids=lambda plan: plan.benchmark)
def test_each_entry_but_mpc_is_better_than_the_one_below_it_by_more_than_the_interval(
    plan: Headroom,
) -> None:
    stored = plan.known()
    apart = ordered({name: one for name, one in stored.items() if name != "mpc"})
    steps = {
        (worse, better): paired_interval(stored[better].scores, stored[worse].scores, block=2)
        for worse, better in pairwise(apart)
    }

    assert set(stored) == set(plan.definition.baselines)
    assert all(step is not None and step[0] > 0.0 for step in steps.values()), steps


def test_mpc_is_better_than_l1_and_cannot_be_told_from_lqg() -> None:
    stored = BEFORE.known()
    mpc = stored["mpc"].scores

    below = paired_interval(mpc, stored["l1"].scores, block=2)
    beside = paired_interval(mpc, stored["lqr"].scores, block=2)

    assert below is not None
    assert beside is not None
    assert below[0] > 0.0
    assert beside[0] < 0.0 < beside[1]


@pytest.mark.parametrize("plan", [BEFORE, PLAN], ids=lambda plan: plan.benchmark)
def test_the_page_has_the_table_of_what_was_measured_and_the_benchmark_its_scale(
    plan: Headroom,
) -> None:
    stored = plan.known()
    table = reference_table(plan, stored, plan.titles())

    assert table in (DOCS / "benchmarks.md").read_text("utf-8")
    assert plan.definition.scale == pytest.approx(
        [mean(stored[name].scores) for name in ("nothing", "oracle")], abs=0.0005
    )
