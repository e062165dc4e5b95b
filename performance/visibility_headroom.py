"""`python -m performance.visibility_headroom [ENTRY ...]`: how visibility-v2 spreads its entries.

Every named entry (all of them without a name) runs the reference trials, and as many trials in
water of other seeds; its figures are stored in performance/visibility_headroom.json. From those
stored it prints the table of docs/benchmarks.md and how far the order depends on the trials, and
redraws the figures visibility-v2-headroom.png, -difficulty.png and -textures.png.
It takes about half a minute per entry on an idle core, for KCF and ECC some minutes.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from performance.camera_figures import FOLDER
from performance.validation.markdown import table
from performance.validation.plots import figure
from performance.visibility_attacks import Playback, Remembering, stored_paths
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.trackers import declaration, make

NAME = "visibility-v2"
FILE = Path(__file__).with_suffix(".json")
TRIALS = 8  # as many as there are reference trials: each of the textures once
OTHER_SEED = 770_001  # trial i has this seed plus i
AXES = {"turbidity": "optical depth", "motion": "px per image", "jump": "jump [px]"}
SHOWN_DEPTHS = (0.0, 2.0, 4.0)
DRAWN = ("nothing", "blind", "ssd", "box", "kcf", "ecc", "klt", "esm", "oracle")


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A solution: its title, settings, and what makes it if it is not the built-in tracker."""

    title: str
    config: dict[str, object]
    make: Callable[[Any], Any]  # configuration -> solution


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What an entry scored."""

    title: str
    reference: dict[str, Any]  # of metrics.json of the reference trials: see `_kept`
    other: dict[str, Any]  # and of those with other seeds
    scores: Sequence[float]  # of all trials, the reference trials first


def _reference(name: str) -> Callable[[Any], Any]:
    return lambda config: benchmark(NAME).load().built_in(name, config)


def _remembering(config: Any) -> Remembering:
    return Remembering(make(config.tracker, truth=None, **config.tracker_options()))


def _playback(_config: Any) -> Playback:
    protocol = benchmark(NAME).protocol
    seed = 0 if protocol is None else protocol.reference_seed
    return Playback(stored_paths(NAME, seed=seed, trials=TRIALS))


def entries() -> dict[str, Entry]:
    """Return all entries by their short names."""
    built_in = _reference("built-in")
    chosen: dict[str, tuple[str, dict[str, object], Callable[[Any], Any]]] = {
        "nothing": ("Nothing: the corners of the start for ever", {}, _reference("nothing")),
        "playback": ("Playback of the reference trials", {}, _playback),
        "blind": ("Blind after four images: constant velocity", {}, _reference("blind")),
        "ssd": ("Template tracker, SSD, homography", {"criterion": "ssd"}, built_in),
        "box": ("Box tracker", {"tracker": "box"}, built_in),
        "kcf": ("KCF", {"tracker": "kcf"}, built_in),
        "ecc": ("ECC, homography", {"tracker": "ecc", "warp": "homography"}, built_in),
        "klt": ("KLT, homography", {"tracker": "klt", "warp": "homography"}, built_in),
        "esm": ("Template tracker, ZNCC, homography", {}, built_in),
        "remembers": ("ZNCC, homography, remembers the path", {}, _remembering),
        "srt": ("Template tracker, ZNCC, SRT", {"warp": "srt"}, built_in),
        "mi": ("Template tracker, MI, SRT", {"criterion": "mi", "warp": "srt"}, built_in),
        "oracle": ("Oracle: the true corners", {}, _reference("oracle")),
    }
    if not declaration("visp").unavailable():
        chosen["visp"] = ("ViSP, ZNCC, homography", {"tracker": "visp"}, built_in)
    return {
        key: Entry(title=title, config=config, make=make_solution)
        for key, (title, config, make_solution) in chosen.items()
    }


def measure(entry: Entry) -> Measured:
    """Run an entry on the reference trials and on as many others."""
    loaded = benchmark(NAME)
    protocol = loaded.protocol
    reference_seed = 0 if protocol is None else protocol.reference_seed
    config = loaded.read(entry.config)

    def run(trial: int, seed: int) -> TrialResult:
        return run_trial(NAME, config, solution, seed=seed, trial=trial, on_rows=lambda _rows: None)

    solution = entry.make(config)
    known = [run(trial, reference_seed) for trial in range(TRIALS)]
    other = [run(trial, OTHER_SEED + trial) for trial in range(TRIALS)]
    return Measured(
        title=entry.title,
        reference=_kept(summarise(NAME, config, known)),
        other=_kept(summarise(NAME, config, other)),
        scores=[result.score for result in (*known, *other)],
    )


def _kept(metrics: dict[str, Any]) -> dict[str, Any]:
    """Return the part of metrics.json that table and figures show."""
    names = ("axis", "value", "p5_percent", "p1_percent")
    levels = [{name: level[name] for name in names} for level in metrics["levels"]]
    kept = {name: metrics[name] for name in ("score", "score_low", "score_high", "overall")}
    return kept | {"levels": levels}


def stored() -> dict[str, Measured]:
    """Return what was measured, by the short names of the entries."""
    found = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    return {key: Measured(**one) for key, one in found.items()}


def report(found: dict[str, Measured]) -> str:
    """Return the table, lowest score first."""
    ordered = sorted(found.values(), key=lambda one: float(one.other["score"]))
    head = (
        *("entry", "reference", "other seeds", "τ midpoint", "motion px", "basin px"),
        *("admitted %", "false %", "unreported %"),
    )
    rows = [
        (
            one.title,
            f"{one.reference['score']:.2f}",
            f"{one.other['score']:.2f} ± {one.other['score_high'] - one.other['score']:.2f}",
            *(_number(one.other["overall"][name], 2) for name in ("tau_midpoint",)),
            *(_number(one.other["overall"][name], 1) for name in ("motion_held_px", "basin_px")),
            *(
                _number(one.other["overall"][f"{name}_percent"], 0)
                for name in ("admitted_loss", "false_loss", "unreported_loss")
            ),
        )
        for one in ordered
    ]
    return table(head, rows)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def stability(found: dict[str, Measured]) -> str:
    """Return how much the order of the honest entries changes with the trials."""
    honest = {key: one for key, one in found.items() if key not in ("playback", "remembers")}
    halves = [
        _order({key: one.scores[part] for key, one in honest.items()})
        for part in (slice(0, TRIALS), slice(TRIALS, None), slice(0, None, 2), slice(1, None, 2))
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
    ordered = sorted(found.values(), key=lambda one: float(one.other["score"]))
    with figure(out, height=0.4 * len(ordered) + 1.0) as axes:
        at = np.arange(len(ordered))
        scores = [one.other["score"] for one in ordered]
        margins = [one.other["score_high"] - one.other["score"] for one in ordered]
        axes.barh(at, scores, xerr=margins, color="#1d4ed8", alpha=0.75, height=0.6, capsize=3)
        known = [one.reference["score"] for one in ordered]
        axes.plot(known, at, "o", color="#c2410c", label="reference trials")
        axes.set_yticks(at, [one.title for one in ordered])
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
    protocol = entry.protocol
    seed = 0 if protocol is None else protocol.reference_seed
    columns = []
    for trial in range(TRIALS):
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


def main(names: Sequence[str]) -> None:
    """Measure, store, print and draw."""
    for key, entry in entries().items():
        if not names or key in names:
            measured = measure(entry)
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
