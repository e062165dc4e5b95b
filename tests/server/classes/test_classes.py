"""Classes and assignments: who joins, what counts, what the teacher sees."""

import time
from typing import Any

import pytest
from sqlalchemy import update

from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.classes import assignments, classrooms, progress
from seamark.server.classes.progress import PupilProgress
from seamark.server.classes.refusals import ClassRefused
from seamark.server.database.class_tables import Assignment
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.submission import assigned, submission, validation
from seamark.server.runs.submission.validation import Submission, SubmissionRejected
from tests.cast import PI_RUN, Backend
from tests.server.classes.class_cast import assign, classroom, hand_in

SHORT: dict[str, Any] = {"levels": [0.1, 0.2]}
GAIN = {"kp": 0.7}


def score(both: Backend, who: str, assignment: int, value: float) -> int:
    run_id = hand_in(both, who, assignment)
    claim = both.claim_next()
    assert claim.run_id == run_id
    assert both.finish(claim, score=value)
    return run_id


def teachers_page(both: Backend, class_id: int, assignment: int) -> list[PupilProgress]:
    with both.database.reading() as session:
        return progress.page(session, class_id, assignment)


def test_a_pupil_joins_by_the_code_however_it_is_written(backend: Backend) -> None:
    class_id = classroom(backend)
    with backend.database.writing() as session:
        found = classrooms.find(session, class_id)
        assert found is not None
        read_out = f" {found.code.replace('0', 'o').replace('1', 'l').lower()} "
        joined = classrooms.join(session, backend.user_id("ann"), read_out)
        again = classrooms.join(session, backend.user_id("ann"), found.code)
        pupils = [pupil.name for pupil in classrooms.pupils(session, class_id)]

    assert (joined, again, pupils) == (class_id, class_id, ["ann"])


def test_nobody_joins_with_an_old_code_or_an_archived_class(both: Backend) -> None:
    class_id = classroom(both)
    with both.database.writing() as session:
        found = classrooms.find(session, class_id)
        assert found is not None
        classrooms.change(session, class_id, new_code=True)
        with pytest.raises(ClassRefused):
            classrooms.join(session, both.user_id("ann"), found.code)
        renewed = classrooms.find(session, class_id)
        assert renewed is not None
        classrooms.change(session, class_id, archived=True)
        with pytest.raises(ClassRefused):
            classrooms.join(session, both.user_id("ann"), renewed.code)


def test_a_run_for_an_assignment_has_its_settings_seed_and_trials(backend: Backend) -> None:
    room = classroom(backend, "ann")
    assignment = assign(backend, room, config=SHORT, seed=5, trials=2)

    run = backend.show(hand_in(backend, "ann", assignment, config=GAIN))

    assert (run.config["levels"], run.config["kp"]) == ([0.1, 0.2], 0.7)
    assert (run.seed, run.trials, run.kind) == (5, 2, RunKind.PRACTICE)


@pytest.mark.parametrize(
    "changes",
    [{"config": {"levels": [0.1]}}, {"seed": 6}, {"benchmark": "visibility-v1"}],
)
def test_a_pupil_cannot_change_what_the_assignment_fixes(
    backend: Backend, changes: dict[str, Any]
) -> None:
    assignment = assign(backend, classroom(backend, "ann"), config=SHORT, seed=5)

    with pytest.raises(SubmissionRejected):
        hand_in(backend, "ann", assignment, **changes)


def test_a_ranked_assignment_makes_ranked_runs(backend: Backend) -> None:
    assignment = assign(backend, classroom(backend, "ann"), kind="ranked", seed=4)

    run = backend.show(hand_in(backend, "ann", assignment))

    assert (run.kind, run.seed) == (RunKind.RANKED, None)


@pytest.mark.parametrize("who", ["ben", "tim", "root"])
def test_only_pupils_of_the_class_submit_for_its_assignments(backend: Backend, who: str) -> None:
    assignment = assign(backend, classroom(backend, "ann"))

    with pytest.raises(SubmissionRejected, match="not in the class"):
        hand_in(backend, who, assignment)


def test_what_counts_is_the_submission_before_the_deadline_not_the_end_after_it(
    backend: Backend,
) -> None:
    room = classroom(backend, "ann")
    assignment = assign(backend, room, deadline=time.time() + 1000.0)
    hand_in(backend, "ann", assignment)
    with backend.database.writing() as session:
        session.execute(update(Assignment).values(deadline=time.time() - 1.0))

    assert backend.finish(backend.claim_next(), score=40.0)
    with pytest.raises(SubmissionRejected, match="deadline"):
        hand_in(backend, "ann", assignment)

    (ann,) = teachers_page(backend, room, assignment)
    assert (ann.runs, ann.best and ann.best.score) == (1, 40.0)


def test_a_run_submitted_again_counts_for_its_assignment_until_the_deadline(both: Backend) -> None:
    room = classroom(both, "ann")
    assignment = assign(both, room, deadline=time.time() + 1000.0)
    first = hand_in(both, "ann", assignment)

    both.rerun(first, "ann")
    both.rerun(first, "root")
    with both.database.writing() as session:
        session.execute(update(Assignment).values(deadline=time.time() - 1.0))
    late = both.show(both.rerun(first, "ann"))

    (ann,) = teachers_page(both, room, assignment)
    assert (ann.runs, late.teacher_id) == (2, None)


def test_a_run_validated_before_the_deadline_is_refused_when_it_is_inserted_after_it(
    backend: Backend,
) -> None:
    assignment = assign(backend, classroom(backend, "ann"), deadline=time.time() + 1000.0)
    sent = Submission(**(PI_RUN | {"viewer": backend.viewers["ann"]}))
    with backend.database.reading() as session:
        sent = assigned.for_assignment(session, assignment, sent)
    with backend.database.writing() as session:
        session.execute(update(Assignment).values(deadline=time.time() - 1.0))

    with (
        pytest.raises(SubmissionRejected, match="deadline"),
        backend.database.writing() as session,
    ):
        submission.submit(session, validation.validate(sent, backend.settings), backend.settings)


def test_the_teacher_sees_the_best_run_and_the_number_of_runs_of_each_pupil(both: Backend) -> None:
    room = classroom(both, "ann", "ben", "eva")
    assignment, other = assign(both, room), assign(both, room)
    score(both, "ann", assignment, 30.0)
    best = score(both, "ann", assignment, 60.0)
    score(both, "ann", assignment, 60.0)
    score(both, "ben", other, 90.0)
    hand_in(both, "eva", assignment)

    listed = teachers_page(both, room, assignment)

    shown = [(each.pupil.name, each.runs, each.best and each.best.run_id) for each in listed]
    assert shown == [("ann", 3, best), ("ben", 0, None), ("eva", 1, None)]
    with both.database.reading() as session:
        assert progress.totals(session, room, assignment) == progress.Totals(3, 2, 1, 4)


def test_the_ranking_has_places_and_no_names_and_leaves_out_who_left(backend: Backend) -> None:
    room = classroom(backend, "ann", "ben", "eva")
    assignment = assign(backend, room)
    for name, value in (("ann", 50.0), ("ben", 70.0), ("eva", 50.0)):
        score(backend, name, assignment, value)

    with backend.database.reading() as session:
        full = progress.ranking(session, room, assignment, backend.user_id("eva"))
    with backend.database.writing() as session:
        classrooms.leave(session, room, backend.user_id("ben"))
        without = progress.ranking(session, room, assignment, backend.user_id("ann"))

    assert [(p.place, p.score, p.is_own) for p in full] == [
        (1, 70.0, False),
        (2, 50.0, True),
        (2, 50.0, False),
    ]
    assert [(p.place, p.is_own) for p in without] == [(1, True), (1, False)]


def test_a_teacher_reads_the_runs_for_an_assignment_while_the_pupil_is_in_the_class(
    both: Backend,
) -> None:
    room = classroom(both, "ann")
    run_id, own = hand_in(both, "ann", assign(both, room)), both.queue("ann")
    tim, changes = both.viewers["tim"], (Action.PUBLISH, Action.CANCEL, Action.DELETE_DATA)

    assert can(tim, Action.VIEW_PROGRAM, both.show(run_id))
    assert not any(can(tim, action, both.show(run_id)) for action in changes)
    assert not can(tim, Action.VIEW, both.show(own))
    other_teacher = Viewer(user_id=both.user_id("olga"), account_role=tim.account_role)
    assert not can(other_teacher, Action.VIEW, both.show(run_id))

    with both.database.writing() as session:
        classrooms.leave(session, room, both.user_id("ann"))
    assert not can(tim, Action.VIEW, both.show(run_id))


def test_deleting_a_class_leaves_the_runs_to_the_pupils(both: Backend) -> None:
    room = classroom(both, "ann")
    run_id = hand_in(both, "ann", assign(both, room))

    with both.database.writing() as session:
        classrooms.remove(session, room)

    run = both.show(run_id)
    assert (run.user_id, run.teacher_id) == (both.user_id("ann"), None)
    with both.database.reading() as session:
        assert assignments.of_run(session, run_id) is None
