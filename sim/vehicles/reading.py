"""A vehicle's file, checked: the one gate for vehicles, whoever wrote them.

The file is data: reading it runs nothing, opens no other file but the vehicle of ours that it
extends, and takes bounded time. Every mistake becomes a sentence that names the key and says what
to do. `docs/vehicles.md` describes the format.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

from seamark.sim.vehicles.fields import (
    Fields,
    FileInvalid,
    Slot,
    Table,
    number,
    quoted,
    vector,
)
from seamark.sim.vehicles.model import (
    AXES,
    HullBox,
    Place,
    Quantity,
    ThrustCurve,
    Thruster,
    Vehicle,
)
from seamark.sim.vehicles.place_fields import PLACE_KEYS, read_place
from seamark.sim.vehicles.solid_fields import read_solid
from seamark.sim.vehicles.toml_reading import TomlRefused, read_toml

FORMAT = 1
THRUSTERS_MAX, HULL_MAX, SOLIDS_MAX, DEFAULTS_MAX, MOUNTS_MAX = 20, 64, 256, 50, 16
COEFFICIENTS_MAX = 6  # of the compiled curve
_SETTING = re.compile(r"[a-z][a-z0-9_]{0,60}")
TOP_KEYS = (
    *("format", "name", "title", "summary", "extends", "sources", "body", "thrust", "thrusters"),
    *("hull", "drawing", "defaults", "mounts"),
)


class VehicleInvalid(FileInvalid):
    """A vehicle's file breaks rules."""


_BODY = {
    "mass": number("mass", "kg", above=0.0),
    "inertia": vector("inertia about the centre of gravity", "kg m²", above=0.0),
    "weight": number("weight in air", "N", above=0.0),
    "buoyancy": number("weight of the displaced water", "N", low=0.0),
    "centre_of_gravity": vector("centre of gravity", "m"),
    "centre_of_buoyancy": vector("centre of buoyancy", "m"),
}
# key -> meanings and units of the groups of x, y, z and of roll, pitch, yaw
_GROUPS = {
    "added_mass": (("added mass", "kg"), ("added inertia", "kg m²")),
    "drag_linear": (("linear drag {}", "N s/m"), ("linear drag {}", "N m s")),
    "drag_quadratic": (("quadratic drag {}", "N s²/m²"), ("quadratic drag {}", "N m s²")),
}
BODY_KEYS = (*_BODY, *_GROUPS)
THRUST_KEYS = ("kind", "forward", "reverse", "dead_band", "limits", "lag")
_LAG = number("time constant of the thrust", "s", above=0.0)
_DEAD_BAND = number("commands up to this give no thrust", "1", low=0.0)
_LIMITS = Slot("greatest thrust forward, reverse", "N", range(2, 3), above=0.0)
_COEFFICIENTS = range(2, COEFFICIENTS_MAX + 1)
_CURVES = {
    "quadratic": (
        number("thrust at full command", "N", above=0.0),
        number("thrust at full reverse command", "N", above=0.0),
    ),
    "polynomial": (
        Slot("command as a polynomial of the forward thrust", "1/N^i", _COEFFICIENTS),
        Slot("command as a polynomial of the reverse thrust", "1/N^i", _COEFFICIENTS),
    ),
}
_NOZZLE_M = 0.05


def read_vehicle(content: bytes, *, base: Callable[[str], Vehicle]) -> Vehicle:
    """Return the vehicle of a file.

    Parameters
    ----------
    base
        Returns the vehicle that a file extends, by its name; LookupError if there is none.

    Raises
    ------
    VehicleInvalid
        With a sentence for each mistake.
    """
    try:
        document = read_toml(content)
    except TomlRefused as reason:
        raise VehicleInvalid([str(reason)]) from None
    reader = _Reader(document)
    vehicle = reader.vehicle(base)
    if reader.errors:
        raise VehicleInvalid(reader.errors)
    return vehicle


class _Reader(Fields):
    """Reads the tables of a vehicle."""

    def vehicle(self, base: Callable[[str], Vehicle]) -> Vehicle:
        document = self.document
        self.known("", document, TOP_KEYS)
        if document.get("format") != FORMAT:
            self.wrong(f"format must be {FORMAT}: write format = {FORMAT} in the first line.")
        extended = self._extended(base)
        parts = self._body(extended) | self._thrust(extended) | self._drawing(extended)
        for key, read in (
            ("thrusters", self._thrusters),
            ("hull", self._hull),
            ("defaults", self._defaults),
            ("mounts", self._mounts),
        ):
            inherited = extended is not None and key not in document
            parts[key] = getattr(extended, key) if inherited else read()
        return Vehicle(
            name=self.name(document),
            title=self.text("", document, "title"),
            summary=self.text("", document, "summary"),
            **parts,
        )

    def _extended(self, base: Callable[[str], Vehicle]) -> Vehicle | None:
        if "extends" not in self.document:
            return None
        name = self.text("", self.document, "extends")
        try:
            return base(name)
        except LookupError as reason:
            self.wrong(
                f"extends: {reason.args[0]}. Write the name of a vehicle of Seamark, not of a file."
            )
            return None

    def _body(self, extended: Vehicle | None) -> dict[str, Any]:
        table = self.table("", self.document, "body", required=extended is None)
        self.known("body", table, BODY_KEYS)
        body: dict[str, Any] = {}
        for key, slot in _BODY.items():
            inherited = extended is not None and key not in table
            more = ("about",) if key == "inertia" else ()
            body[key] = (
                getattr(extended, key)
                if inherited
                else self.quantity("body", table, key, slot, more)
            )
        for key in _GROUPS:
            inherited = extended is not None and key not in table
            body[key] = getattr(extended, key) if inherited else self._groups(table, key)
        return body | {"inertia_point": self._inertia_point(table, extended)}

    def _inertia_point(self, body: Table, extended: Vehicle | None) -> str:
        if extended is not None and "inertia" not in body:
            return extended.inertia_point
        inertia = body.get("inertia")
        about = inertia.get("about", "gravity") if isinstance(inertia, dict) else "gravity"
        return self.choice("body.inertia.about", about, ("gravity", "origin"))

    def _groups(self, table: Table, key: str) -> tuple[Quantity, ...]:
        """Return quantities that together have x, y, z, roll, pitch and yaw in this order."""
        path, groups = f"body.{key}", []
        axes: list[str] = []
        for at, entry in enumerate(self.tables("body", table, key, len(AXES)), start=1):
            given = self._axes(f"{path} {at}", entry)
            meaning, unit = _GROUPS[key][AXES.index(given[0]) // 3]
            count = range(len(given), len(given) + 1)
            slot = Slot(meaning.format(", ".join(given)), unit, count, low=0.0)
            groups.append(self.read_quantity(f"{path} {at}", entry, slot, ("axes",)))
            axes += given
        if axes and axes != list(AXES):
            self.wrong(
                f"{path} must have the axes {', '.join(AXES)}, each once and in this order, not "
                f"{', '.join(axes)}."
            )
        return tuple(groups)

    def _axes(self, path: str, entry: Table) -> list[str]:
        """Return the axes of a group: some of x, y, z, or some of roll, pitch, yaw."""
        given = entry.get("axes")
        for own in (AXES[:3], AXES[3:]):
            if isinstance(given, list) and 0 < len(given) <= 3 and all(one in own for one in given):
                return given
        self.wrong(f"{path}: axes must be a list of x, y, z, or of roll, pitch, yaw.")
        return ["x"]

    def _thrust(self, extended: Vehicle | None) -> dict[str, Any]:
        table = self.table("", self.document, "thrust", required=extended is None)
        self.known("thrust", table, THRUST_KEYS)
        if extended is not None and "lag" not in table:
            lag = extended.lag
        else:
            lag = self.quantity("thrust", table, "lag", _LAG)
        if extended is not None and not table.keys() - {"lag"}:
            return {"curve": extended.curve, "lag": lag}
        return {"curve": self._curve(table), "lag": lag}

    def _curve(self, table: Table) -> ThrustCurve:
        kind = self.choice("thrust.kind", table.get("kind"), tuple(_CURVES))
        forward, reverse = _CURVES[kind]
        curve = ThrustCurve(
            kind="quadratic" if kind == "quadratic" else "polynomial",
            forward=self.quantity("thrust", table, "forward", forward),
            reverse=self.quantity("thrust", table, "reverse", reverse),
            dead_band=self.quantity("thrust", table, "dead_band", _DEAD_BAND),
            limits=self.quantity("thrust", table, "limits", _LIMITS),
        )
        if curve.dead_band.scalar >= 1.0:
            self.wrong("thrust.dead_band.value must be below 1: commands are from -1 to 1.")
        return curve

    def _thrusters(self) -> tuple[Thruster, ...]:
        thrusters = []
        slot = vector("position of the thruster", "m")
        for path, entry in self.named("thrusters", THRUSTERS_MAX):
            self.known(path, entry, ("name", "position", "direction"))
            position = self.quantity(path, entry, "position", slot)
            direction = self.direction(f"{path}.direction", entry.get("direction"))
            thrusters.append(Thruster(name=entry["name"], position=position, direction=direction))
        return tuple(thrusters)

    def _hull(self) -> tuple[HullBox, ...]:
        boxes = []
        for path, entry in self.named("hull", HULL_MAX):
            self.known(path, entry, ("name", "centre", "size"))
            centre = self.quantity(path, entry, "centre", vector("centre of the hull", "m"))
            slot = vector("box around the hull", "m", above=0.0)
            size = self.quantity(path, entry, "size", slot)
            boxes.append(HullBox(name=entry["name"], centre=centre, size=size))
        return tuple(boxes)

    def _drawing(self, extended: Vehicle | None) -> dict[str, Any]:
        table = self.table("", self.document, "drawing", required=False)
        self.known("drawing", table, ("nozzle_radius_m", "solids"))
        radius = _NOZZLE_M if extended is None else extended.nozzle_radius_m
        if "nozzle_radius_m" in table:
            radius = self.plain("drawing.nozzle_radius_m", table["nozzle_radius_m"], above=0.0)
        solids = () if extended is None else extended.solids
        if "solids" in table:
            entries = self.tables("drawing", table, "solids", SOLIDS_MAX)
            solids = tuple(
                read_solid(self, f"drawing.solids {at}", one)
                for at, one in enumerate(entries, start=1)
            )
        return {"nozzle_radius_m": radius, "solids": solids}

    def _defaults(self) -> Mapping[str, object]:
        table = self.table("", self.document, "defaults", required=False)
        if len(table) > DEFAULTS_MAX:
            self.wrong(f"defaults: there are {len(table)}; at most {DEFAULTS_MAX} are read.")
            return {}
        for key, value in table.items():
            if not _SETTING.fullmatch(key):
                self.wrong(f"defaults: {quoted(key)} is not the name of a setting.")
            elif isinstance(value, str):
                self.text("defaults", table, key)
            elif not isinstance(value, bool):
                self.plain(f"defaults.{key}", value)
        return dict(table)

    def _mounts(self) -> Mapping[str, Place]:
        table = self.table("", self.document, "mounts", required=False)
        if len(table) > MOUNTS_MAX:
            self.wrong(f"mounts: there are {len(table)}; at most {MOUNTS_MAX} are read.")
            return {}
        mounts = {}
        for arm in table:
            if not self.is_name("mounts: the name of an arm", arm):
                continue
            path, entry = f"mounts.{arm}", self.table("mounts", table, arm, required=True)
            self.known(path, entry, PLACE_KEYS)
            if "place" not in entry:
                self.wrong(f"{path}.place is missing: write where the arm is put.")
            mounts[arm] = read_place(self, path, entry)
        return mounts
