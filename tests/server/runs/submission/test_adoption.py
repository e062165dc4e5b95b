"""Runs of a guest who signs in."""

from seamark.server.accounts.permissions import Viewer
from seamark.server.runs.submission.adoption import adopt_runs
from tests.cast import Backend


def test_queued_runs_of_a_guest_who_signs_in_take_turns_as_those_of_the_account(
    both: Backend,
) -> None:
    both.viewers["other"] = Viewer(guest="h", network="n")
    first, second, late = both.queue("other"), both.queue("guest"), both.queue("guest")
    bens = [both.queue("ben") for _ in range(2)]

    with both.database.writing() as session:
        adopted = adopt_runs(session, both.user_id("ann"), "g")

    order = [second, bens[0], late, bens[1], first]
    assert adopted == 2
    assert [both.show(run_id).position for run_id in order] == [1, 2, 3, 4, 5]
    assert [both.claim_next().run_id for _ in order] == order
