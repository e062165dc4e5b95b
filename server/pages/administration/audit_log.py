"""The audit log, for admins."""

from flask import Blueprint, render_template, request
from flask.typing import ResponseReturnValue

from seamark.server.accounts import audit
from seamark.server.accounts.audit import AuditAction, AuditFilter
from seamark.server.accounts.permissions import Action
from seamark.server.web import access
from seamark.server.web.services import services

page = Blueprint("audit_log", __name__, url_prefix="/admin/audit")
_IN_URL = ("action", "actor", "target")


@page.get("")
def show() -> ResponseReturnValue:
    """Show who did what, newest first."""
    access.require(Action.ADMINISTER)
    kept = {
        name: request.args[name].strip()[: audit.TARGET_MAX]
        for name in _IN_URL
        if request.args.get(name)
    }
    after = request.args.get("after", type=int)
    with services().database.reading() as session:
        found = audit.page(session, AuditFilter(**kept), after=after)
    return render_template(
        "admin/audit.html",
        found=found,
        kept=kept,
        first=after is None,
        actions={action.value: action.label for action in AuditAction},
        days=services().settings.audit_days,
        target_max=audit.TARGET_MAX,
    )
