"""`seamark token`: API tokens."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.cli.console import print_json
from seamark.cli.local_service import data_option, database_of, settings_of
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

SCOPES = (
    "read",
    "submit",
    "admin",
)  # seamark.server.accounts.permissions.SCOPES; a test holds them equal


@click.group()
def token() -> None:
    """Create API tokens."""


@token.command()
@click.argument("name")
@click.option(
    "--scope",
    "scopes",
    type=click.Choice(SCOPES),
    multiple=True,
    default=("read", "submit"),
    show_default=True,
    help="Repeatable.",
)
@click.option(
    "--days",
    type=click.FloatRange(min=0, max=3650, min_open=True),
    default=90,
    show_default=True,
    help="Days until it expires.",
)
@click.option("--label", default="made by seamark token new", help="Name in the list of tokens.")
@data_option
@json_option
def new(
    *, name: str, scopes: tuple[str, ...], days: float, label: str, data: Path | None, as_json: bool
) -> None:
    """Create a token for the account NAME and print it, alone, on the last line.

    \b
    Examples:
      seamark token new ana
      seamark token new ana --scope read --days 7
      TOKEN=$(seamark token new ana | tail -n 1)
    """
    from sqlalchemy import select

    from seamark.server.accounts import accounts, audit
    from seamark.server.database.tables import User

    database = database_of(settings_of(data))
    with database.writing() as session:
        owner = session.scalar(select(User).where(User.name_key == name.casefold()))
        if owner is None:
            raise UsageRefused(
                f"There is no account {name}. Create it with `seamark user add {name}`."
            )
        try:
            text = accounts.new_token(session, owner.id, label, scopes, days=days)
            made = {"token": accounts.tokens(session, owner.id)[0].id}
            action = audit.AuditAction.TOKEN_MADE
            audit.record(session, audit.COMMAND_LINE, action, owner.name, made)
        except accounts.AccountRejected as reason:
            raise UsageRefused(str(reason)) from None
    if as_json:
        print_json({"user": owner.name, "scopes": list(scopes), "days": days, "token": text})
        return
    click.echo(f"Token of {owner.name} for {', '.join(scopes)}, {days:g} days (not shown again):")
    click.echo(text)
