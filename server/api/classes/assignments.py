"""Assignments: show, change, delete; what the students made of them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask import Response, jsonify
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action
from seamark.server.api.classes.class_schemas import (
    AssignedRunResponse,
    AssignmentChange,
    AssignmentPath,
    AssignmentResponse,
    OwnRunsResponse,
    ProgressQuery,
    ProgressResponse,
    RankingResponse,
)
from seamark.server.api.classes.classes import assignment_answer
from seamark.server.api.requests import refusals, request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.classes import assignments, progress
from seamark.server.classes.classrooms import PAGE
from seamark.server.classes.progress import AssignedRunView
from seamark.server.web import access, assignment_csv, class_access, csv_export
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_assignments",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Classes", description="Classes, their students and assignments.")],
)


@api.get("/assignments/<int:assignment_id>", responses={200: AssignmentResponse})
def show_assignment(path: AssignmentPath) -> dict[str, Any]:
    """Show an assignment of a class that you teach or are in.

    Submit a run for it with `POST /api/v1/runs` and `assignment`.
    """
    return assignment_answer(class_access.assignment_for(path.assignment_id))


@api.patch("/assignments/<int:assignment_id>", responses={200: AssignmentResponse})
def change_assignment(path: AssignmentPath) -> dict[str, Any]:
    """Replace title, instructions and deadline of an assignment; its settings stay."""
    class_access.taught_assignment(path.assignment_id)
    body = request_body.json_body(AssignmentChange)
    with refusals.as_problems(), services().database.writing() as database:
        assignments.describe(database, path.assignment_id, **body.model_dump())
    return assignment_answer(class_access.assignment_for(path.assignment_id))


@api.delete("/assignments/<int:assignment_id>", responses={204: None})
def delete_assignment(path: AssignmentPath) -> Response:
    """Delete an assignment. The runs stay those of the students."""
    class_access.taught_assignment(path.assignment_id)
    with services().database.writing() as database:
        assignments.remove(database, path.assignment_id)
    return Response(status=204)


@api.get("/assignments/<int:assignment_id>/pupils", responses={200: ProgressResponse})
def list_progress(path: AssignmentPath, query: ProgressQuery) -> Response:
    """List the students of the class with the number of their runs and the best one.

    As CSV it has all students, with the seed and the metrics of the best run.
    """
    assignment = class_access.taught_assignment(path.assignment_id)
    if query.format == "csv":
        lines = assignment_csv.lines(services().database, assignment)
        return Response(lines, content_type=csv_export.MEDIA_TYPE)
    with services().database.reading() as database:
        listed = progress.page(database, assignment.class_id, assignment.id, after=query.after)
    pupils = [
        {
            "user_id": each.pupil.user_id,
            "name": each.pupil.name,
            "runs": each.runs,
            "best": None if each.best is None else _run(each.best),
        }
        for each in listed
    ]
    following = listed[-1].pupil.name if len(listed) == PAGE else None
    return jsonify({"pupils": pupils, "next": following})


@api.get("/assignments/<int:assignment_id>/runs", responses={200: OwnRunsResponse})
def list_own_runs(path: AssignmentPath) -> dict[str, Any]:
    """List your own runs for an assignment, newest first."""
    user_id = access.require_account(Action.VIEW_CLASSES)
    assignment = class_access.assignment_for(path.assignment_id)
    with services().database.reading() as database:
        runs = progress.own_runs(database, assignment.id, user_id)
    return {"runs": [_run(run) for run in runs]}


@api.get("/assignments/<int:assignment_id>/ranking", responses={200: RankingResponse})
def show_ranking(path: AssignmentPath) -> dict[str, Any]:
    """Return the best scores of the class without names, if the teacher shows them."""
    user_id = access.require_account(Action.VIEW_CLASSES)
    assignment = class_access.assignment_for(path.assignment_id)
    if not assignment.shows_ranking and not class_access.is_teacher(assignment):
        raise Problem("forbidden", "The teacher does not show a ranking of this class.")
    with services().database.reading() as database:
        places = progress.ranking(database, assignment.class_id, assignment.id, user_id)
    return {"places": [asdict(place) for place in places]}


def _run(run: AssignedRunView) -> dict[str, Any]:
    names = [name for name in AssignedRunResponse.model_fields if name != "run"]
    return {"run": run.run_id} | {name: getattr(run, name) for name in names}
