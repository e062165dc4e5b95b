"""Classes: make, join, leave, change, delete; their students and assignments."""

from __future__ import annotations

from typing import Any

from flask import Response, jsonify, url_for
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action
from seamark.server.api.classes.class_schemas import (
    AssignmentRequest,
    AssignmentResponse,
    AssignmentsResponse,
    ClassChange,
    ClassesResponse,
    ClassPath,
    ClassRequest,
    ClassResponse,
    JoinRequest,
    PupilPath,
    PupilsQuery,
    PupilsResponse,
)
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import AssignmentView, Draft
from seamark.server.classes.classrooms import PAGE, ClassView
from seamark.server.web import access, class_access, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

api = APIBlueprint(
    "api_classes",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Classes", description="Classes, their students and assignments.")],
)


@api.get("/classes", responses={200: ClassesResponse})
def list_classes() -> dict[str, Any]:
    """List the classes that you teach and those that you are in, newest first."""
    user_id = access.require_account(Action.VIEW_CLASSES)
    with services().database.reading() as database:
        taught = classrooms.taught_by(database, user_id)
        joined = classrooms.joined_by(database, user_id)
    return {
        "taught": [class_answer(each) for each in taught],
        "joined": [class_answer(each) for each in joined],
    }


@api.post("/classes", responses={201: ClassResponse})
def create_class() -> Response:
    """Create a class. Requires the role teacher. Students join with its code."""
    user_id = access.require_account(Action.TEACH)
    body = request_body.json_body(ClassRequest)
    with refusals.as_problems(), services().database.writing() as database:
        class_id = classrooms.create(database, user_id, body.name)
    answer = jsonify(_answer(class_id))
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/classes/{class_id}"
    return answer


def _answer(class_id: int) -> dict[str, Any]:
    """Return a class to whoever has just created or joined it, whatever the token's scopes."""
    with services().database.reading() as database:
        classroom = classrooms.find(database, class_id)
    if classroom is None:
        raise Problem("not-found")
    return class_answer(classroom)


@api.post("/classes/join", responses={200: ClassResponse})
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
@rate_limits.limiter.limit(
    rate_limits.CODES, key_func=rate_limits.client, deduct_when=rate_limits.failed
)
@rate_limits.limiter.limit(rate_limits.CODES_OF_ADDRESS, deduct_when=rate_limits.failed)
def join() -> dict[str, Any]:
    """Join the class with a code. Joining it again changes nothing."""
    user_id = access.require_account(Action.JOIN_CLASSES)
    body = request_body.json_body(JoinRequest)
    with refusals.as_problems(), services().database.writing() as database:
        class_id = classrooms.join(database, user_id, body.code)
    return _answer(class_id)


@api.get("/classes/<int:class_id>", responses={200: ClassResponse})
def show_class(path: ClassPath) -> dict[str, Any]:
    """Show a class that you teach or are in."""
    return class_answer(class_access.class_for(path.class_id))


@api.patch("/classes/<int:class_id>", responses={200: ClassResponse})
def change_class(path: ClassPath) -> dict[str, Any]:
    """Change a class that you teach: name, ranking, archive, code."""
    class_access.taught_class(path.class_id)
    changes = request_body.json_body(ClassChange)
    with refusals.as_problems(), services().database.writing() as database:
        classrooms.change(database, path.class_id, **changes.model_dump())
    return class_answer(class_access.class_for(path.class_id))


@api.delete("/classes/<int:class_id>", responses={204: None})
def delete_class(path: ClassPath) -> Response:
    """Delete a class with its assignments. The students keep their runs."""
    class_access.taught_class(path.class_id)
    with services().database.writing() as database:
        classrooms.remove(database, path.class_id)
    return Response(status=204)


@api.post("/classes/<int:class_id>/leave", responses={204: None})
def leave(path: ClassPath) -> Response:
    """Leave a class. Its teacher no longer sees the runs that you made for it."""
    user_id = access.require_account(Action.JOIN_CLASSES)
    with services().database.writing() as database:
        if not classrooms.leave(database, path.class_id, user_id):
            raise Problem("not-found", f"You are not in a class {path.class_id}.")
    return Response(status=204)


@api.get("/classes/<int:class_id>/pupils", responses={200: PupilsResponse})
def list_pupils(path: ClassPath, query: PupilsQuery) -> dict[str, Any]:
    """List the students of a class that you teach, in the order of their names."""
    class_access.taught_class(path.class_id)
    with services().database.reading() as database:
        pupils = classrooms.pupils(database, path.class_id, after=query.after)
    listed = [
        {"user_id": pupil.user_id, "name": pupil.name, "joined_at": pupil.joined_at}
        for pupil in pupils
    ]
    return {"pupils": listed, "next": pupils[-1].name if len(pupils) == PAGE else None}


@api.delete("/classes/<int:class_id>/pupils/<int:user_id>", responses={204: None})
def remove_pupil(path: PupilPath) -> Response:
    """Remove a student from a class that you teach."""
    class_access.taught_class(path.class_id)
    with services().database.writing() as database:
        if not classrooms.leave(database, path.class_id, path.user_id):
            raise Problem("not-found", f"The class has no student {path.user_id}.")
    return Response(status=204)


@api.get("/classes/<int:class_id>/assignments", responses={200: AssignmentsResponse})
def list_assignments(path: ClassPath) -> dict[str, Any]:
    """List the assignments of a class that you teach or are in, newest first."""
    class_access.class_for(path.class_id)
    with services().database.reading() as database:
        listed = assignments.of_class(database, path.class_id)
    return {"assignments": [assignment_answer(each) for each in listed]}


@api.post("/classes/<int:class_id>/assignments", responses={201: AssignmentResponse})
def create_assignment(path: ClassPath) -> Response:
    """Add an assignment to a class that you teach: fixed settings, or ranked runs."""
    class_access.taught_class(path.class_id)
    draft = Draft(**request_body.json_body(AssignmentRequest).model_dump())
    trials_max = services().settings.practice_trials_max
    with refusals.as_problems(), services().database.writing() as database:
        made = assignments.create(database, path.class_id, draft, trials_max=trials_max)
    answer = jsonify(assignment_answer(class_access.assignment_for(made)))
    answer.status_code = 201
    answer.headers["Location"] = f"/api/v1/assignments/{made}"
    return answer


def class_answer(view: ClassView) -> dict[str, Any]:
    """Return the JSON of a class."""
    same = ("id", "name", "teacher", "pupils", "shows_ranking", "created_at", "archived_at")
    code = view.code if class_access.is_teacher(view) else None
    link = None if code is None else f"{site_address()}{url_for('classes.invitation', code=code)}"
    return {name: getattr(view, name) for name in same} | {"code": code, "join_url": link}


def assignment_answer(view: AssignmentView) -> dict[str, Any]:
    """Return the JSON of an assignment."""
    return {name: getattr(view, name) for name in AssignmentResponse.model_fields}
