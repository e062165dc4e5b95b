"""The `seamark` command: one file per command, loaded when it is asked for."""

from __future__ import annotations

import importlib
import sys
from types import TracebackType

import click

COMMANDS = {  # name -> module:attribute, what it does; the second saves loading all for --help
    "up": ("up:up", "Start everything on this machine and keep it running."),
    "init": ("init:init", "Write a controller to start from."),
    "check": ("check:check", "Say what is wrong with a program, in seconds."),
    "run": ("run:run", "Evaluate a controller here, without a server."),
    "submit": ("submit:submit", "Send a controller to a server."),
    "dataset": ("dataset:dataset", "Write pictures with their truth, to work on offline."),
    "benchmarks": ("benchmarks:benchmarks", "List the benchmarks and their settings."),
    "doctor": ("doctor:doctor", "Say what this machine can do, and how to mend it."),
    "user": ("user:user", "Make accounts, set passwords."),
    "token": ("token:token", "Make tokens for programs."),
    "db": ("db:db", "Look after the database."),
    "web": ("service:web", "Run the web server only."),
    "worker": ("service:worker", "Run a worker only."),
}


class Lazy(click.Group):
    """A group whose commands are imported when they are needed, so that --help is quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of the table."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command."""
        if cmd_name not in COMMANDS:
            return None
        module, _, attribute = COMMANDS[cmd_name][0].partition(":")
        loaded: click.Command = getattr(
            importlib.import_module(f"seamark.cli.commands.{module}"), attribute
        )
        return loaded

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the table without importing the commands."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, says) for name, (_, says) in COMMANDS.items()])


@click.command(
    cls=Lazy,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 fine, 1 the program under test failed, 2 wrong usage, 3 the platform "
    "failed. `seamark COMMAND --help` has examples.",
)
@click.version_option(package_name="seamark", prog_name="seamark")
def cli() -> None:
    """Seamark: the online benchmark for underwater robots."""


def _platform_failed(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Report our own mistake with exit code 3; 1 would blame the participant's program."""
    import os
    import traceback

    traceback.print_exception(kind, error, trace)
    print("seamark: this is a mistake in Seamark, not in your program.", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(3)


def main() -> None:
    """Run the command line."""
    sys.excepthook = _platform_failed
    cli.main(prog_name="seamark")


if __name__ == "__main__":
    main()
