"""Repeat the published experiment on its own plant and draw the figure.

    ./run performance paper_figures [--out docs/figures/p-and-pi.png] [--tracker esm]

Prints our numbers beside a planar check of the same laws, and writes one figure: X and Y error in
px over the five levels, P (Kp 0.5) and PI (Kp 0.5, Ki 0.02).
"""

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance import FIGURES
from performance.plots import figure
from performance.simulator.validation.trials import PAPER_VEHICLE, trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark

PX_PER_M = 514.7 / 2.27  # focal length over height
WINDOW_S = 30.0  # end of a level: two periods of the force on Y
BAND_PX = 2.0  # counts as zero in the table below
SMOOTHING_S = 1.0
LAWS = {"p": "P (Kp 0.5)", "pi": "PI (Kp 0.5, Ki 0.02)"}


class Planar(NamedTuple):
    """Constants of one axis of the published plant (sources: sim/vehicles/girona500-uwsim.toml)."""

    effort: float  # effort per m/s
    thrusters: int
    force: Callable[[float, float], float]  # (level, t) -> N


def _constant(level: float, _t: float) -> float:
    return 410.0 * 0.134 * level * level


def _rectified(level: float, t: float) -> float:
    lateral = level * math.sin(0.7 * math.sin(2.0 * math.pi * t / 30.0))
    return 410.0 * 0.134 * lateral * lateral


X_AXIS = Planar(6.0, 1, _constant)
Y_AXIS = Planar(5.0, 2, _rectified)


def planar_check(axis: Planar, level: float, ki: float) -> tuple[float, float, float]:
    """Return mean, minimum and maximum error [px] in the window, with perfect sensors.

    One axis, 147 kg with 148 N s²/m² of drag, thrust 153.8 u|u| N with a lag of 0.2 s, DVL at 5 Hz.
    """
    dt, mass, drag, lag = 0.01, 147.0, 148.0, 0.2
    position = speed = thrust = measured = integral = 0.0
    errors = []
    for step in range(12_000):
        if step % 20 == 0:
            measured = speed
        integral -= ki * position * dt
        effort = axis.effort * (-0.5 * position + integral - measured)
        effort = min(max(effort, -1.0), 1.0)
        thrust += dt / lag * (axis.thrusters * 153.8 * effort * abs(effort) - thrust)
        push = axis.force(level, step * dt) + thrust - drag * speed * abs(speed)
        speed += dt * push / mass
        position += dt * speed
        if step >= 9_000:
            errors.append(position * PX_PER_M)
    return sum(errors) / len(errors), min(errors), max(errors)


def run(controller: str, tracker: str) -> Rows:
    """Return the telemetry of the published experiment with one controller."""
    return trial(controller, vehicle=PAPER_VEHICLE, kp=0.5, ki=0.02, tracker=tracker).rows


class Facts(NamedTuple):
    """What the published figure shows for one level and one axis, in px."""

    mean: float
    minimum: float
    maximum: float
    return_s: float | None  # time from which the smoothed error stays within the band


def facts(rows: Rows, level: int, axis: str) -> Facts:
    """Return the facts of one level; errors are positive in the direction of the current."""
    mine = rows[rows[:, INDEX["level"]] == level]
    sign = -1.0 if axis == "x" else 1.0  # when pushed to starboard, the target moves left
    error = sign * mine[:, INDEX[f"error_{axis}_px"]]
    dt = float(mine[1, INDEX["t"]] - mine[0, INDEX["t"]])
    late = error[-round(WINDOW_S / dt) :]
    width = round(SMOOTHING_S / dt)
    smooth = np.convolve(error, np.full(width, 1.0 / width), mode="valid")
    outside = np.flatnonzero(np.abs(smooth) > BAND_PX)
    return_s = None if len(outside) and outside[-1] == len(smooth) - 1 else 0.0
    if return_s is not None and len(outside):
        return_s = float(outside[-1] + 1) * dt
    return Facts(float(late.mean()), float(late.min()), float(late.max()), return_s)


def table(p_rows: Rows, pi_rows: Rows) -> str:
    """Return our numbers beside the planar check, as a Markdown table."""
    lines = [
        "| V m/s | X, P: ours (planar) | X, PI: ours (within 2 px after) | Y, P: ours (planar) "
        "| Y, PI: ours (planar) |",
        "|---|---|---|---|---|",
    ]
    for level, speed in enumerate(benchmark("currents-v1").read({}).model_dump()["levels"]):
        x_p, x_pi = facts(p_rows, level, "x"), facts(pi_rows, level, "x")
        y_p, y_pi = facts(p_rows, level, "y"), facts(pi_rows, level, "y")
        settled = "never" if x_pi.return_s is None else f"{x_pi.return_s:.0f} s"
        planar = planar_check(X_AXIS, speed, 0.0)[0]
        y_planar = [_range(planar_check(Y_AXIS, speed, ki)) for ki in (0.0, 0.02)]
        lines.append(
            f"| {speed:g} | {x_p.mean:.1f} ({planar:.1f}) | {x_pi.mean:.1f} ({settled}) "
            f"| {_range(y_p)} ({y_planar[0]}) | {_range(y_pi)} ({y_planar[1]}) |"
        )
    return "\n".join(lines)


def _range(values: Facts | tuple[float, float, float]) -> str:
    mean, minimum, maximum = values[:3]
    return f"{mean:.1f} [{minimum:.1f} to {maximum:.1f}]"


def draw(p_rows: Rows, pi_rows: Rows, out: Path) -> None:
    """Write the figure: X and Y error over time for both controllers."""
    with figure(out, rows=2, height=5.5) as axes:
        for axis, panel in zip("xy", axes, strict=True):
            sign = -1.0 if axis == "x" else 1.0
            for (law, label), rows in zip(LAWS.items(), (p_rows, pi_rows), strict=True):
                values = sign * rows[:, INDEX[f"error_{axis}_px"]]
                colour = {"p": "#c2410c", "pi": "#1d4ed8"}[law]
                panel.plot(rows[:, INDEX["t"]], values, label=label, color=colour, linewidth=1.0)
            panel.set_ylabel(f"{axis.upper()} error [px]")
            for start in range(0, 600, 120):
                panel.axvline(start, color="0.6", linewidth=0.6, linestyle="--")
        axes[0].legend(loc="upper left")
        axes[0].set_title("girona500-uwsim: current 0, 0.1, 0.2, 0.3, 0.4 m/s, 120 s each")
        axes[1].set_xlabel("simulated time [s]")


def main(arguments: Sequence[str]) -> int:
    """Run both controllers, print the table, write the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=FIGURES / "p-and-pi.png")
    parser.add_argument("--tracker", default="esm")
    options = parser.parse_args(arguments)
    p_rows, pi_rows = (run(law, options.tracker) for law in LAWS)
    print(table(p_rows, pi_rows))
    draw(p_rows, pi_rows, options.out)
    print(f"wrote {options.out}")
    return 0
