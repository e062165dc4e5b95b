"""What joints transmit agrees with what motors, friction, water and contacts give."""

import numpy as np
import pytest

from seamark.sim.multibody.loads import write_loads, write_pair_forces
from seamark.sim.multibody.mechanism import command_for, state_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import advance
from seamark.sim.physics.current import Current
from tests.sim.multibody.scenes import GROUND, STEP_S, vehicle_with_arm

TIMING = Timing(STEP_S, 10)


@pytest.mark.slow
def test_joints_transmit_what_their_rows_give_and_nothing_is_left_over_at_the_vehicle() -> None:
    mechanism = vehicle_with_arm()
    model = mechanism.model(STEP_S)
    state, work, command = state_for(model), work_for(model), command_for(model)
    current = Current(0.2, rng=np.random.Generator(np.random.PCG64(1)), duration_s=10.0)
    state.q[2] = GROUND.depth - 0.35
    state.v[:] = 0.2
    command.speed[:], command.thrust[:] = (0.1, 0.2, -0.1, 0.1, -0.2), 3.0
    loads = np.empty((len(mechanism.links), 6))
    speed, rows, touched = model.structure.speed, model.rows, 0

    for step in range(0, 1000, 50):
        advance((step, 50), TIMING, model, state, command, current.water, GROUND, work)
        write_loads(TIMING, model, state, work, loads)

        assert np.abs(loads[0]).max() < 1e-10
        for link in range(1, len(mechanism.links)):
            given = -model.links.rotor[link] * work.acceleration[speed[link]]
            for row, place in enumerate(rows.place):
                own = rows.speed[place] == speed[link]
                tied = rows.other[place] == speed[link]
                share = 1.0 if own else -rows.ratio[place] if tied else 0.0
                given += share * state.impulses.joint[row] / STEP_S
            assert model.links.axis[link] @ loads[link, 3:] == pytest.approx(given, abs=1e-10)
        touched += np.count_nonzero(state.impulses.contact[:, 0])
    assert touched > 10


def test_loads_of_the_outer_links_alone_are_those_among_all() -> None:
    mechanism = vehicle_with_arm()
    model, first = mechanism.model(STEP_S), 3
    state, work, command = state_for(model), work_for(model), command_for(model)
    state.q[2], command.speed[:] = GROUND.depth - 0.35, 0.1
    advance((0, 1000), TIMING, model, state, command, Current(0.2).water, GROUND, work)
    every, outer = np.full((2, len(mechanism.links), 6), np.nan)

    write_loads(TIMING, model, state, work, every)
    write_loads(TIMING, model, state, work, outer, first)

    assert np.count_nonzero(state.impulses.contact[:, 0]) > 0
    assert outer[first:].tobytes() == every[first:].tobytes()
    assert np.isnan(outer[:first]).all()


def test_the_bottom_carries_the_weight_of_what_lies_on_it() -> None:
    mechanism = vehicle_with_arm()
    mechanism.links[0].net_weight = 50.0
    model = mechanism.model(STEP_S)
    state, work, command = state_for(model), work_for(model), command_for(model)
    state.q[2] = GROUND.depth - 0.3
    still = Current(0.0).water

    advance((0, 10_000), TIMING, model, state, command, still, GROUND, work)
    forces = np.empty(len(mechanism.pairs))
    write_pair_forces(TIMING, model, state, work, forces)

    weight = sum(link.net_weight for link in mechanism.links)
    below = [k for k, pair in enumerate(mechanism.pairs) if "ground" in pair]
    assert forces[below].sum() == pytest.approx(weight, rel=1e-6)
