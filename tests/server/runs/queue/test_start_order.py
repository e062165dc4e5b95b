"""The order of the queue that admins see is the one in which runs start."""

import pytest
from sqlalchemy import event

from seamark.server.runs.queue import start_order
from tests.cast import Backend


def _order(both: Backend, limit: int = 100) -> list[int]:
    with both.database.reading() as session:
        return start_order.first(session, limit)


def _started(both: Backend, count: int) -> list[int]:
    return [both.claim_next().run_id for _ in range(count)]


@pytest.mark.parametrize("served", [0, 3])
def test_the_listed_order_is_the_one_in_which_runs_are_claimed(both: Backend, served: int) -> None:
    both.settings = both.settings.model_copy(update={"running_max": 100, "quota_live": 100})
    for who in ("ann", "ann", "ann", "guest", "ben", "ann", "eva", "guest", "ben", "eva", "guest"):
        both.queue(who)
    _started(both, served)

    listed = _order(both)

    assert len(listed) == 11 - served
    assert listed == _started(both, len(listed))


def test_a_part_of_the_order_is_its_beginning(both: Backend) -> None:
    for who in ("ann", "ann", "ben", "guest"):
        both.queue(who)

    assert _order(both, 3) == _order(both)[:3]
    assert len(_order(both)) == 4


def test_the_order_costs_the_same_number_of_queries_at_any_length(both: Backend) -> None:
    statements: list[str] = []
    event.listen(
        both.database.engine,
        "before_cursor_execute",
        lambda _c, _k, statement, *_rest: statements.append(statement),
    )

    both.queue("ann")
    statements.clear()
    _order(both)
    short = len(statements)
    for who in ("ann", "ben", "eva", "guest"):
        both.queue(who)
    statements.clear()
    _order(both)

    assert len(statements) == short
