"""How a command fails: a message for people, an exit code for programs.

0 = success, 1 = the program of the participant failed, 2 = wrong usage, 3 = the platform failed.
"""

from __future__ import annotations

import click


class UsageRefused(click.ClickException):
    """The command was used wrongly; the message says what to do instead."""

    exit_code = 2


class ProgramFailed(click.ClickException):
    """The program of the participant failed; the message is the verdict."""

    exit_code = 1


class PlatformFailed(click.ClickException):
    """Seamark, its host or its server failed."""

    exit_code = 3
