"""Our trackers compared with those of ViSP and OpenCV: same images, same run, one thread.

`./run performance trackers` prints the tables; with `--page` it writes docs/trackers-table.md.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

import cv2

from performance import DOCS
from performance.perception.trackers.basin import EACH, WITHIN_PX, basin_table, turning_table
from performance.perception.trackers.contenders import CELLS, PEERS, SLOW_CELLS
from performance.perception.trackers.photographs import TARGET_PX
from performance.perception.trackers.race import Result, fastest, qualified, race
from performance.perception.trackers.sequences import FRAMES, SEQUENCES
from seamark.sim.camera.pictures import PHOTOGRAPHS
from seamark.sim.recording.manifest import cpu_class
from seamark.sim.trackers.visp.installation import unavailable_reason

PAGE = DOCS / "trackers-table.md"
ROUNDS = 2
_INTRODUCTION = """# Trackers compared with ViSP and OpenCV

Written by `./run performance trackers --page` on {cpu}.

All trackers process the same images in the same run, on one thread, in turns of some images each
(CSRT, KCF and ViSP's MI, a hundred to a thousand times slower, run after the others). Times are the
median CPU time over the images, with the fastest of {rounds} rounds for each image.
ViSP's time is that of its own `track()`, without the pipe to its process. "Speed-up" is relative to
ViSP's fastest homography that kept the target, with or without prediction; empty if none did.

"Predicts" says whether a tracker starts where the target would be at constant velocity. Ours and
ECC do so unless you turn it off. ViSP does not, so we compare it without prediction, and with our
prediction set as its start (`setp()`). For each line of ViSP we tried one and two pyramid levels
and show the faster set-up that kept the target; if none did, the one that kept it longest (its MI
has one level). "First versions" are the options of currents-v1 and visibility-v1; all our other
lines use those of currents-v2 and visibility-v2.

ViSP's templates leave out 3 px at the rim of the target, as ours do. ViSP runs with sampling 2 (MI
with homography: 1, otherwise it loses the target), its pyramid goes down to full resolution, and
its ESM has `setGain(2)`.

Errors are root mean squares over the four corners, over the images before the first with more than
10 px; there, a tracker counts as lost. The plain target has only its edges, so all trackers start
6 px beyond it. Times depend on the machine and its load: compare them only within one table.

"""
_BASIN = f"""### Convergence on photographs

Share of the targets of {TARGET_PX[0]}x{TARGET_PX[1]} px that a tracker finds to within
{WITHIN_PX:g} px in one image, after each corner moved by Gaussian noise of standard deviation σ
along both axes; {EACH} displacements for each of {len(PHOTOGRAPHS)} photographs.

"""
_TURNING = """### Error of a turning target

The targets turn by 60° in steps of 5°: photographs, and the benchmarks' box below a turning vehicle
at 1.27 to 3 m, 320x240 and 640x480. The table shows the median error over the sequences, and the
geometric mean of its ratio to ECC's.

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


def main(arguments: Sequence[str]) -> int:
    """Write the page, section by section, and print it."""
    parser = argparse.ArgumentParser(prog="./run performance trackers")
    parser.add_argument("--page", action="store_true", required=True, help="write the page")
    parser.parse_args(arguments)
    page = _INTRODUCTION.format(cpu=cpu_class()["model"], rounds=ROUNDS).rstrip()
    print(page)
    for section in sections():
        print("\n" + section, flush=True)
        page += "\n\n" + section
        PAGE.write_text(page + "\n", encoding="utf-8")
    return 0
