"""Contacts: what is pressed is felt, what is hit takes momentum, what is far costs nothing."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.multibody.hull import Hull
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.bullet import BulletEngine
from seamark.sim.physics.contact import Contact, MakeEngine, TargetBox, lowest_point
from seamark.sim.physics.current import Current
from seamark.sim.physics.hydrodynamics import write_rotation
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import Bottom
from seamark.sim.vehicles import Quantity, Vehicle, load
from tests.services.prepared import printed, run
from tests.sim.oldest_processor import printed_here

SEABED_Z = 4.785
FLAT = Bottom(SEABED_Z)
BOX = TargetBox(centre=(0.0, 0.0, SEABED_Z - 0.065))


def quantity(*value: float) -> Quantity:
    return Quantity(meaning="test", value=value, unit="", tag="E", source="test")


def frictionless(vehicle: Vehicle) -> Vehicle:
    """A vehicle without drag and without net weight: nothing but contacts change its momentum."""
    none = (quantity(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),)
    return replace(vehicle, drag_linear=none, drag_quadratic=none, buoyancy=vehicle.weight)


def momentum(plant: Plant) -> Array:
    """The momentum of vehicle and moved water, (3,) NED."""
    mass = plant.vehicle.mass_rigid() + plant.vehicle.mass_added()
    rotation = np.empty((3, 3))
    write_rotation(*plant.state[3:7], rotation)
    return rotation @ (mass @ plant.state[7:13])[:3]


class Listening(Contact):
    """A contact that remembers what it gave."""

    def __init__(
        self,
        vehicle: Vehicle,
        bottom: Bottom,
        *,
        engine: MakeEngine,
        box: TargetBox | None = None,
    ) -> None:
        super().__init__(vehicle, bottom, box=box, engine=engine)
        self.pushes: list[Array] = []

    def impulse(self, before: Array, after: Array, step_s: float) -> Array:
        push = super().impulse(before, after, step_s)
        self.pushes.append(push)
        return push


@pytest.fixture(params=[Hull, BulletEngine])
def engine(request: pytest.FixtureRequest) -> MakeEngine:
    """Each of the engines: what contacts are does not depend on it."""
    made: MakeEngine = request.param
    return made


@pytest.fixture
def heavy() -> Vehicle:
    """A vehicle that presses on the bottom with 50 N."""
    vehicle = load("girona500")
    return replace(vehicle, buoyancy=quantity(vehicle.weight.scalar - 50.0))


@pytest.fixture
def bottom(heavy: Vehicle, engine: MakeEngine) -> Iterator[Listening]:
    contact = Listening(heavy, FLAT, engine=engine)
    yield contact
    contact.close()


@pytest.mark.slow
def test_a_steady_force_of_fifty_newtons_reads_fifty_newtons(
    heavy: Vehicle, bottom: Listening
) -> None:
    plant = Plant(heavy, Current(0.0), contact=bottom)
    plant.reset(np.array([0.0, 0.0, SEABED_Z - 0.53, 0.0, 0.0, 0.0]))

    plant.advance(0, np.zeros(5), 2000)

    reading = -np.mean([push[2] for push in bottom.pushes[-500:]]) / plant.step_s
    assert reading == pytest.approx(50.0, rel=0.01)
    plant.advance(2000, np.zeros(5), 5)
    assert plant.contact_force() == pytest.approx(50.0, rel=0.01)
    assert plant.pose()[2] == pytest.approx(SEABED_Z - 0.514, abs=0.01)


def test_a_collision_conserves_momentum(engine: MakeEngine) -> None:
    vehicle = frictionless(load("girona500"))
    size = (0.42, 0.13, 0.13)
    floating = TargetBox(centre=(1.5, 0.0, 2.0), size=size, mass=1000.0 * size[0] * size[1] ** 2)
    contact = Contact(vehicle, Bottom(100.0), box=floating, engine=engine)
    plant = Plant(vehicle, Current(0.0), contact=contact)
    plant.reset(np.array([0.0, 0.0, 2.0 - 0.361, 0.0, 0.0, 0.0]))
    plant.state[7] = 0.4
    before = momentum(plant)

    plant.advance(0, np.zeros(5), 300)
    first, _turn = contact.box_pose()
    plant.advance(300, np.zeros(5), 1)
    second, _turn = contact.box_pose()
    contact.close()

    given = floating.mass * (second - first) / plant.step_s
    assert given[0] > 1.0
    assert momentum(plant) + given == pytest.approx(before, abs=0.01 * before[0])


def test_a_pushed_box_comes_to_rest_on_the_bottom(engine: MakeEngine) -> None:
    vehicle = load("girona500")
    contact = Contact(vehicle, FLAT, box=BOX, engine=engine)
    plant = Plant(vehicle, Current(0.0), contact=contact)
    plant.reset(np.array([-1.1, 0.0, SEABED_Z - 0.55, 0.0, 0.0, 0.0]))
    plant.state[7] = 0.5

    plant.advance(0, np.array([0.0, 0.0, 0.1, 0.1, 0.0]), 1000)
    place, _turn = contact.box_pose()
    asleep = not contact.awake
    contact.close()

    assert place[0] > 0.02
    assert place[2] == pytest.approx(BOX.centre[2], abs=0.01)
    assert asleep


def test_a_vehicle_that_lands_on_a_fixed_box_rests_on_it_and_the_box_stays(
    heavy: Vehicle, engine: MakeEngine
) -> None:
    box = replace(BOX, fixed=True)
    contact = Listening(heavy, FLAT, box=box, engine=engine)
    plant = Plant(heavy, Current(0.0), contact=contact)
    plant.reset(np.array([0.049, 0.0, SEABED_Z - 0.13 - 0.53, 0.0, 0.0, 0.0]))

    plant.advance(0, np.zeros(5), 1500)
    place, _turn = contact.box_pose()
    contact.close()

    assert plant.pose()[2] == pytest.approx(SEABED_Z - 0.13 - 0.514, abs=0.01)
    assert plant.contact_force() == pytest.approx(50.0, rel=0.02)
    assert place == pytest.approx(box.centre)
    assert not contact.awake


def test_a_fixed_box_stops_a_vehicle_that_hits_it(engine: MakeEngine) -> None:
    vehicle = load("girona500")
    contact = Contact(vehicle, FLAT, box=replace(BOX, fixed=True), engine=engine)
    plant = Plant(vehicle, Current(0.0), contact=contact)
    plant.reset(np.array([-1.2, 0.0, SEABED_Z - 0.56, 0.0, 0.0, 0.0]))
    plant.state[7] = 0.5

    plant.advance(0, np.zeros(5), 300)
    contact.close()

    bow = plant.pose()[0] - 0.049 + 0.5 * 1.507
    assert bow == pytest.approx(BOX.centre[0] - 0.5 * BOX.size[0], abs=0.25)
    assert plant.velocity()[0] < 0.1


def test_contact_runs_repeat_to_the_last_bit(heavy: Vehicle, engine: MakeEngine) -> None:
    states = []
    for _ in range(2):
        contact = Contact(heavy, FLAT, box=BOX, engine=engine)
        plant = Plant(heavy, Current(0.2), contact=contact)
        plant.reset(np.array([0.1, 0.05, SEABED_Z - 0.9, 0.0, 0.0, 0.3]))
        plant.advance(0, np.zeros(5), 600)
        states.append(plant.state.tobytes())
        contact.close()

    assert states[0] == states[1]


CONTACT_RUN = """
import hashlib
import numpy as np
from seamark.sim.engine.program import BuiltIn
from seamark.sim.registry import benchmark
from seamark.sim.recording.telemetry import INDEX
from seamark.sim.engine.trial import run_trial

class Dive:
    def reset(self, level): pass
    def step(self, values): return 0.0, 0.0, 1.0, 0.1

rows = []
config = benchmark("currents-v1").read({"levels": 0.3, "level_duration_s": 12.0, "settle_s": 1.0,
                                        "tracker": "truth"})
result = run_trial("currents-v1", config, Dive(), seed=3, trial=0, on_rows=rows.append)
print(result.digest, np.count_nonzero(np.concatenate(rows)[:, INDEX["contact_n"]]))
"""


@pytest.mark.slow
def test_a_run_that_ends_on_the_target_is_the_same_in_two_processes() -> None:
    here = printed_here(CONTACT_RUN)

    assert here == printed(CONTACT_RUN)
    assert int(here.split()[1]) > 20


def test_a_run_without_contact_is_the_same_with_contacts_enabled(engine: MakeEngine) -> None:
    vehicle = load("girona500")
    runs = []
    for contact in (None, Contact(vehicle, FLAT, box=BOX, engine=engine)):
        plant = Plant(vehicle, Current(0.3), contact=contact)
        plant.reset(np.array([0.0, 0.0, 1.5, 0.0, 0.0, 0.0]))
        plant.advance(0, np.full(5, 0.2), 200)
        runs.append(plant.state.tobytes())

    assert runs[0] == runs[1]


@given(
    angles=st.tuples(*[st.floats(-3.1, 3.1)] * 3),
    sizes=st.tuples(*[st.floats(0.1, 1.0)] * 3),
    centre=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
)
def test_the_lowest_point_is_that_of_the_lowest_corner(
    angles: tuple[float, ...], sizes: tuple[float, ...], centre: tuple[float, ...]
) -> None:
    plant = Plant(load("girona500"), Current(0.0))
    plant.reset(np.array([1.0, 2.0, 3.0, angles[0], 0.4 * angles[1], angles[2]]))
    rotation = np.empty((3, 3))
    write_rotation(*plant.state[3:7], rotation)
    corners = [
        np.array(centre) + 0.5 * np.array(sizes) * signs for signs in product((-1, 1), repeat=3)
    ]

    lowest = lowest_point(plant.state, np.array([centre]), 0.5 * np.array([sizes]))

    assert lowest == pytest.approx(max(3.0 + rotation[2] @ corner for corner in corners))


ENGINES = """
import sys
import numpy as np
from seamark.sim.engine.trial import run_trial
from seamark.sim.registry import benchmark

class Dive:
    def reset(self, level): pass
    def step(self, values): return 0.0, 0.0, 1.0, 0.0

for contacts in ("seamark", "pybullet"):
    config = benchmark("currents-v1").read({"levels": 0.3, "level_duration_s": 12.0,
                                            "settle_s": 1.0, "tracker": "truth",
                                            "contacts": contacts})
    result = run_trial("currents-v1", config, Dive(), seed=3, trial=0, on_rows=lambda rows: None)
    print("pybullet" in sys.modules, config.exact())
"""


@pytest.mark.slow
def test_bullet_is_loaded_only_where_it_is_chosen_and_prints_nothing() -> None:
    done = run(ENGINES)

    assert done.stdout.splitlines() == ["False True", "True False"]
    assert (done.returncode, done.stderr) == (0, "")
