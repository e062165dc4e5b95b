"""One control step of the vector environment beside others that simulate less.

All rows are wall time per vehicle and control step (0.05 s, five physics steps), with everything
that a step has: current, sensors, noise, velocity controller, true corners, reward and `info`. The
NumPy vectorisation has the vehicle's rigid-body dynamics alone, MuJoCo a free body in a fluid.
"""

import time
from collections.abc import Callable
from typing import Any

import gymnasium
import mujoco
import numpy as np

import seamark.gym  # noqa: F401  # registers the environments
from performance.physics import MUJOCO_MODEL
from performance.table import Row
from seamark.sim.physics.dynamics import body_parameters
from seamark.sim.vehicles import load

_VEHICLES = 2048
_STEPS, _REPEATS, _PHYSICS_STEPS, _STEP_S = 20, 5, 5, 0.01
_NAME = "seamark/StationKeeping-v2"
_SETTINGS = {"tracker": "truth", "vehicle": "girona500"}
_PER_SECOND = 1e6  # us


def rows() -> list[Row]:
    """Measure and return the rows."""
    fleet = {threads: _fleet_us(threads) for threads in (1, 2)}
    peers = {
        "the vector environment, one thread": fleet[1],
        "the single environment, true corners": _single_us(),
        "plain NumPy, rigid-body dynamics alone": _numpy_us(),
        "MuJoCo implicitfast, free body in a fluid, one by one": _mujoco_us(),
    }
    measured = [
        Row(
            what=f"vector environment, {_VEHICLES} vehicles, two threads",
            value=fleet[2],
            unit="us wall per vehicle",
            baseline=name,
            baseline_value=value,
        )
        for name, value in peers.items()
    ]
    per_second = Row(
        what="the same", value=1e-3 * _PER_SECOND / fleet[2], unit="thousand control steps/s"
    )
    return [*measured, per_second]


def _least_us(call: Callable[[], object], vehicles: int, steps: int = _STEPS) -> float:
    """Return the least wall time [us] per vehicle and step of several repetitions."""
    call()
    least = float("inf")
    for _ in range(_REPEATS):
        begin = time.perf_counter()
        for _ in range(steps):
            call()
        least = min(least, time.perf_counter() - begin)
    return least / (steps * vehicles) * _PER_SECOND


def _fleet_us(threads: int) -> float:
    env: Any = gymnasium.make_vec(_NAME, num_envs=_VEHICLES, settings=_SETTINGS, threads=threads)
    env.reset(seed=0)
    actions = np.full((_VEHICLES, 4), 0.1)
    try:
        return _least_us(lambda: env.step(actions), _VEHICLES)
    finally:
        env.close()


def _single_us() -> float:
    env = gymnasium.make(_NAME, settings=_SETTINGS).unwrapped
    env.reset(seed=0)
    action = np.full(4, 0.1)
    try:
        return _least_us(lambda: env.step(action), 1, steps=200)
    finally:
        env.close()


def _mujoco_us() -> float:
    model = mujoco.MjModel.from_xml_string(MUJOCO_MODEL.format("implicitfast"))
    data = mujoco.MjData(model)
    return _least_us(lambda: mujoco.mj_step(model, data, _PHYSICS_STEPS), 1, steps=1000)


def _numpy_us() -> float:
    """Return the time of RK4 over the columns of arrays (n, 6): one vehicle each."""
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

    return _least_us(step, _VEHICLES, steps=2)
