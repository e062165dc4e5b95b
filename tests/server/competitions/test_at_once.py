"""What people do at the same moment: they make drafts, found teams and join them."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import Any

from sqlalchemy.orm import Session

from seamark.competitions import document
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.refusals import CompetitionRefused
from tests.cast import Backend
from tests.server.judging.cup import Cup, values

OVERLAP_S = 0.2  # for which a transaction stays open


def outcomes(backend: Backend, *acts: Callable[[Session], object]) -> list[str]:
    """Let each act be done in a transaction of its own, all at once."""
    together = Barrier(len(acts))

    def done(act: Callable[[Session], object]) -> str:
        together.wait()
        try:
            with backend.database.writing() as session:
                act(session)
                time.sleep(OVERLAP_S)
        except CompetitionRefused:
            return "refused"
        return "done"

    with ThreadPoolExecutor(len(acts)) as pool:
        return sorted(pool.map(done, acts))


def test_of_two_teams_that_are_founded_with_one_name_at_once_one_is_refused(both: Backend) -> None:
    view = Cup.opened(both).view
    ann, eva = both.user_id("ann"), both.user_id("eva")

    found = outcomes(
        both,
        lambda session: teams.found(session, view, ann, "Kelp"),
        lambda session: teams.found(session, view, eva, "KELP"),
    )

    assert found == ["done", "refused"]


def test_who_founds_two_teams_at_once_is_in_one(both: Backend) -> None:
    view, ann = Cup.opened(both).view, both.user_id("ann")

    found = outcomes(
        both,
        lambda session: teams.found(session, view, ann, "Kelp"),
        lambda session: teams.found(session, view, ann, "Wrack"),
    )

    assert found == ["done", "refused"]


def test_a_team_with_one_free_place_takes_one_of_two_who_join_at_once(both: Backend) -> None:
    cup = Cup.opened(both, team_size=2)
    cup.team("ann")
    view = cup.view
    with both.database.reading() as session:
        team = teams.of_user(session, cup.id, both.user_id("ann"))
    assert team is not None
    eva, ben = both.user_id("eva"), both.user_id("ben")

    joined = outcomes(
        both,
        lambda session: teams.join(session, view, eva, team.code),
        lambda session: teams.join(session, view, ben, team.code),
    )

    assert joined == ["done", "refused"]


def test_of_two_drafts_that_are_made_with_one_name_at_once_one_is_refused(both: Backend) -> None:
    asked = competitions.prepared(document.read(values()), None)
    more: dict[str, Any] = {"picture": None, "vehicle": None, "secret": b"secret"}
    olga, root = both.user_id("olga"), both.user_id("root")

    made = outcomes(
        both,
        lambda session: competitions.create(session, olga, asked, **more),
        lambda session: competitions.create(session, root, asked, **more),
    )

    assert made == ["done", "refused"]
