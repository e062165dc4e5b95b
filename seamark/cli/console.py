"""What commands print for programs, and how they end."""

from __future__ import annotations

import json
import sys
from typing import NoReturn

import click

INTERRUPTED = 130  # 128 + SIGINT, as shells have it


def print_json(value: object) -> None:
    """Print one JSON object for a program."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def print_json_line(value: object) -> None:
    """Print a JSON object in one line: several of them are JSON lines."""
    click.echo(json.dumps(value, allow_nan=False))


def exit_with(code: int) -> NoReturn:
    """End the command with an exit code."""
    sys.stdout.flush()
    raise click.exceptions.Exit(code)
