"""`seamark user`: accounts."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import TextIO

import click

from seamark.cli.console import print_json, print_json_line
from seamark.cli.local_service import data_option, database_of, existing_database_of, settings_of
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

# seamark.server.accounts.permissions.ACCOUNT_ROLES; a test holds them equal
ROLES = ("user", "teacher", "organiser", "admin")


@click.group()
def user() -> None:
    """Manage accounts."""


@user.command()
@click.argument("name")
@click.option("--password", metavar="P", help="At least 10 characters.  [default: random]")
@click.option("--role", type=click.Choice(ROLES), default="user", show_default=True)
@click.option("--admin", "role", flag_value="admin", help="The same as --role admin.")
@data_option
@json_option
def add(*, name: str, password: str | None, role: str, data: Path | None, as_json: bool) -> None:
    """Create the account NAME.

    A teacher may also invite people to sign up, an organiser may besides take published runs off
    the leaderboards, and an admin may do everything with all runs.

    \b
    Examples:
      seamark user add ana --password 'long enough'
      seamark user add mr-lee --role teacher
    """
    from seamark.server.accounts import accounts
    from seamark.server.accounts.permissions import Role

    drawn = None if password is not None else secrets.token_urlsafe(12)
    database = database_of(settings_of(data))
    try:
        with database.writing() as session:
            made = accounts.sign_up(session, name, password or drawn, role=Role[role.upper()])
            user_id = made.id
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    if as_json:
        print_json({"id": user_id, "name": name, "role": role, "password": drawn})
        return
    click.echo(f"Created the account {name} with the role {role}.")
    if drawn is not None:
        click.echo(f"Password (not shown again): {drawn}")


@user.command("import")
@click.argument("file", type=click.File(encoding="utf-8"))
@data_option
@json_option
def import_names(file: TextIO, data: Path | None, as_json: bool) -> None:
    """Create an account for each line of FILE (- for standard input), such as a class list.

    A line is a name, or starts with a name and a comma. Prints a CSV table with the password of
    each new account, or the reason why it was refused; with --json, one JSON object per line. The
    passwords are not shown again.

    \b
    Examples:
      seamark user import pupils.txt > passwords.csv
      docker compose exec -T web seamark user import - < pupils.txt > passwords.csv
    """
    from seamark.server.accounts import accounts
    from seamark.server.web import csv_export

    database = existing_database_of(settings_of(data))
    columns = ("name", "password", "refused")
    if not as_json:
        click.echo(csv_export.lines(columns, ()), nl=False)
    for name in filter(None, (line.partition(",")[0].strip() for line in file)):
        drawn, refused = secrets.token_urlsafe(12), ""
        try:
            with database.writing() as session:  # one each: others write in between
                accounts.sign_up(session, name, drawn)
        except accounts.AccountRejected as reason:
            drawn, refused = "", str(reason)
        row = {"name": name, "password": drawn, "refused": refused}
        if as_json:
            print_json_line({column: value or None for column, value in row.items()})
        else:
            click.echo(csv_export.lines(columns, (row,), header=False), nl=False)


@user.command()
@click.option("--count", type=click.IntRange(1, 1000), default=1, show_default=True)
@click.option(
    "--days",
    type=click.FloatRange(min=0, max=365, min_open=True),
    default=14,
    show_default=True,
    help="Days until it expires.",
)
@data_option
@json_option
def invite(count: int, days: float, data: Path | None, as_json: bool) -> None:
    """Print invitations, one on each line: each lets one person sign up.

    They are needed where SEAMARK_SIGN_UP is `invitation`, and not shown again. The address of the
    form with an invitation filled in ends in /sign-up?invitation=TEXT.

    \b
    Example:
      seamark user invite --count 30 > invitations.txt
    """
    from seamark.server.accounts import invitations

    with database_of(settings_of(data)).writing() as session:
        texts = invitations.create(session, days=days, count=count)
    if as_json:
        print_json({"invitations": texts, "days": days})
        return
    for text in texts:
        click.echo(text)


@user.command("list")
@data_option
@json_option
def show_all(data: Path | None, as_json: bool) -> None:
    """List all accounts with their roles, oldest first."""
    from seamark.server.accounts import accounts

    with existing_database_of(settings_of(data)).reading() as session:
        listed = [
            {"id": each.id, "name": each.name, "role": each.role, "created_at": each.created_at}
            for each in accounts.people(session)
        ]
    if as_json:
        print_json({"users": listed})
        return
    for each in listed:
        click.echo(f"{each['name']:<40} {each['role']}")


@user.command("role")
@click.argument("name")
@click.argument("role", type=click.Choice(ROLES))
@data_option
@json_option
def set_role(name: str, role: str, data: Path | None, as_json: bool) -> None:
    """Give the account NAME another ROLE; its tokens can do no more than the role allows.

    \b
    Example:
      seamark user role mr-lee teacher
    """
    from seamark.server.accounts import accounts, audit
    from seamark.server.accounts.permissions import Role
    from seamark.server.administration import people

    try:
        with database_of(settings_of(data)).writing() as session:
            person = accounts.person(session, name)
            people.set_role(session, audit.COMMAND_LINE, person, Role[role.upper()])
            changed = person.name
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    if as_json:
        print_json({"name": changed, "role": role})
    else:
        click.echo(f"{changed} has the role {role}.")


@user.command("reset")
@click.argument("name")
@data_option
@json_option
def reset(name: str, data: Path | None, as_json: bool) -> None:
    """Print a link with which the account NAME can set a new password, once, within 24 hours.

    The password, browsers and tokens stay as they are until the link is used. A further link
    replaces it.

    \b
    Example:
      seamark user reset ana
    """
    from seamark.server.accounts import accounts, audit, password_resets
    from seamark.server.administration import people

    settings = settings_of(data)
    try:
        with existing_database_of(settings).writing() as session:
            person = accounts.person(session, name)
            text = people.make_reset_link(session, audit.COMMAND_LINE, person)
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    link = f"{settings.url}/reset?link={text}"
    if as_json:
        print_json({"name": name, "link": link, "hours": password_resets.HOURS})
        return
    click.echo(link)


@user.command("delete")
@click.argument("name")
@click.option("--keep-published", is_flag=True, help="Keep published runs, without the name.")
@click.confirmation_option(prompt="Delete the account with its runs? This cannot be undone.")
@data_option
@json_option
def delete(name: str, keep_published: bool, data: Path | None, as_json: bool) -> None:
    """Delete the account NAME with its runs, files, classes and tokens.

    Without --keep-published, its published runs are deleted as well.

    \b
    Example:
      seamark user delete ana --yes
    """
    from seamark.server.accounts import accounts, audit
    from seamark.server.administration import people
    from seamark.server.runs.ending import account_deletion

    settings = settings_of(data)
    database = existing_database_of(settings)
    try:
        with database.writing() as session:
            person = accounts.person(session, name)
            user_id = person.id
            people.close(session, audit.COMMAND_LINE, person, keep_published=keep_published)
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    while account_deletion.step(database, settings):
        pass
    if as_json:
        print_json({"deleted": name, "id": user_id})
        return
    click.echo(f"Deleted the account {name}.")


@user.command("password")
@click.argument("name")
@click.option("--password", metavar="P", help="At least 10 characters.  [default: random]")
@data_option
@json_option
def set_password(name: str, password: str | None, data: Path | None, as_json: bool) -> None:
    """Set a new password for the account NAME, sign it out everywhere and revoke its tokens.

    \b
    Example:
      seamark user password ana
    """
    from seamark.server.accounts import accounts, audit

    drawn = None if password is not None else secrets.token_urlsafe(12)
    database = database_of(settings_of(data))
    try:
        with database.writing() as session:
            changed = accounts.change_password(session, name, password or drawn or "").name
            action = audit.AuditAction.PASSWORD_CHANGED
            audit.record(session, audit.COMMAND_LINE, action, changed)
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    if as_json:
        print_json({"name": name, "password": drawn})
        return
    click.echo(f"Changed the password of {name}.")
    if drawn is not None:
        click.echo(f"New password (not shown again): {drawn}")
