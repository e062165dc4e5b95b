"""Gets the program of a stranger, makes its object, answers question after question.

Arguments: number of the protocol's descriptor; processes and memory [MiB] to limit here, 0 where
control groups do it.
"""

import contextlib
import errno
import gc
import json
import os
import resource
import struct
import sys
import traceback
import types
from collections.abc import Callable
from typing import Any, NamedTuple, NoReturn

from .files import ArchiveUnusable, Files
from .images import Images, as_detections, as_track, corners_of
from .values import HEADER, AnswerInvalid, Observation, as_command, observe_by

VERSION = 1
COMMAND = struct.Struct("<cB2xI4d")
SIZES = struct.Struct("<II")
ERROR = struct.Struct("<cH")
MOST_BYTES = 65536  # [B] one frame
MOST_SENTENCE, MOST_TRACEBACK = 1500, 16000  # [B]
MOST_FRAMES = 30  # of a traceback
DISCONNECTED = 70  # exit code: the program closed the connection under the runner
DESCRIPTORS = 4096  # above the limit of open files


class Role(NamedTuple):
    """What a program may be."""

    maker: str  # the class that it defines
    methods: tuple[str, ...]  # that the class must have; the first gives the answers
    interface: str
    answer: str


ROLES = {
    "controller": Role(
        "Controller",
        ("step",),
        "A program has a class Controller with __init__(self, config), step(self, observation) "
        "and, if it likes, reset(self, level).",
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


class Runner:
    """Answers the trusted side until it says good-bye."""

    def __init__(self, descriptor: int) -> None:
        self.fd = descriptor
        self.sequence = 0
        self.files: Any = None  # of the program, as soon as they are there
        self.role = ROLES["controller"]
        self.program: Any = None  # the object of the stranger's class
        self.images: Any = None
        self.doing = "the program"

    def send(self, kind: bytes, body: bytes = b"") -> None:
        """Send one frame that answers the present question."""
        os.write(self.fd, HEADER.pack(kind, VERSION, self.sequence) + body)

    def receive(self) -> tuple[bytes, bytes]:
        """Return kind and the whole frame; ends the process when the other side is gone."""
        data = os.read(self.fd, MOST_BYTES)
        if not data:
            os._exit(0)
        kind, _, self.sequence = HEADER.unpack_from(data)
        return kind, data

    def run(self) -> None:
        """Get the program, make its controller, answer; never returns."""
        try:
            self.send(b"k")
            self.begin()
            self.send(b"k")
            self.answers()
        except BaseException as error:  # (whatever a program may raise, also exit)
            self.fail(error)

    def begin(self) -> None:
        """Receive header and source, run the source, make the controller."""
        _, data = self.receive()
        header_size, source_size = SIZES.unpack_from(data, HEADER.size)
        text = bytearray()
        while len(text) < header_size + source_size:
            text += self.receive()[1][HEADER.size :]
        header = json.loads(text[:header_size])
        source = bytes(text[header_size:])
        gc.enable()  # off since the start
        self.prepare(header)
        try:
            self.files = files = Files(source, header["filename"])
        except ArchiveUnusable as reason:
            self.give_up(b"s", str(reason))
        module = types.ModuleType("controller")
        module.__file__ = files.path
        sys.modules["controller"] = module
        self.doing = "compile"
        code = compile(files.source, files.path, "exec", dont_inherit=True)
        self.doing = "the program"
        exec(code, module.__dict__)  # noqa: S102  (this is what the box is for)
        self.program = self.make(module, header["config"])

    def prepare(self, header: dict[str, Any]) -> None:
        """Get ready for the program's role; close what it does not need."""
        layout = header["layout"]
        self.role = ROLES[layout.get("role", "controller")]
        observe_by(layout)
        if "images" in header:
            self.images = Images(header["images"])
        os.closerange(3, self.fd)
        os.closerange(self.fd + 1, DESCRIPTORS)

    def make(self, module: types.ModuleType, config: dict[str, object]) -> Any:
        """Return the object of the program's class, which is checked for its methods."""
        role = self.role
        maker: Any = getattr(module, role.maker, None)
        if maker is None:
            self.give_up(b"u", f"{self.files.name} has no class {role.maker}. {role.interface}")
        for method in role.methods:
            if not callable(getattr(maker, method, None)):
                self.give_up(b"u", f"{role.maker} has no method {method}. {role.interface}")
        self.doing = f"{role.maker}(config)"
        return maker(config)

    def answers(self) -> None:
        """Answer question after question."""
        if self.images is None:
            self.control()
        while True:
            kind, data = self.receive()
            if kind == b"U":
                self.doing = "update(image)"
                self.send(b"t", as_track(self.program.update(self.images.of(data))))
            elif kind == b"D":
                self.doing = "detect(image)"
                self.send(b"d", as_detections(self.program.detect(self.images.of(data))))
            elif kind == b"T":
                self.doing = "start(image, corners)"
                self.program.start(self.images.of(data), corners_of(data))
                self.send(b"k")
            else:
                self.others(kind, data)

    def control(self) -> None:
        """Answer as a controller: many and short questions."""
        step: Callable[[Observation], object] = self.program.step
        read, write, unpack, pack = os.read, os.write, HEADER.unpack_from, COMMAND.pack
        descriptor = self.fd
        while True:
            data = read(descriptor, MOST_BYTES)
            if not data:
                os._exit(0)
            kind, _, self.sequence = unpack(data)
            if kind == b"O":
                self.doing = "step(observation)"
                numbers = as_command(step(Observation(data)))
                write(descriptor, pack(b"c", VERSION, self.sequence, *numbers))
            else:
                self.others(kind, data)

    def others(self, kind: bytes, data: bytes) -> None:
        """Answer what every role is asked: `reset` if the program has one, and the end."""
        if kind != b"R":
            self.leave()
        self.doing = "reset(level)"
        method = getattr(self.program, "reset", None)
        if method is not None:
            method(json.loads(data[HEADER.size :]))
        self.send(b"k")

    def leave(self) -> None:
        """Say the last word and end well. No atexit and no __del__ of the program run."""
        flush()
        self.send(b"q")
        os._exit(0)

    def fail(self, error: BaseException) -> None:
        """Report what ended the program and end."""
        try:
            own = self.own_frames(error)
            kind, sentence = self.describe(error, own)
            text = "" if isinstance(error, AnswerInvalid) else trace_text(own)
        except BaseException:  # (an exception whose own text raises)
            kind, sentence, text = b"u", f"{type(error).__name__} (its text cannot be shown)", ""
        self.give_up(kind, sentence, text)

    def own_frames(self, error: BaseException) -> traceback.TracebackException:
        """Return the exception with the frames of the program alone."""
        own = traceback.TracebackException.from_exception(error, compact=True)
        waiting = [own]
        while waiting:
            one = waiting.pop()
            frames = [frame for frame in one.stack if self.files.own(frame.filename)]
            if len(frames) > MOST_FRAMES:
                frames = frames[: MOST_FRAMES // 2] + frames[-MOST_FRAMES // 2 :]
            one.stack = traceback.StackSummary.from_list(frames)
            waiting += [cause for cause in (one.__cause__, one.__context__) if cause is not None]
        return own

    def describe(
        self, error: BaseException, own: traceback.TracebackException
    ) -> tuple[bytes, str]:
        """Return the kind of the end and one sentence for the owner."""
        what = "".join(own.format_exception_only()).strip().splitlines()[-1]
        if self.doing == "compile":
            line = getattr(error, "lineno", None)
            return b"s", f"{what} (line {line} of {self.files.name})" if line else what
        if isinstance(error, AnswerInvalid):
            name = self.role.methods[0]
            code = getattr(self.program, name).__code__
            where = f"{name} begins in line {code.co_firstlineno} of {code.co_filename}"
            return b"p", f"{error}; {self.role.answer} ({where})"
        if what == "MemoryError":
            what = "MemoryError: the program asked for more memory than it may use"
        if not own.stack:
            return kind_of(error), f"{what} (called as {self.doing}). {self.role.interface}"
        last = own.stack[-1]
        return kind_of(error), f"{what} (line {last.lineno} of {last.filename})"

    def give_up(self, kind: bytes, sentence: str, text: str = "") -> NoReturn:
        """Send the last frame and end."""
        flush()
        if self.files is not None:
            sentence, text = self.files.shown(sentence), self.files.shown(text)
        words = sentence.encode("utf-8", "replace")[:MOST_SENTENCE]
        trace = text.encode("utf-8", "replace")[:MOST_TRACEBACK]
        with contextlib.suppress(OSError):
            self.send(b"x", ERROR.pack(kind, len(words)) + words + trace)
            os._exit(1)
        os._exit(DISCONNECTED)


def kind_of(error: BaseException) -> bytes:
    """Return the letter of the verdict for an exception."""
    if isinstance(error, MemoryError):
        return b"m"
    no_process = isinstance(error, BlockingIOError) and error.errno == errno.EAGAIN
    if no_process or (isinstance(error, RuntimeError) and "start new thread" in str(error)):
        return b"r"
    return b"u"


def trace_text(own: traceback.TracebackException) -> str:
    """Return the traceback as text, without an empty heading."""
    if not own.stack:
        return "".join(own.format_exception_only())
    return "".join(own.format())


def flush() -> None:
    """Push out what the program printed, whatever it did to its streams."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(BaseException):  # a program may put anything there
            stream.flush()


def limit(which: int, value: int) -> None:
    """Lower a limit for good; 0 leaves it."""
    if value:
        resource.setrlimit(which, (value, value))


def main() -> None:
    """Set the limits, serve."""
    descriptor, processes, memory_mib = (int(word) for word in sys.argv[1:4])
    # Inside the namespace: outside, the boxes of one user would take processes from each other.
    limit(resource.RLIMIT_NPROC, processes)
    limit(resource.RLIMIT_AS, memory_mib << 20)
    sys.argv[:] = ["controller"]
    stdout: Any = sys.stdout
    stdout.reconfigure(line_buffering=True, errors="backslashreplace")
    gc.freeze()  # what is imported by now stays: a program's collections need not look at it
    Runner(descriptor).run()
