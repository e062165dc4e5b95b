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
from tests.chaos.faults import FAULTS, HANG_S, OBJECT_FAULTS
from tests.chaos.installation import installation, installation_with_objects

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
    names = [*FAULTS, *OBJECT_FAULTS]
    parser.add_argument("fault", nargs="*", choices=[*names, []], help="default: all of them")
    options = parser.parse_args()
    # Processes that lose their parents become ours, so that they can be counted.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # and stop the service on the way
    problems: list[str] = []
    print(HEADER, "|---" * 8 + "|", sep="\n", flush=True)
    for faults, started in ((FAULTS, installation), (OBJECT_FAULTS, installation_with_objects)):
        if chosen := [name for name in faults if name in (options.fault or names)]:
            with started() as service:
                for name in chosen:
                    seed = options.seed + zlib.crc32(name.encode())
                    found = Campaign(service, options.runs, seed).run(faults[name])
                    print(row(name, options.runs, found), flush=True)
                    problems += [f"{name}: {problem}" for problem in problems_of(name, found)]
    print(*problems, sep="\n")
    return int(bool(problems))


def problems_of(name: str, found: Findings) -> list[str]:
    """Return what must not happen under a fault, in words."""
    problems = list(found.problems)
    # No run can end while the object storage that takes its data is away.
    longest_s = STANDSTILL_S + (HANG_S if name in OBJECT_FAULTS else 0.0)
    if found.standstill_s > longest_s:
        problems.append(f"no run ended for {found.standstill_s:.0f} s")
    if name in OBJECT_FAULTS and found.attempts > 1:
        problems.append(f"a run needed {found.attempts} attempts")
    return problems


if __name__ == "__main__":
    sys.exit(main())
