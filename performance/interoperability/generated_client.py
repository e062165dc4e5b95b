"""A client in TypeScript, generated from the OpenAPI document, compiled strictly, follows a run.

    ./run openapi-client

Proves that the document is good: the generator reads it, the compiler accepts what a program does
with the generated types, and the answers of a real service are what they say. Needs Node.js and
npm, which downloads the generator and the compiler as `package-lock.json` has them.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import httpx

from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from tests.services.embedded import cancel_baselines, started

SOURCES = Path(__file__).parent / "typescript_client"
TIMEOUT_S = 600


def main(_arguments: Sequence[str]) -> int:
    """Print each step; 0 if all of them succeeded."""
    if shutil.which("npm") is None:
        print("This needs Node.js 20 or newer with npm.", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="seamark-typescript-") as name:
        folder = Path(name) / "client"
        shutil.copytree(SOURCES, folder)
        with started(Path(name) / "data") as (address, _):
            document = httpx.get(f"{address}/api/v1/openapi.json").raise_for_status()
            (folder / "openapi.json").write_bytes(document.content)
            return _build_and_run(folder, address, _token(Path(name) / "data"))


def _build_and_run(folder: Path, address: str, token: str) -> int:
    """Run the steps until one fails."""
    steps: tuple[tuple[str, Sequence[str]], ...] = (
        ("Install the generator and the compiler", ("npm", "ci", "--silent", "--no-fund")),
        ("Generate the client", ("npm", "run", "--silent", "generate")),
        ("Compile it strictly", ("npm", "run", "--silent", "compile")),
        ("Follow a run", ("npm", "run", "--silent", "start", "--", address, token)),
    )
    for title, command in steps:
        print(f"{title} ...", flush=True)
        done = subprocess.run(command, cwd=folder, check=False, timeout=TIMEOUT_S)
        if done.returncode != 0:
            print(f"{title}: failed.", file=sys.stderr)
            return 1
    return 0


def _token(data: Path) -> str:
    """Return a token of a new account; the built-in entries leave the worker to its run."""
    with closing(Database(f"sqlite:///{data / 'seamark.db'}")) as database:
        cancel_baselines(database)
        with database.writing() as session:
            user = accounts.sign_up(session, "typescript", None)
            return accounts.new_token(session, user.id, "t", ("read", "submit"), days=1.0)
