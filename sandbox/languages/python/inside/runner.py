"""Imports the user's program, constructs its object, answers request after request.

Arguments: the number of the socket's descriptor; the limits of processes and memory [MiB] to set
here, 0 if control groups enforce them.
"""

import contextlib
import errno
import gc
import json
import os
import signal
import struct
import sys
import traceback
import types
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, NoReturn

from ...inside.connection import Connection, connected
from ...inside.wire import HEADER, MAX_MESSAGE_BYTES, VERSION, command_names
from . import quiet_import
from .files import ArchiveUnusable, Files
from .images import Images, as_detections, as_track, start_corners
from .values import (
    VEHICLE,
    AnswerInvalid,
    Configuration,
    Observation,
    as_command,
    set_layout,
)

MAX_FRAMES = 30  # of a traceback
PACKAGES = "/box/packages"


class Role(NamedTuple):
    """What a program can be."""

    class_name: str  # the class that it defines
    methods: tuple[str, ...]  # required; the first one returns the answers
    interface: str
    answer: str


ROLES = {
    "controller": Role(
        "Controller",
        ("step",),
        "A program has a class Controller with __init__(self, config), step(self, observation) "
        "and, optionally, reset(self, level).",
        "step must return four finite numbers: surge, sway, heave in m/s and yaw rate in rad/s",
    ),
    "tracker": Role(
        "Tracker",
        ("update", "start"),
        "A tracker is a class Tracker with __init__(self, config), start(self, image, corners) "
        "and update(self, image).",
        "update must return the target's four corners (x, y) in px, or None if it is lost",
    ),
    "detector": Role(
        "Detector",
        ("detect",),
        "A detector is a class Detector with __init__(self, config) and detect(self, image).",
        "detect must return a list of (label, corners, confidence)",
    ),
}


def answer_with_arm(names: Sequence[str]) -> str:
    """Return what a controller of a vehicle with an arm has to return."""
    joints = ", ".join(names[VEHICLE:])
    return (
        f"step must return {len(names)} finite numbers: surge, sway, heave in m/s, yaw rate "
        f"in rad/s, and the speeds of the joints {joints}"
    )


class Runner:
    """Answers the simulator until it asks the program to quit."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.files: Any = None  # of the program, as soon as they have arrived
        self.role = ROLES["controller"]
        self.command = command_names({})
        self.program: Any = None  # an object of the user's class
        self.images: Any = None
        self.doing = "the program"

    def run(self) -> None:
        """Load the program, construct its object, answer; never returns."""
        try:
            self.connection.send(b"k")
            self.begin()
            self.connection.send(b"k")
            self.serve()
        except BaseException as error:  # (a program may raise anything, SystemExit included)
            self.fail(error)

    def begin(self) -> None:
        """Receive header and source, execute the source, construct the object."""
        header, source = self.connection.program()
        gc.enable()  # disabled since the start
        self.prepare(header)
        try:
            self.files = files = Files(source, header["filename"])
        except ArchiveUnusable as reason:
            self.give_up(b"s", str(reason))
        module = types.ModuleType("controller")
        module.__file__ = files.path
        sys.modules["controller"] = module
        signal.signal(signal.SIGUSR1, self.locate)
        self.doing = "compile"
        code = compile(files.source, files.path, "exec", dont_inherit=True)
        self.doing = "the program"
        exec(code, module.__dict__)  # noqa: S102  (the purpose of the box)
        self.program = self.construct(module, Configuration(header["config"]))

    def prepare(self, header: dict[str, Any]) -> None:
        """Prepare for the program's role; close the descriptors that it does not need."""
        layout = header["layout"]
        self.role = ROLES[layout.get("role", "controller")]
        self.command = names = command_names(layout)
        if len(names) > VEHICLE:
            self.role = self.role._replace(answer=answer_with_arm(names))
        if "images" in header:
            self.images = Images(header["images"])
        set_layout(layout, self.images)
        self.connection.close_others()

    def construct(self, module: types.ModuleType, config: dict[str, object]) -> Any:
        """Return the object of the program's class after checking the class's methods."""
        role = self.role
        program_class: Any = getattr(module, role.class_name, None)
        if program_class is None:
            sentence = f"{self.files.name} has no class {role.class_name}. {role.interface}"
            self.give_up(b"u", sentence)
        for method in role.methods:
            if not callable(getattr(program_class, method, None)):
                self.give_up(b"u", f"{role.class_name} has no method {method}. {role.interface}")
        self.doing = f"{role.class_name}(config)"
        return program_class(config)

    def serve(self) -> None:
        """Answer request after request."""
        if self.role.class_name == "Controller":
            self.control()
        send = self.connection.send
        while True:
            message_type, body = self.connection.receive()
            if message_type == b"U":
                self.doing = "update(image)"
                send(b"t", as_track(self.program.update(self.images.image(body))))
            elif message_type == b"D":
                self.doing = "detect(image)"
                send(b"d", as_detections(self.program.detect(self.images.image(body))))
            elif message_type == b"T":
                self.doing = "start(image, corners)"
                self.program.start(self.images.image(body), start_corners(body))
                send(b"k")
            else:
                self.answer_any_role(message_type, body)

    def control(self) -> None:
        """Answer as a controller: many short requests, without calls that can be saved."""
        step: Callable[[Observation], object] = self.program.step
        read, write, unpack = os.read, os.write, HEADER.unpack_from
        pack = struct.Struct(f"{HEADER.format}{len(self.command)}d").pack  # in one call
        connection, descriptor = self.connection, self.connection.descriptor
        while True:
            data = read(descriptor, MAX_MESSAGE_BYTES)
            if not data:
                os._exit(0)
            message_type, _, connection.sequence = unpack(data)
            if message_type == b"O":
                self.doing = "step(observation)"
                numbers = as_command(step(Observation(data)))
                write(descriptor, pack(b"c", VERSION, connection.sequence, *numbers))
            else:
                self.answer_any_role(message_type, data[HEADER.size :])

    def answer_any_role(self, message_type: bytes, body: bytes) -> None:
        """Answer what every role is asked: `reset`, if the program has it, and to quit."""
        if message_type != b"R":
            flush()
            self.connection.quit()
        self.doing = "reset(level)"
        method = getattr(self.program, "reset", None)
        if method is not None:
            method(json.loads(body))
        self.connection.send(b"k")

    def fail(self, error: BaseException) -> None:
        """Report the exception that ended the program, and exit."""
        try:
            own = self.own_frames(error)
            letter, sentence = self.describe(error, own)
            text = "" if isinstance(error, AnswerInvalid) else trace_text(own)
        except BaseException:  # (an exception whose own text raises)
            sentence = f"{type(error).__name__} (its text cannot be shown)"
            letter, text = b"u", ""
        self.give_up(letter, sentence, text)

    def own_frames(self, error: BaseException) -> traceback.TracebackException:
        """Return the exception with the program's own frames only."""
        own = traceback.TracebackException.from_exception(error, compact=True)
        pending = [own]
        while pending:
            one = pending.pop()
            frames = [frame for frame in one.stack if self.files.contains(frame.filename)]
            if len(frames) > MAX_FRAMES:
                frames = frames[: MAX_FRAMES // 2] + frames[-MAX_FRAMES // 2 :]
            one.stack = traceback.StackSummary.from_list(frames)
            pending += [cause for cause in (one.__cause__, one.__context__) if cause is not None]
        return own

    def locate(self, _: int, frame: types.FrameType | None) -> None:
        """Say which line the program is in, and exit: the simulator has waited for too long."""
        stack = traceback.StackSummary.extract(traceback.walk_stack(frame))
        stack.reverse()
        own = [one for one in stack if self.files.contains(one.filename)][-MAX_FRAMES:]
        if own:
            text = "Traceback (most recent call last):\n"
            text += "".join(traceback.StackSummary.from_list(own).format())
            self.give_up(b"u", f"It was in line {own[-1].lineno} of {own[-1].filename}.", text)

    def describe(
        self, error: BaseException, own: traceback.TracebackException
    ) -> tuple[bytes, str]:
        """Return the letter of the verdict and one sentence for the owner."""
        what = "".join(own.format_exception_only()).strip().splitlines()[-1]
        if self.doing == "compile":
            line = getattr(error, "lineno", None)
            return b"s", f"{what} (line {line} of {self.files.name})" if line else what
        if isinstance(error, AnswerInvalid):
            name = self.role.methods[0]
            code = getattr(self.program, name).__code__
            where = f"{name} begins in line {code.co_firstlineno} of {code.co_filename}"
            return b"p", f"{error}; {self.role.answer} ({where})"
        if isinstance(error, ModuleNotFoundError):
            what += there_is_instead(error.name or "")
        if what == "MemoryError":
            what = "MemoryError: the program asked for more memory than it may use"
        if not own.stack:
            return letter_of(error), f"{what} (called as {self.doing}). {self.role.interface}"
        last = own.stack[-1]
        return letter_of(error), f"{what} (line {last.lineno} of {last.filename})"

    def give_up(self, letter: bytes, sentence: str, text: str = "") -> NoReturn:
        """Report an error and exit."""
        flush()
        if self.files is not None:
            sentence = self.files.with_own_names(sentence)
            text = self.files.with_own_names(text)
        self.connection.give_up(letter, sentence, text)


def letter_of(error: BaseException) -> bytes:
    """Return the letter of the verdict for an exception."""
    if isinstance(error, MemoryError):
        return b"m"
    no_process = isinstance(error, BlockingIOError) and error.errno == errno.EAGAIN
    if no_process or (isinstance(error, RuntimeError) and "start new thread" in str(error)):
        return b"r"
    return b"u"


def there_is_instead(name: str) -> str:
    """Return which packages there are, unless the missing module belongs to one of them."""
    names = sorted(entry for entry in os.listdir(PACKAGES) if entry.isidentifier())
    packages = [entry for entry in names if entry != __name__.partition(".")[0]]
    if name.partition(".")[0] in packages:
        return ""
    return f"; beside the standard library, the box has {', '.join(packages)}"


def trace_text(own: traceback.TracebackException) -> str:
    """Return the traceback as text, without an empty heading."""
    if not own.stack:
        return "".join(own.format_exception_only())
    return "".join(own.format())


def flush() -> None:
    """Flush what the program printed, whatever it did to its streams."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(BaseException):  # a program may replace them by anything
            stream.flush()


def main() -> None:
    """Set the limits, serve."""
    connection = connected(sys.argv[1:4], images=True)
    sys.argv[:] = ["controller"]
    stdout: Any = sys.stdout
    stdout.reconfigure(line_buffering=True, errors="backslashreplace")
    quiet_import.install()
    gc.freeze()  # what is imported so far stays: collections need not visit it
    Runner(connection).run()
