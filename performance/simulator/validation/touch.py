"""Contact against Coulomb's law, weight and geometry, and more iterations of the solver."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.multibody_at_valve import EVERY, AtValve, in_current
from performance.tables import below
from seamark.sim.multibody.loads import write_loads
from seamark.sim.multibody.mechanism import Link, Mechanism, Motor, Shape
from seamark.sim.multibody.solver import Timing
from seamark.sim.numerics.arrays import Array
from tests.sim.multibody.scenes import ALONG_Y, GROUND, STEP_S
from tests.sim.multibody.test_contacts import (
    FRICTION,
    WEIGHT_N,
    Scene,
    box_on_the_bottom,
    ground,
    peg,
    solid,
)

TITLE = "Contact"
MASS = 15.0  # [kg] of the box
SHARES = (0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.2, 1.4, 1.6)
WEIGHTS_N = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 77.6)
HELD_S = 30.0
CHAMFERS_MM = (0.0, 2.0, 4.0)
CLEARANCE_MM = 1.0
OFFSETS_MM = np.arange(0.0, 7.01, 0.25)
ITERATIONS = (5, 10, 20, 40, 80)
WORKING = 10


class Lifted(NamedTuple):
    """A load on a hook: force at the hook's joint [N], how far it moves while it is held [mm]."""

    force: float
    moved_mm: float


def pushed(share: float) -> tuple[float, float]:
    """Return acceleration [m/s²] and way in 10 s [mm] of a box, from a share of the limit."""
    scene = box_on_the_bottom(push=True)
    place = scene.state.q[0]
    scene.command.thrust[:] = share * FRICTION * WEIGHT_N
    scene.run(1000)
    before = scene.state.v[0]
    scene.run(500)
    gained = scene.state.v[0] - before
    scene.run(3500)
    return float(gained), float(1e3 * (scene.state.q[0] - place))


def hook_below_bar(weight_n: float, *, step_s: float = STEP_S, iterations: int = 10) -> Scene:
    """Return a box on the bottom, and a hook below the bar above it."""
    hook = Link(
        name="hook",
        joint="prismatic",
        offset=(0.0, 0.0, GROUND.depth - 0.25),
        axis=(0.0, 0.0, -1.0),
        rigid=solid(1.0, (0.1, 0.02, 0.02)),
    )
    load = Link(name="load", rigid=solid(MASS, (0.3, 0.2, 0.2)), net_weight=weight_n)
    radius = 0.01
    shapes = [
        ground(),
        Shape(
            name="hook", kind="capsule", link="hook", size=(radius, 0.05, 0.0), friction=FRICTION
        ),
        Shape(name="box", kind="box", link="load", size=(0.15, 0.1, 0.1), friction=FRICTION),
        Shape(
            name="bar",
            kind="capsule",
            link="load",
            place=(0.0, 0.0, -0.2),
            turn=ALONG_Y,
            size=(radius, 0.08, 0.0),
            friction=FRICTION,
        ),
    ]
    mechanism = Mechanism(
        links=[load, hook],
        motors=[Motor(link="hook", effort=200.0)],
        shapes=shapes,
        pairs=[("box", "ground"), ("hook", "bar")],
    )
    scene = Scene(mechanism, step_s=step_s, iterations=iterations)
    scene.state.q[2] = GROUND.depth - 0.1
    scene.command.speed[:] = 0.1
    return scene


def lifted(weight_n: float) -> Lifted:
    """Lift a box by the bar above it with a hook, and hold it."""
    scene = hook_below_bar(weight_n)
    scene.run(1500)
    scene.command.speed[:] = 0.0
    scene.run(2500)
    held = scene.state.q[:3].copy()
    scene.run(round(HELD_S / STEP_S))
    loads = np.empty((2, 6))
    write_loads(scene.timing, scene.model, scene.state, scene.work, loads)
    moved = 1e3 * float(np.abs(scene.state.q[:3] - held).max())
    return Lifted(-float(loads[1, 2]), moved)


def jaw(iterations: int) -> Array:
    """Return the angles of a jaw that turns a valve in a current, one for each command [rad]."""
    task = AtValve()
    task.scene.timing = Timing(STEP_S, iterations)
    task.scene.water = in_current(0).water
    angles = []
    for k in range(400):
        task.scene.command.thrust[:] = task.thrusts()
        task.scene.command.speed[:] = task.speeds(k * EVERY * STEP_S)
        task.scene.run(EVERY)
        angles.append(float(task.q[11]))
    return np.array(angles)


def _draw_friction(out: Path) -> tuple[float, float]:
    motions = [pushed(share) for share in SHARES]
    limit = FRICTION * WEIGHT_N
    fine = np.linspace(0.0, 1.7, 100)
    with figure(out) as axes:
        axes.plot(fine, np.maximum(fine - 1.0, 0.0) * limit / MASS, color="0.5", label="Coulomb")
        axes.plot(SHARES, [a for a, _ in motions], "o", color=COLOURS[0], label="ours")
        axes.set_xlabel("push over friction coefficient times weight")
        axes.set_ylabel("acceleration [m/s²]")
        axes.legend()
    ways = [way for share, (_, way) in zip(SHARES, motions, strict=True) if share < 1.0]
    above = [
        abs(a / ((share - 1.0) * limit / MASS) - 1.0)
        for share, (a, _) in zip(SHARES, motions, strict=True)
        if share > 1.0
    ]
    return max(ways), max(above)


def _draw_hook(out: Path) -> tuple[float, float]:
    lifts = [lifted(weight) for weight in WEIGHTS_N]
    with figure(out) as axes:
        axes.plot([0.0, 80.0], [0.0, 80.0], color="0.5", label="weight")
        axes.plot(WEIGHTS_N, [one.force for one in lifts], "o", color=COLOURS[0], label="ours")
        axes.set_xlabel("weight of the load in water [N]")
        axes.set_ylabel("force at the hook's joint [N]")
        axes.legend()
    errors = [abs(one.force - weight) for one, weight in zip(lifts, WEIGHTS_N, strict=True)]
    return max(errors), max(one.moved_mm for one in lifts)


def _draw_peg(out: Path) -> tuple[int, int]:
    tried, wrong = 0, 0
    with figure(out) as axes:
        for chamfer, colour, marker in zip(CHAMFERS_MM, COLOURS, "o^s", strict=False):
            depths = [1e3 * peg(1e-3 * offset, chamfer=1e-3 * chamfer) for offset in OFFSETS_MM]
            limit = CLEARANCE_MM + chamfer
            label = f"chamfer {chamfer:g} mm"
            size = 4.0 + chamfer  # points of the deepest chamfer are around those of the others
            axes.plot(OFFSETS_MM, depths, marker, color=colour, label=label, ms=size, mfc="none")
            axes.axvline(limit, color=colour, linestyle="--", linewidth=1.0)
            for offset, depth in zip(OFFSETS_MM, depths, strict=True):
                if offset != limit:
                    tried += 1
                    wrong += (depth > 30.0) != (offset < limit)
        axes.set_xlabel(
            "offset of the peg from the hole's axis [mm]; dashed: clearance and chamfer"
        )
        axes.set_ylabel("depth reached [mm]")
        axes.legend()
    return tried, wrong


def _draw_iterations(out: Path) -> tuple[float, float]:
    best = jaw(4 * ITERATIONS[-1])
    errors = [1e3 * float(np.abs(jaw(count) - best).max()) for count in ITERATIONS]
    with figure(out) as axes:
        axes.loglog(ITERATIONS, errors, "o-", color=COLOURS[0])
        axes.axvline(WORKING, color="0.7", label="iterations of runs")
        axes.set_xticks(ITERATIONS, [f"{count}" for count in ITERATIONS], minor=False)
        axes.set_xticks([], minor=True)
        ticks = (0.1, 0.2, 0.5, 1.0, 2.0)
        axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
        axes.set_yticks([], minor=True)
        axes.set_xlabel("iterations of the solver")
        axes.set_ylabel("largest error of a jaw's angle [mrad]")
        axes.legend()
    return errors[ITERATIONS.index(WORKING)], errors[-1]


def section(_names: list[str], figures: Path) -> str:
    """Return the section's text."""
    way, wrong = _draw_friction(figures / "touch-friction.png")
    off, moved = _draw_hook(figures / "touch-hook.png")
    pegs, against = _draw_peg(figures / "touch-peg.png")
    now, more = _draw_iterations(figures / "touch-iterations.png")
    return "\n\n".join(
        [
            f"A box of {MASS:g} kg that is pushed with up to 98 % of what friction holds moves "
            f"{way:.1g} mm in 10 s; with more, its acceleration is Coulomb's within "
            f"{100.0 * wrong:.1g} %.",
            "![Acceleration over push](figures/touch-friction.png)",
            f"A hook that lifts a load of {WEIGHTS_N[0]:g} to {WEIGHTS_N[-1]:g} N feels its "
            f"weight; the error is {below(off)} N. Held for {HELD_S:g} s, the load moves "
            f"{moved:.1g} mm.",
            "![Force at the hook over weight](figures/touch-hook.png)",
            f"A peg of 20 mm with a clearance of {CLEARANCE_MM:g} mm enters a hole if its offset "
            "is within clearance and chamfer, and stays outside beyond, in "
            f"{pegs - against} of {pegs} cases.",
            "![Depth of a peg over its offset](figures/touch-peg.png)",
            f"While jaws turn a valve of 3 N m in a current, the angle of one is up to {now:.1f} "
            f"mrad from where it is with {4 * ITERATIONS[-1]} iterations; {ITERATIONS[-1]} "
            f"iterations leave {more:.1f} mrad.",
            "![Error of a jaw over iterations](figures/touch-iterations.png)",
        ]
    )
