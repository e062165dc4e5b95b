"""`python -m performance.trackers`: measure, print and write docs/trackers-table.md."""

import sys
from pathlib import Path

from performance.trackers import ROUNDS, sections
from seamark.sim.recording.manifest import cpu_class

PAGE = Path(__file__).parents[2] / "docs" / "trackers-table.md"
_INTRODUCTION = """# Trackers compared with ViSP and OpenCV

Written by `python -m performance.trackers` on {cpu}.

All trackers process the same images in the same run, on one thread, in turns of some images each
(CSRT, KCF and ViSP's MI, a hundred to a thousand times slower, after the others). Times are medians
over the images of the CPU time, taking the fastest of {rounds} rounds for each image; ViSP's is
that of its own `track()`, without the pipe to its process. "Speed-up" is relative to ViSP's fastest
homography that kept the target, whether with prediction or without; empty if none did.

"Predicts" says whether a tracker starts where the target would be at constant velocity. Ours and
ECC do so unless it is switched off; ViSP does not by itself, so it is compared without, and with
our prediction set as its start (`setp()`). Each line of ViSP is the faster of its set-ups with one
and with two pyramid levels among those that kept the target; if none did, the one that kept it
longest (its MI has one level). "First versions" are the options of currents-v1 and visibility-v1,
all other lines of ours those of currents-v2 and visibility-v2.

ViSP's templates leave out 3 px at the rim of the target, as ours do. ViSP runs with sampling 2 (MI
with homography: 1, otherwise it loses the target), its pyramid goes down to full resolution, and
its ESM has `setGain(2)`.

Errors are root mean squares over the four corners, over the images before the first with more than
10 px, where a tracker counts as lost. On the plain target, which has nothing but its edges, all
trackers are initialised 6 px beyond it. Times depend on the machine and its load: compare them only
within one table.

"""


def main() -> int:
    """Write the page, section by section, and print it."""
    page = _INTRODUCTION.format(cpu=cpu_class()["model"], rounds=ROUNDS).rstrip()
    print(page)
    for section in sections():
        print("\n" + section, flush=True)
        page += "\n\n" + section
        PAGE.write_text(page + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
