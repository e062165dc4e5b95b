"""Scene updaters that nest into a grid: each varies one setting from point to point.

Each level is then a point of the grid. The outermost loop varies slowest, as in nested for loops;
the benchmark's own levels are the outermost loop, unless one of the loops sets the same quantity.
"""

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any, Self

from seamark.sim.metrics.metric import Metric
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import setting

MAX_POINTS = 60
MAX_DURATION_S = (
    7200.0  # [s] simulated, all points of a trial together: what twelve long levels take
)
NONE = "none"
SPEED = "current_speed"
MAX_VALUES = 12


@dataclass(frozen=True, slots=True)
class Updater:
    """What a loop varies: `sets` returns the settings for one of its values."""

    quantity: Metric  # name, label and unit of the value
    sets: Callable[[float], Mapping[str, object]]


def _one(setting: str) -> Callable[[float], Mapping[str, object]]:
    return lambda value: {setting: value}


def _turbid(value: float) -> Mapping[str, object]:
    return {"water_type": "grey", "water_attenuation_1_m": value}


UPDATERS: Mapping[str, Updater] = {
    SPEED: Updater(Metric(SPEED, "Current", "m/s", "higher"), lambda _value: {}),
    "current_azimuth": Updater(
        Metric("current_azimuth", "Direction of the current", "rad", "higher"),
        _one("current_azimuth_rad"),
    ),
    "current_gust": Updater(
        Metric("current_gust", "Gusts relative to the current", "", "higher"), _one("current_gust")
    ),
    "turbidity": Updater(
        Metric("turbidity", "Attenuation of grey water", "1/m", "higher"), _turbid
    ),
    "light": Updater(
        Metric("light", "Daylight relative to the standard", "", "higher"), _one("light_level")
    ),
    "snow": Updater(Metric("snow", "Marine snow", "1/m³", "higher"), _one("snow_per_m3")),
    "camera_noise": Updater(
        Metric("camera_noise", "Camera noise", "grey", "higher"), _one("camera_noise_grey")
    ),
    "altitude": Updater(Metric("altitude", "Camera altitude", "m", "higher"), _one("altitude_m")),
    "dvl_noise": Updater(Metric("dvl_noise", "DVL noise", "m/s", "higher"), _one("dvl_sigma_m_s")),
    "dvl_dropout": Updater(
        Metric("dvl_dropout", "DVL drop-outs, fraction", "", "higher"), _one("dvl_dropout")
    ),
    "repeat": Updater(Metric("repeat", "Repetition", "", "higher"), lambda _value: {}),
}


def _choice(what: Metric) -> str:
    return f"{what.label} [{what.unit}]" if what.unit else what.label


CHOICES = {NONE: "Nothing"} | {name: _choice(one.quantity) for name, one in UPDATERS.items()}
grid_setting = partial(setting, group="Grid", role="scenario", advanced=True)


def _loop(title: str, help: str) -> Any:  # as setting itself
    return grid_setting(NONE, title=title, help=help, choices=CHOICES)


def _values(loop: str) -> Any:  # as setting itself
    return grid_setting(
        (),
        title=f"Values of the {loop}",
        help="Separated by commas, in order; a repetition takes one number, the count.",
        low=-1000,
        high=2000,
        length=(0, MAX_VALUES),
    )


class GridSettings(Configuration):
    """Up to three nested loops."""

    loop1: str = _loop(
        "First loop",
        "Runs at each current level; a loop over the current speed replaces them.",
    )
    loop1_values: tuple[float, ...] = _values("first loop")
    loop2: str = _loop("Second loop", "Runs at each value of the first loop.")
    loop2_values: tuple[float, ...] = _values("second loop")
    loop3: str = _loop("Third loop", "Runs at each value of the second loop.")
    loop3_values: tuple[float, ...] = _values("third loop")

    @abstractmethod
    def base_levels(self) -> tuple[float, ...]:
        """Return the benchmark's levels: mean speeds [m/s] of the current."""

    def points(self) -> tuple[dict[str, float], ...]:
        """Return name of the updater -> value for each level, in order."""
        loops = list(self._loops())
        names = [name for name, _ in loops]
        if SPEED not in names:
            loops.insert(0, (SPEED, self.base_levels()))
            names.insert(0, SPEED)
        return tuple(
            dict(zip(names, values, strict=True)) for values in product(*(v for _, v in loops))
        )

    def grid_point(self, level: int) -> dict[str, float]:
        """Return name of the updater -> value at a level; empty without a grid."""
        return self.points()[level] if self.has_grid() else {}

    def has_grid(self) -> bool:
        """Return whether there is any loop."""
        return any(getattr(self, f"loop{i}") != NONE for i in (1, 2, 3))

    def at(self, level: int) -> Self:
        """Return the configuration of one level, with what the loops set there."""
        return self.model_copy(update=_settings(self.grid_point(level)))

    def _loops(self) -> Iterator[tuple[str, Sequence[float]]]:
        for i in (1, 2, 3):
            name, values = getattr(self, f"loop{i}"), getattr(self, f"loop{i}_values")
            if name == "repeat":
                yield name, tuple(float(n) for n in range(1, 1 + int(values[0]))) if values else ()
            elif name != NONE:
                yield name, values

    def grid_errors(self) -> dict[str, str]:
        """Return setting -> message for invalid loops."""
        errors = self._loop_errors()
        if errors or not self.has_grid():
            return errors
        count = len(self.points())
        if count > MAX_POINTS:
            return {
                "loop1_values": f"The grid has {count} points; at most {MAX_POINTS} are allowed."
            }
        if self.trial_duration_s() > MAX_DURATION_S:
            return {
                "loop1_values": (
                    f"The grid takes {self.trial_duration_s():g} s of simulated time; at most "
                    f"{MAX_DURATION_S:g} s are allowed. Use fewer points or shorter levels."
                )
            }
        return self._point_errors()

    def _loop_errors(self) -> dict[str, str]:
        errors: dict[str, str] = {}
        seen: set[str] = set()
        for i in (1, 2, 3):
            name, values = getattr(self, f"loop{i}"), getattr(self, f"loop{i}_values")
            if name == NONE:
                if values:
                    errors[f"loop{i}"] = (
                        f"loop{i} has values but nothing to vary: choose what it varies."
                    )
                continue
            if name in seen:
                errors[f"loop{i}"] = f"loop{i} varies {name}, which an outer loop varies already."
            seen.add(name)
            if reason := _why_no_loop(name, values):
                errors[f"loop{i}_values"] = f"loop{i}_values {reason}"
        return errors

    def _point_errors(self) -> dict[str, str]:
        """Return the message about the first value of a loop that its setting does not allow."""
        plain = self.model_dump()
        for i in (1, 2, 3):
            plain |= {f"loop{i}": NONE, f"loop{i}_values": ()}
        before = self._wrong(plain).keys()  # errors without the loops
        for i in (1, 2, 3):
            for value in getattr(self, f"loop{i}_values"):
                sets = _settings({getattr(self, f"loop{i}"): value})
                wrong = self._wrong(plain | sets)
                messages = " ".join(text for name, text in wrong.items() if name not in before)
                if messages:
                    return {f"loop{i}_values": f"loop{i}_values, {value:g}: {messages}"}
        return {}

    def _wrong(self, values: Mapping[str, object]) -> dict[str, str]:
        """Return setting -> message for what is wrong with values."""
        try:
            type(self).read(values)
        except ConfigurationInvalid as wrong:
            return dict(wrong.errors)
        return {}


def _settings(point: Mapping[str, float]) -> dict[str, object]:
    """Return the settings of a point of the grid."""
    result: dict[str, object] = {}
    for name, value in point.items():
        result |= UPDATERS[name].sets(value)
    return result


def _why_no_loop(name: str, values: Sequence[float]) -> str:
    if not values:
        return "must have at least one value."
    if name == "repeat" and (len(values) > 1 or not 1 <= values[0] <= MAX_VALUES or values[0] % 1):
        return f"must be one whole number from 1 to {MAX_VALUES} for a repetition."
    if name == SPEED and not all(0 <= value <= 1 for value in values):
        return "must be from 0 to 1 m/s for the current."
    return ""


def _quantity(name: str) -> Metric:
    """Return what an updater changes; a stored run may name one that no longer exists."""
    return UPDATERS[name].quantity if name in UPDATERS else Metric(name, name, "", "higher")


def describe(point: Mapping[str, float]) -> str:
    """Return a point of the grid in words, such as "Current 0.2 m/s, Repetition 2"."""
    parts = ((_quantity(name), value) for name, value in point.items())
    return ", ".join(f"{what.label} {value:g} {what.unit}".strip() for what, value in parts)


def level_names(config: Configuration) -> tuple[str, ...]:
    """Return a short name for each level, such as "0.2 · 1.5" in a grid.

    Empty if its value and unit say enough.
    """
    if not isinstance(config, GridSettings) or not config.has_grid():
        return config.level_names()
    return tuple(" · ".join(f"{value:g}" for value in point.values()) for point in config.points())


def axes(config: Configuration) -> str:
    """Return the quantities and units in `level_names`; empty without a grid."""
    if not isinstance(config, GridSettings) or not config.has_grid():
        return ""
    return " · ".join(_choice(_quantity(name)) for name in config.grid_point(0))


def level_comments(config: Configuration) -> list[str]:
    """Return a line for each level for the head of a table: what it sets."""
    if isinstance(config, GridSettings) and config.has_grid():
        described = [describe(point) for point in config.points()]
    elif names := config.level_names():
        described = list(names)
    else:
        what = config.level_metric()
        described = [
            f"{what.label} {value:g} {what.unit}".strip() for value in config.level_values()
        ]
    return [f"level {level}: {text}" for level, text in enumerate(described)]
