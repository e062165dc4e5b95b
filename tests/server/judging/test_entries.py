"""What teams submit: in time, within the quota, with the scenario of the organiser."""

import threading
import time

import pytest
from sqlalchemy import select, update

from seamark.programs.failure_reasons import FailureReason
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.database.competition_tables import Entry, Team
from seamark.server.database.tables import Run
from seamark.server.judging import entries
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission.validation import Submission, SubmissionRejected
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import Backend
from tests.server.judging.cup import DAY_S, FINAL, PRACTICE, QUALIFICATION, Cup, round_of


@pytest.fixture
def cup(backend: Backend) -> Cup:
    made = Cup.opened(backend)
    made.team("ann", "ben")
    return made


def own(cup: Cup, who: str) -> list[entries.EntryView]:
    view = cup.view
    with cup.backend.database.reading() as session:
        team = teams.of_user(session, cup.id, cup.backend.user_id(who))
        assert team is not None
        return entries.own(session, view, team.id)


def leave(cup: Cup, who: str) -> None:
    with cup.backend.database.writing() as session:
        team = teams.of_user(session, cup.id, cup.backend.user_id(who))
        assert team is not None
        teams.leave(session, team, cup.backend.user_id(who))


def test_an_entry_has_the_scenario_of_the_organiser_and_belongs_to_the_team(cup: Cup) -> None:
    run_id = cup.submit("ann", config={"kp": 0.5})

    with cup.backend.database.reading() as session:
        run = session.get_one(Run, run_id)
        assert (run.config["levels"], run.config["kp"]) == ([0.0, 0.2], 0.5)
        assert (run.user_id, run.guest, run.trials) == (None, None, 3)
        assert run.owner.startswith(teams.OWNER)


def test_a_setting_of_the_scenario_cannot_be_chosen(cup: Cup) -> None:
    with pytest.raises(SubmissionRejected, match="fixes") as caught:
        cup.submit("ann", config={"levels": [0.0]})
    assert caught.value.field == "levels"


def test_the_true_corners_are_no_tracker_of_an_entry(cup: Cup) -> None:
    with pytest.raises(ConfigurationInvalid, match="tracker"):
        cup.submit("ann", config={"tracker": "truth"})


def test_a_reference_solution_is_no_entry_of_a_team(cup: Cup) -> None:
    with pytest.raises(SubmissionRejected, match="reference entry"):
        cup.submit("ann", controller="oracle")


def test_a_submission_draws_water_by_what_is_submitted_and_by_the_round(cup: Cup) -> None:
    first, second = cup.submit("ann"), cup.submit("ben")
    third = cup.submit("ann", config={"kp": 0.7})

    with cup.backend.database.reading() as session:
        seeds = [session.get_one(Run, run_id).seed for run_id in (first, second, third)]
    assert seeds[0] == seeds[1] != seeds[2]


def test_whoever_is_in_no_team_submits_nothing(cup: Cup) -> None:
    with pytest.raises(SubmissionRejected, match="no team"):
        cup.submit("eva")


def test_members_share_the_quota_of_their_team(cup: Cup) -> None:
    for who in ("ann", "ben", "ann"):
        cup.submit(who)

    with pytest.raises(SubmissionRejected, match="used its submissions"):
        cup.submit("ben")
    assert entries.left(own(cup, "ann"), cup.view.rounds[QUALIFICATION - 1]) == 0


def test_what_the_service_broke_or_was_cancelled_before_it_started_does_not_count(
    cup: Cup,
) -> None:
    cup.fail(cup.submit("ann"), FailureReason.PLATFORM_ERROR)
    assert cup.backend.cancel(cup.submit("ann"))
    cup.fail(cup.submit("ann"))

    assert entries.left(own(cup, "ann"), cup.view.rounds[QUALIFICATION - 1]) == 2


def test_two_submissions_at_once_do_not_both_take_the_last_one_of_the_quota(both: Backend) -> None:
    cup = Cup.opened(both)
    cup.team("ann", "ben")
    cup.submit("ann"), cup.submit("ann")
    begin, refused = threading.Barrier(2), list[str]()

    def submit(who: str) -> None:
        begin.wait()
        try:
            cup.submit(who)
        except SubmissionRejected as refusal:
            refused.append(str(refusal))

    together = [threading.Thread(target=submit, args=(who,)) for who in ("ann", "ben")]
    for thread in together:
        thread.start()
    for thread in together:
        thread.join()

    assert len(refused) == 1
    assert len(own(cup, "ann")) == 3


def test_a_team_has_a_limited_number_of_methods(backend: Backend) -> None:
    cup = Cup.opened(backend, methods=1)
    cup.team("ann")
    cup.submit("ann", "Sliding mode")
    cup.submit("ann", "sliding  MODE")

    with pytest.raises(SubmissionRejected, match="1 methods at most") as caught:
        cup.submit("ann", "MPC")
    assert caught.value.field == entries.METHOD


def test_what_was_submitted_in_time_counts_whenever_it_is_evaluated(cup: Cup) -> None:
    run_id = cup.submit("ann")
    cup.close_qualification()
    cup.advance()
    assert cup.view.rounds[QUALIFICATION - 1].decided_at is None  # it waits for the entry

    cup.finish(run_id, [40.0, 41.0, 42.0])
    cup.advance()
    assert cup.view.rounds[QUALIFICATION - 1].decided_at is not None
    assert [row.run_id for row in cup.board(QUALIFICATION).rows] == [run_id]


def test_a_round_that_closes_during_a_submission_does_not_accept_it(cup: Cup) -> None:
    backend = cup.backend
    with backend.database.reading() as session:
        sent = entries.for_competition(
            *(session, cup.view.name, "PI"),
            Submission(
                viewer=backend.viewers["ann"], benchmark="currents-v1", config={}, controller="pi"
            ),
            backend.settings,
        )
    cup.close_qualification()
    valid = cup.validated(sent)

    with backend.database.writing() as session, pytest.raises(SubmissionRejected, match="closed"):
        cup.insert(session, valid)


def test_nobody_submits_between_rounds_or_to_a_final(cup: Cup) -> None:
    cup.close_qualification()
    with pytest.raises(SubmissionRejected, match="No round"):
        cup.submit("ann")
    cup.shift(FINAL, opens_in_s=-1.0)
    with pytest.raises(SubmissionRejected, match="No round"):
        cup.submit("ann")


def test_no_rule_of_ranked_runs_keeps_an_entry_off_a_board(cup: Cup) -> None:
    run_id = cup.submit("ann")
    cup.finish(run_id, [40.0, 41.0, 42.0], broken=3)

    assert [row.run_id for row in cup.board(QUALIFICATION).rows] == [run_id]


def test_an_entry_without_a_value_of_the_expression_says_why_at_its_run(backend: Backend) -> None:
    cup = Cup.opened(backend, settings={"levels": [0.0, 0.2], "score": "1 / (score - 41)"})
    cup.team("ann")
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])

    refusal = own(cup, "ann")[0].refusal or ""
    assert refusal.startswith("The score of the competition has no value:")
    assert backend.show(run_id).not_ranked == refusal
    assert cup.board(QUALIFICATION).rows == ()


def test_the_expression_of_the_organiser_is_the_score(backend: Backend) -> None:
    cup = Cup.opened(backend, settings={"levels": [0.0, 0.2], "score": "2 * score - 1"})
    cup.team("ann")
    cup.entered("ann", [40.0, 41.0, 42.0])

    assert own(cup, "ann")[0].score == 81.0


def test_a_withdrawn_entry_is_on_no_board_and_still_counts_for_the_quota(cup: Cup) -> None:
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])
    view = cup.view
    with cup.backend.database.writing() as session:
        team = teams.of_user(session, cup.id, cup.backend.user_id("ann"))
        assert team is not None
        entries.withdraw(session, view, team, run_id)

    assert cup.board(QUALIFICATION).rows == ()
    assert entries.left(own(cup, "ann"), cup.view.rounds[QUALIFICATION - 1]) == 2


def test_entries_stay_with_the_team_when_a_member_leaves_or_deletes_the_account(
    both: Backend,
) -> None:
    cup = Cup.opened(both)
    team_id = cup.team("ann", "ben")
    cup.entered("ann", [40.0, 41.0, 42.0])
    with both.database.writing() as session:
        account_deletion.close(session, both.user_id("ann"), keep_published=False)
    while account_deletion.step(both.database, both.settings):
        pass

    assert [row.team_id for row in cup.board(QUALIFICATION).rows] == [team_id]
    with both.database.reading() as session:
        assert session.get_one(Team, team_id).captain_id == both.user_id("ben")
        assert session.scalars(select(Entry.user_id).where(Entry.team_id == team_id)).one() is None


def test_a_competition_goes_on_when_its_organiser_deletes_the_account(both: Backend) -> None:
    cup = Cup.opened(both)
    cup.team("ann")
    cup.entered("ann", [40.0, 41.0, 42.0])
    with both.database.writing() as session:
        account_deletion.close(session, both.user_id("olga"), keep_published=False)
    while account_deletion.step(both.database, both.settings):
        pass
    for _ in cup.begin_final():
        cup.play_batch({})
        cup.advance()

    assert cup.view.ended_at is not None
    assert cup.view.organiser == ""


def test_the_last_member_who_leaves_leaves_the_entries_in_the_competition(cup: Cup) -> None:
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])
    for who in ("ann", "ben"):
        leave(cup, who)

    assert [row.run_id for row in cup.board(QUALIFICATION).rows] == [run_id]


def test_nobody_gets_a_second_quota_by_another_team(cup: Cup) -> None:
    cup.submit("ann")
    leave(cup, "ann")

    with pytest.raises(CompetitionRefused, match="submitted for the team Team ann"):
        cup.team("ann", name="Second")


def test_a_member_who_left_may_come_back_to_the_same_team(cup: Cup) -> None:
    cup.submit("ben")
    leave(cup, "ben")
    with cup.backend.database.writing() as session:
        team = teams.of_user(session, cup.id, cup.backend.user_id("ann"))
        assert team is not None
        teams.join(session, cup.view, cup.backend.user_id("ben"), team.code)

    assert own(cup, "ben")


def test_a_moved_end_moves_the_rounds_after_it_and_everybody_sees_why(cup: Cup) -> None:
    before = [one.opens_at for one in cup.view.rounds]
    until = before[FINAL - 1] + DAY_S
    with cup.backend.database.writing() as session:
        competitions.move_round(session, cup.view, QUALIFICATION, until, "The service was down.")

    rounds = cup.view.rounds
    assert rounds[QUALIFICATION - 1].closes_at == until
    assert rounds[FINAL - 1].opens_at == until
    assert [move.reason for move in rounds[QUALIFICATION - 1].moves] == ["The service was down."]


def test_a_round_that_has_closed_can_be_extended_until_it_is_decided(cup: Cup) -> None:
    cup.close_qualification()
    with cup.backend.database.writing() as session:
        until = time.time() + 60.0
        competitions.move_round(session, cup.view, QUALIFICATION, until, "The service was down.")
    cup.submit("ann")

    with cup.backend.database.writing() as session:
        session.execute(update(Run).values(state=RunState.CANCELLED))
    cup.close_qualification()
    cup.advance()
    with cup.backend.database.writing() as session, pytest.raises(CompetitionRefused):
        competitions.move_round(session, cup.view, QUALIFICATION, time.time() + 60.0, "Again.")


@pytest.mark.parametrize("until", [0.0, float("nan"), 1e12])
def test_a_round_is_moved_to_a_later_time_within_reach(cup: Cup, until: float) -> None:
    with cup.backend.database.writing() as session, pytest.raises(CompetitionRefused):
        competitions.move_round(session, cup.view, QUALIFICATION, until, "The service was down.")


def test_the_organiser_does_not_take_part_and_nobody_is_in_two_teams(cup: Cup) -> None:
    with pytest.raises(CompetitionRefused, match="organise"):
        cup.team("olga")
    with pytest.raises(CompetitionRefused, match="in a team"):
        cup.team("ann", name="Second")


def test_practice_of_one_round_does_not_count_in_the_next(backend: Backend) -> None:
    rounds = [
        round_of("practice", -DAY_S, DAY_S, trials=3, quota=1),
        round_of("qualification", DAY_S, 2 * DAY_S, trials=3, quota=1),
    ]
    cup = Cup.opened(backend, rounds=rounds)
    cup.team("ann")
    cup.entered("ann", [90.0, 90.0, 90.0])
    cup.shift(PRACTICE, closes_in_s=-1.0)
    cup.shift(QUALIFICATION, opens_in_s=-1.0)
    second = cup.entered("ann", [40.0, 40.0, 41.0])

    assert [row.run_id for row in cup.board(QUALIFICATION).rows] == [second]
