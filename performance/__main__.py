"""`./run performance [NAME ...]`: measure and print the quick tables, named tables or `all`.

After a single name, further words are arguments of that command.
"""

import os
import sys
from collections.abc import Sequence
from itertools import takewhile

from performance import commands
from performance.commands import ALL, MODULES, QUICK, TABLES, takes_arguments
from seamark.server.monitoring import log


def main(arguments: Sequence[str]) -> int:
    """Run the commands; 2 if a name is unknown."""
    if {"-h", "--help"} & set(arguments[:1]):
        print(__doc__, commands.described(), sep="\n")
        return 0
    names = [*takewhile(lambda word: word in (*MODULES, ALL), arguments)]
    rest = arguments[len(names) :]
    if rest and not (len(names) == 1 and takes_arguments(names[0])):
        print(f"Unknown command: {rest[0]}. Choose from {', '.join(MODULES)} or {ALL}.")
        return 2
    os.environ.setdefault("SEAMARK_LOG_LEVEL", "warning")  # of services that are measured
    log.configure("warning", "text")
    if not names:
        print(f"The quick tables: {', '.join(QUICK)}. `./run performance {ALL}` prints all tables.")
    chosen = TABLES if ALL in names else names or QUICK
    return max(commands.run(name, rest) for name in chosen)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
