"""Observations for the user's program, and the commands that it returns."""

import itertools
import math
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from numbers import Real
from typing import Any, NoReturn

import numpy as np

from ...inside.wire import HEADER, IMAGE, MAX_VALUE, command_limits, command_names

NUMBER = struct.Struct("<d")
FLOAT64 = np.float64
FLOATS = (float, FLOAT64)
VEHICLE = 4  # numbers of a command that are the vehicle's; the speeds of an arm's joints follow
COMMAND_NAMES = [
    "the surge",
    "the sway",
    "the heave",
    "the yaw rate",
]  # and joints, by `set_layout`
LIMITS = [MAX_VALUE] * VEHICLE  # of the magnitude of each


class AnswerInvalid(Exception):
    """A method returned something that is not an answer. The text is for the program's owner."""


class KeyMissing(KeyError):
    """A KeyError whose text is a sentence; its name is shown as that of its base."""

    def __str__(self) -> str:
        """Return the sentence without the quotes that KeyError adds."""
        return str(self.args[0])


KeyMissing.__name__ = KeyMissing.__qualname__ = "KeyError"
KeyMissing.__module__ = "builtins"


class ByCamera(dict):  # type: ignore[type-arg]
    """The newest images: a dict that says which cameras there are."""

    def __missing__(self, key: object) -> NoReturn:
        """Refuse a camera that is none, and name those that are."""
        raise KeyMissing(missing("images", key, self))


class Configuration(dict):  # type: ignore[type-arg]
    """The settings of the run, as a program gets them: a dict that says which keys it has."""

    def __missing__(self, key: object) -> NoReturn:
        """Refuse a key that is none, and name those that are."""
        raise KeyMissing(missing("config", key, self))


def missing(what: str, key: object, known: Iterable[str]) -> str:
    """Return a sentence about a key that does not exist."""
    return f"{what} has no key {key!r}; it has {', '.join(sorted(known))}"


class Observation(Mapping):  # type: ignore[type-arg]
    """The vehicle's measurements: `observation.depth` or `observation["depth"]`, read-only.

    Numbers are float or bool, vectors and images are read-only NumPy arrays. Each field is a
    property, which takes a third of the time of `__getattr__`.
    """

    __slots__ = ("_cache", "_data")
    _fields: dict[str, Callable[["Observation"], object]] = {}  # noqa: RUF012  (set once, from the layout)

    _data: bytes
    _cache: dict[str, object]

    def __init__(self, data: bytes) -> None:
        set_data(self, data)
        set_cache(self, {})

    def __getitem__(self, name: str) -> object:
        """Return a field; vectors as read-only arrays."""
        try:
            field = self._fields[name]
        except KeyError:
            raise KeyMissing(missing("the observation", name, self._fields)) from None
        return field(self)

    def __getattr__(self, name: str) -> object:
        """Refuse what is no field."""
        known = ", ".join(self._fields)
        raise AttributeError(f"an observation has no {name!r}; it has {known}")

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse."""
        raise AttributeError("an observation cannot be changed")

    def __delattr__(self, name: str) -> None:
        """Refuse."""
        raise AttributeError("an observation cannot be changed")

    def __iter__(self) -> Iterator[str]:
        """Return the names of the fields."""
        return iter(self._fields)

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(self._fields)

    def __repr__(self) -> str:
        """Return all fields with their values."""
        return "Observation(" + ", ".join(f"{name}={self[name]}" for name in self) + ")"


# `__setattr__` refuses, and object.__setattr__ is slower than these.
set_data: Callable[[Observation, bytes], None] = Observation._data.__set__  # type: ignore[attr-defined]
set_cache: Callable[[Observation, dict[str, object]], None]
set_cache = Observation._cache.__set__  # type: ignore[attr-defined]


def set_layout(layout: dict[str, list], memory: Any = None) -> None:  # type: ignore[type-arg]
    """Set where each field of an observation is in its message, and what a command has.

    `memory` are the `Images` of a program that is given some.
    """
    offset = HEADER.size
    booleans = set(layout.get("booleans", ()))
    for name, count in layout.get("observation", ()):
        read = _vector(name, offset, count) if count else _number(offset, name in booleans)
        Observation._fields[name] = read
        setattr(Observation, name, property(read))
        offset += 8 * (count or 1)
    if cameras := [name for name, *_size in layout.get("images", ())]:
        Observation._fields["images"] = read = _images(cameras, offset, memory)
        setattr(Observation, "images", property(read))  # noqa: B010  (as above)
    COMMAND_NAMES[VEHICLE:] = [f"the joint {name}" for name in command_names(layout)[VEHICLE:]]
    LIMITS[VEHICLE:] = command_limits(layout)[VEHICLE:]


def _vector(name: str, offset: int, count: int) -> Callable[[Observation], object]:
    def read(observation: Observation) -> object:
        cache = observation._cache
        if name not in cache:
            cache[name] = np.frombuffer(observation._data, FLOAT64, count, offset)
        return cache[name]

    return read


def _images(cameras: list[str], offset: int, memory: Any) -> Callable[[Observation], object]:
    places = {name: offset + IMAGE.size * number for number, name in enumerate(cameras)}

    def read(observation: Observation) -> object:
        cache, data = observation._cache, observation._data
        if "images" not in cache:
            newest = {name: memory.image(data, at) for name, at in places.items()}
            cache["images"] = ByCamera(newest)
        return cache["images"]

    return read


def _number(offset: int, boolean: bool) -> Callable[[Observation], object]:
    def read(observation: Observation) -> object:
        (value,) = NUMBER.unpack_from(observation._data, offset)
        return bool(value) if boolean else value

    return read


def as_command(answer: Any) -> Sequence[float]:
    """Return the floats of a command; AnswerInvalid says what was returned instead."""
    values = answer if type(answer) is list else as_list(answer)
    if len(values) not in {VEHICLE, len(COMMAND_NAMES)}:
        raise AnswerInvalid(f"step returned {len(values)} values")
    if len(values) == VEHICLE:
        rest = (0.0,) * (len(COMMAND_NAMES) - VEHICLE)  # of an arm
        a, b, c, d = values
        if type(a) in FLOATS and type(b) in FLOATS and type(c) in FLOATS and type(d) in FLOATS:
            a, b, c, d = four = float(a), float(b), float(c), float(d)
            most = MAX_VALUE
            small = -most <= a <= most and -most <= b <= most
            if small and -most <= c <= most and -most <= d <= most:
                return four + rest  # the usual case, and the fast one
    elif all(map(_is_usual, values, LIMITS)):
        return tuple(map(float, values))
    numbers = tuple(as_number(index, value) for index, value in enumerate(values))
    return numbers if len(numbers) > VEHICLE else numbers + rest


def _is_usual(value: Any, most: float) -> bool:
    return type(value) in FLOATS and -most <= value <= most


def as_list(answer: Any) -> list[Any]:
    """Return the values of an answer that is no plain list; AnswerInvalid if it has none."""
    if isinstance(answer, np.ndarray):
        if answer.shape not in {(VEHICLE,), (len(COMMAND_NAMES),)}:
            raise AnswerInvalid(f"step returned an array of shape {answer.shape}")
        if answer.dtype.kind not in "fiu":
            raise AnswerInvalid(f"step returned an array of {answer.dtype}")
        return list(answer.tolist())
    if answer is None:
        raise AnswerInvalid("step returned None (is a return missing?)")
    if not isinstance(answer, (list, tuple)):
        raise AnswerInvalid(f"step returned a value of type {type(answer).__name__}")
    wanted = len(COMMAND_NAMES)
    values = list(itertools.islice(answer, wanted + 1))  # a user-defined list may be endless
    if len(values) not in {VEHICLE, wanted}:
        count = len(answer) if len(answer) not in {VEHICLE, wanted} else f"more than {wanted}"
        raise AnswerInvalid(f"step returned {count} values")
    return values


def as_number(index: int, value: Any) -> float:
    """Return one value of a command as a float."""
    if isinstance(value, np.ndarray) and value.shape == ():
        value = value.item()
    if not isinstance(value, Real):
        raise AnswerInvalid(
            f"step returned a value of type {type(value).__name__} for {COMMAND_NAMES[index]}"
        )
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not abs(number) <= LIMITS[index]:  # also catches NaN
        beyond = f", beyond its limit of {LIMITS[index]:g}" if index >= VEHICLE else ""
        raise AnswerInvalid(f"step returned {number} for {COMMAND_NAMES[index]}{beyond}")
    return number
