"""PyBullet, which knows nothing of water, agrees in vacuum."""

from pathlib import Path

import numpy as np
import pybullet
import pytest

from seamark.sim.multibody import tree
from seamark.sim.multibody.mechanism import Link, Mechanism, state_for, work_for
from seamark.sim.vehicles import STANDARD_GRAVITY
from tests.sim.multibody.scenes import about

MASSES, INERTIAS = (2.0, 1.0, 0.5), ((0.02, 0.03, 0.04), (0.01, 0.02, 0.015), (0.004, 0.005, 0.003))
AXES = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
OFFSETS = ((0.0, 0.0, 0.1), (0.3, 0.0, 0.05), (0.25, -0.1, 0.0))
CENTRES = ((0.1, 0.02, 0.0), (0.12, 0.0, -0.03), (0.05, 0.01, 0.02))


def numbers(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))


def urdf() -> str:
    """Three links on a base that does not move."""
    parts = ['<robot name="chain"><link name="l0"/>']
    for k in range(3):
        ixx, iyy, izz = INERTIAS[k]
        parts.append(
            f'<link name="l{k + 1}"><inertial><origin xyz="{numbers(CENTRES[k])}"/>'
            f'<mass value="{MASSES[k]}"/><inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" '
            'ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="{numbers(OFFSETS[k])}"/><axis xyz="{numbers(AXES[k])}"/></joint>'
        )
    return "".join([*parts, "</robot>"])


def chain() -> Mechanism:
    return Mechanism(
        links=[
            Link(
                name=f"l{k + 1}",
                parent=f"l{k}" if k else None,
                joint="revolute",
                offset=OFFSETS[k],
                axis=AXES[k],
                rigid=about(MASSES[k], np.diag(INERTIAS[k]), CENTRES[k]),
                net_weight=MASSES[k] * STANDARD_GRAVITY,
                moment=tuple(MASSES[k] * STANDARD_GRAVITY * c for c in CENTRES[k]),  # type: ignore[arg-type]
            )
            for k in range(3)
        ]
    )


def test_torques_of_a_chain_in_vacuum_are_pybullets(tmp_path: Path) -> None:
    file = tmp_path / "chain.urdf"
    file.write_text(urdf())
    world = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, STANDARD_GRAVITY, physicsClientId=world)  # z is down
    body = pybullet.loadURDF(
        str(file),
        useFixedBase=True,
        flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
        physicsClientId=world,
    )
    model = chain().model(0.002)
    state, work = state_for(model), work_for(model)
    source = np.random.Generator(np.random.PCG64(3))

    for _ in range(20):
        q, v, rate = source.standard_normal((3, 3))
        state.q[:], state.v[:] = q, v
        tree.place(model.structure, model.links, state.q, work.frames)
        tree.write_bias(model.structure, model.links, state.v, np.zeros(6), work.frames)
        tree.write_mass(model.structure, model.links, work.frames)
        lower = np.tril(work.frames.factor)
        mass = lower + np.tril(lower, -1).T

        theirs = pybullet.calculateInverseDynamics(
            body, q.tolist(), v.tolist(), rate.tolist(), physicsClientId=world
        )

        assert mass @ rate + work.frames.bias == pytest.approx(theirs, rel=1e-9, abs=1e-9)
    pybullet.disconnect(world)
