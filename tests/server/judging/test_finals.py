"""Finals: who is carried into them, on which trials they are evaluated, and when they end."""

import threading
from typing import Any

import pytest
from sqlalchemy import select

from seamark.competitions import keys
from seamark.programs.failure_reasons import FailureReason
from seamark.server.competitions import teams
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.database.competition_tables import Entry
from seamark.server.database.tables import Run
from seamark.server.judging import entries, finals
from seamark.server.runs.data import retention
from tests.cast import Backend
from tests.server.judging.cup import DAY_S, FINAL, PRACTICE, QUALIFICATION, Cup, round_of, values

SAME = [40.0, 41.0, 42.0]
APART = [30.0, 31.0, 32.0, 33.0, 34.0, 35.0]
BETTER = [value + 10.0 + 0.01 * at for at, value in enumerate(APART)]
MIXED = [36.0, 29.0, 38.0, 28.0, 36.0, 33.0]  # neither better nor worse than APART


def with_final(**changes: Any) -> dict[str, Any]:
    """Return the rounds of the usual document with another final."""
    rounds = values()["rounds"]
    return {"rounds": [*rounds[:2], rounds[2] | changes]}


def carried(cup: Cup) -> set[str]:
    """Return the methods of teams that are in the batch that waits."""
    query = select(Entry.method).where(Entry.run_id.in_(cup.live()), Entry.team_id.is_not(None))
    with cup.backend.database.reading() as session:
        return set(session.scalars(query))


def choose(cup: Cup, who: str, run_id: int, *, chosen: bool = True) -> None:
    view = cup.view
    with cup.backend.database.writing() as session:
        team = teams.of_user(session, cup.id, cup.backend.user_id(who))
        assert team is not None
        entries.choose(session, view, team, run_id, chosen=chosen)


def test_a_final_ends_after_one_batch_if_ranks_separate(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC")
    cup.begin_final()
    cup.play_batch({"PI": APART, "MPC": BETTER})

    assert cup.advance() == 0
    assert [(row.method, row.place_low, row.place_high) for row in cup.board(FINAL).rows] == [
        ("MPC", 1, 1),
        ("PI", 2, 2),
    ]
    assert cup.view.rounds[FINAL - 1].batches == 1


def test_a_final_whose_ranks_do_not_separate_ends_when_its_budget_is_spent(both: Backend) -> None:
    cup = Cup.opened(both)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC")
    cup.begin_final()
    for batch in (1, 2):
        assert cup.view.rounds[FINAL - 1].batches == batch
        assert cup.view.ended_at is None
        cup.play_batch({"PI": APART, "MPC": MIXED})
        cup.advance()

    board = cup.board(FINAL)
    assert cup.view.ended_at is not None
    assert {(row.place_low, row.place_high) for row in board.rows} == {(1, 2)}
    assert [row.place for row in board.rows] == [1, 2]


def test_each_batch_has_water_of_its_own_that_all_share(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC")
    seeds = []
    cup.begin_final()
    for _ in range(2):
        with backend.database.reading() as session:
            seeds.append(set(session.scalars(select(Run.seed).where(Run.id.in_(cup.live())))))
        cup.play_batch({"PI": APART, "MPC": MIXED})
        cup.advance()

    assert [len(each) for each in seeds] == [1, 1]
    assert seeds[0] != seeds[1]


def test_who_does_not_separate_shares_a_place_where_the_rules_say_so(backend: Backend) -> None:
    cup = Cup.opened(backend, ties="shared", **with_final(batches=1))
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC")
    cup.begin_final()
    cup.play_batch({"PI": APART, "MPC": MIXED})
    cup.advance()

    assert [row.place for row in cup.board(FINAL).rows] == [1, 1]


def test_of_exactly_equal_scores_the_earlier_submission_is_ahead(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.team("eva")
    cup.entered("eva", SAME, "MPC")
    cup.entered("ann", SAME, "PI")
    cup.begin_final()
    cup.play_batch({"PI": APART, "MPC": APART})
    cup.advance()

    assert [row.method for row in cup.board(FINAL).rows] == ["MPC", "PI"]
    assert cup.view.rounds[FINAL - 1].batches == 1  # more trials would not tell them apart


def test_the_best_entry_of_each_team_is_carried_into_the_final(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.entered("ann", [50.0, 51.0, 52.0], "Good")
    cup.entered("ann", SAME, "Bad")
    cup.begin_final()

    assert carried(cup) == {"Good"}


def test_as_many_methods_as_the_rules_say_are_carried_each_with_its_best_entry(
    backend: Backend,
) -> None:
    cup = Cup.opened(backend, **with_final(finalists=2))
    cup.team("ann")
    cup.entered("ann", [50.0, 51.0, 52.0], "A")
    cup.entered("ann", [49.0, 50.0, 51.0], "A")
    cup.entered("ann", SAME, "B")
    cup.begin_final()

    assert carried(cup) == {"A", "B"}


def test_a_team_takes_what_it_has_chosen_into_the_final(backend: Backend) -> None:
    cup = Cup.opened(backend, **with_final(carry="chosen"))
    cup.team("ann")
    cup.entered("ann", [50.0, 51.0, 52.0], "Lucky")
    second = cup.entered("ann", SAME, "Steady")
    choose(cup, "ann", second)
    cup.begin_final()

    assert carried(cup) == {"Steady"}


def test_a_team_that_has_chosen_nothing_takes_its_best_entry(backend: Backend) -> None:
    cup = Cup.opened(backend, **with_final(carry="chosen"))
    cup.team("ann")
    cup.entered("ann", [50.0, 51.0, 52.0], "Lucky")
    chosen = cup.entered("ann", SAME, "Steady")
    choose(cup, "ann", chosen)
    choose(cup, "ann", chosen, chosen=False)
    cup.begin_final()

    assert carried(cup) == {"Lucky"}


def test_a_team_chooses_no_more_methods_than_it_may_take(backend: Backend) -> None:
    cup = Cup.opened(backend, **with_final(carry="chosen"))
    cup.team("ann")
    first = cup.entered("ann", SAME, "A")
    choose(cup, "ann", first)
    choose(cup, "ann", cup.entered("ann", SAME, "A"))  # takes the place of the first
    with pytest.raises(CompetitionRefused, match="1 method in the final"):
        choose(cup, "ann", cup.entered("ann", SAME, "B"))


def test_nothing_is_chosen_or_withdrawn_once_the_final_has_begun(backend: Backend) -> None:
    cup = Cup.opened(backend, **with_final(carry="chosen"))
    cup.team("ann")
    run_id = cup.entered("ann", SAME)
    cup.begin_final()

    with pytest.raises(CompetitionRefused, match="too late"):
        choose(cup, "ann", run_id)


def test_an_entry_that_failed_or_was_withdrawn_is_not_carried(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.team("eva")
    cup.fail(cup.submit("ann", "Broken"))
    run_id, view = cup.entered("eva", SAME, "Gone"), cup.view
    with backend.database.writing() as session:
        team = teams.of_user(session, cup.id, backend.user_id("eva"))
        assert team is not None
        entries.withdraw(session, view, team, run_id)
    cup.begin_final()

    assert cup.live() == []
    assert cup.view.ended_at is not None  # nobody has qualified
    assert cup.board(FINAL).rows == ()


def test_a_program_that_fails_in_the_final_has_no_place(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC")
    for run_id in cup.begin_final():
        with backend.database.reading() as session:
            failed = session.get_one(Entry, run_id).method == "MPC"
        if failed:
            cup.fail(run_id)
        else:
            cup.finish(run_id, APART)
    cup.advance()

    rows = cup.board(FINAL).rows
    assert [(row.method, row.place, row.refusal) for row in rows] == [
        ("PI", 1, None),
        ("MPC", None, "It failed."),
    ]


def test_what_the_service_broke_in_the_final_is_evaluated_again_on_the_same_water(
    both: Backend,
) -> None:
    cup = Cup.opened(both)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    first, *others = cup.begin_final()
    cup.fail(first, FailureReason.PLATFORM_ERROR)
    for run_id in others:
        cup.finish(run_id, APART)

    assert cup.advance() == 1
    (again,) = cup.live()
    with both.database.reading() as session:
        assert session.get_one(Run, again).seed == session.get_one(Run, first).seed
    cup.finish(again, APART)
    cup.advance()
    assert [row.run_id for row in cup.board(FINAL).rows] == [again]


def test_two_processes_that_advance_at_once_add_one_batch(both: Backend) -> None:
    cup = Cup.opened(both)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    cup.close_qualification()
    cup.advance()
    cup.advance()
    cup.shift(FINAL, opens_in_s=-1.0)
    begin, queued = threading.Barrier(2), list[int]()

    def advance() -> None:
        begin.wait()
        queued.append(cup.advance())

    together = [threading.Thread(target=advance) for _ in range(2)]
    for thread in together:
        thread.start()
    for thread in together:
        thread.join()

    references = len(cup.asked.base.baselines)
    assert sorted(queued) == [0, 1 + references]
    assert cup.view.rounds[FINAL - 1].batches == 1


def test_a_final_ends_even_if_the_service_breaks_an_entry_again_and_again(
    backend: Backend,
) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    for run_id in cup.begin_final()[1:]:
        cup.finish(run_id, APART)
    for _ in range(finals.ATTEMPTS_MAX):
        (broken,) = cup.live()
        cup.fail(broken, FailureReason.PLATFORM_ERROR)
        cup.advance()

    assert cup.view.ended_at is not None
    assert cup.board(FINAL).rows[0].refusal == "The service could not evaluate it."


def test_nobody_but_an_admin_sees_a_run_of_the_final_before_it_is_decided(
    backend: Backend,
) -> None:
    cup = Cup.opened(backend, programs="public")
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    runs = cup.begin_final()
    entry = backend.show(runs[0]).entry

    assert entry is not None
    assert entry.sealed
    assert not entry.seen_by(backend.user_id("ann"), program=False)
    cup.play_batch({"PI": APART})
    cup.advance()
    assert backend.show(runs[0]).public


@pytest.mark.parametrize(("programs", "shown"), [("hidden", False), ("public", True)])
def test_programs_of_the_final_are_published_only_if_the_rules_say_so(
    backend: Backend, programs: str, shown: bool
) -> None:
    cup = Cup.opened(backend, programs=programs)
    cup.team("ann")
    run_id = cup.submit("ann", "Mine", controller="upload", program=backend.store_program())
    cup.finish(run_id, SAME)
    cup.begin_final()
    cup.play_batch({"Mine": APART})
    cup.advance()

    (row,) = cup.board(FINAL).rows
    assert backend.show(row.run_id).program_public is shown
    assert not backend.show(run_id).public  # of the qualification


def test_the_key_of_a_round_stays_secret_until_the_round_is_decided(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    cup.begin_final()

    revealed = [one.key is not None for one in cup.view.rounds]
    assert revealed == [True, True, False]


def test_a_key_that_does_not_fit_its_commitment_is_not_revealed(backend: Backend) -> None:
    cup = Cup.opened(backend)
    backend.settings = backend.settings.model_copy(update={"seed_key": "x" * 40})
    cup.shift(PRACTICE, closes_in_s=-1.0)
    cup.advance()

    one = cup.view.rounds[PRACTICE - 1]
    assert one.decided_at is not None
    assert one.key is None


def test_a_competition_without_a_final_is_decided_by_its_qualification(both: Backend) -> None:
    cup = Cup.opened(both, rounds=[round_of("qualification", -DAY_S, DAY_S, trials=3)])
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "PI")
    best = cup.entered("eva", [90.0, 91.0, 92.0], "MPC")
    cup.shift(1, closes_in_s=-1.0)
    cup.advance()

    view = cup.view
    assert view.ended_at is not None
    assert [(row.place, row.method) for row in cup.board(1).rows] == [(1, "MPC"), (2, "PI")]
    assert both.show(best).public


def test_a_hidden_board_is_shown_when_the_round_is_decided(backend: Backend) -> None:
    rounds = [round_of("qualification", -DAY_S, DAY_S, trials=3, board="hidden")]
    cup = Cup.opened(backend, rounds=rounds)
    assert not cup.view.rounds[0].shows_board
    cup.shift(1, closes_in_s=-1.0)
    cup.advance()
    assert cup.view.rounds[0].shows_board


def test_the_programs_of_a_competition_are_kept_until_it_has_ended(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    run_id = cup.entered("ann", SAME, "PI")

    assert retention.delete(backend.database, backend.settings, [run_id]) == []
    cup.begin_final()
    cup.play_batch({"PI": APART})
    cup.advance()
    assert retention.delete(backend.database, backend.settings, [run_id]) == [run_id]


def test_all_seeds_of_a_round_follow_from_its_revealed_key(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    run_id = cup.entered("ann", SAME, "PI")
    cup.begin_final()

    view = cup.view
    key = bytes.fromhex(view.rounds[QUALIFICATION - 1].key or "")
    with backend.database.reading() as session:
        run = session.get_one(Run, run_id)
        assert run.seed == keys.seed(key, view.name, run.submission or "")
