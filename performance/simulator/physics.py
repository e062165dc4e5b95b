"""One integration step of the vehicle compared with one step of Bullet and of MuJoCo.

Both compute less: Bullet's mass is a scalar, and MuJoCo's ellipsoid fluid model has no added mass
that responds to acceleration. MuJoCo is in the dependency group `performance`.
"""

import mujoco
import numpy as np
import pybullet

from performance.tables import Row, cpu_us
from seamark.sim import vehicles
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant

_STEPS = 1000
_MUJOCO_INTEGRATORS = ("Euler", "implicitfast", "RK4")
MUJOCO_MODEL = """
<mujoco>
  <option timestep="0.01" density="1025" viscosity="0.0009" wind="0.2 0 0" integrator="{}"/>
  <worldbody>
    <geom type="plane" size="50 50 1"/>
    <body pos="0 0 5">
      <freejoint/>
      <geom type="box" size="0.7 0.5 0.5" mass="143" fluidshape="ellipsoid"/>
    </body>
  </worldbody>
</mujoco>
"""


def rows() -> list[Row]:
    """Measure and return the rows."""
    plant = Plant(vehicles.load("girona500"), Current(0.2))
    plant.reset(np.zeros(6))
    command = np.full(len(plant.thrust()), 0.2)
    ours = cpu_us(lambda: plant.advance(0, command, _STEPS)) / _STEPS
    baselines = {"PyBullet stepSimulation, free body over a plane": _bullet_step_us()} | {
        f"MuJoCo {name}, free body in a fluid over a plane": _mujoco_step_us(name)
        for name in _MUJOCO_INTEGRATORS
    }
    return [
        Row(
            what="RK4 step, 6x6 mass matrix, current",
            value=ours,
            unit="us CPU",
            baseline=name,
            baseline_value=value,
        )
        for name, value in baselines.items()
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


def _mujoco_step_us(integrator: str) -> float:
    model = mujoco.MjModel.from_xml_string(MUJOCO_MODEL.format(integrator))
    data = mujoco.MjData(model)
    return cpu_us(lambda: mujoco.mj_step(model, data), inner=_STEPS)
