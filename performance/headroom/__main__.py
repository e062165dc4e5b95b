"""Measure the reference entries of currents-v2 and write their table and plots.

    python -m performance.headroom [ENTRY ...] [--trials N] [--seed S] [--processes P]

Named entries are measured again, by default those that docs/headroom.json does not have yet with
these trials. The scenario is the ranked one; trial i has the seed S + i, none of which is a
benchmark's. Results do not depend on the number of processes, by default one per core.
"""

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from performance.headroom import page
from performance.headroom.measurement import NAME, measure_all
from seamark.sim.registry import benchmark

SEED = 3001  # neither the reference seed nor one that gains were tuned on
DOCS = Path(__file__).parents[2] / "docs"
STORE = DOCS / "headroom.json"


def main(arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    known = benchmark(NAME).baselines
    parser = argparse.ArgumentParser(prog="python -m performance.headroom")
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help=", ".join(known))
    parser.add_argument("--trials", type=int, default=48)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--processes", type=int, default=len(os.sched_getaffinity(0)))
    args = parser.parse_args(arguments)
    if unknown := set(args.entries) - set(known):
        parser.error(f"there is no entry {', '.join(sorted(unknown))}")
    every = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    stored = {name: every[name] for name in known if name in every}  # not of what is no entry now
    seeds = [args.seed + i for i in range(args.trials)]
    missing = [name for name in known if [one["seed"] for one in stored.get(name, ())] != seeds]
    for name in args.entries or missing:  # stored one by one: an interruption loses little
        stored[name] = measure_all(name, seeds, args.processes)
        STORE.write_text(json.dumps(stored, indent=1) + "\n", "utf-8")
        print(f"{name}: {len(stored[name])} trials", flush=True)
    page.write(stored, benchmark(NAME), DOCS)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
