"""The service as `seamark up` starts it, and what it prints."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def started(data: Path) -> Iterator[tuple[str, int]]:
    """Serve a data folder with one worker; gives the address and the process.

    Ranked runs have one trial, so that the built-in entries, which run first, are short.
    """
    command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", "0", "--json"]
    environ = {k: v for k, v in os.environ.items() if not k.startswith("SEAMARK_")}
    service = subprocess.Popen(
        [*command, "--workers", "1", "--data", str(data)],
        env=environ | {"SEAMARK_RANKED_TRIALS": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield address_of(service), service.pid
    finally:
        service.terminate()
        service.wait()


def address_of(service: "subprocess.Popen[str]") -> str:
    """Return the address of a service that starts, once it is ready."""
    assert service.stdout is not None
    lines = []
    for line in service.stdout:
        lines.append(line)
        if line.startswith("}"):
            break
    address: str = json.loads("".join(lines))["address"]
    return address
