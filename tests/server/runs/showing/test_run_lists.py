"""Lists of runs in every order, filtered and searched, page by page."""

from typing import Any

import pytest

from seamark.server.runs.ending import deletion
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import FIRST, ListCursor, RunFilter, RunOrder
from tests.cast import Backend

ORDERS = tuple(RunOrder)


def _pages(backend: Backend, run_filter: RunFilter, order: RunOrder, limit: int) -> list[int]:
    """Return the numbers of all runs of a list, following its pages."""
    found: list[int] = []
    start: ListCursor | None = FIRST
    while start is not None:
        with backend.database.reading() as session:
            page = run_lists.page(
                session, backend.viewers["ann"], run_filter, order=order, start=start, limit=limit
            )
        found += [run.id for run in page.runs]
        start = page.next
    return found


def _listed(backend: Backend, order: RunOrder = RunOrder.NEWEST, **wanted: Any) -> list[int]:
    return _pages(backend, RunFilter(**wanted), order, 50)


def test_each_order_sorts_by_what_it_says(both: Backend) -> None:
    scores = {"beta": 20.0, "alpha": 60.0, "": 40.0}
    ids = {}
    for title, score in scores.items():
        claim = both.running("ann", title=title)
        assert both.finish(claim, score=score)
        ids[title] = claim.run_id
    waiting = both.queue("ann", title="Zeta")
    b, a, nameless = ids["beta"], ids["alpha"], ids[""]

    assert _listed(both, RunOrder.NEWEST) == [waiting, nameless, a, b]
    assert _listed(both, RunOrder.OLDEST) == [b, a, nameless, waiting]
    assert _listed(both, RunOrder.HIGHEST) == [a, nameless, b, waiting]
    assert _listed(both, RunOrder.LOWEST) == [b, nameless, a, waiting]
    assert _listed(both, RunOrder.TITLE) == [a, b, waiting, nameless]


@pytest.mark.parametrize("order", ORDERS)
def test_following_the_pages_shows_every_run_exactly_once(
    backend: Backend, order: RunOrder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_lists, "SEEN_MAX", 3)  # windows of three runs
    ids = {backend.succeeded("ann", title=f"run {number % 3}") for number in range(7)}
    backend.queue("ben")

    found = _pages(backend, RunFilter(text="run"), order, 2)

    assert len(found) == len(ids)
    assert set(found) == ids


def test_a_search_needs_every_word_somewhere(both: Backend) -> None:
    program = both.store_program(name="50%_station.py")
    mine = both.queue("ann", title="Gain sweep", controller="upload", program=program)
    other = both.queue("ann", title="Baseline")

    assert _listed(both, text="gain STATION") == [mine]
    assert _listed(both, text="currents-v1") == [other, mine]
    assert _listed(both, text="gain baseline") == []
    assert _listed(both, text="50%_") == [mine]
    assert _listed(both, text="5__") == []
    assert _listed(both, text=f"#{other}") == [other]


def test_filters_of_state_kind_and_program_leave_out_the_others(both: Backend) -> None:
    uploaded = both.queue_program("ann")
    built_in = both.queue("ann")
    ranked = both.queue("ann", kind="ranked")

    assert _listed(both, program="uploaded") == [uploaded]
    assert _listed(both, program="python") == [uploaded]
    assert _listed(both, program="c") == []
    assert _listed(both, program="built-in", kind="practice") == [built_in]
    assert _listed(both, kind="ranked") == [ranked]


def test_a_deleted_run_is_in_no_list(both: Backend) -> None:
    kept, gone = both.succeeded("ann"), both.succeeded("ann")

    deletion.delete(both.database, both.settings, [gone])

    assert _listed(both) == [kept]
    assert _listed(both, RunOrder.HIGHEST) == [kept]
