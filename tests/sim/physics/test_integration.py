"""The integration: its order, an independent reference, and the same bits everywhere."""

import hashlib
from typing import Any

import numpy as np
import pytest

from performance.simulator.validation.reference import Leg, Water, reference
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import Current, Pattern, Shear
from seamark.sim.physics.dynamics import Span, integrate, integration_buffers
from seamark.sim.physics.plant import Plant
from seamark.sim.vehicles import load
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

COMMAND = np.array([0.45, 0.30, 0.20, -0.15, 0.35])
START = np.array([0.0, 0.0, 2.0, 0.15, -0.1, 0.4])
NAMES = ["girona500", "girona500-uwsim"]


def end_state(step_s: float, seconds: float, current: Current) -> Array:
    plant = Plant(load("girona500"), current, step_s=step_s)
    plant.reset(START)
    plant.advance(0, COMMAND, round(seconds / step_s))
    return plant.state


@pytest.mark.parametrize("gusty", [False, True])
def test_halving_the_step_divides_the_error_by_sixteen(gusty: bool) -> None:
    rng = streams(1, 0, 0).gust if gusty else None
    current = Current(0.3, pattern=Pattern(azimuth_rad=0.5), rng=rng)
    exact = end_state(0.0015625, 5.0, current)

    errors = [np.abs(end_state(h, 5.0, current) - exact).max() for h in (0.05, 0.025, 0.0125)]

    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.35)


def test_the_working_step_is_exact_to_a_micrometre() -> None:
    current = Current(0.3, rng=streams(1, 0, 0).gust)

    coarse, fine = end_state(0.01, 60.0, current), end_state(0.001, 60.0, current)

    assert np.abs(coarse - fine)[:3].max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("law", ["relative", "force"])
@pytest.mark.parametrize("name", NAMES)
def test_the_plant_agrees_with_an_independent_reference(name: str, law: str) -> None:
    pattern = Pattern(azimuth_rad=0.5, law="force" if law == "force" else "relative")
    plant = Plant(load(name), Current(0.4, pattern=pattern))
    plant.reset(START)

    plant.advance(0, COMMAND, 2000)
    water = Water(level=0.4, azimuth=0.5, force=law == "force")
    expected = reference(load(name), START, [Leg(20.0, COMMAND)], water)

    assert plant.pose() == pytest.approx(expected[:6], abs=2e-7)
    assert plant.velocity() == pytest.approx(expected[6:12], abs=2e-7)
    assert plant.thrust() == pytest.approx(expected[12:], abs=1e-6)


@pytest.mark.parametrize("name", [*NAMES, "bluerov2-heavy"])
def test_in_a_sheared_current_too_the_plant_agrees_with_the_reference(name: str) -> None:
    vehicle = load(name)
    shear = Shear(exponent=0.5, bottom_m=5.0, height_m=2.0)
    plant = Plant(vehicle, Current(0.4, pattern=Pattern(azimuth_rad=0.5), shear=shear))
    plant.reset(START)
    command = np.resize(COMMAND, len(vehicle.thrusters))

    plant.advance(0, command, 300)
    water = Water(level=0.4, azimuth=0.5, force=False, exponent=0.5, bottom=5.0, height=2.0)
    expected = reference(vehicle, START, [Leg(3.0, command)], water)

    assert abs(plant.pose()[2] - START[2]) > 0.02
    assert plant.pose() == pytest.approx(expected[:6], abs=2e-7)
    assert plant.velocity() == pytest.approx(expected[6:12], abs=2e-7)


def test_many_short_calls_give_the_bits_of_one_long_call() -> None:
    states = []
    for chunk in (1, 5, 300):
        plant = Plant(load("girona500"), Current(0.3, rng=streams(4, 0, 0).gust))
        plant.reset(START)
        for step in range(0, 300, chunk):
            plant.advance(step, COMMAND, chunk)
        states.append(plant.state.tobytes())

    assert len(set(states)) == 1


RUN = """
import hashlib
import numpy as np
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant
from seamark.sim.sensors.dvl import Dvl
from tests.sim.sampling import Truth, sample
from seamark.sim.numerics.random_streams import streams
from seamark.sim.vehicles import load

digest = hashlib.sha256()
source = streams(11, 2, 3)
plant = Plant(load("girona500"), Current(0.3, rng=source.gust))
plant.reset(np.array([0.0, 0.0, 2.0, 0.15, -0.1, 0.4]))
dvl = Dvl(source.dvl)
for step in range(0, 3000, 5):
    truth = Truth(plant.pose(), plant.velocity(), 2.5)
    values, valid = sample(dvl, step, truth)
    command = np.array([-values[0], -values[0], 0.1, 0.12, -3.0 * values[1]])
    plant.advance(step, command, 5)
    digest.update(plant.state.tobytes() + np.array(values).tobytes())
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_another_process_on_another_processor_gives_the_same_bytes() -> None:
    here = printed_here(RUN)

    assert here == printed(RUN, on="oldest")
    assert len(here.strip()) == len(hashlib.sha256().hexdigest())


@pytest.mark.slow
def test_the_machine_code_has_no_fused_operations() -> None:
    plant = Plant(load("girona500"), Current(0.1))
    plant.reset(START)

    span, work = Span(0, 1, 0.01, np.inf), integration_buffers(len(plant.state))
    target = np.zeros(len(plant.vehicle.thrusters))
    integrate(plant.state, target, span, plant.body, plant.water, work)
    assembly = "".join(map(_assembly, integrate.overloads.values()))

    assert "mulsd" in assembly
    assert "fmadd" not in assembly
    assert "fmsub" not in assembly
    assert "fnmadd" not in assembly


def _assembly(compiled: Any) -> str:
    """What `inspect_asm` returns, which Numba refuses for code from its cache."""
    library = compiled.library
    return str(library.codegen._tm.emit_assembly(library._get_module_for_linking()))
