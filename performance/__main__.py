"""`./run performance [NAME ...]`: measure and print the quick tables, named tables or `all`."""

import importlib
import os
import sys

from performance.table import text
from seamark.server import log

QUICK = ("full_run", "physics", "camera", "exchange")
SERVICE = (
    *("streams", "live_lag", "many_runs", "start_latency", "fake_runs", "claims", "player"),
    *("downloads", "connected", "upgrade_flood", "strangers_bytes"),
)
TABLES = (
    *QUICK,
    "gym",
    "start",
    "neighbours",
    "leaks",
    "growth",
    "scaling",
    "load_model",
    "leaderboard",
    "trackers",
    *SERVICE,
)
ALL = "all"


def main(names: list[str]) -> int:
    """Print the tables; 2 if a name is unknown."""
    unknown = [name for name in names if name not in (*TABLES, ALL)]
    if unknown:
        print(f"Unknown table: {', '.join(unknown)}. Choose from {', '.join(TABLES)} or {ALL}.")
        return 2
    os.environ.setdefault("SEAMARK_LOG_LEVEL", "warning")  # of services that are measured
    log.configure("warning", "text")
    chosen = TABLES if ALL in names else names or QUICK
    if not names:
        print(f"The quick tables: {', '.join(QUICK)}. `./run performance {ALL}` prints all tables.")
    for name in chosen:
        module = importlib.import_module(f"performance.{name}")
        own = getattr(module, "table", None)  # a table with its own columns
        print(f"\n{name}\n{own() if own else text(module.rows())}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
