"""Classes: the teacher's and the student's; joining by a code; changes by the teacher."""

from flask import Blueprint, flash, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.server.accounts.permissions import Action, can
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.classrooms import PAGE
from seamark.server.classes.refusals import ClassRefused
from seamark.server.web import access, class_access
from seamark.server.web.problems import Problem
from seamark.server.web.rate_limits import (
    CODES,
    CODES_OF_ADDRESS,
    SUBMISSIONS,
    client,
    failed,
    limiter,
)
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

page = Blueprint("classes", __name__, url_prefix="/classes")


@page.get("/")
def index() -> ResponseReturnValue:
    """Show the viewer's classes, and the forms to join or make one."""
    access.require(Action.VIEW_CLASSES)
    return _index()


@page.post("/")
def create() -> ResponseReturnValue:
    """Make a class."""
    user_id = access.require_account(Action.TEACH)
    try:
        with services().database.writing() as session:
            class_id = classrooms.create(session, user_id, request.form.get("name", ""))
    except ClassRefused as refusal:
        return _index(create_error=str(refusal)), 422
    return redirect(url_for("classes.show", class_id=class_id), code=303)


@page.post("/join")
@limiter.limit(SUBMISSIONS, key_func=client)
@limiter.limit(CODES, key_func=client, deduct_when=failed)
@limiter.limit(CODES_OF_ADDRESS, deduct_when=failed)
def join() -> ResponseReturnValue:
    """Join the class with a code."""
    user_id = access.require_account(Action.JOIN_CLASSES)
    try:
        with services().database.writing() as session:
            class_id = classrooms.join(session, user_id, request.form.get("code", ""))
    except ClassRefused as refusal:
        return _index(join_error=str(refusal)), 422
    flash("You have joined the class.", "good")
    return redirect(url_for("classes.show", class_id=class_id), code=303)


@page.get("/join/<code>")
@limiter.limit(CODES_OF_ADDRESS, deduct_when=failed)
def invitation(code: str) -> ResponseReturnValue:
    """Show to whoever has the link of a class how to join it."""
    with services().database.reading() as session:
        room = classrooms.opened_by(session, code)
        inside = room is not None and (
            room.teacher_id == g.viewer.user_id
            or classrooms.has_member(session, room.id, g.viewer.user_id)
        )
    if room is None:
        raise Problem("not-found", classrooms.UNKNOWN_CODE)
    if inside:
        return _back(room.id)
    return render_template("classes/join.html", room=room)


@page.get("/<row:class_id>")
def show(class_id: int) -> ResponseReturnValue:
    """Show a class with its assignments; to its teacher also the code."""
    room = class_access.class_for(class_id)
    with services().database.reading() as session:
        listed = assignments.of_class(session, class_id)
    return render_template(
        "classes/show.html",
        room=room,
        assignments=listed,
        teaches=class_access.is_teacher(room),
        link=site_address() + url_for("classes.invitation", code=room.code),
        name_max=classrooms.NAME_MAX,
    )


@page.post("/<row:class_id>")
def change(class_id: int) -> ResponseReturnValue:
    """Rename a class and choose whether students see the ranking."""
    class_access.taught_class(class_id)
    ranking = request.form.get("shows_ranking") == "on"
    try:
        with services().database.writing() as session:
            name = request.form.get("name", "")
            classrooms.change(session, class_id, name=name, shows_ranking=ranking)
    except ClassRefused as refusal:
        flash(str(refusal), "bad")
    else:
        flash("The class has been changed.", "good")
    return _back(class_id)


@page.post("/<row:class_id>/code")
def renew_code(class_id: int) -> ResponseReturnValue:
    """Replace the code of a class."""
    class_access.taught_class(class_id)
    with services().database.writing() as session:
        classrooms.change(session, class_id, new_code=True)
    flash("The class has a new link and a new code. Nobody can join with the old ones.", "good")
    return _back(class_id)


@page.post("/<row:class_id>/archive")
def archive(class_id: int) -> ResponseReturnValue:
    """Archive a class, or open an archived one again."""
    archived = class_access.taught_class(class_id).archived_at is None
    with services().database.writing() as session:
        classrooms.change(session, class_id, archived=archived)
    flash("The class is archived." if archived else "The class is open again.", "good")
    return _back(class_id)


@page.post("/<row:class_id>/delete")
def delete(class_id: int) -> ResponseReturnValue:
    """Delete a class whose name has been typed to confirm it."""
    room = class_access.taught_class(class_id)
    if request.form.get("confirm", "").strip() != room.name:
        flash("The class was not deleted: type its name to confirm.", "bad")
        return _back(class_id)
    with services().database.writing() as session:
        classrooms.remove(session, class_id)
    flash(f"The class {room.name} has been deleted.", "good")
    return redirect(url_for("classes.index"), code=303)


@page.post("/<row:class_id>/leave")
def leave(class_id: int) -> ResponseReturnValue:
    """Leave a class."""
    user_id = access.require_account(Action.JOIN_CLASSES)
    with services().database.writing() as session:
        if not classrooms.leave(session, class_id, user_id):
            raise Problem("not-found", "You are not in this class.")
    flash("You have left the class.", "good")
    return redirect(url_for("classes.index"), code=303)


@page.get("/<row:class_id>/pupils")
def pupils(class_id: int) -> ResponseReturnValue:
    """List the students of a class."""
    room = class_access.taught_class(class_id)
    after = request.args.get("after", "")
    with services().database.reading() as session:
        listed = classrooms.pupils(session, class_id, after=after)
    following = listed[-1].name if len(listed) == PAGE else None
    return render_template(
        "classes/pupils.html", room=room, pupils=listed, next=following, first=not after
    )


@page.post("/<row:class_id>/pupils/<row:user_id>/remove")
def remove_pupil(class_id: int, user_id: int) -> ResponseReturnValue:
    """Remove a student from a class."""
    class_access.taught_class(class_id)
    with services().database.writing() as session:
        if not classrooms.leave(session, class_id, user_id):
            raise Problem("not-found", "The class has no such student.")
    flash(
        "The student has been removed. Press “New link and code” on the page of the class "
        "to keep them from joining again.",
        "good",
    )
    return redirect(url_for("classes.pupils", class_id=class_id), code=303)


def _index(*, create_error: str = "", join_error: str = "") -> str:
    user_id = g.viewer.user_id
    with services().database.reading() as session:
        taught = classrooms.taught_by(session, user_id)
        joined = classrooms.joined_by(session, user_id)
    return render_template(
        "classes/index.html",
        taught=taught,
        joined=joined,
        may_teach=can(g.viewer, Action.TEACH),
        may_invite=can(g.viewer, Action.INVITE),
        create_error=create_error,
        join_error=join_error,
        name=request.form.get("name", ""),
        code=request.values.get("code", ""),
        name_max=classrooms.NAME_MAX,
    )


def _back(class_id: int) -> ResponseReturnValue:
    return redirect(url_for("classes.show", class_id=class_id), code=303)
