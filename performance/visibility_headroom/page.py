"""Table and figures of the entries of visibility-v2, from what is stored of them."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from performance.validation.markdown import signed, table
from performance.validation.plots import figure
from performance.visibility_headroom.measurement import (
    NAME,
    REFERENCE_TRIALS,
    Measured,
    reference_seed,
)
from seamark.sim.numerics.statistics import paired_interval
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark

AXES = {"turbidity": "optical depth", "motion": "px per image", "jump": "jump [px]"}
SHOWN_DEPTHS = (0.0, 2.0, 4.0)
DRAWN = (
    *("nothing", "blind", "ssd-homography", "box", "kcf", "ecc", "klt", "zncc-homography"),
    "oracle",
)


def report(found: dict[str, Measured]) -> str:
    """Return the table, lowest score first."""
    head = (
        *("entry", "mark", "reference", "other seeds", "better than the mark above"),
        *("τ midpoint", "motion px", "basin px", "admitted %", "false %", "unreported %"),
    )
    steps, marks = mark_steps(found), benchmark(NAME).baselines
    return table(
        head,
        (_row(found[key], "yes" if key in marks else "", steps[key]) for key in ordered(found)),
    )


def ordered(found: dict[str, Measured]) -> list[str]:
    """Return the short names of the entries, lowest score first."""
    return sorted(found, key=lambda key: float(found[key].other["score"]))


def mark_steps(found: dict[str, Measured]) -> dict[str, tuple[float, float] | None]:
    """Return for each entry by how much it is better than the next mark with a lower score.

    The 95 % interval of the mean difference on the same trials, none of them a reference trial;
    None for the lowest.
    """
    steps: dict[str, tuple[float, float] | None] = {}
    below: Measured | None = None
    for key in ordered(found):
        own = found[key].scores[REFERENCE_TRIALS:]
        steps[key] = paired_interval(own, below.scores[REFERENCE_TRIALS:]) if below else None
        if key in benchmark(NAME).baselines:
            below = found[key]
    return steps


def _row(one: Measured, mark: str, step: tuple[float, float] | None) -> tuple[str, ...]:
    overall = one.other["overall"]
    losses = (f"{name}_loss_percent" for name in ("admitted", "false", "unreported"))
    return (
        one.title,
        mark,
        f"{one.reference['score']:.2f}",
        f"{one.other['score']:.2f} ± {one.other['score_high'] - one.other['score']:.2f}",
        "" if step is None else f"{signed(step[0], 3)} to {signed(step[1], 3)}",
        _number(overall["tau_midpoint"], 2),
        *(_number(overall[name], 1) for name in ("motion_held_px", "basin_px")),
        *(_number(overall[name], 0) for name in losses),
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def stability(found: dict[str, Measured]) -> str:
    """Return how much the order of the honest entries changes with the trials."""
    honest = {key: one for key, one in found.items() if key not in ("playback", "remembers")}
    halves = [
        _order({key: one.scores[part] for key, one in honest.items()})
        for part in (
            slice(0, REFERENCE_TRIALS),
            slice(REFERENCE_TRIALS, None),
            slice(0, None, 2),
            slice(1, None, 2),
        )
    ]
    agree = [_agreement(halves[0], halves[1]), _agreement(halves[2], halves[3])]
    return (
        f"Pairs of {len(honest)} entries in the same order: {agree[0]:.0f} % with other seeds, "
        f"{agree[1]:.0f} % between the even and the odd trials."
    )


def _order(scores: dict[str, Sequence[float]]) -> list[str]:
    return sorted(scores, key=lambda key: float(np.mean(scores[key])))


def _agreement(first: list[str], second: list[str]) -> float:
    """Return the share of pairs [%] that two orders agree on."""
    place = {key: at for at, key in enumerate(second)}
    pairs = [(a, b) for at, a in enumerate(first) for b in first[at + 1 :]]
    return 100.0 * sum(place[a] < place[b] for a, b in pairs) / len(pairs)


def draw_headroom(found: dict[str, Measured], out: Path) -> None:
    """Draw the scores with their intervals."""
    entries = [found[key] for key in ordered(found)]
    with figure(out, height=0.4 * len(entries) + 1.0) as axes:
        at = np.arange(len(entries))
        scores = [one.other["score"] for one in entries]
        margins = [one.other["score_high"] - one.other["score"] for one in entries]
        axes.barh(at, scores, xerr=margins, color="#1d4ed8", alpha=0.75, height=0.6, capsize=3)
        known = [one.reference["score"] for one in entries]
        axes.plot(known, at, "o", color="#c2410c", label="reference trials")
        axes.set_yticks(at, [one.title for one in entries])
        axes.set_xlabel("turbidity held [optical depth], mean and 95 % interval, other seeds")
        axes.set_xlim(0.0, 7.2)
        axes.legend(loc="lower right")


def draw_difficulty(found: dict[str, Measured], out: Path) -> None:
    """Draw the share of success over the levels of each axis."""
    shown = [key for key in DRAWN if key in found]
    with figure(out, rows=len(AXES), height=10.0, share_x=False) as panels:
        for panel, (axis, label) in zip(panels, AXES.items(), strict=True):
            metric = "p1_percent" if axis == "jump" else "p5_percent"
            for number, key in enumerate(shown):
                levels = [one for one in found[key].other["levels"] if one["axis"] == axis]
                values = [one["value"] for one in levels]
                shares = [one[metric] for one in levels]
                style = "-" if number % 2 else "--"
                panel.plot(values, shares, style, marker=".", label=found[key].title)
            panel.set_xlabel(label)
            panel.set_ylabel("p@1 [%]" if axis == "jump" else "p@5 [%]")
        panels[1].legend(fontsize=7, loc="center right")


def draw_textures(out: Path) -> None:
    """Write a column for each reference trial: its target at three optical depths."""
    entry = benchmark(NAME)
    experiment, config = entry.load(), entry.read({})
    seed = reference_seed()
    columns = []
    for trial in range(REFERENCE_TRIALS):
        kept: list[Rows] = []
        turbid = config.level_values().index(SHOWN_DEPTHS[-1])
        experiment.level(config, None, seed=seed, trial=trial, level=turbid).run(kept.append)
        pose = kept[0][0, INDEX["x"] : INDEX["yaw"] + 1]
        drawn = []
        for depth in SHOWN_DEPTHS:
            level = config.level_values().index(depth)
            camera = experiment.camera(config, seed=seed, trial=trial, level=level)
            column, row = camera.corners(pose).mean(axis=0).round().astype(int)
            padded = np.pad(camera.grey(pose, 0), 60)  # the crop may reach beyond the image
            drawn.append(padded[row + 20 : row + 100, column : column + 120])
        columns.append(np.vstack(drawn))
    cv2.imwrite(str(out), np.hstack(columns))
