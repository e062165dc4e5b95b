"""The `seamark` command: one file per command, imported when it is used."""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import sys
from types import TracebackType

import click
from click.shell_completion import CompletionItem

COMMANDS = {  # name -> module:attribute, help; with the help here, --help imports no command
    "up": ("up:up", "Start the whole service on this machine."),
    "init": ("init:init", "Write a starter program for a benchmark."),
    "check": ("check:check", "Check a program for errors, in seconds."),
    "run": ("run:run", "Evaluate a controller or tracker locally."),
    "rerun": ("rerun:rerun", "Compute an archived run again and say what differs."),
    "export": ("export:export", "Write a result as Parquet, MCAP, MAT, NPZ, CSV or an archive."),
    "bridge": ("bridge:bridge", "Connect a ROS program or an autopilot to a run."),
    "replay": ("replay:replay", "Measure the log of a real mission."),
    "track": ("track:track", "Follow a target through your own video."),
    "identify": ("identify:identify", "Fit drag and added mass of a vehicle to a log."),
    "plot": ("plot:plot", "Plot results in the terminal or as a picture."),
    "tune": ("tune:tune", "Search for the best settings, and check them on fresh trials."),
    "submit": ("submit:submit", "Submit a run to a server."),
    "compare": ("compare:compare", "Compare results or runs of a server side by side."),
    "competition": ("competition:competition", "Organise competitions, take part and check them."),
    "leaderboard": ("leaderboard:leaderboard", "Show a leaderboard of a server."),
    "dataset": ("dataset:dataset", "Render images with ground truth for offline work."),
    "demonstrations": (
        "demonstrations:demonstrations",
        "Write episodes of a built-in expert for imitation learning.",
    ),
    "vehicle": ("vehicle:vehicle", "Check, draw or import the file of a vehicle."),
    "current": ("current:current", "Make a record of currents of a measured or modelled file."),
    "benchmarks": ("benchmarks:benchmarks", "List the benchmarks and their settings."),
    "completion": ("completion:completion", "Print the completion script of a shell."),
    "doctor": ("doctor:doctor", "Check this machine and say how to fix what is missing."),
    "user": ("user:user", "Manage accounts."),
    "token": ("token:token", "Create API tokens."),
    "mail": ("mail:mail", "Try the mail server."),
    "audit": ("audit:audit", "Print who did what: the audit log."),
    "backup": ("backup:backup", "Back up the whole service into one file."),
    "restore": ("backup:restore", "Restore the service from a backup."),
    "db": ("db:db", "Manage the database."),
    "web": ("service:web", "Run only the web server."),
    "worker": ("service:worker", "Run only a worker."),
}
PRIVATE_UMASK = 0o077
# Objects made and not yet deleted, between two collections. Of modules and of a large answer hardly
# anything is garbage in a cycle: to look for it every 700 objects took a sixth of a server's start.
GARBAGE_AFTER = 20_000
OF_CLIENT = frozenset(("submit", "compare", "competition", "leaderboard", "export", "completion"))
SERVICE = frozenset(  # need the extra `server`
    ("up", "user", "token", "mail", "audit", "backup", "restore", "db", "web", "worker")
)


class LazyGroup(click.Group):
    """A group that imports a command when it is used, so that --help is fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of what this installation can do, in the order of the table."""
        from seamark.cli.extras import has_simulator

        return [name for name in COMMANDS if name in OF_CLIENT or has_simulator()]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return a command."""
        if cmd_name not in COMMANDS:
            return None
        from seamark.cli.extras import has_simulator

        if cmd_name not in OF_CLIENT and not has_simulator():
            return _refusing(cmd_name)
        module, _, attribute = COMMANDS[cmd_name][0].partition(":")
        loaded: click.Command = getattr(
            importlib.import_module(f"seamark.cli.commands.{module}"), attribute
        )
        if cmd_name in SERVICE:
            from seamark.cli.extras import refuse_without_server

            refuse_without_server(loaded)
        return loaded

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; what a failure quotes of files and servers is printed without effect."""
        try:
            return super().invoke(ctx)
        except click.ClickException as failure:
            from seamark.sandbox.printable_text import printable_text

            text = printable_text(failure.format_message())
            if text == failure.format_message():
                raise
            click.echo(f"Error: {text}", err=True)
            ctx.exit(failure.exit_code)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete names and options; imports no command for a list of commands."""
        if incomplete.startswith("-"):
            return click.Command.shell_complete(self, ctx, incomplete)
        return [
            CompletionItem(name, help=text)
            for name, (_, text) in COMMANDS.items()
            if name.startswith(incomplete) and name in self.list_commands(ctx)
        ]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the table without importing the commands."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in self.list_commands(ctx)])


def _refusing(name: str) -> click.Command:
    """Return a command that says what it needs, whatever its arguments."""

    def refuse() -> None:
        from seamark.cli.extras import without_simulator

        raise without_simulator(f"seamark {name}")

    anything = {"ignore_unknown_options": True, "allow_extra_args": True}
    return click.Command(name, callback=refuse, context_settings=anything, help=COMMANDS[name][1])


@click.command(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 success, 1 the evaluated program failed, 2 wrong usage, 3 the platform "
    "failed. `seamark COMMAND --help` shows examples.",
)
@click.version_option(package_name="seamark-client", prog_name="seamark")
@click.pass_context
def cli(context: click.Context) -> None:
    """Seamark, the online benchmark for underwater intervention robots."""
    if context.invoked_subcommand in SERVICE:
        # They write keys, hashes of passwords, and what participants show nobody.
        before = os.umask(PRIVATE_UMASK)
        context.call_on_close(lambda: os.umask(before))


def _platform_failed(
    error_type: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Report a bug of Seamark with exit code 3: 1 would blame the participant's program."""
    import traceback

    traceback.print_exception(error_type, error, trace)
    print("seamark: this is a bug in Seamark, not in your program.", file=sys.stderr)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(3)


def main() -> None:
    """Run the command line."""
    sys.excepthook = _platform_failed
    gc.set_threshold(GARBAGE_AFTER)
    atexit.register(gc.freeze)  # the last search for garbage, in all of a simulator, took 0.4 s
    cli.main(prog_name="seamark")


if __name__ == "__main__":
    main()
