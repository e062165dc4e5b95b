"""docs/visibility.md and its plots, from what was measured."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from performance.validation.markdown import table
from performance.validation.plots import figure
from performance.visibility.cases import GROUPS, ON_TARGETS, SHORTEST_S, STEP
from seamark.sim.metrics.tracking import FAILED_PERCENT
from seamark.sim.numerics.statistics import bootstrap_interval, mean
from seamark.sim.settings.targets import TARGETS
from seamark.sim.trackers.choices import CRITERIA, WARPS

Measured = Mapping[str, Any]  # one case, as __main__ keeps it
HEAD = ("tracker", "τ50 (95 % interval)", "p@5 [%]", "p@1 [%]", "error [px]", "unadmitted [%]")
DRAWN = (
    "esm zncc srt",
    "esm zncc homography",
    "esm mi homography",
    "esm ssd homography",
    "klt homography",
    "csrt",
    "visp zncc ic homography",
    "visp ssd ic homography",
)
_PAGE = """# How long trackers keep their target in turbid water

Made by `python -m performance.visibility`, which takes names of groups to measure only these; all
numbers are computed, none typed. visibility-v1 as a ranked run has it (moving vehicle on a
prescribed path, 320x240, optical depth 0 to 7 in steps of 0.25, 5 s each) on ten seeds. τ50 is the
optical depth of the first level with fewer than half of the pictures within 5 px; the interval is a
95 % bootstrap over the seeds. The other columns are over all levels; the error is the mean corner
error of the pictures within 5 px; unadmitted is the share of pictures in which the tracker is more
than 10 px off and says that it has the target.

![p@5 over the optical depth](figures/visibility.png)

## Ours and OpenCV's

{ours}

{verdicts}

## ViSP's

Of the twelve that three criteria and four methods make, ViSP has ten: its headers have no ZNCC with
ESM and none with forward compositional steps. All are set up as in [the table](trackers-table.md).
They take 5 to 200 ms a picture, so their levels last {visp_level_s:g} s; seeds and steps are the
same.

{visp}

## Fewer degrees of freedom

On the benchmark's path the vehicle turns, tilts and rises, which a translation cannot follow; its
errors come from the motion and not from the water. On the path `path_turn_rad=0
path_heave_share=0` it moves at one height and heading, which every warp can follow. There the
number of parameters alone makes the difference. τ50 on both:

{freedom}

{freedom_verdicts}

## Targets

τ50 by target, with homography. The plain box shows nothing but its edges, and by default a template
leaves out the outermost 3 px: with `template_margin_px=6` it has them.

{targets}
{missing}
The rules of the benchmark stand in `sim/benchmarks/visibility_v1/definition.py`.
"""


def write(kept: Mapping[str, Sequence[Measured]], docs: Path) -> None:
    """Write the page and its plot; a group that was never measured is left empty."""
    found = {name: {one["label"]: one for one in cases} for name, cases in kept.items()}
    ours = found.get("ours", {}) | found.get("opencv", {})
    visp = found.get("visp", {}) | found.get("visp-slow", {})
    text = _PAGE.format(
        ours=table(HEAD, _rows(ours)),
        verdicts="\n".join(_verdicts(ours)),
        visp=table(HEAD, _rows(visp)),
        visp_level_s=SHORTEST_S,
        freedom=table(("criterion", "path", *WARPS), _freedom(ours, found.get("in-plane", {}))),
        freedom_verdicts="\n".join(_chains(found.get("in-plane", {}))),
        missing=_missing(found),
        targets=table(("target", *ON_TARGETS), _targets(found.get("targets", {}), ours)),
    )
    (docs / "visibility.md").write_text(text, encoding="utf-8")
    _draw(ours | visp, docs / "figures" / "visibility.png")


def _missing(found: Mapping[str, Mapping[str, Measured]]) -> str:
    """Return which cases have not been measured, as a paragraph; nothing if all were."""
    absent = {
        group: [case.label for case in cases if case.label not in found.get(group, {})]
        for group, cases in GROUPS.items()
    }
    names = "; ".join(f"{group}: {', '.join(labels)}" for group, labels in absent.items() if labels)
    return f"\nNot measured yet: {names}.\n" if names else ""


def _tau(one: Measured | None) -> str:
    if one is None:
        return "–"
    scores = one["scores"]
    low, high = bootstrap_interval(scores) or (scores[0], scores[0])
    return f"{mean(scores):.2f} ({low:.2f} to {high:.2f})"


def _rows(found: Mapping[str, Measured]) -> Iterable[Sequence[str]]:
    """Yield the rows, the longest-lasting tracker first."""
    for label, one in sorted(found.items(), key=lambda item: -mean(item[1]["scores"])):
        overall = one["overall"]
        corner = overall["corner_px"]
        yield (
            label,
            _tau(one),
            f"{overall['p5_percent']:.1f}",
            f"{overall['p1_percent']:.1f}",
            "–" if corner is None else f"{corner:.2f}",
            f"{overall['not_admitted_percent']:.2f}",
        )


def _verdicts(ours: Mapping[str, Measured]) -> Iterable[str]:
    """Yield what the figures say about SSD beside the others."""
    score = {label: mean(one["scores"]) for label, one in ours.items()}
    names = [f"esm {criterion} homography" for criterion in ("ssd", "zncc", "mi")]
    if not set(names) <= set(score):
        return
    ssd, *others = (score[name] for name in names)
    yield (
        f"- Homography: SSD fails at {ssd:.2f}, ZNCC and MI at {min(others):.2f} or later. SSD "
        "compares grey values with those of clear water, and the veil changes them long before the "
        "letters are gone."
    )
    yield (
        "- An upright box (`box`, `kcf`, `csrt`) has errors of its own on this path, as a "
        "translation has: it cannot follow the turn. What they say is coarse, p@1 shows it."
    )


def _freedom(ours: Mapping[str, Measured], plane: Mapping[str, Measured]) -> Iterable[list[str]]:
    for criterion in CRITERIA:
        pairs = [(f"esm {criterion} {warp}", f"{criterion} {warp}") for warp in WARPS]
        yield [criterion, "the benchmark's", *(_tau(ours.get(label)) for label, _ in pairs)]
        yield [criterion, "in the plane", *(_tau(plane.get(label)) for _, label in pairs)]


def _chains(plane: Mapping[str, Measured]) -> Iterable[str]:
    """Yield whether fewer degrees of freedom last longer where all can follow."""
    for criterion in CRITERIA:
        labels = [f"{criterion} {warp}" for warp in WARPS]
        if not set(labels) <= set(plane):
            continue
        scores = [plane[label]["scores"] for label in labels]
        means = [mean(each) for each in scores]
        differences = [a - b for a, b in zip(scores[0], scores[-1], strict=True)]
        low, high = bootstrap_interval(differences) or (differences[0], differences[0])
        word = (
            "at every step" if all(a >= b for a, b in pairwise(means)) else "but not at every step"
        )
        yield (
            f"- {criterion.upper()}: fewer degrees of freedom last longer, {word}. The translation "
            f"lasts {mean(differences):+.2f} beside the homography, on the same seeds "
            f"({low:+.2f} to {high:+.2f})."
        )


def _targets(found: Mapping[str, Measured], ours: Mapping[str, Measured]) -> Iterable[list[str]]:
    own = ("esm zncc homography", "esm ssd homography", "klt homography")
    yield ["lettered", *(_tau(ours.get(label)) for label in own)]
    for target in (*(name for name in TARGETS if name != "lettered"), "plain, margin 6"):
        yield [target, *(_tau(found.get(f"{name} on {target}")) for name in ON_TARGETS)]


def _draw(found: Mapping[str, Measured], out: Path) -> None:
    """Draw p@5 over the optical depth."""
    with figure(out, height=4.5) as axes:
        for number, label in enumerate(name for name in DRAWN if found.get(name, {}).get("p5")):
            one = found[label]
            depths = [k * STEP for k in range(len(one["p5"]))]
            style = "-" if label.startswith("esm") else "--"
            axes.plot(depths, one["p5"], style, color=f"C{number}", label=label, linewidth=1.8)
        axes.axhline(FAILED_PERCENT, color="#64748b", linewidth=1.0, linestyle=":")
        axes.set_xlabel("optical depth τ = c·Z")
        axes.set_ylabel("pictures within 5 px (p@5) [%]")
        axes.legend(fontsize=8)
