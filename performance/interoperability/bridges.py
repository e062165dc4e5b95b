"""Programs with other people's libraries: roslibpy, roslib from npm, and a client in C++.

    ./run bridges

The PI controllers of `examples/rosbridge` run behind `seamark bridge rosbridge`, on this machine
and on a server, and must have the digest of the built-in one. The client in C++ is compiled with
every warning as an error, and orders and follows runs of a real service. Needs Node.js and npm,
which downloads roslib as `package-lock.json` has it, g++, libcurl and nlohmann/json.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from performance import ROOT
from performance.interoperability.steps import (
    NPM_CI,
    SEAMARK,
    TIMEOUT_S,
    Failed,
    are_installed,
    new_token,
    run,
    succeed,
)
from tests.services.embedded import started

EXAMPLES = ROOT / "examples"
ROSLIB = Path(__file__).parent / "roslib_client"
SHORT = ("levels=0,0.3", "level_duration_s=10", "settle_s=2")
RUN = ("currents-v1", "--seed", "7", *(word for pair in SHORT for word in ("--set", pair)))
COMPILE = ("g++", "-std=c++17", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
PROGRAM = EXAMPLES / "linear_controller.py"
WAITING = "Waiting for a program at ws://127.0.0.1:"


def main(_arguments: Sequence[str]) -> int:
    """Print each step; 0 if all of them succeeded."""
    if not are_installed("npm", "node", "g++"):
        return 2
    with tempfile.TemporaryDirectory(prefix="seamark-bridges-") as name:
        folder = Path(name)
        done = succeed(
            (
                (
                    "PI with roslibpy and with roslib behind the bridge",
                    partial(_rosbridge, folder),
                ),
                ("Client in C++", partial(_client_in_cpp, folder)),
            )
        )
    return 0 if done else 1


def _rosbridge(folder: Path) -> None:
    """Compare the digests of the examples with that of the built-in controller."""
    shutil.copytree(ROSLIB, folder / "roslib")
    shutil.copy(EXAMPLES / "rosbridge" / "pi.mjs", folder / "roslib")
    run(NPM_CI, folder / "roslib")
    outcome = json.loads(run((*SEAMARK, "run", *RUN, "--controller", "pi", "--json"), folder))
    expected = outcome["digest"]
    programs: dict[str, Callable[[str], Sequence[str]]] = {
        "roslibpy": lambda port: (
            *(sys.executable, str(EXAMPLES / "rosbridge" / "pi.py")),
            *("127.0.0.1", port),
        ),
        "roslib": lambda port: ("node", "pi.mjs", f"ws://127.0.0.1:{port}"),
    }
    node = folder / "roslib"
    for name, command in programs.items():
        _compare(name, expected, _behind_bridge(command, node)["digest"])
    with started(folder / "ros") as (address, _):
        remote = ("--server", address, "--token", new_token(folder / "ros"))
        for name, command in programs.items():
            run_document = _behind_bridge(command, node, *remote)
            _compare(f"{name} on a server", expected, run_document["result"]["digest"])


def _compare(name: str, expected: str, digest: str) -> None:
    print(f"  {name}: digest {digest}", flush=True)
    if digest != expected:
        raise Failed(f"the digest of the built-in controller is {expected}")


def _behind_bridge(
    command: Callable[[str], Sequence[str]], folder: Path, *options: str
) -> dict[str, Any]:
    """Return what the bridge prints of the run of a program."""
    arguments = (*SEAMARK, "bridge", "rosbridge", *RUN, "--port", "0", "--json", *options)
    bridge = subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder
    )
    try:
        line = bridge.stderr.readline() if bridge.stderr else ""
        if not line.startswith(WAITING):
            raise Failed(f"the bridge printed {line!r}")
        run(command(line.removeprefix(WAITING).strip().rstrip(".")), folder)
        printed, _ = bridge.communicate(timeout=TIMEOUT_S)
    finally:
        bridge.kill()
    document: dict[str, Any] = json.loads(printed)
    return document


def _client_in_cpp(folder: Path) -> None:
    """Compile the example of the client in C++, and run it against a service."""
    program = folder / "follow_run"
    source = EXAMPLES / "cpp" / "follow_run.cpp"
    run((*COMPILE, "-I", str(ROOT / "docs"), str(source), "-lcurl", "-o", str(program)), folder)
    with started(folder / "data") as (address, _):
        token = new_token(folder / "data")
        printed = run((str(program), address, token, str(PROGRAM)), folder)
    print("".join(f"  {line}\n" for line in printed.splitlines()), end="", flush=True)
    written = sorted(folder.glob("run-*.csv"))
    if printed.count("succeeded, score") != len(written) or len(written) != 2:
        raise Failed("not both runs succeeded")
    if "refused 4" not in printed or not all(path.read_text() for path in written):
        raise Failed("no refusal, or no telemetry")
