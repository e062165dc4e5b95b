"""A competition from the draft to the podium, on both databases."""

from sqlalchemy import select

from seamark.competitions import keys
from seamark.server.database.competition_tables import Entry
from seamark.server.database.tables import Run
from tests.cast import Backend
from tests.server.judging.cup import FINAL, NAME, QUALIFICATION, Cup


def test_a_competition_goes_from_the_draft_to_the_podium(both: Backend) -> None:
    cup = Cup.opened(both)
    reef, wreck = cup.team("ann", "ben", name="Reef"), cup.team("eva", name="Wreck")
    cup.entered("ann", [40.0, 41.0, 42.0], "PI")
    first = cup.entered("ben", [50.0, 51.0, 52.0], "Sliding mode")
    second = cup.entered("eva", [60.0, 61.0, 62.0], "MPC")

    assert [row.team for row in cup.board(QUALIFICATION).rows] == ["Wreck", "Reef"]
    assert [row.method for row in cup.board(QUALIFICATION, by_method=True).rows] == [
        *("MPC", "Sliding mode", "PI"),
    ]

    runs = cup.begin_final()
    with both.database.reading() as session:
        carried = set(session.scalars(select(Entry.carried).where(Entry.run_id.in_(runs))))
        seeds = set(session.scalars(select(Run.seed).where(Run.id.in_(runs))))
    assert {first, second} < carried
    assert len(seeds) == 1  # all on the same water
    cup.play_batch({"MPC": [30, 31, 32, 33, 34, 35.0], "Sliding mode": [40, 41, 42, 43, 44, 45.1]})
    assert cup.advance() == 0

    view = cup.view
    assert view.ended_at is not None
    board = cup.board(FINAL)
    assert [(row.place, row.team_id) for row in board.rows] == [(1, reef), (2, wreck)]
    assert len(board.references) == len(view.document.base.baselines)
    for one in view.rounds:
        assert one.key is not None
        assert keys.commitment(bytes.fromhex(one.key)) == one.commitment
    key = bytes.fromhex(view.rounds[-1].key or "")
    assert seeds == {keys.seed(key, NAME, keys.final_label(1))}
    assert all(both.show(run_id).public for run_id in runs)
