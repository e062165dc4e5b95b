"""docs/visibility.md and its plot, from the stored results."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from performance.perception.visibility.cases import GROUPS, ON_TARGETS, SHORTEST_S, STEP
from performance.plots import figure
from performance.tables import markdown_table
from seamark.sim.metrics.tracking import FAILED_PERCENT
from seamark.sim.numerics.statistics import mean, mean_interval
from seamark.sim.settings.targets import TARGETS
from seamark.sim.trackers.options import CRITERIA, WARPS

Measured = Mapping[str, Any]  # one case, as `measurement` stores it
HEAD = ("tracker", "τ50 (95 % interval)", "p@5 [%]", "p@1 [%]", "error [px]", "undetected [%]")
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
_PAGE = """# Trackers in turbid water

`./run performance visibility` computes all numbers and writes this page; give it names of groups to
measure only these. The benchmark is visibility-v1 as in a ranked run (the vehicle moves on a
prescribed path, 320x240, optical depth 0 to 7 in steps of 0.25, 5 s each) on ten seeds. τ50 is the
optical depth of the first level with fewer than half of the images within 5 px, with a 95 %
interval over the seeds (Student's t). The other columns cover all levels: p@5 and p@1 are the
shares of images within 5 px and 1 px, the error is the mean corner error of the images within 5 px,
and "undetected" is the share of images in which the tracker is more than 10 px off but reports
the target as found.

![p@5 over the optical depth](figures/visibility.png)

## Seamark and OpenCV

{ours}

{comparison}

## ViSP

ViSP has ten of the twelve combinations of three criteria and four methods: its headers have no
ZNCC with ESM or with the forward compositional method. All use the same set-up as in
[the table](trackers-table.md). They take 5 to 200 ms per image, so their levels last
{visp_level_s:g} s; seeds and steps are the same.

{visp}

## Fewer degrees of freedom

On the benchmark's path, the vehicle turns, tilts and rises. A translation cannot follow this, so
its errors come from the motion, not from the water. With `path_turn_rad=0` and
`path_heave_share=0`, the vehicle keeps its height and heading. Every warp can follow that, so only
the number of parameters makes a difference. τ50 on both paths:

{freedom}

{freedom_summary}

## Targets

τ50 by target, with homography. The plain box has only its edges, and by default a template leaves
out the outermost 3 px; with `template_margin_px=6` it includes them.

{targets}
{missing}
The rules of the benchmark are in `sim/benchmarks/visibility_v1/definition.py`.
"""


def write(results: Mapping[str, Sequence[Measured]], docs: Path) -> None:
    """Write the page and its plot; groups without results are left empty."""
    groups = {name: {one["label"]: one for one in cases} for name, cases in results.items()}
    ours = groups.get("ours", {}) | groups.get("opencv", {})
    visp = groups.get("visp", {}) | groups.get("visp-slow", {})
    text = _PAGE.format(
        ours=markdown_table(HEAD, _rows(ours)),
        comparison="\n".join(_comparison(ours)),
        visp=markdown_table(HEAD, _rows(visp)),
        visp_level_s=SHORTEST_S,
        freedom=markdown_table(
            ("criterion", "path", *WARPS), _freedom(ours, groups.get("in-plane", {}))
        ),
        freedom_summary="\n".join(_freedom_summary(groups.get("in-plane", {}))),
        missing=_missing(groups),
        targets=markdown_table(("target", *ON_TARGETS), _targets(groups.get("targets", {}), ours)),
    )
    (docs / "visibility.md").write_text(text, encoding="utf-8")
    _draw(ours | visp, docs / "figures" / "visibility.png")


def _missing(groups: Mapping[str, Mapping[str, Measured]]) -> str:
    """Return a paragraph that lists the cases without results; empty if there are none."""
    absent = {
        group: [case.label for case in cases if case.label not in groups.get(group, {})]
        for group, cases in GROUPS.items()
    }
    names = "; ".join(f"{group}: {', '.join(labels)}" for group, labels in absent.items() if labels)
    return f"\nNot measured yet: {names}.\n" if names else ""


def _tau(one: Measured | None) -> str:
    if one is None:
        return "–"
    scores = one["scores"]
    low, high = mean_interval(scores) or (scores[0], scores[0])
    return f"{mean(scores):.2f} ({low:.2f} to {high:.2f})"


def _rows(cases: Mapping[str, Measured]) -> Iterable[Sequence[str]]:
    """Yield the rows, the highest τ50 first."""
    for label, one in sorted(cases.items(), key=lambda item: -mean(item[1]["scores"])):
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


def _comparison(ours: Mapping[str, Measured]) -> Iterable[str]:
    """Yield how SSD compares with the other criteria."""
    score = {label: mean(one["scores"]) for label, one in ours.items()}
    names = [f"esm {criterion} homography" for criterion in ("ssd", "zncc", "mi")]
    if not set(names) <= set(score):
        return
    ssd, *others = (score[name] for name in names)
    yield (
        f"- Homography: SSD fails at {ssd:.2f}, ZNCC and MI at {min(others):.2f} or later. SSD "
        "compares grey values with those in clear water; the veil changes them long before the "
        "letters disappear."
    )
    yield (
        "- An axis-aligned box (`box`, `kcf`, `csrt`) or a translation cannot follow the rotation "
        "on "
        "this path. Their answers are coarse, as p@1 shows."
    )


def _freedom(ours: Mapping[str, Measured], plane: Mapping[str, Measured]) -> Iterable[list[str]]:
    for criterion in CRITERIA:
        pairs = [(f"esm {criterion} {warp}", f"{criterion} {warp}") for warp in WARPS]
        yield [criterion, "the benchmark's", *(_tau(ours.get(label)) for label, _ in pairs)]
        yield [criterion, "in the plane", *(_tau(plane.get(label)) for _, label in pairs)]


def _freedom_summary(plane: Mapping[str, Measured]) -> Iterable[str]:
    """Yield whether τ50 rises with fewer degrees of freedom where every warp can follow."""
    for criterion in CRITERIA:
        labels = [f"{criterion} {warp}" for warp in WARPS]
        if not set(labels) <= set(plane):
            continue
        scores = [plane[label]["scores"] for label in labels]
        means = [mean(each) for each in scores]
        differences = [a - b for a, b in zip(scores[0], scores[-1], strict=True)]
        low, high = mean_interval(differences) or (differences[0], differences[0])
        word = (
            "at every step" if all(a >= b for a, b in pairwise(means)) else "but not at every step"
        )
        yield (
            f"- {criterion.upper()}: τ50 increases with fewer degrees of freedom, {word}. On the "
            f"same seeds the translation differs from the homography by {mean(differences):+.2f} "
            f"({low:+.2f} to {high:+.2f})."
        )


def _targets(cases: Mapping[str, Measured], ours: Mapping[str, Measured]) -> Iterable[list[str]]:
    own = ("esm zncc homography", "esm ssd homography", "klt homography")
    yield ["lettered", *(_tau(ours.get(label)) for label in own)]
    for target in (*(name for name in TARGETS if name != "lettered"), "plain, margin 6"):
        yield [target, *(_tau(cases.get(f"{name} on {target}")) for name in ON_TARGETS)]


def _draw(cases: Mapping[str, Measured], out: Path) -> None:
    """Draw p@5 over the optical depth."""
    with figure(out, height=4.5) as axes:
        for number, label in enumerate(name for name in DRAWN if cases.get(name, {}).get("p5")):
            one = cases[label]
            depths = [k * STEP for k in range(len(one["p5"]))]
            style = "-" if label.startswith("esm") else "--"
            axes.plot(depths, one["p5"], style, color=f"C{number}", label=label, linewidth=1.8)
        axes.axhline(FAILED_PERCENT, color="#64748b", linewidth=1.0, linestyle=":")
        axes.set_xlabel("optical depth τ = c·Z")
        axes.set_ylabel("images within 5 px (p@5) [%]")
        axes.legend(fontsize=8)
