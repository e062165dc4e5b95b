"""`seamark mail`: trying the mail server."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.cli.console import print_json
from seamark.cli.local_service import data_option, settings_of
from seamark.cli.options import json_option
from seamark.failures import PlatformFailed, UsageRefused


@click.group()
def mail() -> None:
    """Try the mail server."""


@mail.command()
@click.argument("address")
@data_option
@json_option
def test(address: str, data: Path | None, as_json: bool) -> None:
    """Send a test e-mail to ADDRESS and say how the mail server answered.

    \b
    Example:
      seamark mail test ana@example.org
    """
    from seamark.server.mail import addresses, smtp

    settings = settings_of(data)
    if not settings.mail_url:
        raise UsageRefused("SEAMARK_MAIL_URL is not set, so this service sends no e-mail.")
    try:
        to = addresses.checked(address)
    except addresses.MailRejected as reason:
        raise UsageRefused(str(reason)) from None
    text = f"E-mail from {settings.url} arrives.\n"
    try:
        smtp.deliver(settings, smtp.message(settings, to, "Test of Seamark", text))
    except (smtp.MailRefused, OSError) as error:
        raise PlatformFailed(f"The mail server did not take the e-mail: {error}") from None
    if as_json:
        print_json({"sent": True, "to": to})
        return
    click.echo(f"The mail server took an e-mail to {to}.")
