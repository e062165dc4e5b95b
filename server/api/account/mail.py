"""What an account has chosen about e-mail."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import BaseModel, ConfigDict, Field

from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import request_body
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import ResponseModel
from seamark.server.mail import addresses
from seamark.server.mail.addresses import MailRejected
from seamark.server.web import access
from seamark.server.web.outgoing_mail import require_mail
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_mail",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[
        Tag(name="E-mail", description="E-mail to the account, where the service sends any.")
    ],
)
_MINUTES = "A run that took as long from submission to end is told by e-mail; null: none is"


class MailRequest(BaseModel):
    """What to change."""

    model_config = ConfigDict(extra="forbid")

    notify_minutes: int | None = Field(ge=0, le=addresses.NOTIFY_MINUTES_MAX, description=_MINUTES)


class MailResponse(ResponseModel):
    """What an account has chosen about e-mail."""

    address: str | None = Field(description="Confirmed")
    pending: str | None = Field(description="An address whose link has not been opened yet")
    notify_minutes: int | None = Field(description=_MINUTES)


@api.get("/me/mail", responses={200: MailResponse})
def show() -> dict[str, Any]:
    """Return the e-mail address of the account and what is sent to it.

    The address is changed on the account page alone, since it can replace the password.
    """
    require_mail()
    user_id = access.require_account(Action.VIEW_ACCOUNT)
    with services().database.reading() as session:
        return asdict(addresses.of_account(session, user_id))


@api.patch("/me/mail", responses={200: MailResponse})
def change() -> dict[str, Any]:
    """Ask for e-mails about runs that have ended, or for none. Needs a confirmed address."""
    require_mail()
    user_id = access.require_account(Action.EDIT_PROFILE)
    body = request_body.json_body(MailRequest)
    try:
        with services().database.writing() as session:
            addresses.set_notification(session, user_id, body.notify_minutes)
            return asdict(addresses.of_account(session, user_id))
    except MailRejected as reason:
        raise Problem("conflict", str(reason)) from None
