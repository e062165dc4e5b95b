"""`./run performance [NAME ...]`: measure and print the tables, or only the named ones."""

import importlib
import sys

from performance.table import text

TABLES = (
    "physics",
    "camera",
    "exchange",
    "leftovers",
    "full_run",
    "growth",
    "scaling",
    "trackers",
)


def main(names: list[str]) -> int:
    """Print the tables; 2 if a name is unknown."""
    unknown = [name for name in names if name not in TABLES]
    if unknown:
        print(f"There is no table {', '.join(unknown)}; there are {', '.join(TABLES)}.")
        return 2
    for name in names or TABLES:
        module = importlib.import_module(f"performance.{name}")
        own = getattr(module, "table", None)  # a table with other columns than ours and the peer's
        print(f"\n{name}\n{own() if own else text(module.rows())}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
