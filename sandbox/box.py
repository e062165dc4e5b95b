"""One program in one box: start, load, exchange messages in lock step, finish.

bubblewrap dies with the thread that started the box. A fork of that process may use the box: the
fork closes it like one of its own; the parent calls `hand_over` right after forking, and `close`
when the fork has ended, which reaps or kills what is left.
"""

import json
from array import array
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import PurePosixPath
from types import TracebackType
from typing import Any, NamedTuple, Self, TypeVar, cast

from seamark.sandbox import verdicts
from seamark.sandbox.isolation.bwrap_command import IMAGES_DESCRIPTOR
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import START_WITHIN_S, Layers, ProcessTree
from seamark.sandbox.isolation.shared_images import SharedImages
from seamark.sandbox.languages import DEFAULT_LANGUAGE, LANGUAGES, images_refusal, role_refusal
from seamark.sandbox.languages.inside import wire
from seamark.sandbox.languages.language import CONTROLLER, Language
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Failure, Outcome, SandboxBroken, Verdict
from seamark.sandbox.protocol import answers, messages
from seamark.sandbox.protocol.answers import Command, Corners, Detection, Loss
from seamark.sandbox.protocol.messages import MessageInvalid
from seamark.sandbox.protocol.session import ProtocolSession
from seamark.sandbox.runtime import Runtime

MAX_NAME_LENGTH = 100  # of a file name in messages

Answer = TypeVar("Answer")


class Usage(NamedTuple):
    """What a box used so far; memory is the peak."""

    cpu_s: float
    memory_mib: float


class Box:
    """A single-use box. It may be started before its program is known."""

    def __init__(
        self,
        language: str = DEFAULT_LANGUAGE,
        *,
        limits: Limits,
        isolation: IsolationLevel,
        core: int | None = None,
        layers: Layers | None = None,
        runtime: Runtime | None = None,
    ) -> None:
        """Start the interpreter in its box and return at once.

        `layers` is for tests alone, which switch one off and must notice. `runtime` replaces the
        language's own: its compiler.
        """
        self.limits = limits
        self._set_language(LANGUAGES[language], compiling=runtime is not None)
        self._tree = ProcessTree(
            runtime or self._language.runtime(),
            limits,
            layers or Layers.of(isolation),
            core=core,
        )
        self._session = ProtocolSession(self._tree, limits)
        self._ready = self._closed = False
        self._step_limit = limits.step_limit
        self._float_count = 0
        self._command: Callable[[memoryview], Command] = answers.command
        self._values: object = None  # the buffer that the last observation came in
        self._body = memoryview(b"")  # its bytes
        self._cameras: tuple[str, ...] = ()  # whose images the program is given
        self._shown = b""  # IMAGE headers of their newest images

    def _set_language(self, language: Language, *, compiling: bool) -> None:
        self._language = language
        binary = language.runs_binaries and not compiling
        self._max_program_kib = self.limits.binary_mib << 10 if binary else self.limits.source_kib

    @property
    def outcome(self) -> Outcome | None:
        """Return how the program ended; None as long as it runs."""
        return self._session.outcome

    def is_alive(self) -> bool:
        """Return whether the box has not ended by itself."""
        return self._tree.exit_code(0.0) is None

    def assign(self, limits: Limits, language: str) -> None:
        """Set limits and language of a box without a program; they must fit what was started."""
        if not limits.fit(self.limits):
            raise ValueError(f"{limits} do not fit a box that was started with {self.limits}")
        if LANGUAGES[language].runtime is not self._language.runtime:
            raise ValueError(f"{language} does not run in a box for {self._language.name}")
        self.limits = self._session.limits = limits
        self._set_language(LANGUAGES[language], compiling=False)
        self._step_limit = limits.step_limit

    def wait_ready(self) -> None:
        """Wait until the interpreter is up; SandboxBroken if it does not start."""
        if not self._ready:
            self._session.answer(messages.READY, self.limits.start_limit, "The interpreter")
            self._tree.find_init()
            self._ready = True

    def load(
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None:
        """Send the program with its configuration; wait until its controller is constructed.

        In the box of a compiler: wait until it has compiled the program.

        Parameters
        ----------
        source
            The text, or what `compilation.compiled` made of it.
        filename
            What its owner calls it: in the outcome's texts, unknown to the program itself, which
            has the same name in all boxes.
        layout
            `role` is one of the language's roles, a controller if it is missing. The layout of a
            controller has the `observation` that `step` is given; the other roles get images. A
            vehicle with an arm has more than four names in `command`, and the fastest speed of
            each joint in `joint_limits`. A controller that gets images, too, has in `images` a list
            of name, height and width [px] of each camera.
        """
        self.wait_ready()
        shown = "".join(c for c in PurePosixPath(filename).name if c.isprintable())
        self._session.begin(self._language.file_name, shown[:MAX_NAME_LENGTH])
        if len(source) > self._max_program_kib << 10:
            sentence = (
                f"The program has {len(source)} bytes; the limit is {self._max_program_kib} KiB."
            )
            self._session.end(Failure(Verdict.COMPILE_ERROR, sentence))
        if refusal := role_refusal(self._language.name, str(layout.get("role", CONTROLLER))):
            self._session.end(Failure(Verdict.COMPILE_ERROR, refusal))
        images = cast(Sequence[Sequence[object]], layout.get("images", ()))
        self._cameras = tuple(str(name) for name, *_size in images)
        if self._cameras and (refusal := images_refusal(self._language.name)):
            self._session.end(Failure(Verdict.COMPILE_ERROR, refusal))
        fields = cast(Sequence[tuple[str, int]], layout.get("observation", ()))
        self._command = partial(answers.command, limits=wire.command_limits(dict(layout)))
        self._float_count = sum(count or 1 for _, count in fields)
        header = json.dumps(self._header(config, layout)).encode()
        self._session.ask(messages.BEGIN, wire.SIZES.pack(len(header), len(source)))
        data = header + source
        for start in range(0, len(data), messages.CHUNK_BYTES):
            self._session.ask(messages.SOURCE, data[start : start + messages.CHUNK_BYTES])
        self._session.answer(messages.READY, self.limits.start_limit, self._language.calls.start)

    def _header(
        self, config: Mapping[str, object], layout: Mapping[str, object]
    ) -> dict[str, object]:
        header: dict[str, object] = {
            "protocol": wire.VERSION,
            "filename": self._language.file_name,
            "config": dict(config),
            "layout": dict(layout),
        }
        if layout.get("role", CONTROLLER) != CONTROLLER or self._cameras:
            header["images"] = self._images.description(IMAGES_DESCRIPTOR)
        return header

    def reset(self, level: Mapping[str, object]) -> None:
        """Announce a level of the benchmark; wait until the program is ready."""
        self._session.ask(messages.RESET, json.dumps(dict(level)).encode())
        self._session.answer(messages.READY, self.limits.start_limit, self._language.calls.reset)

    def step(self, values: Sequence[float]) -> Command:
        """Send one observation, return the checked command.

        Parameters
        ----------
        values : (n,) float64 in the order of the layout
            A float64 buffer is sent without a copy. If the same buffer is passed again, it is not
            checked again.

        Returns
        -------
        tuple of 4 or more [m/s, m/s, m/s, rad/s, and rad/s or m/s of each joint of an arm]
            Finite, with a magnitude of at most 1e6, or the joint's limit.
        """
        if values is not self._values:
            self._set_buffer(values)
        body = self._body if not self._cameras else b"".join((self._body, self._shown))
        self._session.ask(messages.OBSERVE, body)
        return self._checked(messages.COMMAND, self._command, self._language.calls.step)

    def show(self, images: Mapping[str, object]) -> None:
        """Give a controller the newest images of its cameras, for the next `step` and on.

        Parameters
        ----------
        images : camera -> (H, W) uint8, C-contiguous
            Of all the cameras in the layout. Copied once, as for `start`.
        """
        put = self._images.put_of_camera
        self._shown = b"".join(put(i, images[name]) for i, name in enumerate(self._cameras))

    def _set_buffer(self, values: Sequence[float]) -> None:
        """Check what observations come in; the bytes of a buffer follow its current values."""
        body = _float64(values)
        if len(body) != 8 * self._float_count:
            raise ValueError(
                f"{len(body)} bytes of observation, {8 * self._float_count} in the layout"
            )
        owner: object = body.obj
        self._values, self._body = values if owner is values else None, body

    def start(self, image: object, corners: object) -> None:
        """Show a tracker the target; wait until it is ready.

        Parameters
        ----------
        image : (H, W) or (H, W, 3) uint8, C-contiguous
            Any buffer. It is copied once, into memory that the box can only read.
        corners : (4, 2) float64 [px]
            The target's corners in the image (x right, y down).
        """
        packed = answers.packed_corners(corners)
        self._session.ask(messages.START, self._images.put_first(image) + packed)
        self._session.answer(messages.READY, self.limits.start_limit, "start(image, corners)")

    def update(self, image: object) -> Corners | Loss:
        """Show a tracker the next image; return the target's corners, or why there are none.

        Parameters
        ----------
        image : (H, W) or (H, W, 3) uint8, C-contiguous
            As for `start`.

        Returns
        -------
        (4, 2) [px] or Loss
            Nested tuples; finite, with a magnitude of at most 1e6.
        """
        self._session.ask(messages.UPDATE, self._images.put_next(image))
        return self._checked(messages.TRACK, answers.track, "update(image)")

    def detect(self, image: object) -> list[Detection]:
        """Show a detector an image; return its detections, at most MAX_DETECTIONS."""
        self._session.ask(messages.DETECT, self._images.put_next(image))
        return self._checked(messages.DETECTIONS, answers.detections, "detect(image)")

    def finish(self) -> Outcome:
        """Ask the program to quit; its own process must answer and exit with 0."""
        return self._session.finish()

    def take_output(self) -> bytes:
        """Return what the program printed since the last call: head and tail if it is long."""
        return self._session.last_output() if self._closed else self._session.take_output()

    def usage(self) -> Usage:
        """Return what all processes used since the start of the box; for measurements."""
        return Usage(self._tree.cpu_s(), self._tree.memory_mib())

    def processes(self) -> list[int]:
        """Return the host's pids of the processes in the box; for probes and tests."""
        return self._tree.processes()

    def set_affinity(self, cores: set[int]) -> None:
        """Let a box without a program run on other cores."""
        self._tree.set_affinity(cores)

    def wait_killable(self) -> None:
        """Wait until the inner init is known, which takes some milliseconds of the start."""
        self._tree.find_init(START_WITHIN_S)

    def hand_over(self) -> None:
        """Leave the communication with the program to a fork of this process."""
        self._tree.hand_over()

    def detach(self) -> None:
        """In a fork: let go of a box that belongs to the parent or to another fork."""
        self._closed = True
        self._tree.detach()

    def close(self) -> None:
        """Kill everything in the box; SandboxBroken if anything survives."""
        if self._closed:
            return
        self._closed = True
        try:
            self._tree.kill()
        finally:
            self._tree.release()

    def __enter__(self) -> Self:
        """Return the box itself."""
        return self

    def __exit__(
        self,
        error_type: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the box."""
        self.close()

    @property
    def _images(self) -> SharedImages:
        if self._tree.images is None:
            raise SandboxBroken(f"programs in {self._language.label} cannot be given images")
        return self._tree.images

    def _checked(
        self, message_type: bytes, read: Callable[[memoryview], Answer], waited_for: str
    ) -> Answer:
        """Return the program's answer; an invalid one ends the run."""
        data = self._session.answer(message_type, self._step_limit, waited_for)
        try:
            return read(data)
        except MessageInvalid as reason:
            self._session.end(verdicts.protocol_error(str(reason)))


def _float64(values: Sequence[float]) -> memoryview:
    """Return float64 values as bytes, without a copy if they are a buffer of them."""
    try:
        view = memoryview(cast(Any, values))
    except TypeError:
        view = memoryview(b"")
    if view.format != "d" or not view.c_contiguous:
        view = memoryview(array("d", values))
    return view.cast("B")
