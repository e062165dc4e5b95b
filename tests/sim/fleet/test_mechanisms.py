"""Vehicles with arms that move side by side have the bits of those that move alone."""

from collections.abc import Callable

import numpy as np
import pytest

from seamark.sim.fleet.mechanisms import Mechanisms
from seamark.sim.multibody.mechanism import command_for, state_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import State, advance
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import Current, Pattern, Shear
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.tabulation import Motion, Site, current_of
from seamark.sim.physics.water_motion.waves import Waves
from tests.sim.multibody.scenes import GROUND, STEP_S, vehicle_with_arm

COUNT, STEPS = 10, 600
TIMING = Timing(STEP_S, 10)


def current(i: int) -> Current:
    return Current(
        0.1 + 0.02 * i,
        shear=Shear(exponent=1.0 / 7.0, bottom_m=GROUND.depth, height_m=3.0),
        rng=np.random.Generator(np.random.PCG64(i)),
        duration_s=5.0,
    )


def tabulated(i: int) -> Current:
    site = Site(
        bottom_m=GROUND.depth, start_m=GROUND.depth - 3.0, azimuth_rad=float(i), duration_s=5.0
    )
    motion = Motion(place=PLACES["ria"], waves=Waves(0.5, 4.0))
    return current_of(0.1 + 0.02 * i, motion, site, streams(i, 0, 0))


def contents(state: State) -> list[bytes]:
    return [
        *(part.tobytes() for part in state[:3]),
        *(part.tobytes() for part in state.impulses),
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("threads", "water_of"), [(1, current), (2, current), (2, tabulated)])
def test_mechanisms_that_touch_different_things_have_the_bits_of_single_ones(
    threads: int, water_of: Callable[[int], Current]
) -> None:
    rng = np.random.Generator(np.random.PCG64(7))
    models, states, touching = [], [], set()
    for i in range(COUNT):
        mechanism = vehicle_with_arm(valve_torque=1.0 + 0.2 * i)
        mechanism.links[0].rigid = mechanism.links[0].rigid * (1.0 + 0.01 * i)
        models.append(mechanism.model(STEP_S))
        state = state_for(models[-1])
        state.q[0:2] = 0.02 * rng.standard_normal(2)
        state.q[2] = GROUND.depth - (0.3 if i % 4 == 1 else 5.0)
        state.v[:] = 0.1 * rng.standard_normal(state.v.size)
        states.append(state)
    currents = [water_of(i) for i in range(COUNT)]
    thrust, speed = 5.0 * rng.standard_normal((COUNT, 8)), 0.3 * rng.standard_normal((COUNT, 5))
    fleet = Mechanisms(models, currents, GROUND, TIMING, threads=threads)
    for i, state in enumerate(states):
        fleet.place(i, state, step=i)

    fleet.advance(STEPS, thrust, speed)
    fleet.close()

    work, command, together = work_for(models[0]), command_for(models[0]), state_for(models[0])
    for i, state in enumerate(states):
        command.thrust[:], command.speed[:] = thrust[i], speed[i]
        water = currents[i].water
        advance((i, STEPS), TIMING, models[i], state, command, water, GROUND, work)
        fleet.read(i, together)
        assert contents(together) == contents(state)
        touching.add(np.count_nonzero(state.impulses.contact[:, 0]))
    assert {0} < touching


def test_mechanisms_of_different_structure_or_water_are_refused() -> None:
    one, other = vehicle_with_arm().model(STEP_S), vehicle_with_arm(valve_torque=1.0).model(STEP_S)
    still, force = Current(0.0), Current(0.1, pattern=Pattern(law="force"))

    with pytest.raises(ValueError, match="the same structure"):
        Mechanisms([one, other], [still, still], GROUND, TIMING)
    with pytest.raises(ValueError, match="relative law"):
        Mechanisms([one, one], [still, force], GROUND, TIMING)
    with pytest.raises(ValueError, match="tables alone"):
        Mechanisms([one, one], [still, tabulated(0)], GROUND, TIMING)
