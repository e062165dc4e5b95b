"""The functions of a loaded FMU: the subset of FMI 2.0 and 3.0 co-simulation that is needed.

Declarations from the standards (fmi-standard.org: FMI 2.0.4, 2.2 and 4.2; FMI 3.0.1, 2.2 and 4.2).
"""

import ctypes as c
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .description import Description, Unusable, Variable

WARNING = 1  # fmi2Status, fmi3Status: 0 OK, 1 warning; all others end the run
CO_SIMULATION = 1  # fmi2Type
LOG_2 = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p)
LOG_3 = c.CFUNCTYPE(None, c.c_void_p, c.c_int, c.c_char_p, c.c_char_p)
TYPES_2 = {"Float64": ("Real", c.c_double), "Int32": ("Integer", c.c_int)}
TYPES_2 |= {"Boolean": ("Boolean", c.c_int)}
TYPES_3 = {"Float64": c.c_double, "Float32": c.c_float, "Int32": c.c_int32, "Boolean": c.c_bool}


class Callbacks2(c.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOG_2),
        ("allocate_memory", c.c_void_p),
        ("free_memory", c.c_void_p),
        ("step_finished", c.c_void_p),
        ("environment", c.c_void_p),
    )


def _print(message: bytes | None) -> None:
    print((message or b"").decode("utf-8", "replace"), file=sys.stderr, flush=True)


def _logged_2(_: object, name: object, status: object, category: object, message: bytes) -> None:
    _print(message)  # the format string as it is: ctypes callbacks cannot read variable arguments


def _logged_3(_: object, status: object, category: object, message: bytes) -> None:
    _print(message)


LOGGER_2, LOGGER_3 = LOG_2(_logged_2), LOG_3(_logged_3)


class Group:
    """Variables of one type, read or written by one call."""

    def __init__(self, call: Callable[..., None], number: Any, variables: Sequence[Variable]):
        count = sum(variable.count for variable in variables)
        self.values = (number * count)()
        self.real = number in (c.c_double, c.c_float)
        references = (c.c_uint * len(variables))(*(variable.reference for variable in variables))
        self._call, self._arguments = call, (references, len(variables), self.values)

    def transfer(self) -> None:
        """Call the function with the current values."""
        self._call(*self._arguments)


class Library(ABC):
    """One instance of an FMU; each method raises Unusable if the FMU reports an error."""

    def __init__(self, path: Path, description: Description, resources: Path) -> None:
        self.prefix = f"fmi{description.version}"
        self._description, self._resources = description, resources
        try:
            self._library = c.CDLL(str(path))
        except OSError as error:
            raise Unusable(f"The FMU's library cannot be loaded: {error}.") from None
        self.instance: Any = None

    def function(self, name: str, result: Any = c.c_int) -> Any:
        """Return a function of the library."""
        try:
            function = getattr(self._library, self.prefix + name)
        except AttributeError:
            raise Unusable(f"The FMU's library has no {self.prefix}{name}.") from None
        function.restype = result
        return function

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function on the instance."""
        status = self.function(name)(self.instance, *arguments)
        if status > WARNING:
            raise Unusable(f"{self.prefix}{name} returned status {status}.")

    def instantiate(self) -> None:
        """Create the instance."""
        token = self._description.token.encode()
        self.instance = c.c_void_p(self._instantiate(token))
        if not self.instance:
            raise Unusable(
                f"The FMU did not instantiate (the token of its description is {token.decode()})."
            )

    @abstractmethod
    def group(self, action: str, type_name: str, variables: Sequence[Variable]) -> Group:
        """Return a call that sets or gets all of these variables."""

    @abstractmethod
    def initialize(self, start_s: float, set_constants: Callable[[], None]) -> None:
        """Initialize a new instance, so that it can step."""

    @abstractmethod
    def step(self, t: float, dt: float) -> None:
        """Advance the model by dt [s]."""

    @abstractmethod
    def _instantiate(self, token: bytes) -> int | None:
        """Return the pointer to a new instance; None if there is none."""


class Library2(Library):
    """FMI 2.0."""

    def _instantiate(self, token: bytes) -> int | None:
        libc = c.CDLL(None)
        memory = [c.cast(function, c.c_void_p) for function in (libc.calloc, libc.free)]
        self._callbacks = Callbacks2(LOGGER_2, *memory, None, None)
        location = self._resources.as_uri().encode()
        instance: int | None = self.function("Instantiate", c.c_void_p)(
            b"controller", CO_SIMULATION, token, location, c.byref(self._callbacks), 0, 0
        )
        return instance

    def group(self, action: str, type_name: str, variables: Sequence[Variable]) -> Group:
        """Return a call that sets or gets all of these variables."""
        if type_name not in TYPES_2:
            raise Unusable(f"FMI 2.0 has no variables of type {type_name}.")
        name, number = TYPES_2[type_name]

        def call(references: Any, count: int, values: Any) -> None:
            self.call(f"{action}{name}", references, c.c_size_t(count), values)

        return Group(call, number, variables)

    def initialize(self, start_s: float, set_constants: Callable[[], None]) -> None:
        """Initialize a new instance, so that it can step."""
        set_constants()
        begin, nothing = c.c_double(start_s), c.c_double(0.0)
        self.call("SetupExperiment", 0, nothing, begin, 0, nothing)
        self.call("EnterInitializationMode")
        self.call("ExitInitializationMode")

    def step(self, t: float, dt: float) -> None:
        """Advance the model by dt [s]."""
        self.call("DoStep", c.c_double(t), c.c_double(dt), 1)


class Library3(Library):
    """FMI 3.0."""

    def _instantiate(self, token: bytes) -> int | None:
        location = str(self._resources).encode() + b"/"
        no = c.c_bool(False)
        instance: int | None = self.function("InstantiateCoSimulation", c.c_void_p)(
            b"controller",
            token,
            location,
            no,
            no,
            no,
            no,
            None,
            c.c_size_t(0),
            None,
            LOGGER_3,
            None,
        )
        return instance

    def group(self, action: str, type_name: str, variables: Sequence[Variable]) -> Group:
        """Return a call that sets or gets all of these variables."""
        total = c.c_size_t(sum(variable.count for variable in variables))

        def call(references: Any, count: int, values: Any) -> None:
            self.call(f"{action}{type_name}", references, c.c_size_t(count), values, total)

        return Group(call, TYPES_3[type_name], variables)

    def initialize(self, start_s: float, set_constants: Callable[[], None]) -> None:
        """Initialize a new instance, so that it can step."""
        set_constants()
        no, nothing = c.c_bool(False), c.c_double(0.0)
        self.call("EnterInitializationMode", no, nothing, c.c_double(start_s), no, nothing)
        self.call("ExitInitializationMode")

    def step(self, t: float, dt: float) -> None:
        """Advance the model by dt [s]."""
        event, end, early, reached = c.c_bool(), c.c_bool(), c.c_bool(), c.c_double()
        outputs = (c.byref(event), c.byref(end), c.byref(early), c.byref(reached))
        self.call("DoStep", c.c_double(t), c.c_double(dt), c.c_bool(True), *outputs)
        if end:
            raise Unusable(f"The FMU asked to end the simulation at t = {t:g} s.")


LIBRARIES: dict[str, type[Library]] = {"2": Library2, "3": Library3}
