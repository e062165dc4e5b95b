"""Assignments: what is asked, one's own runs, and for the teacher those of the class."""

from datetime import UTC, datetime

from flask import Blueprint, Response, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.programs.setting_values import differences
from seamark.server.classes import assignments, progress
from seamark.server.classes.assignments import PRACTICE, RANKED, Draft
from seamark.server.classes.classrooms import PAGE, ClassView
from seamark.server.classes.refusals import ClassRefused
from seamark.server.web import (
    assignment_csv,
    class_access,
    csv_export,
    known_benchmarks,
    template_runs,
)
from seamark.server.web.services import services
from seamark.server.web.template_runs import NoTemplate
from seamark.sim.settings.refusal import ConfigurationInvalid

page = Blueprint("assignments", __name__)


@page.get("/classes/<row:class_id>/assignments/new")
def new(class_id: int) -> ResponseReturnValue:
    """Show the form of a new assignment."""
    return _form(class_access.taught_class(class_id))


@page.post("/classes/<row:class_id>/assignments")
def create(class_id: int) -> ResponseReturnValue:
    """Add an assignment to a class."""
    room = class_access.taught_class(class_id)
    try:
        draft = _draft()
        with services().database.writing() as session:
            trials_max = services().settings.practice_trials_max
            made = assignments.create(session, class_id, draft, trials_max=trials_max)
    except ClassRefused as refusal:
        return _form(room, {refusal.field: str(refusal)}), 422
    except ConfigurationInvalid as refusal:
        return _form(room, {"run": str(refusal)}), 422
    return redirect(url_for("assignments.show", assignment_id=made), code=303)


@page.get("/assignments/<row:assignment_id>")
def show(assignment_id: int) -> ResponseReturnValue:
    """Show an assignment with the viewer's own runs; to the teacher with those of the class."""
    assignment = class_access.assignment_for(assignment_id)
    teaches, after = class_access.is_teacher(assignment), request.args.get("after", "")
    with services().database.reading() as session:
        listed = (
            progress.page(session, assignment.class_id, assignment.id, after=after)
            if teaches
            else []
        )
        totals = progress.totals(session, assignment.class_id, assignment.id) if teaches else None
        own = [] if teaches else progress.own_runs(session, assignment.id, g.viewer.user_id)
        shown = assignment.shows_ranking or teaches
        places = (
            progress.ranking(session, assignment.class_id, assignment.id, g.viewer.user_id)
            if shown
            else []
        )
    benchmark = known_benchmarks.by_name(assignment.benchmark)
    return render_template(
        "assignments/show.html",
        assignment=assignment,
        benchmark=benchmark,
        headline=benchmark.headline_of(benchmark.restore(assignment.config)),
        settings=differences(benchmark, assignment.fixed()),
        teaches=teaches,
        pupils=listed,
        totals=totals,
        own=own,
        best=max((run.score for run in own if run.score is not None), default=None),
        places=places,
        next=listed[-1].pupil.name if len(listed) == PAGE else None,
        first=not after,
        deadline_text=_as_input(assignment.deadline),
        title_max=assignments.TITLE_MAX,
        instructions_max=assignments.INSTRUCTIONS_MAX,
    )


@page.post("/assignments/<row:assignment_id>")
def change(assignment_id: int) -> ResponseReturnValue:
    """Change title, instructions and deadline."""
    class_access.taught_assignment(assignment_id)
    try:
        with services().database.writing() as session:
            assignments.describe(
                session,
                assignment_id,
                title=request.form.get("title", ""),
                instructions=_instructions(),
                deadline=_deadline(),
            )
    except ClassRefused as refusal:
        flash(str(refusal), "bad")
    else:
        flash("The assignment has been changed.", "good")
    return redirect(url_for("assignments.show", assignment_id=assignment_id), code=303)


@page.post("/assignments/<row:assignment_id>/delete")
def delete(assignment_id: int) -> ResponseReturnValue:
    """Delete an assignment whose title has been typed to confirm it."""
    assignment = class_access.taught_assignment(assignment_id)
    if request.form.get("confirm", "").strip() != assignment.title:
        flash("The assignment was not deleted: type its title to confirm.", "bad")
        return redirect(url_for("assignments.show", assignment_id=assignment_id), code=303)
    with services().database.writing() as session:
        assignments.remove(session, assignment_id)
    flash("The assignment has been deleted. The students keep their runs.", "good")
    return redirect(url_for("classes.show", class_id=assignment.class_id), code=303)


@page.get("/assignments/<row:assignment_id>/pupils.csv")
def as_csv(assignment_id: int) -> ResponseReturnValue:
    """Download the best run of each student with its seed and metrics."""
    assignment = class_access.taught_assignment(assignment_id)
    answer = Response(assignment_csv.lines(services().database, assignment))
    answer.headers["Content-Type"] = csv_export.MEDIA_TYPE
    name = f"seamark-assignment-{assignment.id}.csv"
    answer.headers.set("Content-Disposition", "attachment", filename=name)
    return answer


def _draft() -> Draft:
    """Return the posted assignment; raises ClassRefused."""
    form = request.form
    benchmark, kind = form.get("benchmark", ""), form.get("kind", PRACTICE)
    try:
        run = template_runs.chosen(form.get("run", "")) if kind == "run" else None
    except NoTemplate as refusal:
        raise ClassRefused(str(refusal), field="run") from None
    return Draft(
        title=form.get("title", ""),
        instructions=_instructions(),
        benchmark=benchmark if run is None else run.benchmark,
        kind=RANKED if kind == RANKED else PRACTICE,
        config={} if run is None else run.config,
        seed=_whole("seed", "A seed"),
        trials=_whole("trials", "The number of trials") or 1,
        deadline=_deadline(),
    )


def _whole(name: str, what: str) -> int | None:
    text = request.form.get(name, "").strip()
    if text and not (text.isdecimal() and len(text) < 18):
        raise ClassRefused(f"{what} must be a whole number.", field=name)
    return int(text) if text else None


def _instructions() -> str:
    return request.form.get("instructions", "").replace("\r\n", "\n")


def _deadline() -> float | None:
    """Return the posted deadline [s since 1970]; the form says that it is in UTC."""
    text = request.form.get("deadline", "").strip()
    if not text:
        return None
    try:
        return datetime.fromisoformat(text).replace(tzinfo=UTC).timestamp()
    except (ValueError, OverflowError):
        raise ClassRefused(
            "Write the deadline as 2026-11-30T18:00, in UTC.", field="deadline"
        ) from None


def _as_input(deadline: float | None) -> str:
    """Return a deadline as the value of an input of the type datetime-local."""
    if deadline is None:
        return ""
    return datetime.fromtimestamp(deadline, UTC).strftime("%Y-%m-%dT%H:%M")


def _form(room: ClassView, errors: dict[str, str] | None = None) -> str:
    return render_template(
        "assignments/new.html",
        room=room,
        posted=request.form,
        errors=errors or {},
        benchmarks=known_benchmarks.labels(),
        trials_max=services().settings.practice_trials_max,
        title_max=assignments.TITLE_MAX,
        instructions_max=assignments.INSTRUCTIONS_MAX,
        run=request.values.get("run", ""),
        runs=template_runs.to_choose(request.values.get("run", "")),
    )
