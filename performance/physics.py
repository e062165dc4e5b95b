"""One integration step of the vehicle beside one step of a Bullet world with a free body."""

import numpy as np
import pybullet

from performance.table import Row, cpu_us
from sim import registry
from sim.current import Current
from sim.dynamics import Plant

_STEPS = 1000


def rows() -> list[Row]:
    """Measure and return the rows."""
    plant = Plant(registry.VEHICLES["girona500"].load(), Current(0.2))
    plant.place(np.zeros(6))
    command = np.full(len(plant.thrust()), 0.2)
    ours = cpu_us(lambda: plant.advance(0, command, _STEPS)) / _STEPS
    return [
        Row(
            what="RK4 step, 6x6 mass matrix, current",
            value=ours,
            unit="us CPU",
            peer="PyBullet stepSimulation, free body over a plane",
            peer_value=_bullet_step_us(),
        )
    ]


def _bullet_step_us() -> float:
    world = pybullet.connect(pybullet.DIRECT)
    try:
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=world)
        pybullet.createMultiBody(0.0, plane, physicsClientId=world)
        box = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[0.7, 0.5, 0.5], physicsClientId=world
        )
        pybullet.createMultiBody(143.0, box, basePosition=[0, 0, 5], physicsClientId=world)
        return cpu_us(lambda: pybullet.stepSimulation(physicsClientId=world), inner=_STEPS)
    finally:
        pybullet.disconnect(world)
