"""Started as a process of its own: takes on groups, limits and uid, then becomes bubblewrap.

A program of its own and not a function between fork and exec: forking a large process with
threads and running Python there is neither quick nor safe.
"""

import json
import os
import resource
import sys
from pathlib import Path


def main() -> None:
    """Read the orders from the first argument and carry them out in their order."""
    orders = json.loads(sys.argv[1])
    for entry in orders["groups"]:
        Path(entry).write_text("0")
    if orders["core"] is not None:
        os.sched_setaffinity(0, {orders["core"]})
    Path("/proc/self/oom_score_adj").write_text("1000")  # the kernel takes the box before others
    for name, value in orders["limits"].items():
        resource.setrlimit(getattr(resource, name), (value, value))
    os.umask(0o077)
    if orders["uid"] is not None:
        os.setgroups([])
        os.setresgid(orders["uid"], orders["uid"], orders["uid"])
        os.setresuid(orders["uid"], orders["uid"], orders["uid"])
    os.setsid()
    os.chdir("/")
    # bubblewrap's own start environment can be read inside as /proc/1/environ: it is empty.
    os.execve(orders["command"][0], orders["command"], {})  # noqa: S606


if __name__ == "__main__":
    main()
