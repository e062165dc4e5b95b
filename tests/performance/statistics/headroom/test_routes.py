"""The table of the reference entries of track-v1."""

from performance import DOCS
from performance.statistics.headroom.over_current import Measured, ordered, reference_table
from performance.statistics.headroom.routes import PLAN, columns
from seamark.sim.numerics.statistics import mean, paired_interval


def test_a_row_has_what_was_followed_at_each_current_and_the_trials_by_vehicle_and_route() -> None:
    scores = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8] * 2
    one = Measured(seed=1, scores=scores, levels={"followed": (1.0, 0.75, 0.5, 0.25, 0.125)})

    cells = columns(one)

    assert [*cells.values()][:5] == ["100", "75", "50", "25", "12"]
    assert [*cells][1] == "followed at 0.2 m/s, %"
    assert (cells["Girona 500"], cells["BlueROV2 Heavy"]) == ("0.400", "0.500")
    kinds = [cells[kind] for kind in ("Waypoints", "Helix", "Lemniscate", "Pipe")]
    assert kinds == ["0.150", "0.350", "0.550", "0.750"]


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


def test_from_nothing_to_the_oracle_each_step_is_better_than_the_one_before() -> None:
    known = PLAN.known()
    for worse, better in (
        ("nothing", "pi"),
        ("blind", "pi"),
        ("pi", "p"),
        ("p", "los"),
        ("los", "l1"),
        ("los", "mpc"),
        ("los", "into-flow"),
        ("l1", "oracle"),
        ("into-flow", "oracle"),
    ):
        interval = paired_interval(known[better].scores, known[worse].scores, block=PLAN.block)
        assert interval is not None
        assert interval[0] > 0.0, (worse, better)
