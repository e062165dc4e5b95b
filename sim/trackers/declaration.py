"""How a tracker declares itself: label, options, and what it does not support.

Light: a declaration names the code of its tracker, and loads it only when a run needs it. Detectors
declare themselves alike.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pkgutil import resolve_name
from typing import Generic, TypeVar

from seamark.sim.trackers.interface import Tracker

Made_co = TypeVar("Made_co", covariant=True)
OptionValues = Mapping[str, object]
Errors = dict[str, str]  # option -> sentence


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """An option of a tracker or detector; a setting of the same name is made from it.

    Several may share an option. Its type is that of the default. `applies` restricts it to values
    of other options.
    """

    name: str
    default: bool | int | float | str
    title: str
    help: str
    unit: str = ""
    low: float | None = None  # of a number: allowed range, both ends included
    high: float | None = None
    choices: Mapping[str, str] = field(default_factory=dict)  # value -> label
    tag: str = ""
    source: str = ""
    advanced: bool = False
    applies: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def error(self, value: object) -> str:
        """Return why a value is not allowed; empty if it is."""
        if self.choices and value not in self.choices:
            return f"{self.name} must be one of {', '.join(self.choices)}, not {value!r}."
        if self.low is not None and self.high is not None:
            if not (isinstance(value, int | float) and self.low <= value <= self.high):
                return f"{self.name} must be from {self.low:g} to {self.high:g}, not {value!r}."
        return ""


def number_option(
    name: str, default: float, *, low: float, high: float, title: str, help: str, unit: str = ""
) -> Option:
    """Return an option for experts whose default is our own estimate."""
    return Option(
        name=name,
        default=default,
        title=title,
        help=help,
        unit=unit,
        low=low,
        high=high,
        tag="E",
        source="chosen for our own tracker, by speed and precision",
        advanced=True,
    )


def _available() -> str:
    return ""


def _all_supported(_values: OptionValues) -> Errors:
    return {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Declaration(Generic[Made_co]):
    """A tracker or detector as the form offers it."""

    label: str
    path: str  # module:class of the code itself
    options: tuple[Option, ...] = ()
    exact: bool = True  # whether every x86-64 processor gives the same bits
    unavailable: Callable[[], str] = _available  # why this machine cannot run it; empty if it can
    # combinations of options that are not supported: option -> sentence
    unsupported: Callable[[OptionValues], Errors] = _all_supported

    @property
    def option_names(self) -> tuple[str, ...]:
        """The names of the options, in the form's order."""
        return tuple(option.name for option in self.options)

    def load(self) -> Callable[..., Made_co]:
        """Return the class; loads Numba, OpenCV or whatever else it needs."""
        made: Callable[..., Made_co] = resolve_name(self.path)
        return made

    def errors(self, values: OptionValues) -> Errors:
        """Return option -> why its value is not accepted; empty if all is well.

        Options without a value are not checked.
        """
        errors = {
            option.name: error
            for option in self.options
            if option.name in values and (error := option.error(values[option.name]))
        }
        return errors | self.unsupported(values)


class TrackerDeclaration(Declaration[Tracker]):
    """A tracker."""
