"""One control step of the vector environment beside others that simulate less.

A control step is 0.05 s, five physics steps. In the environments it has everything: current,
sensors, noise, velocity controller, true corners, reward and `info`. The NumPy vectorisation has
the vehicle's rigid-body dynamics alone, MuJoCo a free body in a fluid. Resets are not included: a
level of 60 s has 1200 control steps.
"""

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import gymnasium
import mujoco
import numpy as np

import seamark.gym  # noqa: F401  # registers the environments
from performance.simulator.physics import MUJOCO_MODEL
from performance.tables import markdown_table
from seamark.sim.physics.dynamics import body_parameters
from seamark.sim.vehicles import load

_VEHICLES = 1024
_STEPS, _REPEATS, _PHYSICS_STEPS, _STEP_S = 40, 9, 5, 0.01
_NAME = "seamark/StationKeeping-v3"
_SETTINGS = {"tracker": "truth", "vehicle": "girona500"}
_PER_SECOND = 1e6  # us
_HEAD = (
    "what runs",
    "control steps a second",
    "wall time of a step [µs]",
    "CPU time of a step [µs]",
    "relative",
)


class Cost(NamedTuple):
    """Least time of a vehicle's control step over several repetitions [us]."""

    wall: float
    cpu: float


def table() -> str:
    """Measure and return the table, in Markdown."""
    costs = {
        f"vector environment, {_VEHICLES} vehicles, two threads": _fleet(2),
        f"vector environment, {_VEHICLES} vehicles, one thread": _fleet(1),
        "single environment, true corners": _single(),
        f"plain NumPy, {_VEHICLES} vehicles: rigid-body dynamics alone": _numpy(),
        "MuJoCo `implicitfast`: a free body in a fluid, one by one": _mujoco(),
    }
    return compared(_HEAD, costs)


def compared(head: Sequence[str], costs: Mapping[str, Cost]) -> str:
    """Return the costs as a table, each relative to the first."""
    ours = next(iter(costs.values()))
    rows = (
        (
            name,
            f"{_PER_SECOND / cost.wall:,.0f}",
            f"{cost.wall:.3g}",
            f"{cost.cpu:.3g}",
            f"{cost.wall / ours.wall:.1f}",
        )
        for name, cost in costs.items()
    )
    return markdown_table(head, rows)


def least(call: Callable[[], object], vehicles: int, steps: int = _STEPS) -> Cost:
    """Return the least cost, over several repetitions, of a vehicle's share of a call."""
    call()
    wall, cpu = [], []
    for _ in range(_REPEATS):
        begin, busy = time.perf_counter(), time.process_time()
        for _ in range(steps):
            call()
        wall.append(time.perf_counter() - begin)
        cpu.append(time.process_time() - busy)
    scale = _PER_SECOND / (steps * vehicles)
    return Cost(min(wall) * scale, min(cpu) * scale)


@contextmanager
def own_cores() -> Iterator[None]:
    """Give each thread of the environment a core, where other processes do not move it."""
    cores = sorted(os.sched_getaffinity(0))
    others = [thread for thread in threading.enumerate() if thread.name.startswith("fleet")]
    for core, thread in zip(cores, [threading.main_thread(), *others], strict=False):
        os.sched_setaffinity(thread.native_id or 0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


def _fleet(threads: int) -> Cost:
    env: Any = gymnasium.make_vec(_NAME, num_envs=_VEHICLES, settings=_SETTINGS, threads=threads)
    env.reset(seed=0)
    actions = np.tile([0.1, 0.1, 0.0, 0.1], (_VEHICLES, 1))  # without coming near the bottom
    env.step(actions)  # starts the threads
    try:
        with own_cores():
            return least(lambda: env.step(actions), _VEHICLES)
    finally:
        env.close()


def _single() -> Cost:
    env = gymnasium.make(_NAME, settings=_SETTINGS).unwrapped
    env.reset(seed=0)
    action = np.full(4, 0.1)
    try:
        return least(lambda: env.step(action), 1, steps=100)
    finally:
        env.close()


def _mujoco() -> Cost:
    model = mujoco.MjModel.from_xml_string(MUJOCO_MODEL.format("implicitfast"))
    data = mujoco.MjData(model)
    return least(lambda: mujoco.mj_step(model, data, _PHYSICS_STEPS), 1, steps=1000)


def _numpy() -> Cost:
    """Return the cost of RK4 over the columns of arrays (n, 6): one vehicle each."""
    body = body_parameters(load("girona500"))
    velocity = np.zeros((_VEHICLES, 6))
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (_VEHICLES, 1))
    force = np.full((_VEHICLES, len(body.allocation[0])), 1.0)

    def rates(v: Any, q: Any) -> tuple[Any, Any]:
        momentum = v @ body.mass.T
        wrench = force @ body.allocation.T
        wrench[:, :3] -= np.cross(v[:, 3:], momentum[:, :3])
        wrench[:, 3:] -= np.cross(v[:, 3:], momentum[:, 3:]) + np.cross(v[:, :3], momentum[:, :3])
        wrench -= (body.linear + body.quadratic * np.abs(v)) * v
        w, x, y, z = q.T
        down = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)
        wrench[:, :3] += body.net_weight * down
        wrench[:, 3:] += np.cross(body.moment, down)
        p, r, s = v[:, 3], v[:, 4], v[:, 5]
        turned = (
            *(-x * p - y * r - z * s, w * p + y * s - z * r),
            *(w * r + z * p - x * s, w * s + x * r - y * p),
        )
        return wrench @ body.inverse_mass.T, 0.5 * np.stack(turned, axis=1)

    def step() -> None:
        v, q, h = velocity, attitude, _STEP_S
        for _ in range(_PHYSICS_STEPS):
            a1, b1 = rates(v, q)
            a2, b2 = rates(v + 0.5 * h * a1, q + 0.5 * h * b1)
            a3, b3 = rates(v + 0.5 * h * a2, q + 0.5 * h * b2)
            a4, b4 = rates(v + h * a3, q + h * b3)
            v = v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            q = q + h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
            q = q / np.linalg.norm(q, axis=1, keepdims=True)

    return least(step, _VEHICLES, steps=2)
