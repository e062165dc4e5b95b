"""`seamark audit`: who did what."""

from __future__ import annotations

import json
from pathlib import Path

import click

from seamark.cli.options import data_option, existing_database_of, settings_of


@click.command()
@click.option("--action", default="", metavar="A", help="Only this action, such as role_changed.")
@click.option("--by", "actor", default="", metavar="NAME", help="Only what this account did.")
@click.option("--target", default="", metavar="NAME", help="Only what was done to this one.")
@click.option("--count", type=click.IntRange(1), default=1000, show_default=True, help="At most.")
@data_option
def audit(*, action: str, actor: str, target: str, count: int, data: Path | None) -> None:
    """Print the audit log as JSON lines, newest first.

    Each line is an object with id, at (seconds since 1970, UTC), actor, address, action, target and
    detail.

    \b
    Examples:
      seamark audit --count 20
      seamark audit --action sign_in_blocked
    """
    from seamark.server import audit as log

    database = existing_database_of(settings_of(data))
    wanted, after = log.AuditFilter(action=action, actor=actor, target=target), None
    while count > 0:
        with database.reading() as session:
            page = log.page(session, wanted, after=after, limit=min(count, log.PAGE_MAX))
        for entry in page.entries:
            click.echo(json.dumps(log.as_dict(entry), ensure_ascii=False))
        count, after = count - len(page.entries), page.next
        if after is None:
            break
