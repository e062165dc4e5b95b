"""`seamark user`: accounts."""

from __future__ import annotations

import csv
import secrets
import sys
from pathlib import Path
from typing import TextIO

import click

from seamark.cli.options import answer, data_option, database_of, json_option, say, settings_of
from seamark.failures import UsageRefused


@click.group()
def user() -> None:
    """Make accounts, set passwords."""


@user.command()
@click.argument("name")
@click.option("--password", metavar="P", help="At least 10 characters; drawn if left out.")
@click.option("--admin", is_flag=True, help="May see and cancel everything.")
@data_option
@json_option
def add(name: str, password: str | None, admin: bool, data: Path | None, as_json: bool) -> None:
    """Make the account NAME.

    \b
    Examples:
      seamark user add ana --password 'long enough'
      seamark user add operator --admin
    """
    from seamark.server.accounts import accounts

    drawn = None if password is not None else secrets.token_urlsafe(12)
    database = database_of(settings_of(data))
    try:
        with database.writing() as session:
            made = accounts.sign_up(session, name, password or drawn, is_admin=admin)
            user_id = made.id
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    if as_json:
        answer({"id": user_id, "name": name, "admin": admin, "password": drawn})
        return
    say(f"The account {name} is there{', with the rights of an admin' if admin else ''}.")
    if drawn is not None:
        say(f"Its password, shown only now: {drawn}")


@user.command("import")
@click.argument("file", type=click.File(encoding="utf-8"))
@data_option
def import_names(file: TextIO, data: Path | None) -> None:
    """Make an account for each line of FILE (- for standard input), for example a class.

    A line is a name, or begins with one and a comma. Prints a CSV: each name with its password,
    shown only now, or with the reason why no account was made, such as that it is there already.

    \b
    Example:
      seamark user import pupils.txt > passwords.csv
    """
    from seamark.server.accounts import accounts

    database = database_of(settings_of(data))
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(("name", "password", "refused"))
    for name in filter(None, (line.partition(",")[0].strip() for line in file)):
        drawn, refused = secrets.token_urlsafe(12), ""
        try:
            with database.writing() as session:  # one each: others write meanwhile
                accounts.sign_up(session, name, drawn)
        except accounts.AccountRejected as reason:
            drawn, refused = "", str(reason)
        table.writerow((name, drawn, refused))


@user.command("password")
@click.argument("name")
@click.option("--password", metavar="P", help="At least 10 characters; drawn if left out.")
@data_option
@json_option
def set_password(name: str, password: str | None, data: Path | None, as_json: bool) -> None:
    """Give the account NAME a new password; its browsers have to sign in again.

    \b
    Example:
      seamark user password ana
    """
    from seamark.server.accounts import accounts

    drawn = None if password is not None else secrets.token_urlsafe(12)
    database = database_of(settings_of(data))
    try:
        with database.writing() as session:
            accounts.change_password(session, name, None, password or drawn or "")
    except accounts.AccountRejected as reason:
        raise UsageRefused(str(reason)) from None
    if as_json:
        answer({"name": name, "password": drawn})
        return
    say(f"The password of {name} is changed.")
    if drawn is not None:
        say(f"The new one, shown only now: {drawn}")
