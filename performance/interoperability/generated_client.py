"""A client in TypeScript, generated from the OpenAPI document, compiled strictly, follows a run.

    ./run openapi-client

Proves that the document is good: the generator reads it, the compiler accepts what a program does
with the generated types, and the answers of a real service are what they say. Needs Node.js 20 or
newer and npm, which downloads the generator and the compiler as `package-lock.json` has them.
"""

import shutil
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import httpx

from performance.interoperability.steps import NPM_CI, are_installed, new_token, run, succeed
from tests.services.embedded import started

SOURCES = Path(__file__).parent / "typescript_client"
NPM_RUN = ("npm", "run", "--silent")


def main(_arguments: Sequence[str]) -> int:
    """Print each step; 0 if all of them succeeded."""
    if not are_installed("npm"):
        return 2
    with tempfile.TemporaryDirectory(prefix="seamark-typescript-") as name:
        folder, data = Path(name) / "client", Path(name) / "data"
        shutil.copytree(SOURCES, folder)
        with started(data) as (address, _):
            document = httpx.get(f"{address}/api/v1/openapi.json").raise_for_status()
            (folder / "openapi.json").write_bytes(document.content)
            follow = ("start", "--", address, new_token(data))
            steps: dict[str, Sequence[str]] = {
                "Install the generator and the compiler": NPM_CI,
                "Generate the client": (*NPM_RUN, "generate"),
                "Compile it strictly": (*NPM_RUN, "compile"),
                "Follow a run": (*NPM_RUN, *follow),
            }
            done = succeed((title, partial(_print, steps[title], folder)) for title in steps)
    return 0 if done else 1


def _print(command: Sequence[str], folder: Path) -> None:
    print(run(command, folder), end="", flush=True)
