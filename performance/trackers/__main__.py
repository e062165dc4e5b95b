"""`python -m performance.trackers`: measure, print and write docs/trackers-table.md."""

import sys
from pathlib import Path

from performance.trackers import ROUNDS, table
from seamark.sim.recording.manifest import cpu_class

PAGE = Path(__file__).parents[2] / "docs" / "trackers-table.md"
_INTRODUCTION = """# Trackers beside ViSP and OpenCV

Made by `python -m performance.trackers` on {cpu}.
The same pictures in the same run, one thread, all trackers in turn, some pictures each (CSRT and
KCF, a thousand times slower, after the others). Times are medians over the pictures of CPU time,
the least of {rounds} rounds; ViSP's is that of its own `track()`, without the pipe to it. "times"
is how many times faster than ViSP's fastest homography that kept the target (or of all, if none
did).
ViSP's templates leave out 3 px at the rim of the target, as ours do. It has sampling 2 (MI with
homography 1, or it is lost), two pyramid levels down to full resolution (ZNCC and MI one; with two
they lose this target), and for its ESM `setGain(2)`.
Errors are root mean squares over the four corners, of the pictures until the first with more than
10 px, where a tracker counts as lost. On the plain target, which shows nothing but its edges, all
are started 6 px beyond it. Times differ from machine to machine and with what else runs:
compare within the table.

"""


def main() -> int:
    """Write the page and print it."""
    page = _INTRODUCTION.format(cpu=cpu_class()["model"], rounds=ROUNDS) + table()
    PAGE.write_text(page, encoding="utf-8")
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
