"""How a command ends badly: one sentence for the person, one exit code for programs.

0 = fine, 1 = the user's program failed, 2 = usage, 3 = the platform failed.
"""

from __future__ import annotations

import click


class UsageRefused(click.ClickException):
    """What was asked for cannot be done as asked; the sentence says what to do instead."""

    exit_code = 2


class ProgramFailed(click.ClickException):
    """The participant's program ended badly; the sentence is the verdict."""

    exit_code = 1


class PlatformFailed(click.ClickException):
    """Seamark, its host or its server is not able to do what was asked."""

    exit_code = 3
