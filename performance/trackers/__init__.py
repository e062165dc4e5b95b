"""Our trackers compared with those of ViSP and OpenCV: same images, same run, one thread.

`python -m performance trackers` prints the tables; `python -m performance.trackers` also writes
them to docs/trackers-table.md.
"""

from collections.abc import Iterator
from dataclasses import replace

import cv2

from performance.trackers.basin import EACH, WITHIN_PX, basin_table, turning_table
from performance.trackers.contenders import CELLS, PEERS, SLOW_CELLS
from performance.trackers.photographs import TARGET_PX
from performance.trackers.race import Result, fastest, qualified, race
from performance.trackers.sequences import FRAMES, SEQUENCES
from seamark.sim.camera.pictures import PHOTOGRAPHS
from seamark.sim.trackers.visp.installation import unavailable_reason

ROUNDS = 2
_BASIN = f"""### Convergence on photographs

Share of the targets of {TARGET_PX[0]}x{TARGET_PX[1]} px that are found within {WITHIN_PX:g} px in
one image, after each of their corners moved by Gaussian noise of standard deviation σ along both
axes; {EACH} displacements of each of {len(PHOTOGRAPHS)} photographs.

"""
_TURNING = """### Error of a turning target

Targets that turn by 60° in steps of 5°: photographs, and the benchmarks' box below a turning
vehicle at 1.27 to 3 m, 320x240 and 640x480. The median error over the sequences, and the geometric
mean of its ratio to ECC's.

"""
_HEAD = (
    "tracker",
    "predicts",
    "set-up",
    "us per image",
    "speed-up",
    "median px",
    "95 % px",
    "lost at image",
)


def table() -> str:
    """Measure, and return all sections."""
    return "\n\n".join(sections()) + "\n"


def sections() -> Iterator[str]:
    """Measure, and yield a Markdown table for the photographs and for each sequence."""
    cv2.setNumThreads(1)
    if reason := unavailable_reason():
        yield f"ViSP is not included: {reason}."
    yield _BASIN + basin_table()
    yield _TURNING + turning_table()
    for name, draw in SEQUENCES.items():
        sequence = draw()
        start = replace(sequence, images=sequence.images[:3], corners=sequence.corners[:3])
        results = []
        for cells, rounds in ((CELLS, ROUNDS), (SLOW_CELLS, 1)):
            race([one for cell in cells for one in cell], start)  # warm-up
            contenders = qualified(cells, sequence)
            results += fastest([race(contenders, sequence) for _ in range(rounds)])
        yield (
            f"### {name}: {FRAMES} images, "
            f"corners move up to {sequence.largest_step_px():.1f} px\n\n{_markdown(results)}"
        )


def _markdown(results: list[Result]) -> str:
    peer_us = _peer_us(results)
    lines = ["| " + " | ".join(_HEAD) + " |", "|---|---|---|--:|--:|--:|--:|--:|"]
    for result in results:
        cells = (
            result.contender.label,
            "yes" if result.contender.predicts else "no",
            result.contender.setup,
            f"{result.median_us():.0f}",
            "" if peer_us is None else f"{peer_us / result.median_us():.2g}",
            f"{result.error(50):.3f}",
            f"{result.error(95):.2f}",
            "" if result.lost_at is None else f"{result.lost_at}",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _peer_us(results: list[Result]) -> float | None:
    """Return the time of ViSP's fastest homography that kept the target, if any did."""
    begin, end = PEERS
    labels = ((result, result.contender.label) for result in results)
    peers = [result for result, label in labels if label.startswith(begin) and label.endswith(end)]
    kept = [result for result in peers if result.lost_at is None]
    return min((result.median_us() for result in kept), default=None)
