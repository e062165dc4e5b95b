"""`python -m performance.trackers`: measure, print and write docs/trackers-table.md."""

import sys
from pathlib import Path

from performance.trackers import ROUNDS, table
from seamark.sim.recording.manifest import cpu_class

PAGE = Path(__file__).parents[2] / "docs" / "trackers-table.md"
_INTRODUCTION = """# Trackers compared with ViSP and OpenCV

Written by `python -m performance.trackers` on {cpu}.

All trackers process the same images in the same run, on one thread, in turns of some images each
(CSRT and KCF, a thousand times slower, after the others). Times are medians over the images of the
CPU time, taking the fastest of {rounds} rounds for each image; ViSP's is that of its own `track()`,
without the pipe to its process. "Speed-up" is relative to ViSP's fastest homography that kept the
target (or its fastest homography overall if none did).

ViSP's templates leave out 3 px at the rim of the target, as ours do. ViSP runs with sampling 2 (MI
with homography: 1, otherwise it loses the target), two pyramid levels down to full resolution (ZNCC
and MI: one; with two they lose this target), and `setGain(2)` for its ESM.

Errors are root mean squares over the four corners, over the images before the first with more than
10 px, where a tracker counts as lost. On the plain target, which has nothing but its edges, all
trackers are initialised 6 px beyond it. Times depend on the machine and its load: compare them only
within one table.

"""


def main() -> int:
    """Write the page and print it."""
    page = _INTRODUCTION.format(cpu=cpu_class()["model"], rounds=ROUNDS) + table()
    PAGE.write_text(page, encoding="utf-8")
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
