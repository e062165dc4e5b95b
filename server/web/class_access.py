"""Access of the current request to classes and assignments, for pages and the API alike.

Whoever neither teaches a class nor belongs to it gets the same answer as for one that is not there.
"""

from flask import g, request
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action, can, owns, teaches
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import AssignmentView
from seamark.server.classes.classrooms import ClassView
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services


def class_for(class_id: int) -> ClassView:
    """Return a class that the viewer teaches or belongs to."""
    access.require(Action.VIEW_CLASSES)
    with services().database.reading() as session:
        classroom = classrooms.find(session, class_id)
        if classroom is None or not _sees(session, classroom.id, classroom.teacher_id):
            raise Problem("not-found", f"There is no class {class_id}, or you are not in it.")
    return classroom


def invited_to() -> ClassView | None:
    """Return the class whose code the form or address of a sign-up has; None without one."""
    if "invited_to" not in g:
        code = request.values.get("class", "")
        with services().database.reading() as session:
            g.invited_to = classrooms.opened_by(session, code) if code else None
    classroom: ClassView | None = g.invited_to
    return classroom


def taught_class(class_id: int) -> ClassView:
    """Return a class that the viewer teaches."""
    access.require(Action.TEACH)
    classroom = class_for(class_id)
    _require_teacher(classroom.teacher_id)
    return classroom


def assignment_for(assignment_id: int) -> AssignmentView:
    """Return an assignment of a class that the viewer teaches or belongs to."""
    access.require(Action.VIEW_CLASSES)
    with services().database.reading() as session:
        assignment = assignments.find(session, assignment_id)
        if assignment is None or not _sees(session, assignment.class_id, assignment.teacher_id):
            raise Problem(
                "not-found", f"There is no assignment {assignment_id}, or you are not in its class."
            )
    return assignment


def assignment_of_run(run: RunView) -> AssignmentView | None:
    """Return the assignment that a run was handed in for, to its owner and the teacher alone.

    None also if the owner has left the class.
    """
    viewer, teacher_id = access.viewer(), run.teacher_id
    if teacher_id is None or not can(viewer, Action.VIEW_CLASSES):
        return None
    if not (owns(viewer, run) or teaches(viewer, teacher_id)):
        return None
    with services().database.reading() as session:
        return assignments.of_run(session, run.id)


def taught_assignment(assignment_id: int) -> AssignmentView:
    """Return an assignment of a class that the viewer teaches."""
    access.require(Action.TEACH)
    assignment = assignment_for(assignment_id)
    _require_teacher(assignment.teacher_id)
    return assignment


def is_teacher(of: ClassView | AssignmentView) -> bool:
    """Return whether the viewer has the rights of the teacher."""
    return teaches(access.viewer(), of.teacher_id)


def _sees(session: Session, class_id: int, teacher_id: int) -> bool:
    viewer = access.viewer()
    return teaches(viewer, teacher_id) or classrooms.has_member(session, class_id, viewer.user_id)


def _require_teacher(teacher_id: int) -> None:
    if not teaches(access.viewer(), teacher_id):
        raise Problem("forbidden", "Only the teacher of the class may do this.")
