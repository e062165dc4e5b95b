"""A class of the cast's teacher, its assignments, and runs that are handed in for them."""

from typing import Any

from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.runs.submission import assigned, submission, validation
from seamark.server.runs.submission.validation import Submission
from tests.cast import PI_RUN, Backend


def classroom(both: Backend, *pupils: str) -> int:
    with both.database.writing() as session:
        class_id = classrooms.create(session, both.user_id("tim"), "5b")
        found = classrooms.find(session, class_id)
        assert found is not None
        for name in pupils:
            classrooms.join(session, both.user_id(name), found.code.lower())
    return class_id


def assign(both: Backend, class_id: int, **changes: Any) -> int:
    values: dict[str, Any] = {"title": "Hold still", "benchmark": "currents-v1", "config": {}}
    with both.database.writing() as session:
        draft = Draft(**(values | changes))
        return assignments.create(session, class_id, draft, trials_max=10)


def hand_in(both: Backend, who: str, assignment: int, **changes: Any) -> int:
    wanted = PI_RUN | {"viewer": both.viewers[who]} | changes
    with both.database.writing() as session:
        sent = assigned.for_assignment(session, assignment, Submission(**wanted))
        valid = validation.validate(sent, both.settings)
        return submission.submit(session, valid, both.settings)
