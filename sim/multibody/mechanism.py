"""Mechanisms: links, joints, motors and shapes, and their numbers as compiled code reads them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from seamark.sim.multibody import contacts, solver, tree
from seamark.sim.multibody.contacts import SLOTS, Shapes, touches_for
from seamark.sim.multibody.memory import zeros
from seamark.sim.multibody.solver import Impulses, Rows, Solving
from seamark.sim.multibody.step import Command, Model, State, Thrusters, Work
from seamark.sim.multibody.tree import WORLD, Links, Structure, frames_for
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.numerics.libm import exp
from seamark.sim.numerics.linear_algebra import inverse
from seamark.sim.vehicles.matrices import shifted

Point = tuple[float, float, float]
_Moved = list[tuple[int, int]]  # degrees of freedom, and which of two shapes each moves
_JOINTS = {"free": tree.FREE, "revolute": tree.REVOLUTE, "prismatic": tree.PRISMATIC}
_KINDS = {
    "capsule": contacts.CAPSULE,
    "box": contacts.BOX,
    "cylinder": contacts.CYLINDER,
    "ground": contacts.GROUND,
    "socket": contacts.SOCKET,
}
UNTURNED = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CONTACT_STIFFNESS = 1e7  # [N/m] E: 0.02 mm deep in a fast drop


def _zeros() -> Array:
    return np.zeros((6, 6))


@dataclass(slots=True, kw_only=True)
class Link:
    """A rigid part: twists and wrenches are about its origin in its axes, linear before angular.

    `turn` and `offset` [m] place it in its parent, or in the world, at coordinate zero; the `axis`
    of its joint is in its own axes. `rigid` and `added` are (6, 6) [kg, kg m, kg m²]; `moment`
    [N m] is weight times centre of gravity minus buoyancy times centre of buoyancy. Drag is that of
    the point `centre`.
    """

    name: str
    parent: str | None = None
    joint: Literal["free", "revolute", "prismatic"] = "free"
    offset: Point = (0.0, 0.0, 0.0)
    turn: Sequence[Sequence[float]] = UNTURNED
    axis: Point = (0.0, 0.0, 1.0)
    rigid: Array = field(default_factory=_zeros)
    added: Array = field(default_factory=_zeros)
    rotor: float = 0.0
    net_weight: float = 0.0
    moment: Point = (0.0, 0.0, 0.0)
    linear: Sequence[float] = (0.0,) * 6
    quadratic: Sequence[float] = (0.0,) * 6
    centre: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """It drives a joint at the commanded speed with at most this effort [N m or N]."""

    link: str
    effort: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """Coulomb friction of a joint [N m or N]: to break away, and in motion."""

    link: str
    resting: float
    sliding: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Range of a joint [rad or m], with stops of this stiffness [N m/rad or N/m]."""

    link: str
    low: float
    high: float
    stiffness: float = 1e5


@dataclass(frozen=True, slots=True, kw_only=True)
class Coupling:
    """A joint that follows another one: coordinate = ratio * other's coordinate."""

    link: str
    other: str
    ratio: float
    stiffness: float = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A primitive on a link, or in the world; see `contacts.Shapes` for its size."""

    name: str
    kind: Literal["capsule", "box", "cylinder", "ground", "socket"]
    link: str | None = None
    place: Point = (0.0, 0.0, 0.0)
    turn: Sequence[Sequence[float]] = UNTURNED
    size: Point = (0.0, 0.0, 0.0)
    friction: float = 0.5


@dataclass(slots=True, kw_only=True)
class Mechanism:
    """A description; `model` makes it ready to move.

    `pairs` name the shapes that may touch. `allocation` (6, m) is of thrusters on the first link,
    whose time constant is `lag_s`.
    """

    links: list[Link]
    motors: list[Motor] = field(default_factory=list)
    frictions: list[Friction] = field(default_factory=list)
    limits: list[Limits] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    shapes: list[Shape] = field(default_factory=list)
    pairs: list[tuple[str, str]] = field(default_factory=list)
    allocation: Array = field(default_factory=lambda: np.zeros((6, 0)))
    lag_s: float = 0.1

    def model(self, step_s: float) -> Model:
        """Return the mechanism as compiled code reads it.

        Raises
        ------
        ValueError
            With a sentence: names are missing or doubled, a link comes before its parent, a row is
            of a joint that is none, or contact of a pair is not known.
        """
        for mistake in self._mistakes():
            raise ValueError(mistake)
        structure = self._structure()
        return Model(
            structure=structure,
            links=self._links(step_s),
            shapes=self._shapes(),
            rows=self._rows(structure),
            thrusters=Thrusters(
                allocation=np.ascontiguousarray(self.allocation, dtype=np.float64),
                lag=np.array([1.0 - exp(-step_s / self.lag_s)]),
            ),
        )

    def number(self, name: str | None) -> int:
        """Return the number of a link, or WORLD."""
        if name is None:
            return WORLD
        return next(i for i, link in enumerate(self.links) if link.name == name)

    def _mistakes(self) -> Iterator[str]:
        """Yield what a description must not have, in sentences."""
        joints = {link.name: link.joint for link in self.links}
        yield from _doubled("links", [link.name for link in self.links])
        yield from self._misplaced_links(joints)
        for what, part, name in self._ties():
            if joints.get(name, "free") == "free":
                why = "is free" if name in joints else "does not exist"
                yield f"{what} of {part} needs the joint of {name}, which {why}"
        for tie in self.couplings:
            if tie.link == tie.other:
                yield f"the joint of {tie.link} cannot follow itself"
        yield from self._unknown_shapes(joints)

    def _misplaced_links(self, joints: Collection[str]) -> Iterator[str]:
        above: set[str | None] = {None}
        for link in self.links:
            if link.parent not in above:
                why = "must come before it" if link.parent in joints else "is no link"
                yield f"the link {link.name} hangs on {link.parent}, which {why}"
            if link.parent is not None and link.joint == "free":
                yield f"the link {link.name} is free, so it cannot hang on {link.parent}"
            above.add(link.name)

    def _unknown_shapes(self, links: Collection[str]) -> Iterator[str]:
        names = [shape.name for shape in self.shapes]
        yield from _doubled("shapes", names)
        for shape in self.shapes:
            if shape.link is not None and shape.link not in links:
                yield f"the shape {shape.name} is on {shape.link}, which is no link"
        for name in (name for pair in self.pairs for name in pair if name not in names):
            yield f"there is no shape {name} that could touch anything"

    def _ties(self) -> Iterator[tuple[str, str, str]]:
        """Yield each row's kind, its link, and the link whose joint it needs."""
        yield from (("a motor", part.link, part.link) for part in self.motors)
        yield from (("friction", part.link, part.link) for part in self.frictions)
        yield from (("a limit", part.link, part.link) for part in self.limits)
        for tie in self.couplings:
            yield from (("a coupling", tie.link, name) for name in (tie.link, tie.other))

    def _structure(self) -> Structure:
        parent = [self.number(link.parent) for link in self.links]
        joint = [_JOINTS[link.joint] for link in self.links]
        coordinate: list[int] = []
        speed: list[int] = []
        root: list[int] = []
        above: list[int] = []
        owner: list[int] = []
        coordinates = 0
        for i, link in enumerate(self.links):
            coordinate.append(coordinates)
            speed.append(len(above))
            root.append(i if parent[i] == WORLD else root[parent[i]])
            free = link.joint == "free"
            coordinates += tree.FREE_COORDINATES if free else 1
            for k in range(tree.FREE_SPEEDS if free else 1):
                if k > 0:
                    above.append(len(above) - 1)
                elif parent[i] == WORLD:
                    above.append(-1)
                else:
                    up = parent[i]
                    above.append(speed[up] + (5 if joint[up] == tree.FREE else 0))
                owner.append(i)
        return Structure(*map(_integers, (parent, joint, coordinate, speed, root, above, owner)))

    def _links(self, step_s: float) -> Links:
        parts = self.links
        return Links(
            axis=np.array([link.axis for link in parts], dtype=np.float64),
            offset=np.array([link.offset for link in parts], dtype=np.float64),
            turn=np.array([link.turn for link in parts], dtype=np.float64),
            mass=np.array([link.rigid + link.added for link in parts]),
            added=np.array([link.added for link in parts]),
            rotor=np.array([link.rotor for link in parts], dtype=np.float64),
            net_weight=np.array([link.net_weight for link in parts], dtype=np.float64),
            moment=np.array([link.moment for link in parts], dtype=np.float64),
            linear=np.array([link.linear for link in parts], dtype=np.float64),
            quadratic=np.array([link.quadratic for link in parts], dtype=np.float64),
            centre=np.array([link.centre for link in parts], dtype=np.float64),
            steepest=np.array([_inertia(link) / step_s for link in parts]),
        )

    def _shape_number(self, name: str) -> int:
        return next(i for i, shape in enumerate(self.shapes) if shape.name == name)

    def _pairs(self) -> list[tuple[int, int]]:
        """Return the pairs, each in the order that SLOTS knows."""
        ordered = []
        for names in self.pairs:
            a, b = map(self._shape_number, names)
            kinds = _KINDS[self.shapes[a].kind], _KINDS[self.shapes[b].kind]
            if kinds not in SLOTS:
                a, b, kinds = b, a, kinds[::-1]
            if kinds not in SLOTS:
                raise ValueError(f"no contact between these shapes is known: {names}")
            if self.shapes[a].link == self.shapes[b].link:
                raise ValueError(f"these shapes do not move against each other: {names}")
            ordered.append((a, b))
        return ordered

    def _shapes(self) -> Shapes:
        shapes, pairs = self.shapes, self._pairs()
        slots = [0]
        for a, b in pairs:
            slots.append(slots[-1] + SLOTS[_KINDS[shapes[a].kind], _KINDS[shapes[b].kind]])
        return Shapes(
            kind=_integers([_KINDS[shape.kind] for shape in shapes]),
            link=_integers([self.number(shape.link) for shape in shapes]),
            first=_integers([a for a, _ in pairs]),
            second=_integers([b for _, b in pairs]),
            slot=_integers(slots),
            place=np.array([shape.place for shape in shapes], dtype=np.float64).reshape(-1, 3),
            turn=np.array([shape.turn for shape in shapes], dtype=np.float64).reshape(-1, 3, 3),
            size=np.array([shape.size for shape in shapes], dtype=np.float64).reshape(-1, 3),
            reach=np.array([_reach(shape) for shape in shapes], dtype=np.float64),
        )

    def _joint_rows(self) -> Iterator[_JointRow]:
        for k, motor in enumerate(self.motors):
            yield _JointRow(solver.MOTOR, motor.link, motor=k, most=motor.effort)
        for part in self.frictions:
            yield _JointRow(solver.FRICTION, part.link, most=part.resting, sliding=part.sliding)
        for limit in self.limits:
            for kind, most in ((solver.LOWER, limit.low), (solver.UPPER, limit.high)):
                yield _JointRow(kind, limit.link, most=most, stiffness=limit.stiffness)
        for tie in self.couplings:
            yield _JointRow(
                solver.COUPLING, tie.link, tie.other, ratio=tie.ratio, stiffness=tie.stiffness
            )

    def _rows(self, structure: Structure) -> Rows:
        entries = list(self._joint_rows())
        # By trees, so that those that nothing ties to contacts are side by side.
        places = sorted(
            dict.fromkeys((row.link, row.other, row.ratio) for row in entries),
            key=lambda place: structure.root[self.number(place[0])],
        )
        place = [places.index((row.link, row.other, row.ratio)) for row in entries]
        links = [self.number(link) for link, _, _ in places]
        others = [self.number(other) for _, other, _ in places]
        lists = [self._place_chain(i, j, structure) for i, j in zip(links, others, strict=True)]
        pairs = self._pairs()
        lists += [self._pair_chain(a, b, structure) for a, b in pairs]
        frictions = [self.shapes[a].friction * self.shapes[b].friction for a, b in pairs]
        return Rows(
            kind=_integers([row.kind for row in entries]),
            place=_integers(place),
            motor=_integers([row.motor for row in entries]),
            order=np.array(sorted(range(len(place)), key=place.__getitem__), np.uint64),
            first=_integers([sum(one < k for one in place) for k in range(len(places) + 1)]),
            speed=_integers([structure.speed[i] for i in links]),
            other=_integers([WORLD if i == WORLD else structure.speed[i] for i in others]),
            coordinate=_integers([structure.coordinate[i] for i in links]),
            other_coordinate=_integers([structure.coordinate[max(i, 0)] for i in others]),
            chain=_padded([[i for i, _ in each] for each in lists]).astype(np.uint64),
            length=_integers([len(each) for each in lists]),
            aside=_integers([_aside(lists[: len(places)], each) for each in lists[len(places) :]]),
            side=_padded([[side for _, side in each] for each in lists]),
            ratio=np.array([ratio for _, _, ratio in places], dtype=np.float64),
            most=np.array([row.most for row in entries], dtype=np.float64),
            sliding=np.array([row.sliding for row in entries], dtype=np.float64),
            stiffness=np.array([row.stiffness for row in entries], dtype=np.float64),
            friction=np.sqrt(np.array(frictions, dtype=np.float64)),
            spring=np.full(len(pairs), CONTACT_STIFFNESS),
        )

    def _place_chain(self, link: int, other: int, structure: Structure) -> _Moved:
        """Return the degrees of freedom that a row of joints feels."""
        both = {*_chain_of(link, structure), *_chain_of(other, structure)}
        return [(i, 1) for i in sorted(both, reverse=True)]

    def _pair_chain(self, a: int, b: int, structure: Structure) -> _Moved:
        """Return the degrees of freedom that move two shapes, and which of the two."""
        first, second = (
            set(_chain_of(self.number(self.shapes[k].link), structure)) for k in (a, b)
        )
        ordered = sorted(first | second, reverse=True)
        return [(i, (i in first) - (i in second)) for i in ordered]


@dataclass(frozen=True, slots=True)
class _JointRow:
    """A row of the solver; see `solver.Rows`."""

    kind: int
    link: str
    other: str | None = None
    motor: int = 0
    ratio: float = 0.0
    most: float = 0.0
    sliding: float = 0.0
    stiffness: float = 1.0


def _doubled(what: str, names: Sequence[str]) -> Iterator[str]:
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"two {what} have the same name: {name}"


def _inertia(link: Link) -> Array:
    """Return what a link resists a push with along and about the axes of its drag, alone, (6,)."""
    try:
        moved = inverse(shifted(link.rigid + link.added, [-x for x in link.centre]))
    except ValueError:
        return np.full(6, np.inf)  # it has no mass in some direction: others must carry it
    return 1.0 / np.diag(moved)


def _aside(places: Sequence[_Moved], pair: _Moved) -> int:
    """Return how many first places share no degree of freedom with a pair and later places."""
    for count in range(len(places), 0, -1):
        first = {i for each in places[:count] for i, _ in each}
        if all(first.isdisjoint(i for i, _ in each) for each in (*places[count:], pair)):
            return count
    return 0


def _integers(values: Sequence[int]) -> Integers:
    return np.array(values, dtype=np.int64)


def _padded(lists: Sequence[Sequence[int]]) -> Integers:
    """Return lists as the rows of a matrix, with zeros behind those that are shorter."""
    longest = max((len(each) for each in lists), default=0)
    matrix = np.zeros((len(lists), max(1, longest)), np.int64)
    for row, each in zip(matrix, lists, strict=True):
        row[: len(each)] = each
    return matrix


def _chain(speed: int, structure: Structure) -> Iterator[int]:
    """Yield a degree of freedom and those above it."""
    while speed >= 0:
        yield speed
        speed = int(structure.above[speed])


def _chain_of(link: int, structure: Structure) -> Iterator[int]:
    """Yield the degrees of freedom that move a link."""
    if link != WORLD:
        last = 5 if structure.joint[link] == tree.FREE else 0
        yield from _chain(int(structure.speed[link]) + last, structure)


def _reach(shape: Shape) -> float:
    a, b, c = shape.size
    if shape.kind == "capsule":
        return a + b
    if shape.kind == "cylinder":
        return float(np.sqrt(a * a + b * b))
    if shape.kind == "box":
        return float(np.sqrt(a * a + b * b + c * c))
    return float("inf")


def state_for(model: Model, lanes: tuple[int, ...] = ()) -> State:
    """Return a state at rest: coordinates are zero, quaternions the identity."""
    structure = model.structure
    free = structure.joint == tree.FREE
    count = int(np.where(free, tree.FREE_COORDINATES, 1).sum())
    q = np.zeros((count, *lanes))
    for at in structure.coordinate[free]:
        q[at + 3] = 1.0
    return State(
        q=q,
        v=np.zeros((len(structure.above), *lanes)),
        thrust=np.zeros((model.thrusters.allocation.shape[1], *lanes)),
        impulses=Impulses(
            joint=np.zeros((len(model.rows.kind), *lanes)),
            contact=np.zeros((max(1, int(model.shapes.slot[-1])), 3, *lanes)),
        ),
    )


def command_for(model: Model, lanes: tuple[int, ...] = ()) -> Command:
    """Return a command of zeros."""
    motors = int((model.rows.kind == solver.MOTOR).sum())
    return Command(
        thrust=np.zeros((model.thrusters.allocation.shape[1], *lanes)),
        speed=np.zeros((max(1, motors), *lanes)),
    )


def work_for(model: Model, lanes: tuple[int, ...] = ()) -> Work:
    """Return the memory that a thread needs to move a mechanism, or lanes of them."""
    n, rows, joints = len(model.structure.above), model.rows, len(model.rows.kind)
    slots = max(1, int(model.shapes.slot[-1]))
    longest = rows.chain.shape[1]
    places = len(rows.speed)
    sizes = {
        "w": (n,),
        "x": (3, n),
        "basis": (places, longest),
        "basis_size": (places,),
        "wanted": (joints,),
        "low": (joints,),
        "high": (joints,),
        "soft": (joints,),
        "across": (slots, 6),
        "row": (3 * slots, longest),
        "size": (slots, 2),
        "aim": (slots, 2),
    }
    integers = {"used": (slots,), "pair_of": (slots,), "in_use": (1,)}
    return Work(
        frames=frames_for(len(model.structure.parent), n, lanes),
        touches=touches_for(
            max(1, len(model.shapes.kind)), max(1, len(model.shapes.first)), slots, lanes
        ),
        solving=zeros(Solving, sizes, lanes, integers=integers),
        wrench=np.zeros((6, *lanes)),
        x=np.zeros((n, *lanes)),
        before=np.zeros((n, *lanes)),
        acceleration=np.zeros((n, *lanes)),
    )
