"""`seamark audit`: who did what."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from seamark.cli.local_service import data_option, existing_database_of, settings_of
from seamark.cli.options import json_option


@click.command()
@click.option("--action", default="", metavar="A", help="Only this action, such as role_changed.")
@click.option("--by", "actor", default="", metavar="NAME", help="Only what this account did.")
@click.option("--target", default="", metavar="NAME", help="Only what was done to this one.")
@click.option("--count", type=click.IntRange(1), default=1000, show_default=True, help="At most.")
@data_option
@json_option
def audit(
    *, action: str, actor: str, target: str, count: int, data: Path | None, as_json: bool
) -> None:
    """Print the audit log, newest first.

    With --json each line is an object with id, at (seconds since 1970, UTC), actor, address,
    action, target and detail.

    \b
    Examples:
      seamark audit --count 20
      seamark audit --action sign_in_blocked
    """
    from seamark.server.accounts import audit as log

    database = existing_database_of(settings_of(data))
    wanted, after = log.AuditFilter(action=action, actor=actor, target=target), None
    while count > 0:
        with database.reading() as session:
            page = log.page(session, wanted, after=after, limit=min(count, log.PAGE_MAX))
        for entry in page.entries:
            line = log.as_dict(entry)
            click.echo(json.dumps(line, ensure_ascii=False) if as_json else _text(line))
        count, after = count - len(page.entries), page.next
        if after is None:
            break


def _text(entry: Mapping[str, Any]) -> str:
    at = datetime.fromtimestamp(entry["at"], UTC).strftime("%Y-%m-%d %H:%M:%S")
    who = " from ".join(filter(None, (entry["actor"], entry["address"])))
    detail = (f"{name}={value}" for name, value in entry["detail"].items())
    return "  ".join(filter(None, (at, who, entry["action"], entry["target"], *detail)))
