"""What rests stays, what is held does not creep, what is pushed hard enough moves."""

from math import pi

import numpy as np
import pytest

from seamark.sim.multibody.loads import write_pair_forces
from seamark.sim.multibody.mechanism import (
    Coupling,
    Friction,
    Limits,
    Link,
    Mechanism,
    Motor,
    Point,
    Shape,
    command_for,
    state_for,
    work_for,
)
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Command, Model, State, Work, advance
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current, Water
from tests.sim.multibody.scenes import ALONG_Y, GROUND, STEP_S, about, vehicle_with_arm

STILL = Current(0.0).water
FRICTION = 0.6
WEIGHT_N = 77.6  # of a black box of 15 kg in water
SIZE = (0.3, 0.2, 0.2)
MINUTE = round(60.0 / STEP_S)


def solid(mass: float, size: Point) -> Array:
    a, b, c = size
    inertia = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * (mass / 12.0)
    return about(mass, inertia, (0.0, 0.0, 0.0))


def half(size: Point) -> Point:
    return 0.5 * size[0], 0.5 * size[1], 0.5 * size[2]


def box(name: str, mass: float, weight: float, size: Point = SIZE) -> tuple[Link, Shape]:
    shape = Shape(name=name, kind="box", link=name, size=half(size), friction=FRICTION)
    return Link(name=name, rigid=solid(mass, size), net_weight=weight), shape


def ground() -> Shape:
    return Shape(name="ground", kind="ground", friction=FRICTION)


class Scene:
    """A mechanism that moves."""

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        iterations: int = 10,
        water: Water = STILL,
        step_s: float = STEP_S,
    ) -> None:
        self.mechanism = mechanism
        self.timing = Timing(step_s, iterations)
        self.model: Model = mechanism.model(step_s)
        self.state: State = state_for(self.model)
        self.work: Work = work_for(self.model)
        self.command: Command = command_for(self.model)
        self.water = water
        self.steps = 0

    def run(self, steps: int) -> None:
        """Move on."""
        span = (self.steps, steps)
        water, work = self.water, self.work
        advance(span, self.timing, self.model, self.state, self.command, water, GROUND, work)
        self.steps += steps

    def pair_forces(self) -> Array:
        """The normal force of each pair now."""
        out = np.empty(len(self.mechanism.pairs))
        write_pair_forces(self.timing, self.model, self.state, self.work, out)
        return out


def box_on_the_bottom(*, push: bool = False) -> Scene:
    link, shape = box("box", 15.0, WEIGHT_N)
    mechanism = Mechanism(links=[link], shapes=[ground(), shape], pairs=[("box", "ground")])
    if push:
        mechanism.allocation = np.array([[1.0], [0.0], [0.0], [0.0], [0.0], [0.0]])
    scene = Scene(mechanism)
    scene.state.q[2] = GROUND.depth - 0.5 * SIZE[2]
    scene.run(500)
    return scene


def test_a_box_at_rest_stays_for_a_minute() -> None:
    scene = box_on_the_bottom()
    place = scene.state.q.copy()

    scene.run(MINUTE)

    assert np.abs(scene.state.q - place).max() < 1e-5


def test_a_push_below_the_friction_limit_moves_nothing_and_one_above_it_moves_as_it_should() -> (
    None
):
    below, above = box_on_the_bottom(push=True), box_on_the_bottom(push=True)
    place = below.state.q.copy()

    below.command.thrust[:] = 0.95 * FRICTION * WEIGHT_N
    below.run(5000)
    above.command.thrust[:] = 1.2 * FRICTION * WEIGHT_N
    above.run(1000)
    before = above.state.v[0]
    above.run(500)

    assert np.abs(below.state.q - place).max() < 5e-4
    gained = 0.2 * FRICTION * WEIGHT_N / 15.0  # [m/s] in a second
    assert above.state.v[0] - before == pytest.approx(gained, rel=1e-3)


@pytest.mark.slow
def test_a_box_that_falls_on_a_corner_comes_to_rest_on_a_side_without_sinking_in() -> None:
    scene = box_on_the_bottom()
    scene.state.q[2] = GROUND.depth - 0.6
    turn = np.array([0.9, 0.3, 0.2, 0.1])
    scene.state.q[3:7] = turn / np.linalg.norm(turn)
    scene.state.v[2] = 1.0
    deepest = 0.0

    for _ in range(2000):
        scene.run(1)
        deepest = max(deepest, -float(scene.work.touches.gap.min()))

    assert deepest < 2e-4
    assert np.abs(scene.state.v).max() < 1e-9
    assert scene.pair_forces()[0] == pytest.approx(WEIGHT_N, rel=1e-6)


def test_a_long_bar_rests_across_a_box_though_no_corner_is_inside_the_other() -> None:
    bar, bar_shape = box("bar", 5.0, 20.0, (1.5, 0.1, 0.1))
    below = Shape(name="block", kind="box", place=(0.0, 0.0, 5.0), size=(0.1, 0.5, 0.1))
    mechanism = Mechanism(links=[bar], shapes=[bar_shape, below], pairs=[("bar", "block")])
    scene = Scene(mechanism)
    scene.state.q[2] = 5.0 - 0.1 - 0.05

    scene.run(5000)

    assert scene.state.q[2] == pytest.approx(5.0 - 0.15, abs=1e-4)
    assert scene.pair_forces()[0] == pytest.approx(20.0, rel=1e-4)


@pytest.mark.parametrize(("offset", "yaw"), [(0.0, 0.0), (0.02, 0.0), (0.0, 0.4)])
def test_a_rod_lies_still_across_a_block(offset: float, yaw: float) -> None:
    block = Shape(name="block", kind="box", place=(0.0, 0.0, 5.0), size=(0.05, 0.3, 0.05))
    rod = Shape(name="rod", kind="capsule", link="rod", size=(0.02, 0.5, 0.0))
    link = Link(name="rod", rigid=solid(2.0, (1.0, 0.04, 0.04)), net_weight=20.0)
    scene = Scene(Mechanism(links=[link], shapes=[block, rod], pairs=[("rod", "block")]))
    scene.state.q[0], scene.state.q[2] = offset, 5.0 - 0.05 - 0.02
    scene.state.q[3:7] = np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)
    scene.run(500)
    fastest = 0.0

    for _ in range(500):
        scene.run(1)
        fastest = max(fastest, np.abs(np.delete(scene.state.v, 3)).max())  # it may roll

    assert fastest < 1e-5
    assert scene.pair_forces()[0] == pytest.approx(20.0, rel=1e-5)


def gripper(*, effort: float, bar_weight: float) -> Scene:
    """Two jaws that slide towards each other along y, with a bar between them."""
    bar, bar_shape = box("bar", 2.0, bar_weight, (0.2, 0.04, 0.04))
    links, shapes, motors = [bar], [bar_shape], []
    for name, side in (("left", -1.0), ("right", 1.0)):
        links.append(
            Link(
                name=name,
                joint="prismatic",
                offset=(0.0, side * 0.026, 5.0),
                axis=(0.0, -side, 0.0),
                rigid=solid(0.1, (0.06, 0.01, 0.06)),
            )
        )
        size = (0.03, 0.005, 0.03)
        shapes.append(Shape(name=name, kind="box", link=name, size=size, friction=FRICTION))
        motors.append(Motor(link=name, effort=effort))
    pairs = [("left", "bar"), ("right", "bar")]
    mechanism = Mechanism(links=links, motors=motors, shapes=shapes, pairs=pairs)
    scene = Scene(mechanism)
    scene.state.q[2] = 5.0
    scene.command.speed[:] = 0.2
    return scene


@pytest.mark.slow
def test_a_bar_held_by_friction_does_not_creep_in_a_minute() -> None:
    scene = gripper(effort=40.0, bar_weight=15.0)
    scene.run(500)
    place = scene.state.q[:3].copy()

    scene.run(MINUTE)

    assert np.abs(scene.state.q[:3] - place).max() < 1e-4
    assert scene.pair_forces() == pytest.approx([40.0, 40.0], rel=1e-4)


def test_a_bar_that_is_too_heavy_for_the_grip_slips() -> None:
    scene = gripper(effort=40.0, bar_weight=1.2 * 2.0 * FRICTION * 40.0)
    scene.run(250)
    first = scene.state.q[2]

    scene.run(250)

    assert scene.state.q[2] - first > 0.1


def valve(torque: float, *, step_s: float = STEP_S, iterations: int = 10) -> Scene:
    """A valve that breaks away at 5 N m, and a slide that pushes its lever."""
    links = [
        Link(
            name="pusher",
            joint="prismatic",
            offset=(0.2, 0.0, 5.0),
            axis=(0.0, 1.0, 0.0),
            rigid=solid(1.0, (0.05, 0.05, 0.05)),
        ),
        Link(
            name="valve",
            joint="revolute",
            offset=(0.0, 0.05, 5.0),
            axis=(0.0, 0.0, 1.0),
            rigid=solid(0.5, (0.4, 0.02, 0.02)),
        ),
    ]
    shapes = [
        Shape(name="pusher", kind="capsule", link="pusher", size=(0.02, 0.0, 0.0)),
        Shape(name="lever", kind="capsule", link="valve", size=(0.01, 0.3, 0.0)),
    ]
    mechanism = Mechanism(
        links=links,
        motors=[Motor(link="pusher", effort=torque / 0.2)],
        frictions=[Friction(link="valve", resting=5.0, sliding=4.0)],
        shapes=shapes,
        pairs=[("pusher", "lever")],
    )
    scene = Scene(mechanism, step_s=step_s, iterations=iterations)
    scene.command.speed[:] = 0.1
    return scene


def test_a_stuck_valve_does_not_turn_at_sixty_per_cent_of_its_torque() -> None:
    scene = valve(3.0)
    scene.run(500)
    angle = scene.state.q[1]

    scene.run(round(30.0 / STEP_S))

    assert abs(scene.state.q[1] - angle) < 1e-4
    assert scene.pair_forces()[0] == pytest.approx(3.0 / 0.2, rel=1e-3)


def test_a_valve_turns_above_its_torque() -> None:
    scene = valve(5.5)

    scene.run(1500)

    assert scene.state.q[1] > 0.3


def pendulum(**parts: list[Motor] | list[Limits] | list[Friction]) -> Scene:
    """A rod of 1 kg that hangs level from a joint at its end: 4.9 N m."""
    rod = Link(
        name="rod",
        joint="revolute",
        offset=(0.0, 0.0, 5.0),
        axis=(0.0, -1.0, 0.0),  # positive is downwards
        rigid=about(1.0, np.diag([0.001, 0.1, 0.1]), (0.5, 0.0, 0.0)),
        net_weight=9.8,
        moment=(4.9, 0.0, 0.0),
    )
    return Scene(Mechanism(links=[rod], **parts))  # type: ignore[arg-type]


def test_a_joint_stops_at_its_limit_and_stays_there() -> None:
    scene = pendulum(limits=[Limits(link="rod", low=-0.5, high=0.4)])

    scene.run(3000)

    assert scene.state.q[0] == pytest.approx(0.4, abs=2e-4)
    assert abs(scene.state.v[0]) < 1e-9


def test_a_motor_holds_what_it_can_and_gives_way_beyond() -> None:
    strong = pendulum(motors=[Motor(link="rod", effort=5.0)])
    weak = pendulum(motors=[Motor(link="rod", effort=4.8)])

    strong.run(1000)
    weak.run(1000)

    assert strong.state.q[0] == 0.0 or abs(strong.state.q[0]) < 1e-9
    assert -strong.state.impulses.joint[0] / STEP_S == pytest.approx(4.9, rel=1e-6)
    assert weak.state.q[0] > 0.1


def test_a_motor_reaches_the_commanded_speed_against_its_gear_friction() -> None:
    scene = pendulum(
        motors=[Motor(link="rod", effort=9.0)],
        frictions=[Friction(link="rod", resting=1.0, sliding=0.8)],
    )
    scene.command.speed[:] = -0.5

    scene.run(200)

    assert scene.state.v[0] == pytest.approx(-0.5, abs=1e-6)
    spare, inertia = 9.0 - 4.9 - 0.8, 0.1 + 0.25
    late = 0.5 * 0.5 * inertia / spare  # [s] of the whole way, while it gathers speed
    assert scene.state.q[0] == pytest.approx(-0.5 * (0.4 - late), abs=2e-3)


def test_coupled_joints_move_together() -> None:
    def jaw(name: str) -> Link:
        return Link(
            name=name, joint="revolute", rigid=about(0.1, 1e-4 * np.eye(3), (0.05, 0.0, 0.0))
        )

    mechanism = Mechanism(
        links=[jaw("one"), jaw("two")],
        motors=[Motor(link="one", effort=1.0)],
        frictions=[Friction(link="two", resting=0.2, sliding=0.2)],
        couplings=[Coupling(link="two", other="one", ratio=-1.0)],
    )
    scene = Scene(mechanism)
    scene.command.speed[:] = 0.3

    scene.run(1000)

    assert scene.state.q[0] == pytest.approx(0.6, abs=1e-3)
    assert scene.state.q[1] == pytest.approx(-scene.state.q[0], abs=1e-4)


def test_a_joint_at_rest_holds_more_than_its_friction_in_motion() -> None:
    holds = pendulum(frictions=[Friction(link="rod", resting=5.0, sliding=4.0)])
    slides = pendulum(frictions=[Friction(link="rod", resting=4.8, sliding=4.0)])

    holds.run(5000)
    slides.run(500)

    assert abs(holds.state.q[0]) < 1e-9
    assert slides.state.q[0] > 0.3


def test_a_piston_rests_on_the_bottom_though_friction_cannot_move_it() -> None:
    piston = Link(
        name="piston",
        joint="prismatic",
        offset=(0.0, 0.0, GROUND.depth - 0.2),
        rigid=solid(1.0, (0.1, 0.1, 0.1)),
        net_weight=5.0,
    )
    tip = Shape(name="tip", kind="capsule", link="piston", size=(0.05, 0.0, 0.0), friction=FRICTION)
    scene = Scene(Mechanism(links=[piston], shapes=[ground(), tip], pairs=[("tip", "ground")]))

    scene.run(1000)

    assert scene.state.q[0] == pytest.approx(0.15, abs=1e-5)
    assert scene.state.impulses.contact[0] / STEP_S == pytest.approx([5.0, 0.0, 0.0], abs=1e-6)


def test_shapes_that_cannot_approach_each_other_are_no_pair() -> None:
    link, shape = box("box", 1.0, 0.0)
    shapes = [ground(), Shape(name="wall", kind="box", size=(1.0, 1.0, 1.0)), shape]
    lid = Shape(name="lid", kind="capsule", link="box", size=(0.1, 0.0, 0.0))
    for pair in (("wall", "ground"), ("lid", "box")):
        mechanism = Mechanism(links=[link], shapes=[*shapes, lid], pairs=[pair])

        with pytest.raises(ValueError, match="do not move against each other"):
            mechanism.model(STEP_S)


@pytest.mark.parametrize("angle", [0.0, 0.001, 0.02, 0.07, 0.2, 1.5])
def test_crossed_rods_do_not_sink_into_each_other(angle: float) -> None:
    size, radius = (0.02, 0.15, 0.0), 0.02
    below = Shape(name="below", kind="capsule", place=(0.0, 0.0, 5.0), size=size, friction=FRICTION)
    rod = Shape(name="rod", kind="capsule", link="rod", size=size, friction=FRICTION)
    link = Link(name="rod", rigid=solid(1.0, (0.3, 0.04, 0.04)), net_weight=5.0)
    scene = Scene(Mechanism(links=[link], shapes=[below, rod], pairs=[("rod", "below")]))
    scene.state.q[2] = 5.0 - 2.0 * radius - 0.001
    scene.state.q[3:7] = np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)

    scene.run(250)

    assert scene.state.q[2] == pytest.approx(5.0 - 2.0 * radius, abs=1e-5)
    assert scene.pair_forces()[0] == pytest.approx(5.0, rel=1e-3)


def peg_before_hole(
    offset: float, *, chamfer: float, step_s: float = STEP_S, iterations: int = 20
) -> Scene:
    """A peg of 10 mm radius before a hole of 11 mm, beside its axis.

    It is pushed along the axis with 2 N, may slide sideways, and does not turn.
    """
    links = [
        Link(
            name="sideways",
            joint="prismatic",
            offset=(0.0, 0.0, 5.0),
            axis=(0.0, 1.0, 0.0),
            rigid=solid(0.1, (0.1, 0.02, 0.02)),
        ),
        Link(
            name="peg",
            parent="sideways",
            joint="prismatic",
            axis=(1.0, 0.0, 0.0),
            rigid=solid(0.5, (0.1, 0.02, 0.02)),
        ),
    ]
    # The hole opens along -x of the world: its own x axis points out of it, to the peg.
    out = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
    shapes = [
        Shape(name="peg", kind="cylinder", link="peg", size=(0.01, 0.05, 0.0), friction=0.2),
        Shape(
            name="hole",
            kind="socket",
            place=(0.2, 0.0, 5.0),
            turn=out,
            size=(0.011, 0.06, chamfer),
            friction=0.2,
        ),
    ]
    mechanism = Mechanism(
        links=links, motors=[Motor(link="peg", effort=2.0)], shapes=shapes, pairs=[("peg", "hole")]
    )
    scene = Scene(mechanism, step_s=step_s, iterations=iterations)
    scene.state.q[:] = offset, 0.1
    scene.command.speed[:] = 0.1
    return scene


def peg(offset: float, *, chamfer: float) -> float:
    """How deep [m] that peg gets in 4 s."""
    scene = peg_before_hole(offset, chamfer=chamfer)
    scene.run(2000)
    return float(scene.state.q[1] + 0.05 - 0.2)


@pytest.mark.parametrize("offset", [0.0, 0.0005, -0.0009, 0.003, 0.0045])
def test_a_peg_enters_within_clearance_and_chamfer(offset: float) -> None:
    assert peg(offset, chamfer=0.004) == pytest.approx(0.06, abs=1e-3)


@pytest.mark.parametrize(("offset", "chamfer"), [(0.007, 0.004), (0.002, 0.0), (-0.002, 0.0)])
def test_a_peg_beside_the_mouth_stays_outside(offset: float, chamfer: float) -> None:
    assert peg(offset, chamfer=chamfer) < 0.003


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_an_arm_that_is_thrown_about_at_random_stays_in_one_piece_and_out_of_things(
    seed: int,
) -> None:
    source = np.random.Generator(np.random.PCG64(seed))
    mechanism = vehicle_with_arm(valve_torque=2.0)
    mechanism.links[-1].offset = (0.68, 0.0, GROUND.depth - 0.3)
    scene = Scene(mechanism, water=Current(0.3, rng=source, duration_s=60.0).water)
    scene.state.q[2] = GROUND.depth - 0.4
    shoulder, left, right = 8, 11, 12
    touched = 0

    for _ in range(600):
        scene.command.thrust[:] = source.uniform(-40.0, 40.0, 8)
        scene.command.thrust[4:] += source.choice([-10.0, 10.0])  # up or down
        scene.command.speed[:] = source.uniform(-2.0, 2.0, 5)
        scene.run(50)

        q = scene.state.q
        assert np.abs(scene.state.v).max() < 30.0
        assert scene.work.touches.gap.min() > -1e-3
        assert abs(q[shoulder]) < 1.51
        assert -0.61 < q[left] < 0.31
        assert abs(q[left] + q[right]) < 0.05
        touched += scene.state.impulses.contact[:, 0].any()
    assert touched > 50


def test_a_lever_between_jaws_is_turned_by_them() -> None:
    """The contact of capsules carries a moment: two jaws on a lever, one on each side."""
    links = [
        Link(
            name="wrist",
            joint="revolute",
            offset=(0.0, 0.0, 5.0),
            axis=(1.0, 0.0, 0.0),
            rigid=solid(0.5, (0.1, 0.1, 0.1)),
        ),
        Link(
            name="valve",
            joint="revolute",
            offset=(0.05, 0.0, 5.0),
            axis=(1.0, 0.0, 0.0),
            rigid=solid(0.5, (0.02, 0.3, 0.02)),
        ),
    ]
    shapes = [
        Shape(
            name="up", kind="capsule", link="wrist", place=(0.05, 0.05, 0.025), size=(0.01, 0.05, 0)
        ),
        Shape(
            name="down",
            kind="capsule",
            link="wrist",
            place=(0.05, -0.05, -0.025),
            size=(0.01, 0.05, 0),
        ),
        Shape(name="lever", kind="capsule", link="valve", turn=ALONG_Y, size=(0.01, 0.1, 0.0)),
    ]
    mechanism = Mechanism(
        links=links,
        motors=[Motor(link="wrist", effort=4.0)],
        frictions=[Friction(link="valve", resting=3.0, sliding=3.0)],
        shapes=shapes,
        pairs=[("up", "lever"), ("down", "lever")],
    )
    turning, stalled = Scene(mechanism), Scene(mechanism)
    turning.command.speed[:] = -0.5
    mechanism.frictions = [Friction(link="valve", resting=5.0, sliding=5.0)]
    stalled = Scene(mechanism)
    stalled.command.speed[:] = -0.5

    turning.run(2000)
    stalled.run(2000)

    assert abs(turning.state.q[1]) > 0.5 * pi
    assert abs(stalled.state.q[1]) < 1e-3


def _lever_on_a_box_beside_an_arm() -> Mechanism:
    """An arm with two joints at sea, and a box with a stiff lever on the bottom."""
    own, shape = box("box", 15.0, WEIGHT_N)
    joint = {"joint": "revolute", "axis": (0.0, 1.0, 0.0), "rigid": solid(1.0, (0.1, 0.1, 0.1))}
    upper = Link(name="upper", offset=(0.0, 0.0, 5.0), **joint)
    lower = Link(name="lower", parent="upper", offset=(0.3, 0.0, 0.0), **joint)
    lever = Link(name="lever", parent="box", **joint)
    tip = Shape(name="tip", kind="capsule", link="lower", size=(0.05, 0.0, 0.0))
    return Mechanism(
        links=[upper, lower, own, lever],
        motors=[Motor(link="upper", effort=9.0)],
        # The lever's place is made before that of the coupling.
        frictions=[Friction(link="lever", resting=0.3, sliding=0.25)],
        couplings=[Coupling(link="lower", other="upper", ratio=-1.0)],
        shapes=[ground(), shape, tip],
        pairs=[("box", "ground"), ("tip", "box")],
    )


def test_joints_beside_a_contact_that_they_do_not_feel_give_the_bits_of_joints_before_it() -> None:
    beside, before = (Scene(_lever_on_a_box_beside_an_arm()) for _ in range(2))
    before.model.rows.aside[:] = 0
    for scene in (beside, before):
        scene.state.q[4] = GROUND.depth - 0.5 * SIZE[2]
        scene.state.v[:] = 0.1
        scene.command.speed[:] = 0.4
        scene.run(500)

    # Two places of the arm share no speed with the box on the ground and the lever on the box.
    assert beside.model.rows.aside.tolist() == [2, 0]
    assert beside.work.solving.in_use[0] > 0
    assert beside.state.q.tobytes() == before.state.q.tobytes()
    assert beside.state.v.tobytes() == before.state.v.tobytes()


@pytest.mark.parametrize(
    ("speed", "gap", "corners"),
    [(0.0, 0.0019, 4), (0.0, 0.0021, 0), (3.0, 0.0079, 4), (3.0, 0.0081, 0), (9.0, 0.0099, 4)],
)
def test_what_could_not_touch_within_a_step_has_no_rows(
    speed: float, gap: float, corners: int
) -> None:
    link, shape = box("box", 15.0, 0.0)
    pile = Mechanism(links=[link], shapes=[ground(), shape], pairs=[("box", "ground")])
    scene = Scene(pile)
    scene.state.q[2] = GROUND.depth - 0.5 * SIZE[2] - gap
    scene.state.v[2] = speed

    scene.run(1)

    assert scene.work.solving.in_use[0] == corners


@pytest.mark.parametrize("speed", [0.5, 2.0, 4.0])
def test_what_falls_fast_does_not_sink_into_the_bottom(speed: float) -> None:
    scene = box_on_the_bottom()
    rest = scene.state.q[2]
    scene.state.q[2] -= 0.05
    scene.state.v[2] = speed

    depths = []
    for _ in range(100):
        scene.run(1)
        depths.append(scene.state.q[2])

    assert max(depths) - rest < 1e-4
