"""One program in one box: start, load, answer by answer in lock step, end.

bubblewrap dies when the thread ends that made the box. A fork of the maker may use the box: it
`closes` it like its own, the maker `leaves` it right after the fork and closes it when the fork has
ended, which reaps what is left or ends what the fork could not.
"""

import json
from array import array
from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePosixPath
from types import TracebackType
from typing import Any, NamedTuple, Self, TypeVar, cast

from seamark.sandbox import verdicts
from seamark.sandbox.isolation.bwrap_command import IMAGES_DESCRIPTOR
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import START_WITHIN_S, Confined, Layers
from seamark.sandbox.isolation.shared_images import Pictures
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import Language, Runtime
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, SandboxBroken, Verdict
from seamark.sandbox.protocol import answers, messages
from seamark.sandbox.protocol.answers import Command, Corners, Detection
from seamark.sandbox.protocol.messages import Failure, FrameInvalid
from seamark.sandbox.protocol.session import Conversation

ROLES = ("controller", "tracker", "detector")  # what a program may be; the first if nothing is said

Answer = TypeVar("Answer")


class Usage(NamedTuple):
    """What a box used so far; memory is the peak."""

    cpu_s: float
    memory_mib: float


class Box:
    """A single-use box: may be started before its program is known (warm)."""

    def __init__(
        self,
        language: str = "python",
        *,
        limits: Limits,
        isolation: IsolationLevel,
        core: int | None = None,
        layers: Layers | None = None,
        runtime: Runtime | None = None,
    ) -> None:
        """Start the interpreter in its box and return at once.

        `layers` is for tests alone: they switch one off and must notice. `runtime` is what runs in
        the place of the language's own: its compiler.
        """
        self.limits = limits
        self._speak(LANGUAGES[language], compiling=runtime is not None)
        self._cage = Confined(
            runtime or self._language.runtime(), limits, layers or Layers.of(isolation), core=core
        )
        self._talk = Conversation(self._cage, limits)
        self._ready = self._closed = False
        self._stepping = limits.stepping
        self._floats = 0
        self._values: object = None  # what the last observation came in
        self._body = memoryview(b"")  # its bytes

    def _speak(self, language: Language, *, compiling: bool) -> None:
        self._language = language
        made = language.compiler is not None or language.refusal is not None
        binary = made and not compiling
        self._most_kib = self.limits.binary_mib << 10 if binary else self.limits.source_kib

    @property
    def outcome(self) -> Outcome | None:
        """Return how the program ended; None as long as it has not."""
        return self._talk.outcome

    def lives(self) -> bool:
        """Tell whether the box has not ended by itself."""
        return self._cage.exit_code(0.0) is None

    def adopt(self, limits: Limits, language: str) -> None:
        """Give a box that has no program yet its limits and language, which must fit its start."""
        if not limits.fit(self.limits):
            raise ValueError(f"{limits} do not fit a box that was started with {self.limits}")
        if LANGUAGES[language].runtime is not self._language.runtime:
            raise ValueError(f"{language} does not run in a box for {self._language.name}")
        self.limits = self._talk.limits = limits
        self._speak(LANGUAGES[language], compiling=False)
        self._stepping = limits.stepping

    def wait_ready(self) -> None:
        """Wait until the interpreter is up; SandboxBroken if it does not come."""
        if not self._ready:
            self._talk.answer(messages.READY, self.limits.starting, "The interpreter")
            self._cage.meet_init()
            self._ready = True

    def load(
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None:
        """Send the program and its configuration; wait until its controller is made.

        `source` is the text, or what `compilation.compiled` made of it. While a compiler is
        in the box: wait until it has done its work.

        `layout["role"]` is one of ROLES. A controller's layout has the `observation` that `step`
        is given; trackers and detectors are given images.
        """
        self.wait_ready()
        self._talk.begin()
        if len(source) > self._most_kib << 10:
            limit = f"The program has {len(source)} bytes; the limit is {self._most_kib} KiB."
            self._talk.end(Failure(Verdict.COMPILE_ERROR, limit, ""))
        role = str(layout.get("role", ROLES[0]))
        if role not in self._language.roles:
            able = ", ".join(each.label for each in LANGUAGES.values() if role in each.roles)
            refused = f"A {role} is written in {able}, not in {self._language.label}."
            self._talk.end(Failure(Verdict.COMPILE_ERROR, refused, ""))
        fields = cast(Sequence[tuple[str, int]], layout.get("observation", ()))
        self._floats = sum(count or 1 for _, count in fields)
        header = json.dumps(self._header(filename, config, layout)).encode()
        self._talk.ask(messages.BEGIN, messages.SIZES.pack(len(header), len(source)))
        blob = header + source
        for start in range(0, len(blob), messages.CHUNK_BYTES):
            self._talk.ask(messages.SOURCE, blob[start : start + messages.CHUNK_BYTES])
        self._talk.answer(messages.READY, self.limits.starting, self._language.calls.start)

    def _header(
        self, filename: str, config: Mapping[str, object], layout: Mapping[str, object]
    ) -> dict[str, object]:
        name = "".join(c for c in PurePosixPath(filename).name if c.isprintable())[:100]
        header: dict[str, object] = {
            "protocol": messages.VERSION,
            "filename": name or "program",
            "config": dict(config),
            "layout": dict(layout),
        }
        if layout.get("role", ROLES[0]) != ROLES[0]:
            header["images"] = self._pictures.described(IMAGES_DESCRIPTOR)
        return header

    def reset(self, level: Mapping[str, object]) -> None:
        """Announce a level; wait until the program is ready."""
        self._talk.ask(messages.RESET, json.dumps(dict(level)).encode())
        self._talk.answer(messages.READY, self.limits.starting, self._language.calls.reset)

    def step(self, values: Sequence[float]) -> Command:
        """Send one observation, return the checked command.

        Parameters
        ----------
        values : (n,) float64 in the order of the layout
            A buffer of float64 is sent as it is, and looked at once if it comes again and again.

        Returns
        -------
        tuple of 4 [m/s, m/s, m/s, rad/s]
            Finite, at most 1e6 in size.
        """
        if values is not self._values:
            self._take(values)
        self._talk.ask(messages.OBSERVE, self._body)
        return self._checked(messages.ANSWER, answers.command, self._language.calls.step)

    def _take(self, values: Sequence[float]) -> None:
        """Look at what observations come in; a buffer's bytes are those of its present values."""
        body = _float64(values)
        if len(body) != 8 * self._floats:
            raise ValueError(f"{len(body)} bytes of observation, {8 * self._floats} in the layout")
        whose: object = body.obj
        self._values, self._body = values if whose is values else None, body

    def start(self, image: object, corners: object) -> None:
        """Show a tracker the target; wait until it is ready.

        Parameters
        ----------
        image : (H, W) or (H, W, 3) uint8, C-contiguous
            Any buffer. It is copied once, into memory that the box can only read.
        corners : (4, 2) float64 [px]
            Where the target is in it (x right, y down).
        """
        where = answers.packed_corners(corners)
        body = self._pictures.first(image) + where
        self._talk.ask(messages.START, body)
        self._talk.answer(messages.READY, self.limits.starting, "start(image, corners)")

    def update(self, image: object) -> Corners | None:
        """Show a tracker the next image; return the target's corners, None if it is lost.

        Parameters
        ----------
        image : (H, W) or (H, W, 3) uint8, C-contiguous
            As `start`.

        Returns
        -------
        (4, 2) [px] or None
            Nested tuples; finite, at most 1e6 in size.
        """
        self._talk.ask(messages.UPDATE, self._pictures.next(image))
        return self._checked(messages.TRACK, answers.track, "update(image)")

    def detect(self, image: object) -> list[Detection]:
        """Show a detector an image; return what it sees, at most MOST_DETECTIONS."""
        self._talk.ask(messages.DETECT, self._pictures.next(image))
        return self._checked(messages.DETECTIONS, answers.detections, "detect(image)")

    def finish(self) -> Outcome:
        """Say good-bye; the same process must answer and end by itself, well."""
        return self._talk.finish()

    def take_output(self) -> bytes:
        """Return what the program printed since the last call: head and tail if it is much."""
        return self._talk.last_output() if self._closed else self._talk.take_output()

    def usage(self) -> Usage:
        """Return what all processes used since the start of the box; for measurements."""
        return Usage(self._cage.cpu_s(), self._cage.memory_mib())

    def processes(self) -> list[int]:
        """Return the pids of the box as the host sees them; for probes and tests."""
        return self._cage.processes()

    def move(self, cores: set[int]) -> None:
        """Let a box that has no program yet run on other cores."""
        self._cage.move(cores)

    def wait_known(self) -> None:
        """Wait until it can be ended in one stroke, which takes some milliseconds of its start."""
        self._cage.meet_init(START_WITHIN_S)

    def leave(self) -> None:
        """Leave the talking to a fork of this process."""
        self._cage.leave()

    def forget(self) -> None:
        """In a fork: have nothing to do with this box, which is the maker's or another fork's."""
        self._closed = True
        self._cage.forget()

    def close(self) -> None:
        """Kill everything in the box; SandboxBroken if anything survives."""
        if self._closed:
            return
        self._closed = True
        try:
            self._cage.kill()
        finally:
            self._cage.release()

    def __enter__(self) -> Self:
        """Return the box itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the box."""
        self.close()

    @property
    def _pictures(self) -> Pictures:
        if self._cage.pictures is None:
            raise SandboxBroken(f"programs in {self._language.label} cannot be given images")
        return self._cage.pictures

    def _checked(
        self, kind: bytes, read: Callable[[memoryview], Answer], waited_for: str
    ) -> Answer:
        """Return the answer to a step if it is a good one; else the run ends."""
        data = self._talk.answer(kind, self._stepping, waited_for)
        try:
            return read(data)
        except FrameInvalid as reason:
            self._talk.end(verdicts.misbehaved(str(reason)))


def _float64(values: Sequence[float]) -> memoryview:
    """Return float64 values as bytes, without a copy where they are a buffer of them."""
    try:
        view = memoryview(cast(Any, values))
    except TypeError:
        view = memoryview(b"")
    if view.format != "d" or not view.c_contiguous:
        view = memoryview(array("d", values))
    return view.cast("B")
