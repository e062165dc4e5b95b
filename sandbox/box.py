"""One program in one box: start, load, step by step in lock step, end.

A box belongs to the thread that made it: bubblewrap dies when that thread ends.
"""

import json
import os
import select
import socket
import time
from array import array
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from types import TracebackType
from typing import NoReturn, Self, cast

from sandbox import frames, verdicts
from sandbox.confined import Confined, Layers
from sandbox.frames import Failure, FrameInvalid
from sandbox.languages import LANGUAGES
from sandbox.languages.language import Runtime
from sandbox.level import Level
from sandbox.limits import Limits, Patience
from sandbox.outcome import Outcome, ProgramEnded, SandboxBroken, Verdict
from sandbox.printed import HeadTail

Command = tuple[float, float, float, float]

MOST_FIELD = 1e6  # [m/s, rad/s] a command beyond is a mistake, not a wish
SLICE_S = 0.25  # [s] waiting is cut into these, so that all limits are seen
LAST_WORDS_S = 2.0  # [s] for the process to end after its connection did
READ_BYTES = 65536  # [B] the capacity of a pipe


class Box:
    """A single-use box: may be started before its program is known (warm)."""

    def __init__(
        self,
        language: str = "python",
        *,
        limits: Limits,
        level: Level,
        core: int | None = None,
        layers: Layers | None = None,
        runtime: Runtime | None = None,
    ) -> None:
        """Start the interpreter in its box and return at once.

        `layers` is for tests alone: they switch one off and must notice. `runtime` is what runs in
        the place of the language's own: its compiler.
        """
        self.limits = limits
        self._language = LANGUAGES[language]
        compiled = self._language.compiler is not None and runtime is None
        self._most_kib = limits.binary_mib << 10 if compiled else limits.source_kib
        self.outcome: Outcome | None = None
        self._cage = Confined(
            runtime or self._language.runtime(), limits, layers or Layers.of(level), core=core
        )
        self._socket = self._cage.socket
        self._poll = select.poll()
        for descriptor in (self._socket.fileno(), self._cage.pidfd, self._cage.output):
            self._poll.register(descriptor, select.POLLIN)
        self._socket_fd = self._socket.fileno()
        self._answer_only = [(self._socket_fd, select.POLLIN)]
        self._cpu_every_s = self._cage.cpu_every_s
        self._buffer = bytearray(frames.MOST_BYTES)
        self._printed = HeadTail(limits.output_kib << 10)
        self._news = HeadTail(limits.output_kib << 10)
        self._sequence = 0
        self._ready = self._closed = self._loaded = False
        self._floats = 0
        self._waited_s = self._cpu_before_s = self._cpu_seen_s = self._cpu_at = 0.0

    def wait_ready(self) -> None:
        """Wait until the interpreter is up; SandboxBroken if it does not come."""
        if not self._ready:
            self._await(frames.READY, self.limits.starting, "The interpreter")
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
        """
        self.wait_ready()
        self._loaded = True
        self._cpu_before_s = self._cpu_seen_s = self._cage.cpu_s()
        self._waited_s = 0.0
        if len(source) > self._most_kib << 10:
            limit = f"The program has {len(source)} bytes; the limit is {self._most_kib} KiB."
            self._end(Failure(Verdict.COMPILE_ERROR, limit, ""))
        fields = cast(Sequence[tuple[str, int]], layout["observation"])
        self._floats = sum(count or 1 for _, count in fields)
        name = "".join(c for c in PurePosixPath(filename).name if c.isprintable())[:100]
        header = json.dumps(
            {
                "protocol": frames.VERSION,
                "filename": name or "program",
                "config": dict(config),
                "layout": dict(layout),
            }
        ).encode()
        self._ask(frames.BEGIN, frames.SIZES.pack(len(header), len(source)))
        blob = header + source
        for start in range(0, len(blob), frames.CHUNK_BYTES):
            self._ask(frames.SOURCE, blob[start : start + frames.CHUNK_BYTES])
        self._await(frames.READY, self.limits.starting, self._language.calls.start)

    def reset(self, level: Mapping[str, object]) -> None:
        """Announce a level; wait until the program is ready."""
        self._ask(frames.RESET, json.dumps(dict(level)).encode())
        self._await(frames.READY, self.limits.starting, self._language.calls.reset)

    def step(self, values: Sequence[float]) -> Command:
        """Send one observation, return the checked command.

        Parameters
        ----------
        values : (n,) float64 in the order of the layout
            A buffer of float64 is sent as it is.

        Returns
        -------
        tuple of 4 [m/s, m/s, m/s, rad/s]
            Finite, at most 1e6 in size.
        """
        body = _float64(values)
        if len(body) != 8 * self._floats:
            raise ValueError(f"{len(body)} bytes of observation, {8 * self._floats} in the layout")
        self._ask(frames.OBSERVE, body)
        answer = self._await(frames.ANSWER, self.limits.stepping, self._language.calls.step)
        if len(answer) != frames.COMMAND.size:
            self._end(verdicts.misbehaved(f"The program answered with {len(answer)} bytes."))
        _, _, _, surge, sway, heave, yaw = frames.COMMAND.unpack(answer)
        most = MOST_FIELD  # NaN compares false, so that it does not get through either
        if not (
            -most <= surge <= most
            and -most <= sway <= most
            and -most <= heave <= most
            and -most <= yaw <= most
        ):
            self._end(verdicts.misbehaved("The program answered with a number beyond all limits."))
        return surge, sway, heave, yaw

    def finish(self) -> Outcome:
        """Say good-bye; the same process must answer and end by itself, well."""
        self._ask(frames.QUIT)
        self._look_at_limits()
        self._cage.memory_mib()
        self._await(frames.BYE, self.limits.stepping, "The end of the program")
        code = self._cage.exit_code(LAST_WORDS_S)
        if code != 0:
            self._end(verdicts.died(code) if code else _lives_on())
        self._drain()
        self.outcome = self._outcome(Failure(Verdict.OK, "The program ended well.", ""))
        return self.outcome

    def take_output(self) -> bytes:
        """Return what the program printed since the last call: head and tail if it is much."""
        if not self._closed:
            self._drain()
        text = self._news.text()
        self._news = HeadTail(self.limits.output_kib << 10)
        return text

    def processes(self) -> list[int]:
        """Return the pids of the box as the host sees them; for probes and tests."""
        return self._cage.processes()

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

    def _ask(self, kind: bytes, body: bytes = b"") -> None:
        """Send one frame, after a look whether the program spoke without being asked."""
        if self.outcome is not None:
            raise ProgramEnded(self.outcome)
        if self._poll.poll(0):
            self._look_between()
        self._sequence += 1
        message = frames.frame(kind, self._sequence, body)
        deadline = time.monotonic() + self.limits.start_wall_s
        while not self._sent(message):
            self._look_at_limits()
            if time.monotonic() > deadline:
                self._late("The program", self.limits.start_wall_s, since_cpu_s=self._cpu_seen_s)
            writable = select.poll()
            writable.register(self._socket.fileno(), select.POLLOUT)
            writable.poll(SLICE_S * 1000)
            self._drain()

    def _sent(self, message: bytes) -> bool:
        try:
            self._socket.send(message)
        except BlockingIOError:
            return False
        except (BrokenPipeError, ConnectionResetError):
            self._gone()
        return True

    def _await(self, kind: bytes, patience: Patience, waited_for: str) -> memoryview:
        """Return the program's answer; drains its output and minds all limits meanwhile."""
        begin = now = time.monotonic()
        seen_s = self._cpu_seen_s
        deadline = begin + min(patience.wall_s, max(self.limits.wall_s - self._waited_s, 0.0))
        while True:
            ready = self._poll.poll(min(deadline - now, SLICE_S) * 1000) if now < deadline else []
            now = time.monotonic()
            if now - self._cpu_at > self._cpu_every_s:
                self._cpu_at = now
                self._look_at_limits()
            if not ready:
                seen_s = self._mind_answer(patience, waited_for, seen_s, now - begin)
            if ready != self._answer_only:  # it prints, it ended, or it is late
                self._drain()
            descriptors = dict(ready)
            if self._socket_fd in descriptors:
                self._waited_s += now - begin
                return self._received(kind)
            if self._cage.pidfd in descriptors:
                self._gone()
            if now >= deadline:
                self._late(waited_for, patience.wall_s, since_cpu_s=seen_s)

    def _mind_answer(
        self, patience: Patience, waited_for: str, seen_s: float, waited_s: float
    ) -> float:
        """End the run if one answer took too much CPU time; return that of its begin.

        It was last read some steps before. On one core, more than the time that went by since the
        begin cannot be this answer's.
        """
        self._look_at_limits()
        begin_s = max(seen_s, self._cpu_seen_s - waited_s)
        if self._loaded and self._cpu_seen_s - begin_s > patience.cpu_s:
            self._end(verdicts.answer_limit(waited_for, patience.cpu_s))
        return begin_s

    def _received(self, kind: bytes) -> memoryview:
        """Return the waiting frame if it is the answer to the present question."""
        size = self._received_bytes()
        if size == 0:
            self._gone()
        try:
            if size > len(self._buffer):
                raise FrameInvalid(f"The program sent a frame of {size} bytes past its runner.")
            data = memoryview(self._buffer)[:size]
            if frames.check(data, kind + frames.FAILED, self._sequence) == frames.FAILED:
                self._failed(frames.failure(data))
        except FrameInvalid as reason:
            self._end(verdicts.misbehaved(str(reason)))
        return data

    def _received_bytes(self, flags: int = 0) -> int:
        """Return the size of the waiting frame, also if it is cut; 0 at the connection's end."""
        try:
            return self._socket.recv_into(self._buffer, 0, socket.MSG_TRUNC | flags)
        except ConnectionResetError:
            return 0

    def _look_between(self) -> None:
        """Nothing but print may come from the program while nobody asks it."""
        self._drain()
        descriptors = [descriptor for descriptor, _ in self._poll.poll(0)]
        if self._socket_fd in descriptors:
            if self._received_bytes(socket.MSG_PEEK):
                self._end(verdicts.misbehaved("The program answered a question nobody asked."))
            self._gone()
        if self._cage.pidfd in descriptors:
            self._gone()

    def _drain(self) -> None:
        """Take what the program printed; ends the run if it is too much."""
        data = b" "
        while data:
            try:
                data = os.read(self._cage.output, READ_BYTES)
            except BlockingIOError:
                return
            self._printed.feed(data)
            self._news.feed(data)
            if self._printed.total > self.limits.output_max_mib << 20 and self.outcome is None:
                self._end(verdicts.output_limit(self.limits))
        if self._cage.output >= 0 and self.outcome is None:
            self._forget_output()

    def _forget_output(self) -> None:
        """Stop looking at a pipe whose other end is closed: it would be readable for ever."""
        try:
            self._poll.unregister(self._cage.output)
        except KeyError:
            return

    def _look_at_limits(self) -> None:
        self._cpu_seen_s = self._cage.cpu_s()
        used_s = self._cpu_seen_s - self._cpu_before_s
        if self._loaded and used_s > self.limits.cpu_s:
            self._end(verdicts.cpu_limit(self.limits, used_s))

    def _late(self, waited_for: str, wall_s: float, *, since_cpu_s: float) -> NoReturn:
        """End the run for its wall time; the host is suspected if little CPU time was used."""
        self._look_at_limits()
        whole_run = self._waited_s + wall_s > self.limits.wall_s
        said = (
            verdicts.run_limit(self.limits)
            if whole_run
            else verdicts.wall_limit(waited_for, wall_s)
        )
        used_s = self._cpu_seen_s - (self._cpu_before_s if whole_run else since_cpu_s)
        self._end(said, suspect_host=used_s < wall_s / 2)

    def _failed(self, failure: Failure) -> NoReturn:
        """End the run for what the runner reports, seen in the light of the kernel's counters."""
        if failure.verdict is Verdict.USER_ERROR and self._cage.out_of_memory():
            failure = verdicts.memory_limit(self.limits)
        elif failure.verdict is Verdict.USER_ERROR and self._cage.out_of_processes():
            failure = verdicts.process_limit(self.limits, failure.traceback)
        self._end(failure)

    def _gone(self) -> NoReturn:
        """End the run because the process ended, or closed its connection and lives on."""
        code = self._cage.exit_code(LAST_WORDS_S)
        if code is None:
            self._end(_lives_on())
        self._look_at_limits()
        if self._cage.out_of_memory():
            self._end(verdicts.memory_limit(self.limits))
        self._failed(verdicts.died(code))

    def _end(self, failure: Failure, *, suspect_host: bool = False) -> NoReturn:
        """Kill the box, keep what is known, raise it."""
        outcome = self._outcome(failure, suspect_host=suspect_host)
        self._cage.kill()
        self.outcome = outcome
        self._drain()
        if not self._loaded:
            raise SandboxBroken(
                f"{failure.sentence} {frames.readable(self._printed.text())}".strip()
            )
        self.outcome = self._outcome(failure, suspect_host=suspect_host)
        raise ProgramEnded(self.outcome)

    def _outcome(self, failure: Failure, *, suspect_host: bool = False) -> Outcome:
        return Outcome(
            verdict=failure.verdict,
            sentence=failure.sentence,
            traceback=failure.traceback,
            cpu_s=max(self._cage.cpu_s() - self._cpu_before_s, 0.0),
            wall_s=self._waited_s,
            memory_mib=self._cage.memory_mib(),
            output=self._printed.text(),
            output_dropped=self._printed.dropped,
            suspect_host=suspect_host,
        )


def _lives_on() -> Failure:
    return verdicts.misbehaved("The program closed its connection to the simulator and lived on.")


def _float64(values: Sequence[float]) -> bytes:
    """Return float64 values as bytes, without a copy by element where they are a buffer."""
    try:
        view = memoryview(values)  # type: ignore[arg-type]
    except TypeError:
        return array("d", values).tobytes()
    if view.format != "d":
        return array("d", values).tobytes()
    return view.tobytes()
