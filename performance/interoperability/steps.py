"""What the checks with other people's libraries share: steps, commands, an account of a service."""

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from pathlib import Path

from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from tests.services.embedded import cancel_baselines

SEAMARK = (sys.executable, "-m", "seamark.cli.main")
NPM_CI = ("npm", "ci", "--silent", "--no-fund")  # as `package-lock.json` has them
TIMEOUT_S = 600


class Failed(Exception):
    """A step failed; the text says why."""


def are_installed(*programs: str) -> bool:
    """Return whether all programs are installed; say which ones are not."""
    missing = [name for name in programs if shutil.which(name) is None]
    if missing:
        print(f"This needs {', '.join(missing)}.", file=sys.stderr)
    return not missing


def succeed(steps: Iterable[tuple[str, Callable[[], object]]]) -> bool:
    """Print each step before it begins; return False at the first one that fails."""
    for title, step in steps:
        print(f"{title} ...", flush=True)
        try:
            step()
        except Failed as failed:
            print(f"{title}: {failed}", file=sys.stderr)
            return False
    return True


def run(command: Sequence[str], folder: Path) -> str:
    """Return what a command prints; raises Failed if it fails."""
    done = subprocess.run(
        command, cwd=folder, stdout=subprocess.PIPE, text=True, check=False, timeout=TIMEOUT_S
    )
    if done.returncode != 0:
        raise Failed(f"{Path(command[0]).name} ended with {done.returncode}")
    return done.stdout


def new_token(data: Path) -> str:
    """Return a token of a new account; the built-in entries leave the worker to its runs."""
    with closing(Database(f"sqlite:///{data / 'seamark.db'}")) as database:
        cancel_baselines(database)
        with database.writing() as session:
            user = accounts.sign_up(session, "checker", None)
            return accounts.new_token(session, user.id, "t", ("read", "submit"), days=1.0)
