"""The audit log, for admins."""

from flask import render_template, request
from flask.typing import ResponseReturnValue

from seamark.server.accounts import audit
from seamark.server.accounts.audit import AuditAction, AuditFilter
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.web.services import services

ADMIN_PAGE = admin_page("audit_log", __name__, label="Audit log", path="/audit")
page = ADMIN_PAGE.blueprint
_IN_URL = ("action", "actor", "target")


@page.get("")
def show() -> ResponseReturnValue:
    """Show who did what, newest first."""
    kept = {
        name: request.args[name].strip()[: audit.TARGET_MAX]
        for name in _IN_URL
        if request.args.get(name)
    }
    after = request.args.get("after", type=int)
    with services().database.reading() as session:
        listed = audit.page(session, AuditFilter(**kept), after=after)
    return render_template(
        "admin/audit.html",
        log=listed,
        kept=kept,
        first=after is None,
        actions={action.value: action.label for action in AuditAction},
        days=services().settings.audit_days,
        target_max=audit.TARGET_MAX,
    )
