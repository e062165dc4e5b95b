"""Measure the entries of visibility-v2 and write their table and figures.

    python -m performance.visibility_headroom [ENTRY ...]

Every named entry (all of them without a name) runs the reference trials, and 24 trials in water of
other seeds, the same for all; its figures are stored in performance/visibility_headroom.json. From
those stored it prints the table of docs/benchmarks.md and how far the order depends on the trials,
and redraws the figures visibility-v2-headroom.png, -difficulty.png and -textures.png.
It takes about twenty seconds per entry on two idle cores, for KCF and ECC some minutes.
"""

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict

from performance.camera_figures import FOLDER
from performance.visibility_headroom.measurement import FILE, entries, measure, stored
from performance.visibility_headroom.page import (
    draw_difficulty,
    draw_headroom,
    draw_textures,
    report,
    stability,
)


def main(names: Sequence[str]) -> None:
    """Measure, store, print and draw."""
    for key in entries():
        if not names or key in names:
            measured = measure(key, len(os.sched_getaffinity(0)))
            known = stored() | {key: measured}  # read late: another process may have added some
            plain = {name: asdict(one) for name, one in sorted(known.items())}
            FILE.write_text(json.dumps(plain, indent=1) + "\n", encoding="utf-8")
    found = stored()
    sys.stdout.write(f"{report(found)}\n\n{stability(found)}\n")
    draw_headroom(found, FOLDER / "visibility-v2-headroom.png")
    draw_difficulty(found, FOLDER / "visibility-v2-difficulty.png")
    draw_textures(FOLDER / "visibility-v2-textures.png")


if __name__ == "__main__":
    main(sys.argv[1:])
