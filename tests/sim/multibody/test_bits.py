"""The same bits in every process and on every processor, with joints and contacts."""

import pytest

from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

SCENES = """
import hashlib
import numpy as np
from seamark.sim.multibody.mechanism import command_for, state_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import advance
from seamark.sim.physics.current import Current
from tests.sim.multibody.scenes import GROUND, STEP_S, vehicle_with_arm

digest, touched = hashlib.sha256(), 0
for depth in (5.0, 9.7):
    model = vehicle_with_arm(valve_torque=2.0).model(STEP_S)
    state, work, command = state_for(model), work_for(model), command_for(model)
    state.q[0], state.q[2] = 0.03, depth
    command.speed[:], command.thrust[:] = (0.05, 0.1, -0.1, 0.4, 0.3), 2.0
    water = Current(0.1, rng=np.random.Generator(np.random.PCG64(1)), duration_s=5.0).water
    for first in range(0, 2000, 100):
        advance((first, 100), Timing(STEP_S, 10), model, state, command, water, GROUND, work)
        touched += np.count_nonzero(state.impulses.contact[:, 0])
        for part in (*state[:3], *state.impulses):
            digest.update(part.tobytes())
print(digest.hexdigest(), touched)
"""


MODELS = """
import hashlib
import numpy as np
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.registry import ARMS, THINGS
from seamark.sim.vehicles import Quantity, load
from seamark.sim.vehicles.model import Place
from seamark.sim.vehicles.linkage_reading import load_linkage

point, turn = (
    Quantity(meaning="", value=value, unit=unit, tag="E", source="a test")
    for value, unit in (((0.2, 0.1, 0.3), "m"), ((0.3, -0.7, 1.9), "rad"))
)
place, digest = Place(point=point, turn=turn), hashlib.sha256()
for name in (*ARMS, *THINGS):
    mounting = Mounting(linkage=load_linkage(name), place=place, on_vehicle=name in ARMS)
    assembly = assemble(load("girona500"), [mounting])
    model = assembly.mechanism.model(0.002)
    for part in (*model.links, *model.shapes, *model.rows, assembly.state(model).q):
        digest.update(np.ascontiguousarray(part).tobytes())
print(digest.hexdigest(), len(ARMS) + len(THINGS))
"""


@pytest.mark.slow
def test_contact_has_the_same_bits_in_two_processes_and_on_the_oldest_processor() -> None:
    here = printed_here(SCENES)

    assert here == printed(SCENES, on="oldest")
    assert int(here.split()[1]) > 20


@pytest.mark.slow
def test_arms_and_things_are_the_same_mechanisms_on_the_oldest_processor() -> None:
    here = printed_here(MODELS)

    assert here == printed(MODELS, on="oldest")
    assert int(here.split()[1]) >= 8
