"""Runs inside the box, beside the program of a stranger: interpreter, NumPy, then the program.

Arguments: number of the protocol's descriptor; processes and memory [MiB] to limit here, 0 where
control groups do it. The frames are described in sandbox/frames.py; their numbers stand here once
more, since a box holds nothing of ours but this file. Nothing here is trusted by the other side.
"""

import contextlib
import errno
import itertools
import json
import linecache
import math
import os
import resource
import struct
import sys
import traceback
import types
from collections.abc import Callable, Iterator, Mapping
from numbers import Real
from typing import Any

import numpy as np  # before the program is known: this is what takes 60 ms

VERSION = 1
HEADER = struct.Struct("<cB2xI")
COMMAND = struct.Struct("<cB2xI4d")
SIZES = struct.Struct("<II")
ERROR = struct.Struct("<cH")
FLOAT64 = np.float64
MOST_BYTES = 65536  # [B] one frame
MOST_FIELD = 1e6  # [m/s, rad/s] a command beyond is a mistake, not a wish
MOST_SENTENCE, MOST_TRACEBACK = 1500, 16000  # [B]
MOST_FRAMES = 30  # of a traceback
DISCONNECTED = 70  # exit code: the program closed the connection under the runner
DESCRIPTORS = 4096  # above the limit of open files

INTERFACE = (
    "A program has a class Controller with __init__(self, config), step(self, observation) and, "
    "if it likes, reset(self, level)."
)
ANSWER = "step must return four finite numbers: surge, sway, heave in m/s and yaw rate in rad/s"


class AnswerInvalid(Exception):
    """`step` returned something that is not a command."""


class Observation(Mapping):  # type: ignore[type-arg]
    """What the vehicle knows: `observation.depth` or `observation["depth"]`, read-only.

    Numbers are float or bool, vectors are NumPy arrays that cannot be written.
    """

    __slots__ = ("_cache", "_data")
    _fields: dict[str, tuple[int, int, bool]] = {}  # noqa: RUF012  (set once, from the layout)

    _data: bytes
    _cache: dict[str, object]

    def __init__(self, data: bytes) -> None:
        object.__setattr__(self, "_data", data)
        object.__setattr__(self, "_cache", {})

    def __getitem__(self, name: str) -> object:
        """Return a field; vectors as read-only arrays."""
        cache = self._cache
        if name not in cache:
            offset, count, boolean = self._fields[name]
            value = np.frombuffer(self._data, "<f8", count or 1, offset)
            cache[name] = value if count else (bool if boolean else float)(value[0])
        return cache[name]

    def __getattr__(self, name: str) -> object:
        """Return a field by its attribute."""
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self._fields)
            raise AttributeError(f"an observation has no {name!r}; it has {known}") from None

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


def observe_by(layout: dict[str, list]) -> None:  # type: ignore[type-arg]
    """Teach Observation where each field stands in a frame."""
    offset = HEADER.size
    booleans = set(layout.get("booleans", ()))
    for name, count in layout["observation"]:
        Observation._fields[name] = (offset, count, name in booleans)
        offset += 8 * (count or 1)


def as_command(answer: Any) -> list[float]:
    """Return four floats; AnswerInvalid with a sentence that says what came instead."""
    if type(answer) is list and len(answer) == 4:
        return [as_number(index, value) for index, value in enumerate(answer)]
    if isinstance(answer, np.ndarray):
        if answer.shape != (4,):
            raise AnswerInvalid(f"step returned an array of shape {answer.shape}")
        if answer.dtype.kind not in "fiu":
            raise AnswerInvalid(f"step returned an array of {answer.dtype}")
        answer = answer.tolist()
    elif answer is None:
        raise AnswerInvalid("step returned None (is a return missing?)")
    elif not isinstance(answer, (list, tuple)):
        raise AnswerInvalid(f"step returned a value of type {type(answer).__name__}")
    values = list(itertools.islice(answer, 5))  # a list of one's own kind may have no end
    if len(values) != 4:
        count = len(answer) if len(answer) != 4 else "more than 4"
        raise AnswerInvalid(f"step returned {count} values")
    return [as_number(index, value) for index, value in enumerate(values)]


def as_number(index: int, value: Any) -> float:
    """Return one value of a command as a float."""
    if type(value) is FLOAT64:
        value = float(value)
    if type(value) is float and -MOST_FIELD <= value <= MOST_FIELD:
        return value  # the usual case, and the quick one
    if isinstance(value, np.ndarray) and value.shape == ():
        value = value.item()
    if not isinstance(value, Real):
        raise AnswerInvalid(f"value {index} that step returned is of type {type(value).__name__}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not abs(number) <= MOST_FIELD:  # also catches NaN
        raise AnswerInvalid(f"value {index} that step returned is {number}")
    return number


class Runner:
    """Answers the trusted side until it says good-bye."""

    def __init__(self, descriptor: int) -> None:
        self.fd = descriptor
        self.sequence = 0
        self.filename = "program"
        self.controller: Any = None
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
            self.answer()
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
        self.filename = header["filename"]
        observe_by(header["layout"])
        lines = source.decode("utf-8", "replace").splitlines(keepends=True)
        linecache.cache[self.filename] = (len(source), None, lines, self.filename)
        module = types.ModuleType("controller")
        module.__file__ = self.filename
        sys.modules["controller"] = module
        self.doing = "compile"
        code = compile(source, self.filename, "exec", dont_inherit=True)
        self.doing = "the program"
        exec(code, module.__dict__)  # noqa: S102  (this is what the box is for)
        self.controller = self.make(module, header["config"])

    def make(self, module: types.ModuleType, config: dict[str, object]) -> Any:
        """Return `Controller(config)`, checked for its methods."""
        maker: Any = getattr(module, "Controller", None)
        if maker is None:
            self.give_up(b"u", f"{self.filename} has no class Controller. {INTERFACE}")
        if not callable(getattr(maker, "step", None)):
            self.give_up(b"u", f"Controller has no method step(self, observation). {INTERFACE}")
        self.doing = "Controller(config)"
        return maker(config)

    def answer(self) -> None:
        """Answer question after question."""
        step: Callable[[Observation], object] = self.controller.step
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
            elif kind == b"R":
                self.doing = "reset(level)"
                self.reset(json.loads(data[HEADER.size :]))
                self.send(b"k")
            else:
                self.leave()

    def reset(self, level: dict[str, object]) -> None:
        """Call `reset` if the program has one."""
        method = getattr(self.controller, "reset", None)
        if method is not None:
            method(level)

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
            text = trace_text(own)
        except BaseException:  # (an exception whose own text raises)
            kind, sentence, text = b"u", f"{type(error).__name__} (its text cannot be shown)", ""
        self.give_up(kind, sentence, text)

    def own_frames(self, error: BaseException) -> traceback.TracebackException:
        """Return the exception with the frames of the program alone."""
        own = traceback.TracebackException.from_exception(error, compact=True)
        waiting = [own]
        while waiting:
            one = waiting.pop()
            frames = [frame for frame in one.stack if frame.filename == self.filename]
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
            return b"s", f"{what} (line {line} of {self.filename})" if line else what
        if isinstance(error, AnswerInvalid):
            line = self.controller.step.__code__.co_firstlineno
            return b"p", f"{error}; {ANSWER} (step begins in line {line} of {self.filename})"
        if what == "MemoryError":
            what = "MemoryError: the program asked for more memory than it may use"
        if not own.stack:
            return kind_of(error), f"{what} (called as {self.doing}). {INTERFACE}"
        return kind_of(error), f"{what} (line {own.stack[-1].lineno} of {self.filename})"

    def give_up(self, kind: bytes, sentence: str, text: str = "") -> None:
        """Send the last frame and end."""
        flush()
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
    """Close what is not needed, set the limits, serve."""
    descriptor, processes, memory_mib = (int(word) for word in sys.argv[1:4])
    os.closerange(3, descriptor)
    os.closerange(descriptor + 1, DESCRIPTORS)
    # Inside the namespace: outside, the boxes of one user would take processes from each other.
    limit(resource.RLIMIT_NPROC, processes)
    limit(resource.RLIMIT_AS, memory_mib << 20)
    sys.argv[:] = ["controller"]
    stdout: Any = sys.stdout
    stdout.reconfigure(line_buffering=True, errors="backslashreplace")
    Runner(descriptor).run()


if __name__ == "__main__":
    main()
