"""The tables of the reference entries of benchmarks with an arm."""

from itertools import pairwise
from pathlib import Path

import pytest

from performance import DOCS
from performance.statistics.headroom.interventions import (
    PUBLISHED,
    SCORES,
    columns,
    main,
    plan,
    published_table,
)
from performance.statistics.headroom.over_current import (
    Measured,
    at_speeds,
    insert,
    ordered,
    reference_table,
)
from seamark.sim.numerics.statistics import mean, paired_interval


def test_a_row_has_how_often_the_work_was_done_at_each_speed_and_both_halves() -> None:
    done = (1.0, 0.75, 0.5, 0.25, 0.125, 0.0)
    one = Measured(seed=1, scores=(0.1, 0.2, 0.3, 0.4), levels={"completed": done})

    cells = columns((0.0, 0.1, 0.2, 0.3, 0.4, 0.5), (), one)

    assert [*cells.values()][: len(done)] == ["100", "75", "50", "25", "12", "0"]
    assert [*cells][1] == "done at 0.1 m/s, %"
    assert (cells["first half"], cells["second half"]) == ("0.150", "0.350")


def test_a_grid_has_the_mean_of_the_levels_at_each_speed_and_of_all_for_further_metrics() -> None:
    levels = {"completed": (1.0, 0.5, 0.5, 0.0), "wrong": (0.0, 0.5, 0.5, 0.0)}
    one = Measured(seed=1, scores=(0.1, 0.2), levels=levels)

    cells = columns((0.0, 0.0, 0.25, 0.25), ("wrong",), one)

    assert cells["done at 0 m/s, %"] == "75"
    assert cells["done at 0.25 m/s, %"] == "25"
    assert cells["wrong, %"] == "25"


def test_our_entries_stand_beside_what_others_published_at_the_same_speeds() -> None:
    done = (1.0, 0.75, 0.5, 0.25, 0.125, 0.0)
    one = Measured(seed=1, scores=(), levels={"completed": done})

    entries = {"scripted": one, "resolved-rate": one, "oracle": one}
    head, _, *rows = published_table("valve-v1", entries).splitlines()

    assert head == "| entry | success [%] at 0 m/s | 0.1 m/s | 0.2 m/s |"
    assert rows[0].endswith("| 87.8 | 64.4 | 68.9 |")
    assert len(rows) == 4
    assert all(row.endswith("| 100.0 | 75.0 | 50.0 |") for row in rows[1:])


def test_a_page_keeps_the_tables_of_two_benchmarks_apart(tmp_path: Path) -> None:
    texts = [published_table(name, plan(name).known()) for name in PUBLISHED]
    page = tmp_path / "page.md"
    page.write_text("\n\n".join(texts) + "\n", "utf-8")
    before = page.read_text("utf-8")

    for text in texts:
        insert(page, text)

    assert page.read_text("utf-8") == before


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_page_has_the_table_of_what_others_published_beside_ours(name: str) -> None:
    table = published_table(name, plan(name).known())

    assert table in (DOCS / "benchmarks.md").read_text("utf-8")


@pytest.mark.parametrize("arguments", [(), ("currents-v2",)])
def test_a_benchmark_without_an_arm_is_refused_with_the_names_of_those_that_have_one(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert "valve-v1" in capsys.readouterr().out


ORDER = {  # from the worst to the best built-in entry, between nothing and the oracle
    "recover-v1": ["blind", "imitation", "scripted", "resolved-rate"],
    "valve-v1": ["blind", "scripted", "resolved-rate"],
    "connect-v1": ["blind", "scripted", "resolved-rate"],
    "mission-v1": ["lawnmower", "no-recognition", "chain"],
}


@pytest.mark.parametrize("name", SCORES)
def test_each_entry_is_better_than_the_one_below_it_by_more_than_the_interval(name: str) -> None:
    stored = plan(name).known()
    order = ordered(stored)
    steps = {
        (worse, better): paired_interval(stored[better].scores, stored[worse].scores, block=1)
        for worse, better in pairwise(order)
    }

    assert order == ["nothing", *ORDER[name], "oracle"]
    assert all(step is not None and step[0] > 0.0 for step in steps.values()), steps


@pytest.mark.parametrize("name", SCORES)
def test_the_best_built_in_idea_leaves_a_fifth_of_the_scale_to_the_oracle(name: str) -> None:
    stored = plan(name).known()

    assert mean(stored[ORDER[name][-1]].scores) <= 0.8 * mean(stored["oracle"].scores)


@pytest.mark.parametrize("name", SCORES)
def test_the_oracles_credit_falls_with_the_current_neither_all_at_once_nor_hardly(
    name: str,
) -> None:
    headroom = plan(name)
    speeds = headroom.definition.read({}).level_values()
    credit = [*at_speeds(speeds, headroom.known()["oracle"].levels["credit"]).values()]

    assert max(weaker - stronger for weaker, stronger in pairwise(credit)) < 0.4
    assert credit[0] - credit[-1] > 0.4


@pytest.mark.parametrize("name", SCORES)
def test_the_page_has_the_table_of_what_was_measured_and_the_benchmark_its_scale(
    name: str,
) -> None:
    headroom = plan(name)
    stored = headroom.known()

    table = reference_table(headroom, stored, headroom.titles())

    assert table in (DOCS / "benchmarks.md").read_text("utf-8")
    assert headroom.definition.scale == pytest.approx(
        [mean(stored[name].scores) for name in ("nothing", "oracle")], abs=0.0005
    )


def test_the_scripted_entry_recovers_the_box_in_four_of_five_trials_at_0_1_m_s() -> None:
    assert plan("recover-v1").known()["scripted"].levels["completed"][1] >= 0.8
