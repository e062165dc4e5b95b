"""The storage, for admins: what takes how much room, and deleting what is due."""

from flask import flash, redirect, render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.server.administration import disk
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.web import access
from seamark.server.web.services import services

ADMIN_PAGE = admin_page("admin_storage", __name__, label="Storage", path="/storage")
page = ADMIN_PAGE.blueprint


@page.get("")
def show() -> ResponseReturnValue:
    """Show what takes how much room, and what retention would delete."""
    held = services()
    with held.database.reading() as session:
        usage = disk.state(session, held.settings)
    return render_template("admin/storage.html", usage=usage, settings=held.settings)


@page.post("/retention")
def run_retention() -> ResponseReturnValue:
    """Have a worker delete at once what retention would delete in time."""
    with services().database.writing() as session:
        disk.request_retention(session, access.actor())
    flash("A worker begins within seconds. This page shows what it has deleted.", "good")
    return redirect(url_for("admin_storage.show"), code=303)
