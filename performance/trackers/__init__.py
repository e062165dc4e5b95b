"""Our trackers compared with those of ViSP and OpenCV: same images, same run, one thread.

`python -m performance trackers` prints the tables; `python -m performance.trackers` also writes
them to docs/trackers-table.md.
"""

from dataclasses import replace

import cv2

from performance.trackers.contenders import CONTENDERS, FILTERS, PEERS
from performance.trackers.race import Result, fastest, race
from performance.trackers.sequences import FRAMES, SEQUENCES
from seamark.sim.trackers.visp.installation import unavailable_reason

ROUNDS = 3
_HEAD = ("tracker", "us per image", "speed-up", "median px", "95 % px", "lost at image")


def table() -> str:
    """Measure, and return one Markdown table for each sequence."""
    cv2.setNumThreads(1)
    parts = []
    for name, draw in SEQUENCES.items():
        sequence = draw()
        start = replace(sequence, images=sequence.images[:3], corners=sequence.corners[:3])
        results = []
        for contenders, rounds in ((CONTENDERS, ROUNDS), (FILTERS, 1)):
            race(contenders, start)  # warm-up
            results += fastest([race(contenders, sequence) for _ in range(rounds)])
        parts.append(
            f"### {name}: {FRAMES} images, "
            f"corners move up to {sequence.largest_step_px():.1f} px\n\n{_markdown(results)}"
        )
    if reason := unavailable_reason():
        parts.append(f"ViSP is not included: {reason}.")
    return "\n\n".join(parts) + "\n"


def _markdown(results: list[Result]) -> str:
    peer_us = _peer_us(results)
    lines = ["| " + " | ".join(_HEAD) + " |", "|---|--:|--:|--:|--:|--:|"]
    for result in results:
        cells = (
            result.contender.label,
            f"{result.median_us():.0f}",
            "" if peer_us is None else f"{peer_us / result.median_us():.2g}",
            f"{result.error(50):.3f}",
            f"{result.error(95):.2f}",
            "" if result.lost_at is None else f"{result.lost_at}",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _peer_us(results: list[Result]) -> float | None:
    """Return the time of ViSP's fastest homography; one that lost the target only if all did."""
    begin, end = PEERS
    labels = ((result, result.contender.label) for result in results)
    peers = [result for result, label in labels if label.startswith(begin) and label.endswith(end)]
    kept = [result for result in peers if result.lost_at is None]
    return min((result.median_us() for result in kept or peers), default=None)
