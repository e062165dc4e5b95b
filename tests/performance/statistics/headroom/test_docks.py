"""The table of the reference entries of dock-v1."""

from performance import DOCS
from performance.statistics.headroom.docks import PLAN, columns
from performance.statistics.headroom.over_current import Measured, ordered, reference_table
from seamark.sim.numerics.statistics import mean, paired_interval


def test_a_row_has_the_share_that_docked_at_each_current_and_the_trials_by_vehicle() -> None:
    levels = {"docking": (0.8, 0.6, 0.4, 0.2, 0.0), "docked": (1.0, 0.75, 0.5, 0.25, 0.125)}
    one = Measured(seed=1, scores=[0.1, 0.2, 0.3, 0.4], levels=levels)

    cells = columns(one)

    assert [*cells.values()][:5] == ["100", "75", "50", "25", "12"]
    assert [*cells][1] == "docked at 0.2 m/s, %"
    assert (cells["Girona 500"], cells["BlueROV2 Heavy"]) == ("0.200", "0.300")


def test_the_table_of_the_page_is_that_of_the_stored_scores() -> None:
    table = reference_table(PLAN, PLAN.known(), PLAN.titles())

    assert table in (DOCS / "benchmarks.md").read_text("utf-8")


def test_every_entry_is_measured_and_the_scale_ends_at_nothing_and_the_oracle() -> None:
    known = PLAN.known()
    names = ordered(known)
    scale = PLAN.definition.scale

    assert set(known) == set(PLAN.definition.baselines)
    assert (names[0], names[-1]) == ("nothing", "oracle")
    assert scale is not None
    ends = [mean(known[name].scores) for name in (names[0], names[-1])]
    assert [round(end, 3) for end in ends] == [*scale]


def test_what_looks_is_better_than_what_does_not_and_the_oracle_is_better_than_all() -> None:
    known = PLAN.known()
    for worse, better in (
        ("nothing", "blind"),
        ("nothing", "acoustic"),
        ("blind", "straight"),
        ("acoustic", "straight"),
        ("acoustic", "staged"),
        ("straight", "oracle"),
        ("staged", "oracle"),
    ):
        assert mean(known[better].scores) > 1.2 * mean(known[worse].scores), (worse, better)
        interval = paired_interval(known[better].scores, known[worse].scores, block=PLAN.block)
        assert interval is not None
        assert interval[0] > 0.0, (worse, better)
