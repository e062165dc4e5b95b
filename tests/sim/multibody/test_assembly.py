"""Vehicles with arms and things from data: they weigh, hang, move and touch as their files say."""

from itertools import product

import numpy as np
import pytest

from seamark.sim.multibody import contacts, tree
from seamark.sim.multibody.assembly import BOTTOM, VEHICLE, Assembly, Mounting, assemble
from seamark.sim.multibody.mechanism import command_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Model, State, advance
from seamark.sim.physics.current import Current
from seamark.sim.physics.terrain import Bottom
from seamark.sim.registry import ARMS, THINGS, VEHICLES
from seamark.sim.vehicles import STANDARD_GRAVITY, Quantity, load
from seamark.sim.vehicles.linkage import TOUCHING
from seamark.sim.vehicles.linkage_reading import load_linkage, read_linkage
from seamark.sim.vehicles.matrices import quaternion_of
from seamark.sim.vehicles.model import Place
from tests.sim.multibody.scenes import STEP_S

TIMING = Timing(STEP_S, 10)
GROUND = Bottom(10.0).ground()
WATER = Current(0.0).water


def place(x: float, y: float, z: float, *turn: float) -> Place:
    point = Quantity(meaning="place", value=(x, y, z), unit="m", tag="E", source="a test")
    angles = turn or (0.0, 0.0, 0.0)
    return Place(
        point=point,
        turn=Quantity(meaning="turn", value=angles, unit="rad", tag="E", source="a test"),
    )


def on_vehicle(name: str, *turn: float) -> Mounting:
    return Mounting(linkage=load_linkage(name), place=place(0.2, 0.0, 0.1, *turn), on_vehicle=True)


def in_world(name: str, x: float, y: float, z: float, *turn: float) -> Mounting:
    return Mounting(linkage=load_linkage(name), place=place(x, y, z, *turn))


def run(model: Model, state: State, seconds: float, speeds: tuple[float, ...] = ()) -> None:
    command, work = command_for(model), work_for(model)
    command.speed[: len(speeds)] = speeds
    advance((0, round(seconds / STEP_S)), TIMING, model, state, command, WATER, GROUND, work)


def total_mass(assembly: Assembly) -> float:
    return sum(float(link.rigid[0, 0]) for link in assembly.mechanism.links)


@pytest.mark.parametrize("name", ARMS)
def test_a_vehicle_with_an_arm_weighs_as_much_as_both(name: str) -> None:
    vehicle, arm = load("girona500"), load_linkage(name)
    volume = sum(link.body.volume.scalar for link in arm.links if link.body)

    assembly = assemble(vehicle, [on_vehicle(name)])

    weight = sum(link.net_weight for link in assembly.mechanism.links)
    own = vehicle.weight.scalar - vehicle.buoyancy.scalar
    assert total_mass(assembly) == pytest.approx(vehicle.mass.scalar + arm.mass())
    assert weight - own == pytest.approx(STANDARD_GRAVITY * (arm.mass() - 1000.0 * volume))
    assert assembly.motors == arm.motors()
    assert all(speed > 0.0 for speed in assembly.fastest)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_an_arm_that_is_told_to_rest_stays_where_it_is(name: str) -> None:
    ahead = Mounting(linkage=load_linkage(name), place=place(1.2, 0.0, 0.4), on_vehicle=True)
    assembly = assemble(load("girona500"), [ahead], bottom=False)
    model = assembly.mechanism.model(STEP_S)
    state = assembly.state(model)
    state.q[2] = 5.0
    for limit in assembly.mechanism.limits:
        state.q[assembly.coordinate(model, limit.link)] = 0.5 * (limit.low + limit.high)
    before = state.q[7:].copy()

    run(model, state, 2.0)

    assert state.q[7:] == pytest.approx(before, abs=1e-3)


MOUNTS = [(name, arm) for name in VEHICLES for arm in load(name).mounts]


@pytest.mark.parametrize(("name", "arm"), MOUNTS)
def test_an_arm_where_a_vehicle_of_ours_carries_it_does_not_start_in_the_hull(
    name: str, arm: str
) -> None:
    vehicle = load(name)
    mounting = Mounting(linkage=load_linkage(arm), place=vehicle.mounts[arm], on_vehicle=True)
    assembly = assemble(vehicle, [mounting], bottom=False)
    mechanism = assembly.mechanism
    hull = [shape.name for shape in mechanism.shapes if shape.link == VEHICLE][: len(vehicle.hull)]
    moving = [shape.name for shape in mechanism.shapes if shape.link != VEHICLE]
    mechanism.pairs = list(product(moving, hull))
    model, state = mechanism.model(STEP_S), assembly.state(mechanism.model(STEP_S))
    work = work_for(model)

    tree.place(model.structure, model.links, state.q, work.frames)
    contacts.place_shapes(model.shapes, work.frames, work.touches)
    contacts.find_touches(model.shapes, GROUND, work.touches)

    assert moving
    assert work.touches.gap.min() > 0.0


def test_a_motor_stops_at_the_end_of_its_range() -> None:
    assembly = assemble(load("girona500"), [on_vehicle("hook")], bottom=False)
    model = assembly.mechanism.model(STEP_S)
    state = assembly.state(model)
    high = next(limit.high for limit in assembly.mechanism.limits if limit.link == "forearm")

    run(model, state, 7.0, (0.0, 0.5))

    assert state.q[assembly.coordinate(model, "forearm")] == pytest.approx(high, abs=1e-3)


def test_jaws_that_follow_open_by_the_same_angle_and_close_on_each_other() -> None:
    assembly = assemble(load("bluerov2-heavy"), [on_vehicle("alpha-like")], bottom=False)
    model = assembly.mechanism.model(STEP_S)
    state = assembly.state(model)
    first, second = (assembly.coordinate(model, f"jaw {side}") for side in ("port", "starboard"))
    state.q[[first, second]] = 0.0

    run(model, state, 1.0, (0.0, 0.0, 0.0, 0.0, 0.4))
    assert state.q[first] == pytest.approx(0.4, abs=0.01)
    assert state.q[second] == pytest.approx(state.q[first], abs=1e-3)

    run(model, state, 2.0, (0.0, 0.0, 0.0, 0.0, -0.4))
    low = next(limit.low for limit in assembly.mechanism.limits if limit.link == "jaw port")
    assert low + 0.01 < state.q[first] < 0.0  # the tips meet before


def test_a_fixed_part_is_as_if_the_vehicle_were_heavier_there() -> None:
    vehicle = load("bluerov2-heavy")
    assembly = assemble(vehicle, [on_vehicle("alpha-like", 0.3, -0.4, 0.5)], bottom=False)
    base = load_linkage("alpha-like").link("base").body
    assert base is not None

    link = assembly.mechanism.links[0]
    more = link.rigid - vehicle.mass_rigid()
    centre = np.array([more[4, 2], more[5, 0], more[3, 1]]) / -base.mass.scalar

    assert link.name == VEHICLE
    assert more[0, 0] == pytest.approx(base.mass.scalar)
    assert np.linalg.norm(centre - [0.2, 0.0, 0.1]) == pytest.approx(0.03)
    inertia = more[3:, 3:] - base.mass.scalar * (
        centre @ centre * np.eye(3) - np.outer(centre, centre)
    )
    assert np.linalg.eigvalsh(inertia) == pytest.approx(sorted(base.inertia.value[:3]))


def test_every_solid_is_drawn_on_a_link_that_moves_or_in_the_world() -> None:
    vehicle, arm, valve = load("bluerov2-heavy"), load_linkage("alpha-like"), load_linkage("valve")
    mountings = [on_vehicle("alpha-like", 0.3, -0.4, 0.5), in_world("valve", 1.0, 2.0, 3.0)]

    assembly = assemble(vehicle, mountings)

    solids = [solid for each in (arm, valve) for link in each.links for solid in link.solids]
    base, panel = arm.link("base").solids[0], valve.link("panel").solids[0]
    on = {look.solid: look.on for look in assembly.looks}
    assert [look.solid for look in assembly.looks] == [*vehicle.drawn(), *solids]
    assert on[arm.link("wrist").solids[0]].link == "wrist"
    assert on[base].link == VEHICLE  # what is fixed is on what carries it
    assert np.linalg.norm(on[base].at(base.centre) - [0.2, 0.0, 0.1]) == pytest.approx(0.03)
    assert on[panel].link is None
    assert on[panel].at(panel.centre).tolist() == pytest.approx([1.12, 2.0, 3.0])


def test_a_thing_starts_where_it_is_put_and_comes_to_rest_on_the_bottom() -> None:
    assembly = assemble(None, [in_world("black-box", 1.0, 2.0, 9.85, 0.0, 0.0, 0.7)])
    model = assembly.mechanism.model(STEP_S)
    state = assembly.state(model)
    assert state.q[:3].tolist() == [1.0, 2.0, 9.85]

    run(model, state, 4.0)
    rest = state.q.copy()
    run(model, state, 2.0)

    assert rest[2] == pytest.approx(9.9, abs=1e-4)
    assert 2.0 * np.arctan2(rest[6], rest[3]) == pytest.approx(0.7, abs=1e-3)
    assert state.q == pytest.approx(rest, abs=1e-6)


def test_a_valve_turns_beyond_its_break_away_torque_only() -> None:
    assembly = assemble(None, [in_world("valve", 0.0, 0.0, 5.0)], bottom=False)
    link = next(link for link in assembly.mechanism.links if link.name == "handle")
    found = []
    for torque in (0.9 * 3.0, 1.1 * 3.0):
        # A weight at the lever's end, which is level at zero.
        link.moment = (0.0, torque, 0.0)
        model = assembly.mechanism.model(STEP_S)
        state = assembly.state(model)
        run(model, state, 1.0)
        found.append(abs(float(state.q[0])))

    assert found[0] < 1e-6
    assert found[1] > 0.1


def test_things_and_arms_that_are_fixed_in_the_world_touch_what_moves() -> None:
    assembly = assemble(
        load("bluerov2-heavy"),
        [
            on_vehicle("alpha-like"),
            in_world("peg", 1.0, 0.0, 5.0),
            in_world("socket", 1.5, 0.0, 5.0),
        ],
    )
    pairs = {frozenset(pair) for pair in assembly.mechanism.pairs}

    assert frozenset({"peg", "hole"}) in pairs
    assert frozenset({"jaw port", "handle"}) in pairs
    assert frozenset({"jaw port", "jaw starboard"}) in pairs
    assert frozenset({"wrist", BOTTOM}) in pairs
    assert frozenset({"wrist", "hole"}) not in pairs  # not a known contact
    assembly.mechanism.model(STEP_S)


def test_every_arm_can_be_assembled_with_every_thing() -> None:
    for arm in ARMS:
        for thing in THINGS:
            mountings = [on_vehicle(arm), Mounting(linkage=load_linkage(thing),
                         place=place(1.0, 0.0, 5.0), prefix="its ")]  # fmt: skip
            assembly = assemble(load("girona500"), mountings)
            assert assembly.mechanism.model(STEP_S).links.mass.shape[1:] == (6, 6)


def test_two_parts_of_one_name_are_refused() -> None:
    assembly = assemble(None, [in_world("peg", 0.0, 0.0, 5.0), in_world("peg", 1.0, 0.0, 5.0)])

    with pytest.raises(ValueError, match="two links have the same name: peg"):
        assembly.mechanism.model(STEP_S)


def test_contacts_that_files_may_name_are_those_of_the_engine() -> None:
    kinds = {value: name for name, value in vars(contacts).items() if name.isupper()
             and isinstance(value, int)}  # fmt: skip
    known = {
        frozenset(kinds[kind].lower() for kind in pair)
        for pair in contacts.SLOTS
        if contacts.GROUND not in pair
    }

    assert known == TOUCHING


@pytest.mark.parametrize(
    "turn", [(0.1, -0.2, 3.0), (3.0, 0.1, 0.0), (0.0, 1.5, 0.2), (0.0, 0.0, 0.0)]
)
def test_a_free_thing_is_turned_as_it_is_placed(turn: tuple[float, float, float]) -> None:
    ((point, matrix),) = assemble(None, [in_world("bar", 0.0, 0.0, 5.0, *turn)]).starts.values()
    w, x, y, z = quaternion_of(matrix)

    assert point.tolist() == [0.0, 0.0, 5.0]
    assert w * w + x * x + y * y + z * z == pytest.approx(1.0)
    # Roll, pitch and yaw of the quaternion.
    assert np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) == pytest.approx(turn[0])
    assert np.arcsin(2 * (w * y - z * x)) == pytest.approx(turn[1])
    assert np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(turn[2])


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.3, 0.5, 1.0), (-1.5, 1.5, 2.0)])
def test_the_larger_arm_ends_where_the_published_chain_does(
    angles: tuple[float, float, float],
) -> None:
    """Denavit and Hartenberg's numbers: a, alpha, d, theta of ARM5Arm.cpp."""
    chain = [
        (0.08052, 0.5 * np.pi, 0.0, 0.0),
        (0.44278, 0.0, 0.0, np.radians(5.0)),
        (-0.083, 0.5 * np.pi, 0.0, np.radians(115.0)),
        (0.0, 0.0, 0.49938, 0.0),
    ]
    published = np.eye(4)
    for (a, alpha, d, theta), angle in zip(chain, (*angles, 0.0), strict=True):
        (s, c), (sa, ca) = ((np.sin(value), np.cos(value)) for value in (theta + angle, alpha))
        published @= [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0.0, sa, ca, d],
            [0.0, 0.0, 0.0, 1.0],
        ]

    assembly = assemble(None, [in_world("arm-5e-like", 0.0, 0.0, 0.0)], bottom=False)
    model = assembly.mechanism.model(STEP_S)
    state, frames = assembly.state(model), work_for(model).frames
    state.q[[assembly.coordinate(model, name) for name in ("slew", "upper arm", "forearm")]] = (
        angles
    )
    tree.place(model.structure, model.links, state.q, frames)
    wrist = assembly.mechanism.number("wrist")
    end = frames.position[wrist] + frames.rotation[wrist] @ [0.49938 - 0.30, 0.0, 0.0]

    assert end == pytest.approx(published[:3, 3], abs=1e-6)
    assert frames.rotation[wrist, :, 0] == pytest.approx(published[:3, 2], abs=1e-6)


def test_the_smaller_arm_reaches_0_41_m() -> None:
    assembly = assemble(None, [in_world("alpha-like", 0.0, 0.0, 0.0)], bottom=False)
    model = assembly.mechanism.model(STEP_S)
    state, frames = assembly.state(model), work_for(model).frames
    state.q[assembly.coordinate(model, "upper arm")] = 1.282  # level
    state.q[assembly.coordinate(model, "forearm")] = 2.674  # in line
    state.q[assembly.coordinate(model, "jaw port")] = 0.0

    tree.place(model.structure, model.links, state.q, frames)
    jaw = assembly.mechanism.number("jaw port")
    tip = frames.position[jaw] + frames.rotation[jaw] @ [0.07, 0.0, 0.0]

    assert tip == pytest.approx([0.409, -0.012, -0.05], abs=1e-6)


def test_a_linkage_of_a_stranger_is_assembled_as_ours_are() -> None:
    text = (
        ARMS["hook"]
        .read_text("utf-8")
        .replace('value = 1.0, unit = "kg"', 'value = 2.0, unit = "kg"')
    )
    mine = Mounting(
        linkage=read_linkage(text.encode()), place=place(0.2, 0.0, 0.1), on_vehicle=True
    )

    assembly = assemble(load("girona500"), [mine])

    assert assembly.mechanism.links[1].rigid[0, 0] == 2.0
