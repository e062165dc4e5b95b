"""`seamark competition init` to `move`: what an organiser uses."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli import competition_files, competition_text
from seamark.cli.competition_files import OrganisersFile
from seamark.cli.console import exit_with, print_json
from seamark.cli.extras import need_simulator
from seamark.cli.options import json_option, server_options
from seamark.cli.server_answers import refusals_shown
from seamark.drafts import replace_file
from seamark.failures import UsageRefused
from seamark.sandbox.printable_text import printable_text

if TYPE_CHECKING:
    from seamark.client import Client

POLL_S = 3.0  # [s] between two looks at a check
_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("file", type=_FILE)
@json_option
def init(*, file: Path, as_json: bool) -> None:
    """Write FILE, a competition with comments to start from; it is valid as it stands.

    \b
    Examples:
      seamark competition init cup.toml
    """
    if file.suffix.lower() != ".toml":
        raise UsageRefused(f"Name it with .toml at the end: {file.with_suffix('.toml')}.")
    if file.exists():
        raise UsageRefused(f"{file} already exists; nothing was written.")
    try:
        replace_file(file, competition_files.starter().encode())
    except OSError as error:
        raise UsageRefused(f"{file} cannot be written: {error.strerror}.") from None
    if as_json:
        print_json({"file": str(file)})
    else:
        click.echo(f"Wrote {file}. Edit it, then try `seamark competition check {file}`.")


@click.command()
@click.argument("file", type=_FILE)
@click.option("--replace", is_flag=True, help="Change the draft of this name, which is there.")
@server_options
@json_option
def create(*, file: Path, replace: bool, server: str, token: str | None, as_json: bool) -> None:
    """Make a draft of the competition in FILE (TOML or JSON), which nobody else sees.

    The reference entries of the benchmark check it at once. `picture`, `vehicle`,
    `current_record` and `target_texture` in FILE are paths of files beside it, which are sent with
    it.

    \b
    Examples:
      seamark competition create cup.toml --token $TOKEN
      seamark competition create cup.toml --replace --token $TOKEN
    """
    from seamark.client import Client

    need_simulator("seamark competition create")
    written = competition_files.read(file)
    with refusals_shown(), Client(server, token) as client:
        made = _write(client, written, replace=replace)
        page = f"{client.server}{made['links']['page']}"
    if as_json:
        print_json(made)
        return
    name = made["name"]
    click.echo(printable_text(f"The draft {name} is on {page}. Its reference entries run now:"))
    click.echo(printable_text(f"  seamark competition check {name} --wait"))


def _write(client: Client, written: OrganisersFile, *, replace: bool) -> dict[str, Any]:
    files = written.files
    try:
        return client.create_competition(
            written.values,
            picture=files.get("picture"),
            vehicle=files.get("vehicle"),
            current_record=files.get("current_record"),
            target_texture=files.get("target_texture"),
            replace=replace,
        )
    except OSError as error:
        raise UsageRefused(f"{error.filename} cannot be read: {error.strerror}.") from None


@click.command()
@click.argument("name", metavar="NAME|FILE")
@click.option("--wait", is_flag=True, help="Wait until the reference entries have been evaluated.")
@server_options
@json_option
def check(*, name: str, wait: bool, server: str, token: str | None, as_json: bool) -> None:
    """Say what the reference entries show of a draft NAME of yours, before it opens.

    With a FILE (.toml or .json), say whether it is valid; that needs no server. Exit code 1: there
    is a problem.

    \b
    Examples:
      seamark competition check cup.toml
      seamark competition check my-cup-v1 --wait --token $TOKEN
    """
    if Path(name).suffix.lower() in {".toml", ".json"}:
        found = _checked_file(Path(name))
    else:
        found = _checked_draft(name, wait=wait, server=server, token=token, quiet=as_json)
    if as_json:
        print_json(found)
    else:
        for each in found["findings"]:
            click.echo(competition_text.finding_line(each["level"], each["sentence"]))
        if not found["ended"]:
            waiting = f"{found['waiting']} of {found['asked']} reference entries"
            click.echo(f"{waiting} wait for a worker. Try again, or add --wait.")
    exit_with(1 if any(each["level"] == "problem" for each in found["findings"]) else 0)


def _checked_file(file: Path) -> dict[str, Any]:
    need_simulator("seamark competition check FILE")
    from seamark.cli.configuration import with_files
    from seamark.competitions import document
    from seamark.competitions.document import DocumentInvalid

    values, files = competition_files.read(file)
    try:
        asked = document.read(values)
        named = {name: str(file) for name, file in files.items() if name != "picture"}
        settings = {**asked.settings, **with_files(named)}
        asked.model_copy(update={"settings": settings}).scenario()
    except DocumentInvalid as invalid:
        found = [f"{at}: {sentence}" for at, sentence in invalid.errors.items()]
        findings = [{"level": "problem", "sentence": sentence} for sentence in found]
    else:
        sentence = f"{file} is valid. Make a draft of it with `seamark competition create {file}`."
        findings = [{"level": "good", "sentence": sentence}]
    return {"ended": True, "asked": 0, "waiting": 0, "findings": findings, "references": []}


def _checked_draft(
    name: str, *, wait: bool, server: str, token: str | None, quiet: bool
) -> dict[str, Any]:
    from seamark.client import Client

    with refusals_shown(), Client(server, token) as client:
        found = client.competition_check(name)
        while wait and not found["ended"]:
            if not quiet:
                done = found["asked"] - found["waiting"]
                click.echo(f"{done} of {found['asked']} reference entries ...", err=True)
            time.sleep(POLL_S)
            found = client.competition_check(name)
    return found


@click.command(name="open")
@click.argument("name")
@server_options
@json_option
def open_up(*, name: str, server: str, token: str | None, as_json: bool) -> None:
    """Show a draft NAME of yours to everybody. What it asks never changes from then on.

    Its check has to have ended. Times of rounds can be moved, with a reason that everybody sees.

    \b
    Examples:
      seamark competition open my-cup-v1 --token $TOKEN
    """
    from seamark.client import Client

    with refusals_shown(), Client(server, token) as client:
        opened = client.open_competition(name)
        page = f"{client.server}{opened['links']['page']}"
    if as_json:
        print_json(opened)
    else:
        frozen = f"What it asks is frozen as SHA-256 {opened['digest']}."
        click.echo(printable_text(f"{opened['name']} is open: {page}\n{frozen}"))


@click.command()
@click.argument("name")
@click.argument("number", type=click.IntRange(1), metavar="ROUND")
@click.option(
    "--until",
    required=True,
    metavar="TIME",
    help="New end of the round, or beginning of a final: 2027-05-01T12:00, in the time zone of the "
    "competition unless it has an offset.",
)
@click.option("--reason", required=True, help="Why; everybody sees it.")
@server_options
@json_option
def move(
    *,
    name: str,
    number: int,
    until: str,
    reason: str,
    server: str,
    token: str | None,
    as_json: bool,
) -> None:
    """Move the end of ROUND of a competition NAME of yours, or the beginning of its final.

    A round only becomes longer. Rounds after it move as well if they would begin before it ends.

    \b
    Examples:
      seamark competition move my-cup-v1 2 --until 2027-05-01T12:00 --reason "The server was away."
    """
    from seamark.client import Client

    need_simulator("seamark competition move")
    with refusals_shown(), Client(server, token) as client:
        at = _time_in(until, client.competition(name)["zone"])
        moved = client.move_round(name, number, until=at, reason=reason)
    if as_json:
        print_json(moved)
    else:
        click.echo(competition_text.overview(moved))


def _time_in(text: str, zone: str) -> float:
    from seamark.competitions import zones

    try:
        written = datetime.fromisoformat(text)
    except ValueError:
        raise UsageRefused(f"--until {text}: write a time as 2027-05-01T12:00.") from None
    if zone not in zones.zone_names():
        zone = "UTC"
    try:
        return zones.to_utc(written, zone).timestamp()
    except (ValueError, OverflowError) as reason:
        raise UsageRefused(f"--until {text}: {reason}") from None
