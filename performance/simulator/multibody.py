"""Vehicles with arms and contact: what creeps, and what a step costs, beside MuJoCo and PyBullet.

All run the scenes of the tests in this process: rigid bodies without drag for MuJoCo (elliptic
cone, impratio 10, noslip 5) and PyBullet, which know no 6x6 added mass. The last rows are a minute
of a vehicle whose arm turns a valve in a current, alone and eight side by side, and a minute of a
whole run: sensors, telemetry, camera, tracker, and a program in its box that moves the arm, without
and with the images of the camera on it.
"""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from performance.simulator.multibody_at_valve import EVERY, START, AtValve, in_current
from performance.simulator.multibody_judges import MUJOCO_OPTIONS, MuJoCo, PyBullet
from performance.tables import aligned, below
from seamark.sandbox.probing.probes import probe
from seamark.sim.fleet.mechanisms import Mechanisms
from seamark.sim.multibody.mechanism import Mechanism, state_for
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import LANES
from seamark.sim.physics.current import Current
from seamark.sim.physics.hydrodynamics import write_rotation
from seamark.sim.recording.telemetry import ARM_INDEX
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from tests.sim.multibody.scenes import GROUND, STEP_S, vehicle_with_arm
from tests.sim.multibody.test_contacts import (
    FRICTION,
    MINUTE,
    WEIGHT_N,
    Scene,
    box_on_the_bottom,
    gripper,
    valve,
)
from tests.sim.multibody.test_dynamics import acceleration

RUN: dict[str, object] = {
    "vehicle": "bluerov2-heavy-v2",
    "arm": "alpha-like",
    "levels": [0.2],
    "level_duration_s": 60.0,
}
PROGRAM = b"""\
import math

class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, observation):
        x, y, _ = observation.error
        if "images" in observation:
            observation.images["arm"][120, 160]
        slow = 0.3 * math.cos(0.5 * observation.t)
        closing = -0.5  # jaws that press on each other
        return [0.5 * x, 0.5 * y, 0.0, 0.0, slow, -slow, slow, slow, closing]
"""
WHOLE_RUNS = (  # what, goal [s CPU], tracker, images for the program
    ("true corners", 0.6, "truth", "none"),
    ("camera and tracker", 1.0, "esm", "none"),
    ("true corners, images of the arm's camera", 1.0, "truth", "arm"),
    ("camera and tracker, images of the arm's camera", 1.0, "esm", "arm"),
)
PUSH_N = 0.95 * FRICTION * WEIGHT_N


class Result(NamedTuple):
    """What moved, [mm] or [rad], and the CPU time of a step [us]."""

    moved: float
    step_us: float


class Compared(NamedTuple):
    """One scene of the three; None for what cannot run it."""

    what: str
    goal: float
    unit: str
    ours: Result
    mujoco: Result | None
    bullet: Result | None


def measured(run: Callable[[], None], place: Callable[[], Array], steps: int) -> Result:
    """Run once, and return how far it has gone."""
    before, start = place(), time.process_time()
    run()
    used = time.process_time() - start
    return Result(float(np.abs(place() - before).max()), 1e6 * used / steps)


def _ours(scene: Scene, steps: int, place: Callable[[Scene], Array]) -> Result:
    return measured(lambda: scene.run(steps), lambda: place(scene).copy(), steps)


def _mujoco(
    mechanism: Mechanism, settle: int, steps: int, setting: Callable[[MuJoCo], None], size: slice
) -> Result:
    judge = MuJoCo(mechanism, STEP_S, MUJOCO_OPTIONS)
    setting(judge)
    judge.run(settle)
    return measured(lambda: judge.run(steps), judge.data.qpos[size].copy, steps)


def _in_mm(result: Result) -> Result:
    return Result(1e3 * result.moved, result.step_us)


def box(push_n: float) -> tuple[Result, Result, Result]:
    """A box of 15 kg on the bottom, pushed or at rest."""
    scene = box_on_the_bottom(push=True)
    steps = MINUTE if push_n == 0.0 else 5000
    where = scene.state.q[:3].copy()
    scene.command.thrust[:] = push_n
    ours = _ours(scene, steps, lambda scene: scene.state.q[:3])

    def start(judge: MuJoCo) -> None:
        judge.data.qpos[:3] = where
        judge.run(500)
        judge.data.xfrc_applied[1, 0] = push_n

    mujoco = _mujoco(scene.mechanism, 0, steps, start, slice(0, 3))
    bullet = PyBullet(scene.mechanism, STEP_S, WEIGHT_N / 15.0, {"box": where})
    bullet.run(500)
    push = ("box", np.array([push_n, 0.0, 0.0])) if push_n else None
    theirs = measured(lambda: bullet.run(steps, push), lambda: bullet.position("box"), steps)
    bullet.close()
    return _in_mm(ours), _in_mm(mujoco), _in_mm(theirs)


def bar() -> tuple[Result, Result, Result]:
    """A bar of 15 N between two jaws that press with 40 N."""
    scene = gripper(effort=40.0, bar_weight=15.0)
    scene.run(500)
    ours = _ours(scene, MINUTE, lambda scene: scene.state.q[:3])

    def start(judge: MuJoCo) -> None:
        judge.data.qpos[:3] = 0.0, 0.0, 5.0
        judge.data.ctrl[:] = 0.2

    mujoco = _mujoco(scene.mechanism, 500, MINUTE, start, slice(0, 3))
    bullet = PyBullet(scene.mechanism, STEP_S, 7.5, {"bar": np.array([0.0, 0.0, 5.0])})
    for jaw in ("left", "right"):
        bullet.drive(jaw, 0.2, 40.0)
    bullet.run(500)
    theirs = measured(lambda: bullet.run(MINUTE), lambda: bullet.position("bar"), MINUTE)
    bullet.close()
    return _in_mm(ours), _in_mm(mujoco), _in_mm(theirs)


def stuck_valve() -> tuple[Result, Result, Result]:
    """A valve that breaks away at 5 N m, pushed with 3 N m."""
    scene, steps = valve(3.0), MINUTE // 2
    scene.run(500)
    ours = _ours(scene, steps, lambda scene: scene.state.q[1:])

    def start(judge: MuJoCo) -> None:
        judge.data.ctrl[:] = 0.1

    mujoco = _mujoco(scene.mechanism, 500, steps, start, slice(1, 2))
    bullet = PyBullet(scene.mechanism, STEP_S, 0.0, {})
    bullet.drive("pusher", 0.1, 15.0)
    bullet.run(500)
    theirs = measured(
        lambda: bullet.run(steps), lambda: np.array([bullet.coordinate("valve")]), steps
    )
    bullet.close()
    return ours, mujoco, theirs


def resting_vehicle() -> Result:
    """The yaw of a neutral vehicle with an arm at rest in still water."""
    mechanism = vehicle_with_arm()
    mechanism.links[0].net_weight -= sum(link.net_weight for link in mechanism.links)
    scene = Scene(mechanism)
    scene.state.q[2] = 5.0

    def yaw(scene: Scene) -> Array:
        rotation = np.empty((3, 3))
        w, x, y, z = scene.state.q[3:7]
        write_rotation(w, x, y, z, rotation)
        return np.array([np.arctan2(rotation[1, 0], rotation[0, 0])])

    scene.run(1)
    return _ours(scene, MINUTE, yaw)


def side_by_side() -> float:
    """Return the CPU time of a minute of one of eight vehicles with the lanes in use [s]."""
    tasks = [AtValve() for _ in range(LANES)]
    currents = [in_current(seed) for seed in range(LANES)]
    fleet = Mechanisms(
        [task.scene.model for task in tasks], currents, GROUND, tasks[0].scene.timing
    )
    for i, task in enumerate(tasks):
        fleet.place(i, task.scene.state)
    used, every = 0.0, EVERY
    for k in range(MINUTE // every):
        thrust = np.array([task.thrusts() for task in tasks])
        speed = np.array([task.speeds(k * every * STEP_S) for task in tasks])
        start = time.process_time()
        fleet.advance(every, thrust, speed)
        used += time.process_time() - start
        for i, task in enumerate(tasks):
            fleet.read(i, task.scene.state)
    fleet.close()
    return used / LANES


def peers_minute(task: AtValve) -> float:
    """Return MuJoCo's CPU time of a minute of the same mechanism in air, its wrist turning [s]."""
    judge = MuJoCo(task.mechanism, STEP_S, MUJOCO_OPTIONS)
    judge.data.qpos[: task.q.size] = task.q
    start = time.process_time()
    for k in range(MINUTE // EVERY):
        judge.data.ctrl[:] = task.speeds(k * EVERY * STEP_S)
        judge.run(EVERY)
    return time.process_time() - start


def apart_in_vacuum() -> float:
    """Return how far accelerations of a vehicle with an arm are from MuJoCo's, over the largest.

    There is no water, weight, motor or friction; all joints and the vehicle move.
    """
    mechanism = vehicle_with_arm()
    mechanism.motors, mechanism.frictions, mechanism.pairs = [], [], []
    mechanism.couplings, mechanism.limits = [], []
    for link in mechanism.links:
        link.added, link.net_weight, link.moment = np.zeros((6, 6)), 0.0, (0.0, 0.0, 0.0)
        link.linear = link.quadratic = (0.0,) * 6
    judge, worst = MuJoCo(mechanism, STEP_S, {}), 0.0
    source = np.random.Generator(np.random.PCG64(5))
    for _ in range(20):
        state = state_for(mechanism.model(STEP_S))
        state.q[:] = source.standard_normal(state.q.size)
        state.q[3:7] /= np.linalg.norm(state.q[3:7])
        state.v[:] = source.standard_normal(state.v.size)
        rotation = np.empty((3, 3))
        w, x, y, z = state.q[3:7]
        write_rotation(w, x, y, z, rotation)
        judge.data.qpos[:], judge.data.qvel[:] = state.q, state.v
        judge.data.qvel[:3] = rotation @ state.v[:3]  # the world's axes there
        ours = acceleration(mechanism, state, Current(0.0))
        ours[:3] = rotation @ ours[:3]
        theirs = judge.accelerations()
        worst = max(worst, float(np.abs(ours - theirs).max() / np.abs(theirs).max()))
    return worst


def iterations_table() -> str:
    """Return how far jaws at rest are moved while the arm turns the valve, and what that costs."""
    head = ("jaws that are told to rest, at the valve: moved mrad", "0", "0.0001", "0.001 kg m²")
    rows = []
    for iterations in (5, 10, 20, 80):
        tasks = [AtValve(iterations=iterations, jaw_rotor=rotor) for rotor in (0.0, 1e-4, 1e-3)]
        used = [task.run(in_current(0)) for task in tasks]
        slack = [f"{1e3 * task.slack:.2f}" for task in tasks]
        rows.append((f"{iterations} iterations, {min(used):.2f} s of CPU a minute", *slack))
    return aligned([head, *rows])


def compared() -> list[Compared]:
    """Measure the scenes."""
    return [
        Compared("box at rest, 60 s", 0.01, "mm", *box(0.0)),
        Compared("box pushed with 95 % of what friction holds, 10 s", 0.5, "mm", *box(PUSH_N)),
        Compared("bar held by friction, 60 s", 0.1, "mm", *bar()),
        Compared("stuck valve at 60 % of its torque, 30 s", 1e-4, "rad", *stuck_valve()),
        Compared(
            "vehicle with an arm in still water, yaw, 60 s",
            1e-9,
            "rad",
            resting_vehicle(),
            None,
            None,
        ),
    ]


def _moved(result: Result | None) -> str:
    return "" if result is None else f"{result.moved:.1g}"


def _ratio(ours: Result, other: Result | None) -> str:
    return "" if other is None else f"{other.step_us / ours.step_us:.1f}"


def minute_of_a_run(tracker: str, images: str) -> tuple[float, float]:
    """Return the CPU time [s] of simulator and box, best of three, and the mean touch [N]."""
    isolation, used, kept = probe().level, [], []
    settings = RUN | {"tracker": tracker, "images": images}
    for _ in range(3):
        rows: list[Array] = []
        before = time.process_time()
        outcome = evaluate_locally(
            "currents-v2",
            settings,
            seed=3,
            controller=(PROGRAM, "controller.py"),
            isolation=isolation,
            callbacks=Callbacks(rows=rows.append),
        )
        used.append(time.process_time() - before + outcome.usage["cpu_s"])
        kept = rows
    return min(used), float(np.concatenate(kept)[:, ARM_INDEX["touch_1"]].mean())


def table() -> str:
    """Measure everything and return the table."""
    side_by_side()  # compiles, as the next line does
    AtValve().run(in_current(0))
    alone = AtValve()
    air = peers_minute(alone)
    minute = alone.run(in_current(0))
    lanes = side_by_side()
    head = (
        "moved",
        "goal",
        "unit",
        "ours",
        "MuJoCo",
        "PyBullet",
        "step us",
        "MuJoCo's",
        "PyBullet's",
    )
    lines = [
        (
            scene.what,
            f"{scene.goal:g}",
            scene.unit,
            *map(_moved, (scene.ours, scene.mujoco, scene.bullet)),
            f"{scene.ours.step_us:.2f}",
            _ratio(scene.ours, scene.mujoco),
            _ratio(scene.ours, scene.bullet),
        )
        for scene in compared()
    ]
    minutes = [
        (what, goal, *minute_of_a_run(tracker, images))
        for what, goal, tracker, images in WHOLE_RUNS
    ]
    pressed = minutes[0][-1]
    turned, touching = float(alone.q[-1]), alone.touching / (MINUTE // EVERY)
    shift = float(np.abs(alone.q[:3] - np.array(START)).max())
    return "\n".join(
        [
            aligned([head, *lines]),
            "",
            "Accelerations of a vehicle with an arm in vacuum differ from MuJoCo's by "
            f"{below(apart_in_vacuum())} of the largest.",
            f"A minute at a valve of 3 N m in 0.22 m/s: turned {turned:.3f} rad, touching in "
            f"{100.0 * touching:.0f} % of the time, {1e3 * shift:.0f} mm off its place at the end.",
            aligned(
                [
                    ("CPU s", "goal", "ours", "MuJoCo in air", "times real time"),
                    ("alone", "0.6", f"{minute:.3f}", f"{air:.3f}", f"{60.0 / minute:.0f}"),
                    ("eight side by side, each", "0.15", f"{lanes:.3f}", "", f"{60.0 / lanes:.0f}"),
                ]
            ),
            "",
            f"A minute of a whole run, program in its box, jaws that press with {pressed:.0f} N:",
            aligned(
                [
                    ("CPU s", "goal", "ours", "times real time"),
                    *(
                        (what, f"{goal:.1f}", f"{used:.3f}", f"{60.0 / used:.0f}")
                        for what, goal, used, _pressed in minutes
                    ),
                ]
            ),
            "",
            "With the inertia of the jaws' motors, as the joints feel it behind their gears:",
            iterations_table(),
        ]
    )
