"""The file of an arm or of a thing, checked: the one gate for linkages, whoever wrote them.

It is data as a vehicle's is; see `reading`. `docs/vehicles.md` describes the format.
"""

import math
import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, get_args

from seamark.sim.registry import ARMS, THINGS
from seamark.sim.vehicles.body_fields import read_body
from seamark.sim.vehicles.fields import (
    NAME_MAX,
    Fields,
    FileInvalid,
    Slot,
    Table,
    not_given,
    number,
    quoted,
)
from seamark.sim.vehicles.linkage import (
    TOUCHING,
    Joint,
    JointKind,
    Kind,
    Linkage,
    LinkData,
    ShapeKind,
    Spot,
    Touchable,
)
from seamark.sim.vehicles.place_fields import PLACE_KEYS, read_place
from seamark.sim.vehicles.solid_fields import read_solid
from seamark.sim.vehicles.toml_reading import TomlRefused, read_toml

FORMAT = 1
LINKS_MAX, SHAPES_MAX, SOLIDS_MAX = 32, 8, 8
PAIRS_MAX, OUTER_MAX = 32, 12  # what a step looks at
RANGE_MAX = 4.0 * math.pi  # [rad or m] to each side
_TOP = (
    *("format", "kind", "name", "title", "summary", "sources", "links", "touches", "outer"),
    *("hull", "camera", "force_sensor", "tool"),
)
_JOINT = ("kind", *PLACE_KEYS)
_MOVING = (*_JOINT, "axis", "range", "home", "effort", "speed", "friction", "rotor", "follows")
_SIZES: Mapping[ShapeKind, int] = {"capsule": 2, "box": 3, "cylinder": 2, "socket": 3}
_NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9 -]{{0,{NAME_MAX - 1}}}")
_TAKEN = ("vehicle", "bottom")  # by what an arm hangs on and lies on
_FRICTION = number("friction", "1", low=0.0)


class LinkageInvalid(FileInvalid):
    """The file of an arm or a thing breaks rules."""


@cache
def load_linkage(name: str) -> Linkage:
    """Return one of our arms or things, such as "hook".

    Raises
    ------
    LookupError
        There is none of that name in the registry.
    """
    files = ARMS | THINGS
    if name not in files:
        raise LookupError(f"there is no arm and no thing called {name!r}")
    return read_linkage(files[name].read_bytes())


def read_linkage(content: bytes) -> Linkage:
    """Return the linkage of a file.

    Raises
    ------
    LinkageInvalid
        With a sentence for each mistake.
    """
    try:
        document = read_toml(content)
    except TomlRefused as reason:
        raise LinkageInvalid([str(reason)]) from None
    reader = _Reader(document)
    linkage = reader.linkage()
    if linkage is None or reader.errors:
        raise LinkageInvalid(reader.errors)
    return linkage


class _Reader(Fields):
    """Reads the tables of a linkage."""

    def linkage(self) -> Linkage | None:
        document = self.document
        self.known("", document, _TOP)
        if document.get("format") is not FORMAT:
            self.wrong(f"format must be {FORMAT}: write format = {FORMAT} in the first line.")
        kind: Any = self.choice("kind", document.get("kind"), get_args(Kind))
        links = [self._link(path, entry) for path, entry in self.named("links", LINKS_MAX)]
        for link in links:
            for name in (link.name, *(shape.name for shape in link.shapes)):
                self._check_name(name)
        shapes = {shape.name: (shape, link) for link in links for shape in link.shapes}
        if len(shapes) < sum(len(link.shapes) for link in links):
            self.wrong("links: two shapes have the same name; give each its own.")
        _check_tree(self, links)
        if kind == "arm" and any(link.joint.kind == "free" for link in links):
            self.wrong("links: those of an arm are not free: it hangs on a vehicle.")
        names = {link.name for link in links}
        touches = self._touches(shapes)
        outer, hull = (self._shapes_of(key, shapes) for key in ("outer", "hull"))
        camera, sensor, tool = (
            self._spot(key, names) for key in ("camera", "force_sensor", "tool")
        )
        name, title = self.name(document), self.text("", document, "title")
        summary = self.text("", document, "summary")
        if self.errors:
            return None
        return Linkage(
            kind=kind,
            name=name,
            title=title,
            summary=summary,
            links=_in_order(links),
            touches=touches,
            outer=outer,
            hull=hull,
            camera=camera,
            force_sensor=sensor,
            tool=tool,
        )

    def _check_name(self, name: str) -> None:
        if name and (not _NAME.fullmatch(name) or name in _TAKEN):
            self.wrong(
                f"links: {quoted(name)} is no name for a link or a shape; write at most {NAME_MAX} "
                f"letters, digits, spaces and hyphens, and not {' or '.join(_TAKEN)}."
            )

    def _link(self, path: str, entry: Table) -> LinkData:
        self.known(path, entry, ("name", "parent", "joint", "body", "shapes", "solids"))
        joint = self._joint(f"{path}.joint", self.table(path, entry, "joint", required=True))
        body = None
        if joint.kind != "fixed" or "body" in entry:
            table = self.table(path, entry, "body", required=True)
            body = read_body(self, f"{path}.body", table)
        return LinkData(
            name=entry["name"],
            parent=self.text(path, entry, "parent") if "parent" in entry else None,
            joint=joint,
            body=body,
            shapes=tuple(self._shape(at, one) for at, one in self._some(path, entry, "shapes")),
            solids=tuple(
                read_solid(self, at, one) for at, one in self._some(path, entry, "solids")
            ),
        )

    def _some(self, path: str, entry: Table, key: str) -> list[tuple[str, Table]]:
        """Return path and table of each entry of a list that may be missing."""
        most = SHAPES_MAX if key == "shapes" else SOLIDS_MAX
        entries = self.tables(path, entry, key, most) if key in entry else []
        return [(f"{path}.{key} {at}", one) for at, one in enumerate(entries, start=1)]

    def _joint(self, path: str, table: Table) -> Joint:
        kind: JointKind = self.choice(f"{path}.kind", table.get("kind"), get_args(JointKind))  # type: ignore[assignment]
        place = read_place(self, path, table)
        if kind in ("fixed", "free"):
            self.known(path, table, _JOINT)
            return Joint(kind=kind, place=place)
        self.known(path, table, _MOVING)
        turning = kind == "revolute"
        optional = {
            key: self.quantity(path, table, key, slot)
            for key, slot in _joint_slots(turning).items()
            if key in table
        }
        joint = Joint(
            kind=kind,
            place=place,
            axis=self.direction(f"{path}.axis", table.get("axis")),
            follows=self._follows(path, table),
            **optional,
        )
        self._check_joint(path, joint)
        return joint

    def _check_joint(self, path: str, joint: Joint) -> None:
        if joint.range:
            low, high = joint.range.value
            if not -RANGE_MAX <= low < high <= RANGE_MAX:
                self.wrong(
                    f"{path}.range must be its lower end, then its upper one, from {-RANGE_MAX:.4g}"
                    f" to {RANGE_MAX:.4g}."
                )
            if joint.home and not low <= joint.home.scalar <= high:
                self.wrong(f"{path}.home must be within the range.")
        if joint.friction and joint.friction.value[0] < joint.friction.value[1]:
            self.wrong(f"{path}.friction must be that to break away, then that in motion, no more.")
        if (joint.effort is None) != (joint.speed is None):
            self.wrong(f"{path}: a motor has both effort and speed.")
        if joint.effort and joint.follows:
            self.wrong(f"{path}: a joint that follows another one has no effort of its own.")

    def _follows(self, path: str, table: Table) -> tuple[str, float] | None:
        if "follows" not in table:
            return None
        path, inner = f"{path}.follows", self.table(path, table, "follows", required=True)
        self.known(path, inner, ("link", "ratio"))
        ratio = self.plain(f"{path}.ratio", inner.get("ratio"))
        if not 1e-3 <= abs(ratio) <= 1e3:
            self.wrong(f"{path}.ratio must be from 0.001 to 1000, or the negative of that.")
        return self.text(path, inner, "link"), ratio

    def _shape(self, path: str, entry: Table) -> Touchable:
        self.known(path, entry, ("name", "kind", *PLACE_KEYS, "size", "friction"))
        kind: ShapeKind = self.choice(f"{path}.kind", entry.get("kind"), tuple(_SIZES))  # type: ignore[assignment]
        count = range(_SIZES[kind], _SIZES[kind] + 1)
        friction = not_given(_FRICTION, 0.5)
        if "friction" in entry:
            friction = self.quantity(path, entry, "friction", _FRICTION)
        return Touchable(
            name=self.text(path, entry, "name"),
            kind=kind,
            place=read_place(self, path, entry),
            size=self.quantity(path, entry, "size", Slot("size", "m", count, above=0.0)),
            friction=friction,
        )

    def _touches(
        self, shapes: Mapping[str, tuple[Touchable, LinkData]]
    ) -> tuple[tuple[str, str], ...]:
        given = self.document.get("touches", [])
        if not isinstance(given, list) or len(given) > PAIRS_MAX:
            self.wrong(f"touches must be a list of at most {PAIRS_MAX} pairs of shapes.")
            return ()
        pairs = []
        for at, pair in enumerate(given, start=1):
            two = isinstance(pair, list) and len(pair) == 2
            if not two or not all(isinstance(one, str) and one in shapes for one in pair):
                self.wrong(f"touches {at} must be two names of shapes.")
                continue
            (first, link), (second, other) = (shapes[name] for name in pair)
            if frozenset({first.kind, second.kind}) not in TOUCHING or link is other:
                self.wrong(
                    f"touches {at}: contacts of a {first.kind} and a {second.kind} are not known, "
                    "or both are of one link."
                )
            pairs.append((first.name, second.name))
        return tuple(pairs)

    def _shapes_of(self, key: str, shapes: Mapping[str, object]) -> tuple[str, ...]:
        given = self.document.get(key, [])
        if not isinstance(given, list) or len(given) > OUTER_MAX:
            self.wrong(f"{key} must be a list of at most {OUTER_MAX} names of shapes.")
            return ()
        for name in given:
            if not isinstance(name, str) or name not in shapes:
                self.wrong(f"{key}: there is no shape {quoted(name)}.")
        return tuple(given)

    def _spot(self, key: str, links: set[str]) -> Spot | None:
        if key not in self.document:
            return None
        table = self.table("", self.document, key, required=True)
        self.known(key, table, ("link", *PLACE_KEYS))
        spot = Spot(link=self.text(key, table, "link"), place=read_place(self, key, table))
        if spot.link not in links:
            self.wrong(f"{key}.link: there is no link {quoted(spot.link)}.")
        return spot


def _joint_slots(turning: bool) -> dict[str, Slot]:
    angle, effort, speed = ("rad", "N m", "rad/s") if turning else ("m", "N", "m/s")
    inertia = "kg m²" if turning else "kg"
    return {
        "range": Slot("range", angle, range(2, 3)),
        "home": number("coordinate at the start", angle),
        "effort": number("greatest effort of the motor", effort, above=0.0),
        "speed": number("greatest speed", speed, above=0.0),
        "friction": Slot("friction to break away, and in motion", effort, range(2, 3), low=0.0),
        "rotor": number("inertia of the motor, as the joint feels it", inertia, low=0.0),
    }


def _check_tree(fields: Fields, links: Sequence[LinkData]) -> None:
    by_name = {link.name: link for link in links}
    for link in links:
        if link.parent is not None and link.parent not in by_name:
            fields.wrong(f"links: {link.name} hangs on {quoted(link.parent)}, which is no link.")
        elif _goes_round(link, by_name):
            fields.wrong(f"links: {link.name} hangs on itself; its parents go round in a circle.")
        if link.joint.kind == "free" and link.parent is not None:
            fields.wrong(f"links: {link.name} is free; remove its parent.")
        if link.joint.follows:
            _check_follows(fields, link, by_name)


def _goes_round(link: LinkData, by_name: Mapping[str, LinkData]) -> bool:
    above = link.parent
    for _ in by_name:
        if above is None or above not in by_name:
            return False
        if above == link.name:
            return True
        above = by_name[above].parent
    return False


def _check_follows(fields: Fields, link: LinkData, by_name: Mapping[str, LinkData]) -> None:
    other = by_name.get(link.joint.follows[0]) if link.joint.follows else None
    if other is None or other is link or other.joint.kind != link.joint.kind:
        fields.wrong(
            f"links: {link.name} must follow another link whose joint is {link.joint.kind} too."
        )
    elif other.joint.follows:
        fields.wrong(f"links: {link.name} must follow a joint that follows none itself.")


def _in_order(links: Sequence[LinkData]) -> tuple[LinkData, ...]:
    """Return the links, parents before children, else as listed."""
    ordered: list[LinkData] = []
    while len(ordered) < len(links):
        done = {None, *(link.name for link in ordered)}
        ordered += [link for link in links if link.parent in done and link not in ordered]
    return tuple(ordered)
