import pytest
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.database.tables import User
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.leaderboard import leaderboard, rank_history
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import PublicationRefused, Terms
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import standings
from seamark.server.runs.showing.run_lists import RunFilter, RunOrder
from seamark.server.runs.showing.run_lists import page as run_page
from tests.cast import Backend

NAME = "currents-v1"
FOR_REVIEW = Terms(method="Steady hand", anonymous=True)
STRANGER = Viewer()


def publish(both: Backend, run_id: int, terms: Terms = FOR_REVIEW) -> int:
    with both.database.writing() as session:
        assert publications.publish(session, run_id, terms)
    return run_id


def ranked(both: Backend, who: str = "ann", score: float = 50.0, **changes: object) -> int:
    claim = both.running(who, kind="ranked", **changes)
    assert both.finish(claim, score=score)
    return claim.run_id


def only_rank(session: Session) -> Rank:
    (rank,) = leaderboard.page(session, NAME)
    return rank


def test_the_name_of_an_anonymous_entry_is_shown_only_after_it_is_revealed(both: Backend) -> None:
    run_id = publish(both, ranked(both))

    with both.database.reading() as session:
        before = only_rank(session)
        assert leaderboard.rank_of(session, NAME, both.user_id("ann")) == before
    seen = both.show(run_id).user
    with both.database.writing() as session:
        assert publications.reveal(session, run_id)
        assert not publications.reveal(session, run_id)
        after = only_rank(session)

    assert (before.user, before.anonymous, seen) == ("Anonymous author", True, "Anonymous author")
    assert (after.user, after.anonymous, both.show(run_id).user) == ("ann", False, "ann")


def test_the_profile_of_a_user_tells_nothing_of_anonymous_runs(backend: Backend) -> None:
    publish(backend, ranked(backend))
    user_id = backend.user_id("ann")

    with backend.database.reading() as session:
        assert standings.of_user(session, user_id) == []
        assert rank_history.of_user(session, user_id, NAME) == []
        named = run_page(session, STRANGER, RunFilter(which="public", user="ann"))
        every = run_page(session, STRANGER, RunFilter(which="public"))

    assert named.runs == []
    assert [run.user for run in every.runs] == ["Anonymous author"]


def test_what_a_profile_told_while_an_entry_had_a_name_is_hidden_with_it(backend: Backend) -> None:
    run_id, user_id = publish(backend, ranked(backend), Terms()), backend.user_id("ann")
    with backend.database.writing() as session:
        assert publications.withdraw(session, run_id)

    publish(backend, run_id)

    with backend.database.reading() as session:
        assert standings.of_user(session, user_id) == []  # the score would tell which entry it is
    with backend.database.writing() as session:
        assert publications.reveal(session, run_id)
        assert len(standings.of_user(session, user_id)[0].history) == 3


def test_no_run_with_a_name_was_started_from_an_anonymous_one_while_that_was_private(
    backend: Backend,
) -> None:
    run_id = ranked(backend)
    named = publish(backend, backend.succeeded("ann", rerun_of=run_id), Terms())

    publish(backend, run_id)
    later = backend.succeeded("ben", rerun_of=run_id)

    assert backend.show(named).rerun_of is None  # only its author could read it then
    assert backend.show(later).rerun_of == run_id


def test_a_search_does_not_find_the_file_name_of_an_anonymous_run(both: Backend) -> None:
    program = both.store_program(name="anns_own.py")
    run_id = publish(both, ranked(both, controller="upload", program=program))
    search = RunFilter(which="public", text="anns_own")

    with both.database.reading() as session:
        found = run_page(session, STRANGER, search, order=RunOrder.NEWEST)

    assert found.runs == []
    assert both.show(run_id).program_name == "program.py"


@pytest.mark.parametrize("anonymous", [True, False])
def test_ranked_runs_of_a_user_in_a_benchmark_are_all_named_or_all_anonymous(
    backend: Backend, anonymous: bool
) -> None:
    publish(backend, ranked(backend, score=40.0), Terms(anonymous=anonymous))
    second, practice = ranked(backend, score=60.0), backend.succeeded("ann")

    with pytest.raises(PublicationRefused, match="one row for each user"):
        publish(backend, second, Terms(anonymous=not anonymous))
    publish(backend, practice, Terms(anonymous=not anonymous))
    publish(backend, second, Terms(anonymous=anonymous))

    with backend.database.reading() as session:
        assert only_rank(session).run_id == second


def test_revealing_a_ranked_run_reveals_the_others_of_its_benchmark(backend: Backend) -> None:
    first, second, practice = ranked(backend), ranked(backend), backend.succeeded("ann")
    for run_id in (first, second, practice):
        publish(backend, run_id)

    with backend.database.writing() as session:
        publications.reveal(session, second)

    users = [backend.show(run_id).user for run_id in (first, second, practice)]
    assert users == ["ann", "ann", "Anonymous author"]


def test_with_the_results_alone_nobody_else_reads_program_log_or_traceback(both: Backend) -> None:
    claim = both.running(controller="upload", program=both.store_program())
    detail = {"title": "Error", "sentence": "It raised.", "traceback": "line 3", "log_tail": ["x"]}
    assert both.finish(
        claim, state=RunState.FAILED, cause="user_error", detail=detail, metrics=None
    )
    run_id = publish(both, claim.run_id, Terms(method="Steady hand", program=False))
    run, eva = both.show(run_id), both.viewers["eva"]

    may = {action for action in Action if can(eva, action, run)}

    assert Action.VIEW in may
    assert not may & {Action.VIEW_PROGRAM, Action.VIEW_LOG, Action.RERUN}
    assert run.detail == {"title": "Error", "sentence": "It raised."}
    assert can(both.viewers["ann"], Action.VIEW_PROGRAM, run)


@pytest.mark.parametrize(
    ("built_in", "terms"),
    [
        (True, Terms(licence="MIT")),
        (False, Terms(licence="MIT", program=False)),
        (False, Terms(licence="Beerware")),
    ],
)
def test_a_licence_is_one_of_the_list_and_for_a_program_that_is_published(
    backend: Backend, built_in: bool, terms: Terms
) -> None:
    chosen = {} if built_in else {"controller": "upload", "program": backend.store_program()}
    run_id = backend.succeeded("ann", **chosen)

    with pytest.raises(PublicationRefused):
        publish(backend, run_id, terms)

    assert not backend.show(run_id).public


@pytest.mark.parametrize(
    ("method", "anonymous", "says"),
    [
        ("", False, "Name the method"),
        (" \u200b\n", False, "Name the method"),
        ("Mine.py", False, "name of the file"),
        ("x" * 61, False, "to 60 characters; it has 61"),
        ("Observer of ANN", True, "leave “ann” out"),
        ("Doe's observer, J. Doe", True, "leave “J. Doe” out"),
    ],
)
def test_a_program_is_published_only_with_a_name_of_its_method_that_can_be_shown(
    both: Backend, method: str, anonymous: bool, says: str
) -> None:
    run_id = both.succeeded("ann", controller="upload", program=both.store_program(name="mine.py"))
    with both.database.writing() as session:
        session.get_one(User, both.user_id("ann")).public_name = "J. Doe"

    with pytest.raises(PublicationRefused, match=says) as refusal:
        publish(both, run_id, Terms(method=method, anonymous=anonymous))

    assert refusal.value.field == "method"
    assert not both.show(run_id).public


def test_the_name_of_a_method_is_one_line_and_outlives_a_withdrawal(backend: Backend) -> None:
    run_id = backend.succeeded("ann", controller="upload", program=backend.store_program())
    publish(backend, run_id, Terms(method="  Plan\n of  Anna\u202e ", anonymous=True))

    with backend.database.writing() as session:
        publications.withdraw(session, run_id)

    assert (
        backend.show(run_id).method == "Plan of Anna"
    )  # to be suggested when it is published again


def test_a_built_in_solution_has_its_own_name(backend: Backend) -> None:
    run_id = publish(backend, ranked(backend, title="kp 0.7, third try"), Terms())

    with backend.database.reading() as session:
        assert only_rank(session).method == backend.show(run_id).method == "PI"


@pytest.mark.parametrize("by", ["withdrawal", "closing the account"])
def test_what_was_public_is_remembered_after_it_is_gone(backend: Backend, by: str) -> None:
    run_id = publish(backend, ranked(backend))

    with backend.database.writing() as session:
        if by == "withdrawal":
            assert publications.withdraw(session, run_id)
        else:
            account_deletion.close(session, backend.user_id("ann"), keep_published=False)
    while by != "withdrawal" and account_deletion.step(backend.database, backend.settings):
        pass

    with backend.database.reading() as session:
        found = publications.history(session, run_id)
        assert found is not None
        assert found.withdrawn_at is not None
        assert leaderboard.page(session, NAME) == []


def test_a_run_that_is_published_again_keeps_its_first_date_and_no_earlier_terms(
    backend: Backend,
) -> None:
    run_id = publish(backend, ranked(backend))
    with backend.database.writing() as session:
        first = publications.history(session, run_id)
        assert first is not None
        first_at = first.first_at
        publications.withdraw(session, run_id)

    publish(backend, run_id, Terms())

    with backend.database.reading() as session:
        again = publications.history(session, run_id)
        assert again is not None
        assert (again.first_at, again.withdrawn_at) == (first_at, None)
    assert backend.show(run_id).user == "ann"
