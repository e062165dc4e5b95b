"""What control steps change in a fleet: all that has to be kept to go on from there.

What a vehicle is made of is no part of it: that follows from seed, trial and level. Fields of
records that are settings are none either, so no file can change them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.engine.tracker_in_loop import TrackerInLoop
from seamark.sim.engine.world import World
from seamark.sim.fleet.fleet import Fleet
from seamark.sim.fleet.images import FleetImages
from seamark.sim.fleet.tables import Tables
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.physics.contact import Contact
from seamark.sim.registry import TRUTH
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.trackers.template.frame_step import next_window, unpack_state
from seamark.sim.trackers.template.tracker import TemplateTracker

Arrays = Mapping[str, NDArray[Any]]
Views = dict[str, NDArray[Any]]
COPIED = (TRUTH, "esm")  # trackers whose state is known; OpenCV's and ViSP's keep theirs
_ANY = -1  # length of an axis
_TRACKER_NUMBERS = 29  # that a template tracker changes, see `Memory._tracker`
_SEARCH = 27  # index of the search margin among them
_FINITE = float(np.finfo(np.float64).max)
_LARGEST = 1e6  # [px] or without unit, of those numbers; a tracker that works stays far below
_READING = ("slot", "readings", "measured_at", "values", "valid")  # fields that a step changes
_ERROR = ("error", "error_px", "age_s", "visible")
_MEASURED = ("velocity", "depth", "yaw", "yaw_rate", "fresh", "tilt", "tilt_rates")
_ESTIMATE = ("velocity", "disturbance", "thrust")
_HOLD = ("target", "force")
_OUTPUTS = (  # but not `touching`, which only a step knows
    *("corners", "visible", "rows", "observation", "reward"),
    *("diverged", "contact_n", "pose"),
)


class MemoryInvalid(ValueError):
    """Arrays are not what a fleet has kept, or it cannot keep all; the text says why."""


class Memory:
    """What the vehicles of a fleet have in mind: copied, and given to others of the like."""

    def __init__(
        self, fleet: Fleet, config: StationKeepingSettings, images: FleetImages | None
    ) -> None:
        """Take a fleet, its configuration and, if it has any, its images."""
        self._fleet, self._images = fleet, images
        self._tracks = config.tracker != TRUTH
        self._size = config.camera_width_px, config.camera_height_px
        options: Mapping[str, Any] = config.tracker_options()
        self._search_px = max(options.get(name, 0.0) for name in ("search_px", "reacquire_px"))
        self._last_frame = len(config.levels) * fleet.steps_per_level
        self._refused = ""
        if config.tracker not in COPIED:
            self._refused = f"the tracker {config.tracker} keeps what nobody can copy"
        elif config.contact_engine() == "pybullet":
            self._refused = "PyBullet (contacts) keeps what nobody can copy"

    def save(self) -> Views:
        """Return copies of all that control steps change, by name; the first index is the vehicle.

        With what `Fleet.place` was given, the future of the vehicles depends on nothing else.

        Raises
        ------
        MemoryInvalid
            The trackers or the engine of contacts keep more than can be copied.
        """
        self._refuse()
        kept = {name: view.copy() for name, view in self._views().items()}
        kept["contacts"] = _joined(
            [contact.impulses() if contact else np.zeros((0, 3)) for contact in self._contacts()]
        )
        if self._tracks:
            every = range(self._fleet.count)
            kept["trackers"] = np.array([np.concatenate(self._tracker(i)) for i in every])
        return kept

    def check(self, kept: Arrays, count: int, *, going: Flags) -> None:
        """Make sure that arrays are those of `count` vehicles of such a fleet.

        `going`, (count,), tells whose levels are to go on. What compiled code takes for an index or
        a number of repetitions has to be within its bounds, whoever wrote the arrays.

        Raises
        ------
        MemoryInvalid
            They are not; or as in `save`.
        """
        self._refuse()
        for name, view in self._views().items():
            _expect(kept, name, (count, *view.shape[1:]), view.dtype)
        _expect(kept, "contacts", (count, _ANY, 3), np.float64)
        _within(kept, "progress.step", 0, self._fleet.steps_per_level)
        if (going & (kept["progress.step"] == self._fleet.steps_per_level)).any():
            raise MemoryInvalid("a vehicle is to go on after the end of its level")
        for name, noise in self._fleet.tables.instruments.noises._asdict().items():
            _within(kept, f"{name}.readings", 0, noise.shape[1])
        if self._images is not None:
            _within(kept, "images.motions", -_FINITE, _FINITE)
            _within(kept, "images.frames", 0, self._last_frame)
        if self._tracks:
            _expect(kept, "trackers", (count, _TRACKER_NUMBERS), np.float64)
            _within(kept, "trackers", -_LARGEST, _LARGEST)
            if (kept["trackers"][:, _SEARCH] > self._search_px).any():
                raise MemoryInvalid(f"a tracker searches farther than {self._search_px:g} px")

    def restore(self, kept: Arrays, source: Integers) -> None:
        """Let each vehicle be as the vehicle `source`, (n,), of arrays that were checked.

        It must have begun the level that the other one was in.
        """
        for name, view in self._views().items():
            view[...] = kept[name][source]
        for i, (contact, k) in enumerate(zip(self._contacts(), source, strict=True)):
            if contact is not None:
                contact.start_from(kept["contacts"][k])
            if self._tracks:
                self._give_tracker(i, kept["trackers"][k])

    def _refuse(self) -> None:
        if self._refused:
            raise MemoryInvalid(self._refused)

    def _views(self) -> Views:
        found = _changing(self._fleet.tables)
        if self._images is not None:
            found |= {f"images.{name}": view for name, view in self._images.changing().items()}
        return found

    def _contacts(self) -> list[Contact | None]:
        return [craft.contact if craft else None for craft in self._fleet.craft]

    def _tracker(self, i: int) -> tuple[Array, ...]:
        """Return what a tracker changes from image to image, each (k,): views."""
        state = unpack_state(self._template_tracker(i).memory().state)
        found = state.homography, state.motion, state.last, state.similarity, state.reach[:1]
        return *(each.reshape(-1) for each in found), state.lost

    def _give_tracker(self, i: int, numbers: Array) -> None:
        """Let a tracker have these numbers, as `_tracker` has them, and read its next window."""
        begin = 0
        for view in self._tracker(i):
            view[:] = numbers[begin : begin + view.size]
            begin += view.size
        memory = self._template_tracker(i).memory()
        memory.window[:] = next_window(memory.state, *self._size)

    def _template_tracker(self, i: int) -> TemplateTracker:
        world = self._fleet.craft[i]
        tracking = world.tracking if isinstance(world, World) else None
        tracker = tracking.tracker if isinstance(tracking, TrackerInLoop) else None
        if not isinstance(tracker, TemplateTracker):
            raise LookupError("a vehicle that never began has no tracker")
        return tracker


def _changing(tables: Tables) -> Views:
    """Return what control steps change in the tables, by name: views."""
    _, motion, instruments, controllers, progress, outputs = tables
    records: dict[str, tuple[Any, tuple[str, ...]]] = {
        name: (each, _READING) for name, each in instruments.records._asdict().items()
    }
    records |= {
        "keeper": (instruments.keeper, _ERROR),
        "measured": (controllers.measured, _MEASURED),
        "axes": (controllers.axes, _ESTIMATE),
        "holds": (controllers.holds, _HOLD),
    }
    found = {
        f"{name}.{field}": record[field]
        for name, (record, fields) in records.items()
        for field in fields
    }
    found |= {f"outputs.{name}": getattr(outputs, name) for name in _OUTPUTS}
    return found | {
        "motion.state": motion.state,
        "motion.command": motion.command,
        "motion.thrust": motion.thrust,
        "progress.step": progress.step,
        "progress.images": progress.images,
        "progress.commands": progress.commands,
    }


def _expect(kept: Arrays, name: str, shape: tuple[int, ...], dtype: Any) -> None:
    if name not in kept:
        raise MemoryInvalid(f"it has no {name}")
    array = kept[name]
    fits = len(shape) == array.ndim and all(
        wanted in (_ANY, length) for wanted, length in zip(shape, array.shape, strict=True)
    )
    if not fits or array.dtype != dtype:
        wanted = f"{np.dtype(dtype)} of shape {shape}"
        raise MemoryInvalid(f"{name} is {array.dtype} of shape {array.shape}, not {wanted}")


def _within(kept: Arrays, name: str, least: float, most: float) -> None:
    array = kept[name]
    if not ((least <= array) & (array <= most)).all():
        raise MemoryInvalid(f"{name} is not from {least:g} to {most:g}")


def _joined(rows: Sequence[Array]) -> Array:
    """Return arrays (k, 3) of vehicles as one, (n, most, 3), with zeros where one has fewer."""
    out = np.zeros((len(rows), max(map(len, rows)), 3))
    for i, row in enumerate(rows):
        out[i, : len(row)] = row
    return out
