"""Links in water against Lagrange's equations, conservation laws and smaller steps."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.plots import COLOURS, figure
from performance.tables import below
from seamark.sim.multibody.mechanism import command_for, state_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import advance
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current
from tests.sim.multibody.scenes import GROUND, vehicle_with_arm
from tests.sim.multibody.test_dynamics import (
    STEADY,
    STEP_S,
    Lagrangian,
    acceleration,
    in_vacuum,
    kinetic,
    of_the_numbers,
    put,
    random_mechanism,
    rng,
    run,
    tumbling,
)

TITLE = "Vehicles with arms: dynamics"
SEEDS = range(25)
SPEED, CURRENT = 0.8, 0.2  # [m/s] of the water around random trees, and around a vehicle
STEPS_S = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4)
FINEST_S = 6.25e-5
WORKING_S = 2e-3
COAST_S, SWING_S = 2.0, 5.0
TUMBLING = (3.0, 10.0, 30.0)  # [rad/s]
TUMBLING_S = np.arange(1.0, 61.0, 2.0)
OFF_CENTRE = (0.1, 0.05, -0.02)  # [m] of the body's origin from its centre of mass
STILL = Current(0.0)


class Drift(NamedTuple):
    """Relative changes of what should be kept."""

    energy: float
    momentum: float


def disagreement(seed: int, *, free: bool, speed: float) -> float:
    """Return the largest error of an acceleration of a random mechanism, over the largest one."""
    mechanism = random_mechanism(seed, free=free)
    current = Current(speed, pattern=STEADY)
    lagrangian = Lagrangian(mechanism, current.velocity(0.0))
    state = state_for(mechanism.model(STEP_S))
    q, rate = 0.5 * rng(100 + seed).standard_normal((2, len(state.v)))
    put(q, lagrangian, rate, state)
    v = state.v.copy()
    change = of_the_numbers(acceleration(mechanism, state, current), v, free=free)
    expected = lagrangian.speed_changes(q, rate)
    return float(np.abs(change - expected).max() / np.abs(expected).max())


def drift(step_s: float) -> Drift:
    """Return what a tumbling tree of five links loses or gains in vacuum."""
    mechanism = in_vacuum(4)
    model = mechanism.model(step_s)
    state = state_for(model)
    state.v[:] = 0.5 * rng(9).standard_normal(len(state.v))
    first = kinetic(mechanism, state, step_s)
    span, timing, command = (0, round(COAST_S / step_s)), Timing(step_s, 0), command_for(model)
    advance(span, timing, model, state, command, STILL.water, GROUND, work_for(model))
    last = kinetic(mechanism, state, step_s)
    lost = np.abs(last[1] - first[1]).max() / np.abs(first[1]).max()
    return Drift(abs(last[0] / first[0] - 1.0), float(lost))


def tumbled(rate: float) -> Array:
    """Return the relative change of a free body's energy in vacuum at times `TUMBLING_S`."""
    mechanism = tumbling(centre=OFF_CENTRE)
    v = [0.5, -0.3, 0.2, 0.3 * rate, rate, 0.1 * rate]
    energies = [
        kinetic(mechanism, run(mechanism, WORKING_S, seconds, v), WORKING_S)[0]
        for seconds in (0.0, *TUMBLING_S)
    ]
    return np.array(energies[1:]) / energies[0] - 1.0


def swung(step_s: float) -> Array:
    """Return where a vehicle is that has swung its arm in a current, (3,) [m]."""
    mechanism = vehicle_with_arm()
    mechanism.links[0].net_weight -= sum(link.net_weight for link in mechanism.links)
    model = mechanism.model(step_s)
    state, command, work = state_for(model), command_for(model), work_for(model)
    state.q[2] = 5.0
    command.speed[:] = 0.4, -0.3, 0.25, 0.5, 0.0
    water = Current(CURRENT, pattern=STEADY).water
    span = (0, round(SWING_S / step_s))
    advance(span, Timing(step_s, 10), model, state, command, water, GROUND, work)
    return state.q[:3].copy()


def _draw_agreement(out: Path) -> float:
    cases = [
        (
            f"{'floating' if free else 'fixed'}, {'still water' if speed == 0.0 else 'current'}",
            free,
            speed,
        )
        for free in (True, False)
        for speed in (0.0, SPEED)
    ]
    worst = 0.0
    with figure(out) as axes:
        for (label, free, speed), colour in zip(cases, COLOURS, strict=True):
            errors = [disagreement(seed, free=free, speed=speed) for seed in SEEDS]
            worst = max(worst, *errors)
            axes.semilogy(list(SEEDS), errors, "o", color=colour, label=label, markersize=4)
        axes.axhline(
            np.finfo(float).eps, color="0.5", linestyle="--", label="rounding of one number"
        )
        axes.set_xlabel("random mechanism")
        axes.set_ylabel("error over largest acceleration")
        axes.set_ylim(1e-17, 1e-12)
        axes.legend(ncols=3, fontsize="small")
    return worst


def _draw_drift(out: Path) -> Drift:
    drifts = [drift(step_s) for step_s in STEPS_S]
    with figure(out) as axes:
        for name, colour in zip(Drift._fields, COLOURS, strict=False):
            values = [getattr(entry, name) for entry in drifts]
            axes.loglog([1e3 * s for s in STEPS_S], values, "o-", color=colour, label=name)
        line = [drifts[0].energy * s / STEPS_S[0] for s in STEPS_S]
        axes.loglog([1e3 * s for s in STEPS_S], line, "--", color="0.5", label="first order")
        axes.axvline(1e3 * WORKING_S, color="0.7", label="step of runs")
        axes.set_xticks([1e3 * s for s in STEPS_S], [f"{1e3 * s:g}" for s in STEPS_S], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("step [ms]")
        axes.set_ylabel(f"relative change in {COAST_S:g} s")
        axes.legend()
    return drifts[STEPS_S.index(WORKING_S)]


def _draw_tumbling(out: Path) -> list[float]:
    changes = [tumbled(rate) for rate in TUMBLING]
    with figure(out) as axes:
        for rate, change, colour in zip(TUMBLING, changes, COLOURS, strict=False):
            label = f"{rate:g} rad/s"
            axes.plot(TUMBLING_S, 100.0 * change, "o-", color=colour, label=label, markersize=3)
        axes.set_xlabel("time [s]")
        axes.set_ylabel("change of energy [%]")
        axes.legend()
    return [float(np.abs(change).max()) for change in changes]


def _draw_steps(out: Path) -> float:
    finest = swung(FINEST_S)
    errors = [1e3 * float(np.linalg.norm(swung(step_s) - finest)) for step_s in STEPS_S]
    with figure(out) as axes:
        milliseconds = [1e3 * s for s in STEPS_S]
        axes.loglog(milliseconds, errors, "o-", color=COLOURS[0], label="place of the vehicle")
        line = [errors[0] * s / STEPS_S[0] for s in STEPS_S]
        axes.loglog(milliseconds, line, "--", color="0.5", label="first order")
        axes.axvline(1e3 * WORKING_S, color="0.7", label="step of runs")
        axes.set_xticks([1e3 * s for s in STEPS_S], [f"{1e3 * s:g}" for s in STEPS_S], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("step [ms]")
        axes.set_ylabel(f"error after {SWING_S:g} s [mm]")
        axes.legend()
    return errors[STEPS_S.index(WORKING_S)]


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    worst = _draw_agreement(figures / "links-lagrange.png")
    lost = _draw_drift(figures / "links-conservation.png")
    tumbling_changes = _draw_tumbling(figures / "links-tumbling.png")
    apart = _draw_steps(figures / "links-steps.png")
    return "\n\n".join(
        [
            f"The accelerations of {4 * len(SEEDS)} random trees of five links differ from "
            f"Lagrange's equations by {below(worst)} of the largest one. Each link has a random "
            "positive definite 6x6 mass and added mass, weight and buoyancy, one a rotor; joints "
            "turn or slide, the base floats or is fixed, the water is still or flows. The "
            "Lagrangian is written in Euler angles and shares no equation with the engine; its "
            "derivatives are complex steps, which do not round.",
            "![Errors of accelerations against Lagrange's equations](figures/links-lagrange.png)",
            f"In vacuum a tumbling tree changes its energy by {100.0 * lost.energy:.2f} % and its "
            f"momentum by {100.0 * lost.momentum:.2f} % in {COAST_S:g} s with the step of "
            f"{1e3 * WORKING_S:g} ms. Both halve with the step: the method is of first order.",
            "![Change of energy and momentum over step size](figures/links-conservation.png)",
            "A free body that tumbles in vacuum about a point beside its origin, for a minute with "
            f"the step of {1e3 * WORKING_S:g} ms, has an energy that swings by up to "
            + ", ".join(
                f"{100.0 * change:.2g} % at {rate:g} rad/s"
                for change, rate in zip(tumbling_changes, TUMBLING, strict=True)
            )
            + ". It does not grow.",
            "![Change of a tumbling body's energy over time](figures/links-tumbling.png)",
            f"A vehicle that swings all joints of its arm in a current of {CURRENT:g} m/s is, "
            f"after {SWING_S:g} s, {apart:.2f} mm from where it is with steps of "
            f"{1e6 * FINEST_S:g} us.",
            "![Error of a swinging arm's vehicle over step size](figures/links-steps.png)",
        ]
    )
