"""Runs an FMU as a controller: unpacked, read and loaded in a box, never outside.

Arguments: `--`, then those of `connected`.
"""

import json
import struct
import sys
from pathlib import Path
from typing import Any, NoReturn

from ...inside.connection import Connection, connected
from .description import Description, Unusable, checked, read
from .library import LIBRARIES, Group, Library
from .wiring import Wiring, wired

FOLDER = Path("/tmp/fmu")  # noqa: S108  (inside the box)
DT_S = 0.05  # [s] if neither level nor observation has the step


class Model:
    """One instance of the model with its connections."""

    def __init__(self, description: Description, header: dict[str, Any]) -> None:
        self._wiring: Wiring = wired(description, header["layout"], header["config"])
        self.command, self.limits = self._wiring.command, self._wiring.limits
        unpack(description)
        library_class = LIBRARIES[description.version]
        self._library: Library = library_class(
            FOLDER / description.library, description, FOLDER / "resources"
        )
        self._library.instantiate()
        self._used = self._ready = False
        self._t, self._dt = 0.0, DT_S
        self._inputs = self._groups("Set", self._wiring.inputs)
        self._outputs = self._groups("Get", self._wiring.outputs)
        self._constants = self._groups("Set", self._wiring.constants)

    def _groups(self, action: str, ends: list[Any]) -> list[tuple[Group, list[Any]]]:
        """Return one call for each type of variable, with what the variables are connected to."""
        types: dict[str, list[Any]] = {}
        for end in ends:
            types.setdefault(end.variable.type, []).append(end)
        return [
            (self._library.group(action, name, [end.variable for end in same]), same)
            for name, same in types.items()
        ]

    def reset(self, level: dict[str, Any]) -> None:
        """Start again at the time of the level."""
        self._t, self._dt = float(level.get("t", 0.0)), float(level.get("dt", DT_S))
        if self._used:
            self._library.call("Reset")
        self._library.initialize(self._t, self._set_constants)
        self._used = self._ready = True

    def step(self, values: tuple[float, ...]) -> list[float]:
        """Set the inputs, step, return the command."""
        if not self._ready:
            self.reset({})
        for group, ends in self._inputs:
            at = 0
            for _, span in ends:
                for value in values[span.offset : span.offset + span.size]:
                    group.values[at] = value if group.real else int(value)
                    at += 1
            group.transfer()
        self._library.step(self._t, self._dt)
        self._t += self._dt
        command = [self._wiring.fixed.get(index, 0.0) for index in range(len(self.command))]
        for group, ends in self._outputs:
            group.transfer()
            at = 0
            for _, span in ends:
                command[span.offset : span.offset + span.size] = [
                    float(value) for value in group.values[at : at + span.size]
                ]
                at += span.size
        return command

    def _set_constants(self) -> None:
        for group, ends in self._constants:
            for at, constant in enumerate(ends):
                group.values[at] = constant.value if group.real else int(constant.value)
            group.transfer()


def unpack(description: Description) -> None:
    """Unpack library and resources; nothing else is needed."""
    (FOLDER / "resources").mkdir(parents=True)
    archive = description.archive
    for name in archive.namelist():
        if name == description.library or name.startswith("resources/"):
            archive.extract(name, FOLDER)
    (FOLDER / description.library).chmod(0o700)


def start(connection: Connection) -> NoReturn:
    """Load the FMU and answer until the end."""
    header, data = connection.program()
    try:
        description = checked(read(data), str(header["filename"]))
        model = Model(description, header)
        connection.send(b"k")
        answer(connection, model)
    except Unusable as reason:
        connection.give_up(b"p", str(reason))


def answer(connection: Connection, model: Model) -> NoReturn:
    """Answer request after request."""
    while True:
        message_type, body = connection.receive()
        if message_type == b"O":
            command = model.step(struct.unpack(f"<{len(body) // 8}d", body))
            limited = zip(command, model.limits, strict=True)
            if not all(abs(value) <= most for value, most in limited):  # also catches NaN
                named = zip(model.command, command, strict=True)
                words = ", ".join(f"{name} = {v:g}" for name, v in named)
                within = "".join(
                    f", {name} within +-{most:g}"
                    for name, most in zip(model.command[4:], model.limits[4:], strict=True)
                )
                raise Unusable(f"The outputs of the FMU are {words}; they must be finite{within}.")
            connection.send(b"c", struct.pack(f"<{len(command)}d", *command))
        elif message_type == b"R":
            model.reset(json.loads(body))
            connection.send(b"k")
        else:
            sys.stdout.flush()
            connection.quit()


def main() -> None:
    """Report that the box is up, wait for the FMU."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :])
    connection.send(b"k")
    start(connection)
