"""The state of the service, for admins, and what needs a person."""

from flask import render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.server.administration import overview as service_overview
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.web.services import services

ADMIN_PAGE = admin_page("admin_overview", __name__, label="Overview")
page = ADMIN_PAGE.blueprint


@page.get("/")
def show() -> ResponseReturnValue:
    """Show the state of the service and what needs a person."""
    held = services()
    with held.database.reading() as session:
        overview_now = service_overview.overview(session, held.settings)
    return render_template("admin/overview.html", overview=overview_now, links=_links())


def _links() -> dict[str, str]:
    """Return the pages to which warnings lead, by area."""
    return {
        "workers": url_for("admin_workers.show"),
        "queue": url_for("admin_queue.show"),
        "disk": url_for("admin_storage.show"),
        "runs": url_for("runs.mine", of="all", state="failed"),
        "status": url_for("status.show"),
        "audit": url_for("audit_log.show", action="sign_in_blocked"),
    }
