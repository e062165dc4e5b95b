"""A description that cannot move is refused with a sentence."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from seamark.sim.multibody.mechanism import (
    Coupling,
    Friction,
    Limits,
    Link,
    Mechanism,
    Motor,
    Shape,
)
from tests.sim.multibody.scenes import STEP_S

BODY = np.eye(6)


def described() -> Mechanism:
    """A free body with two joints in a chain, each with a ball."""
    return Mechanism(
        links=[
            Link(name="body", rigid=BODY),
            Link(name="upper", parent="body", joint="revolute", rigid=BODY),
            Link(name="fore", parent="upper", joint="revolute", rigid=BODY),
        ],
        motors=[Motor(link="upper", effort=1.0)],
        frictions=[Friction(link="fore", resting=0.2, sliding=0.1)],
        limits=[Limits(link="upper", low=-1.0, high=1.0)],
        couplings=[Coupling(link="fore", other="upper", ratio=1.0)],
        shapes=[
            Shape(name="ball", kind="capsule", link="fore", size=(0.1, 0.0, 0.0)),
            Shape(name="bottom", kind="ground"),
        ],
        pairs=[("ball", "bottom")],
    )


def shuffled(mechanism: Mechanism) -> None:
    mechanism.links = [mechanism.links[k] for k in (0, 2, 1)]


def orphaned(mechanism: Mechanism) -> None:
    mechanism.links[1] = replace(mechanism.links[1], parent="nobody")


def own_parent(mechanism: Mechanism) -> None:
    mechanism.links[1] = replace(mechanism.links[1], parent="upper")


def hanging_free(mechanism: Mechanism) -> None:
    mechanism.links[2] = replace(mechanism.links[2], joint="free")


def twins(mechanism: Mechanism) -> None:
    mechanism.links.append(Link(name="fore", joint="revolute", rigid=BODY))


def twin_shapes(mechanism: Mechanism) -> None:
    mechanism.shapes.append(Shape(name="ball", kind="capsule", size=(0.1, 0.0, 0.0)))


def free_motor(mechanism: Mechanism) -> None:
    mechanism.motors.append(Motor(link="body", effort=1.0))


def no_friction(mechanism: Mechanism) -> None:
    mechanism.frictions.append(Friction(link="hand", resting=1.0, sliding=1.0))


def no_limit(mechanism: Mechanism) -> None:
    mechanism.limits.append(Limits(link="hand", low=0.0, high=1.0))


def no_other(mechanism: Mechanism) -> None:
    mechanism.couplings.append(Coupling(link="fore", other="hand", ratio=1.0))


def itself(mechanism: Mechanism) -> None:
    mechanism.couplings.append(Coupling(link="fore", other="fore", ratio=1.0))


def lost_shape(mechanism: Mechanism) -> None:
    mechanism.shapes[0] = replace(mechanism.shapes[0], link="hand")


def lost_pair(mechanism: Mechanism) -> None:
    mechanism.pairs.append(("ball", "wall"))


MISTAKES = {
    shuffled: "the link fore hangs on upper, which must come before it",
    orphaned: "the link upper hangs on nobody, which is no link",
    own_parent: "the link upper hangs on upper, which must come before it",
    hanging_free: "the link fore is free, so it cannot hang on upper",
    twins: "two links have the same name: fore",
    twin_shapes: "two shapes have the same name: ball",
    free_motor: "a motor of body needs the joint of body, which is free",
    no_friction: "friction of hand needs the joint of hand, which does not exist",
    no_limit: "a limit of hand needs the joint of hand, which does not exist",
    no_other: "a coupling of fore needs the joint of hand, which does not exist",
    itself: "the joint of fore cannot follow itself",
    lost_shape: "the shape ball is on hand, which is no link",
    lost_pair: "there is no shape wall that could touch anything",
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_cannot_move_is_refused_with_a_sentence(mistake: Callable[[Mechanism], None]) -> None:
    mechanism = described()
    assert len(mechanism.model(STEP_S).structure.parent) == 3
    mistake(mechanism)

    with pytest.raises(ValueError, match=re.escape(MISTAKES[mistake])):
        mechanism.model(STEP_S)
