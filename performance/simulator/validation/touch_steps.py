"""Scenes with contact again with smaller steps, and with more iterations of the solver."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.validation.touch import hook_below_bar
from performance.tables import markdown_table
from seamark.sim.numerics.arrays import Array
from tests.sim.multibody.test_contacts import Scene, peg_before_hole, valve

TITLE = "Contact: smaller steps and more iterations"
STEPS_S = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
FINEST_S = 6.25e-5
WORKING_S, WORKING_ITERATIONS = 2e-3, 10
ITERATIONS = (5, 10, 20, 40, 80)
MOST_ITERATIONS = 640
SHOWN = 1e-5  # [mm or mrad] smaller errors are drawn here
EVERY_S = 0.02  # between two looks
LOAD_N = 77.6
TORQUE_N_M = 5.5  # the valve breaks away at 5
OFFSET_M, CHAMFER_M = 0.003, 0.004


class Case(NamedTuple):
    """A scene: how it is made of a step and iterations, what moves, for how long."""

    label: str
    made: Callable[[float, int], Scene]
    coordinate: int
    seconds: float
    unit: str


CASES = (
    Case(
        "hook lifts 77.6 N",
        lambda step_s, count: hook_below_bar(LOAD_N, step_s=step_s, iterations=count),
        2,
        2.0,
        "mm",
    ),
    Case(
        "valve of 5 N m is pushed",
        lambda step_s, count: valve(TORQUE_N_M, step_s=step_s, iterations=count),
        1,
        1.5,
        "mrad",
    ),
    Case(
        "peg slides down a chamfer",
        lambda step_s, count: peg_before_hole(
            OFFSET_M, chamfer=CHAMFER_M, step_s=step_s, iterations=count
        ),
        1,
        2.0,
        "mm",
    ),
)


def path(case: Case, step_s: float, iterations: int) -> Array:
    """Return where what moves is at each look, [m or rad]."""
    scene, found = case.made(step_s, iterations), []
    for _ in range(round(case.seconds / EVERY_S)):
        scene.run(round(EVERY_S / step_s))
        found.append(float(scene.state.q[case.coordinate]))
    return np.array(found)


def errors_over_steps(case: Case) -> list[float]:
    """Return the largest errors of the path over `STEPS_S`, [mm or mrad]."""
    best = path(case, FINEST_S, WORKING_ITERATIONS)
    return [
        1e3 * float(np.abs(path(case, step_s, WORKING_ITERATIONS) - best).max())
        for step_s in STEPS_S
    ]


def errors_over_iterations(case: Case) -> list[float]:
    """Return the largest errors of the path over `ITERATIONS`, [mm or mrad]."""
    best = path(case, WORKING_S, MOST_ITERATIONS)
    return [1e3 * float(np.abs(path(case, WORKING_S, n) - best).max()) for n in ITERATIONS]


def _draw_steps(errors: list[list[float]], out: Path) -> None:
    milliseconds = [1e3 * step_s for step_s in STEPS_S]
    with figure(out) as axes:
        for case, values, colour in zip(CASES, errors, COLOURS, strict=False):
            axes.loglog(
                milliseconds, values, "o-", color=colour, label=f"{case.label} [{case.unit}]"
            )
        first = max(values[0] for values in errors)
        line = [first * step_s / STEPS_S[0] for step_s in STEPS_S]
        axes.loglog(milliseconds, line, "--", color="0.5", label="first order")
        axes.axvline(1e3 * WORKING_S, color="0.7", label="step of runs")
        axes.set_xticks(milliseconds, [f"{one:g}" for one in milliseconds], minor=False)
        axes.set_xticks([], minor=True)
        ticks = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
        axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
        axes.set_yticks([], minor=True)
        axes.set_xlabel("step [ms]")
        axes.set_ylabel("largest error of the path")
        axes.legend(fontsize="small")


def _draw_iterations(errors: list[list[float]], out: Path) -> None:
    with figure(out) as axes:
        for case, values, colour in zip(CASES, errors, COLOURS, strict=False):
            shown = [max(value, SHOWN) for value in values]
            axes.loglog(ITERATIONS, shown, "o-", color=colour, label=f"{case.label} [{case.unit}]")
        axes.axvline(WORKING_ITERATIONS, color="0.7", label="iterations of runs")
        axes.set_xticks(ITERATIONS, [f"{count}" for count in ITERATIONS], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("iterations of the solver")
        axes.set_ylabel(f"largest error of the path; {SHOWN:g} or less")
        axes.legend(fontsize="small")


def _row(case: Case, errors: list[float]) -> tuple[str, ...]:
    return f"{case.label} [{case.unit}]", *(f"{value:.2g}" for value in errors)


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    by_step = [errors_over_steps(case) for case in CASES]
    by_count = [errors_over_iterations(case) for case in CASES]
    _draw_steps(by_step, figures / "touch-steps.png")
    _draw_iterations(by_count, figures / "touch-scene-iterations.png")
    steps = ("scene", *(f"{1e3 * step_s:g} ms" for step_s in STEPS_S))
    counts = ("scene", *(f"{count} iterations" for count in ITERATIONS))
    return "\n\n".join(
        [
            "A hook lifts a load by its bar, a slide pushes the lever of a valve past its "
            "break-away torque, and a peg beside a hole slides down the chamfer into it. The "
            "largest error of the path, looked at every "
            f"{1e3 * EVERY_S:g} ms, against steps of {1e6 * FINEST_S:g} us with "
            f"{WORKING_ITERATIONS} iterations:",
            markdown_table(steps, [_row(*pair) for pair in zip(CASES, by_step, strict=True)]),
            "![Error of scenes with contact over step size](figures/touch-steps.png)",
            f"Against {MOST_ITERATIONS} iterations, with the step of {1e3 * WORKING_S:g} ms:",
            markdown_table(counts, [_row(*pair) for pair in zip(CASES, by_count, strict=True)]),
            "![Error of scenes with contact over iterations](figures/touch-scene-iterations.png)",
        ]
    )
