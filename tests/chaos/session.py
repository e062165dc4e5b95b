"""`./run chaos [--runs N] [--seed S] [FAULT...]`: many runs under each fault, on a whole service.

Prints a line for each fault, and ends with 1 if a run was lost, has another result than an
undisturbed one, or left something behind.
"""

import argparse
import ctypes
import signal
import sys
import zlib

from seamark.embedded.supervisor import PR_SET_CHILD_SUBREAPER
from tests.chaos.campaign import Campaign, Findings
from tests.chaos.faults import FAULTS
from tests.chaos.installation import installation

RUNS = 200
STANDSTILL_S = 60.0
HEADER = "| fault | injected | runs | wrong | most attempts | longest standstill | left | time |"


def row(name: str, runs: int, found: Findings) -> str:
    """Return the line of the table for one fault."""
    cells = [name, found.injected, runs, len(found.wrong), found.attempts]
    cells += [f"{found.standstill_s:.1f} s", len(found.left), f"{found.seconds:.0f} s"]
    return f"| {' | '.join(map(str, cells))} |"


def main() -> int:
    """Run the session; return the exit code."""
    parser = argparse.ArgumentParser(prog="./run chaos", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS, help="runs under each fault")
    parser.add_argument("--seed", type=int, default=1, help="decides when and where faults happen")
    parser.add_argument("fault", nargs="*", choices=[*FAULTS, []], help="default: all of them")
    options = parser.parse_args()
    # Processes that lose their parents become ours, so that they can be counted.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # and stop the service on the way
    problems: list[str] = []
    print(HEADER, "|---" * 8 + "|", sep="\n", flush=True)
    with installation() as service:
        for name in options.fault or FAULTS:
            seed = options.seed + zlib.crc32(name.encode())
            found = Campaign(service, options.runs, seed).run(FAULTS[name])
            print(row(name, options.runs, found), flush=True)
            problems += [f"{name}: {problem}" for problem in found.problems]
            if found.standstill_s > STANDSTILL_S:
                problems.append(f"{name}: no run ended for {found.standstill_s:.0f} s")
    print(*problems, sep="\n")
    return int(bool(problems))


if __name__ == "__main__":
    sys.exit(main())
