"""`seamark competition show` and `join`: what those use who take part."""

from __future__ import annotations

import time
from typing import Any
from urllib.parse import urlsplit

import click

from seamark.cli import competition_text
from seamark.cli.console import print_json
from seamark.cli.options import json_option, server_options
from seamark.cli.server_answers import refusals_shown
from seamark.failures import UsageRefused
from seamark.sandbox.printable_text import printable_text

_NAME_AND_CODE = 3  # the last parts of a link: name/join/code


@click.command()
@click.argument("name")
@click.option("--round", "number", type=click.IntRange(1), help="Whose board.  [default: the last]")
@click.option(
    "--per",
    type=click.Choice(["team", "method"]),
    default="team",
    show_default=True,
    help="One row for each team, or for each method of a team.",
)
@server_options
@json_option
def show(
    *, name: str, number: int | None, per: str, server: str, token: str | None, as_json: bool
) -> None:
    """Show the rounds of a competition NAME, in its time zone and in yours, and a board.

    \b
    Examples:
      seamark competition show harbour-cup-v1
      seamark competition show harbour-cup-v1 --round 1 --per method --json
    """
    from seamark.client import Client

    with refusals_shown(), Client(server, token) as client:
        found = client.competition(name)
        shown = number or _last_opened(found)
        board = client.competition_board(name, shown, per="method" if per == "method" else "team")
    if as_json:
        print_json({"competition": found, "board": board})
        return
    click.echo(competition_text.overview(found))
    click.echo(f"\n{competition_text.board(board)}")


def _last_opened(found: dict[str, Any]) -> int:
    """Return the number of the last round that has opened, or of the first."""
    now = time.time()
    return max((one["number"] for one in found["rounds"] if one["opens_at"] <= now), default=1)


@click.command()
@click.argument("link")
@click.option("--agree", is_flag=True, help="Say that you agree on the rules of the competition.")
@server_options
@json_option
def join(*, link: str, agree: bool, server: str, token: str | None, as_json: bool) -> None:
    """Join the team that LINK is of, which its captain has sent you.

    \b
    Examples:
      seamark competition join https://SERVER/competitions/harbour-cup-v1/join/ABCDE-12345 --agree
    """
    from seamark.client import Client

    name, code = _name_and_code(link, server)
    if not agree:
        page = f"{server.rstrip('/')}/competitions/{name}"
        raise UsageRefused(printable_text(f"Read the rules on {page}, then add --agree."))
    with refusals_shown(), Client(server, token) as client:
        team = client.join_team(name, code)
    if as_json:
        print_json(team)
    else:
        members = ", ".join(member["name"] for member in team["members"])
        click.echo(printable_text(f"You are in the team {team['name']} of {name}: {members}"))


def _name_and_code(link: str, server: str) -> tuple[str, str]:
    """Return the competition and the code in a link to a team of this server.

    Raises
    ------
    UsageRefused
        It is no such link, or of another server: that one would get the token.
    """
    parts = urlsplit(link)
    words = parts.path.rstrip("/").split("/")[-_NAME_AND_CODE:]
    if not parts.netloc or len(words) < _NAME_AND_CODE or words[1] != "join":
        raise UsageRefused(
            "This is no link to a team. It looks like "
            "https://SERVER/competitions/harbour-cup-v1/join/ABCDE-12345."
        )
    if parts.netloc != urlsplit(server).netloc:
        raise UsageRefused(
            f"The link is to {parts.netloc}, but your token is for {server}. If you have an "
            "account there, name that server with --server, and your token of it with --token."
        )
    return words[0], words[2]
