"""`visp`: ViSP's template trackers behind the same interface, in a child process."""

import struct
import subprocess
import weakref
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.options import LARGEST_JUMP
from seamark.sim.trackers.plausibility import PlausibilityGate
from seamark.sim.trackers.template.tracker import SMALLEST_TEMPLATE_PX
from seamark.sim.trackers.template.warps import apply, from_square, inverse, multiply
from seamark.sim.trackers.visp.installation import bridge_path, unavailable_reason

_CRITERIA = {"ssd": 0, "zncc": 1, "mi": 2}
_METHODS = {
    "esm": 0,
    "inverse_compositional": 1,
    "forward_additional": 2,
    "forward_compositional": 3,
}
_WARPS = {"translation": 0, "rt": 1, "srt": 2, "affine": 3, "homography": 4}
_SL3 = 5
_SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
_ANYWHERE = np.full((4, 2), np.nan)  # instead of the corners that are expected
_ANSWER = struct.Struct("=8did")  # corners u, v; iterations; CPU seconds


@dataclass(frozen=True, slots=True, kw_only=True)
class VispOptions:
    """The tracker's options, as declared."""

    warp: str = "homography"
    criterion: str = "ssd"
    method: str = "inverse_compositional"
    pyramid_levels: int = 2
    sampling_px: float = 1.0
    template_margin_px: int = -3
    visp_iterations: int = 60
    visp_sl3: bool = True
    visp_predict: bool = False
    max_jump: float = LARGEST_JUMP

    def numbers(self) -> tuple[int, ...]:
        """Return the settings of a start message (bridge.cpp)."""
        return (
            _CRITERIA[self.criterion],
            _METHODS[self.method],
            _SL3 if self.warp == "homography" and self.visp_sl3 else _WARPS[self.warp],
            self.pyramid_levels,
            round(self.sampling_px),
            self.visp_iterations,
        )


class VispTracker:
    """One of ViSP's trackers, with settings that make the comparison fair (bridge.cpp).

    As in the template tracker, the template excludes the target's rim: with surroundings in another
    plane, ViSP's ZNCC and MI lost the target at once, and the error of its SSD was 50 % larger.
    """

    def __init__(self, **options: Any) -> None:
        if reason := unavailable_reason():
            raise ValueError(f"ViSP is not available: {reason}.")
        self._options = VispOptions(**options)
        self._shape = (0, 0)
        self._bridge: _Bridge | None = None
        self.spent_s = 0.0  # CPU time of ViSP alone for the last update

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Start ViSP with a whole image (H, W) and the target's corners (4, 2) in it."""
        self._gate = PlausibilityGate(corners, max_jump=self._options.max_jump)
        self._shape = image.shape
        if self._bridge is None or self._bridge.ended:
            self._bridge = _Bridge()
        settings = struct.pack("=8i", *self._options.numbers(), image.shape[1], image.shape[0])
        self._previous = self._gate.last
        corners = self._gate.last
        points = corners.tobytes() + _outline(corners, self._options.template_margin_px).tobytes()
        self._bridge.send(b"S" + settings + points + _pixels(image))
        self._bridge.answer(0)

    def window(self) -> Window:
        """Return the whole image: ViSP smooths all of it."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Have ViSP find the target in the next image (H, W)."""
        bridge = self._bridge
        if bridge is None:
            raise ValueError("the tracker has not been started")
        if image.shape != self._shape:
            raise ValueError(f"an image of {image.shape} after one of {self._shape}")
        last = self._gate.last
        expected = _continued(self._previous, last) if self._options.visp_predict else _ANYWHERE
        bridge.send(b"T" + expected.tobytes() + _pixels(image))
        self._previous = last  # a lost target is predicted to stand still
        answer = bridge.answer(_ANSWER.size)
        if not answer:
            return Track(last.copy(), False, 1.0, 0)
        *points, iterations, self.spent_s = _ANSWER.unpack(answer)
        ok = self._gate.accept(np.array(points).reshape(4, 2))
        return Track(self._gate.last.copy(), ok, 0.0 if ok else 1.0, iterations)


class _Bridge:
    """The child process. Once it has ended, the target is lost; the run goes on."""

    def __init__(self) -> None:
        process = subprocess.Popen(
            [bridge_path()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={"OMP_NUM_THREADS": "1"},
        )
        if process.stdin is None or process.stdout is None:
            raise RuntimeError("the process was started without pipes")
        self._in: IO[bytes] = process.stdin
        self._out: IO[bytes] = process.stdout
        self.ended = False
        self.process = process.pid
        self._end = weakref.finalize(self, _end, process)

    def send(self, message: bytes) -> None:
        """Send a message; it is dropped if the process has ended."""
        if self.ended:
            return
        try:
            self._in.write(message)
            self._in.flush()
        except BrokenPipeError:
            self._stop()

    def answer(self, size: int) -> bytes:
        """Return an answer of this size; empty if ViSP failed on the image or the process ended."""
        if self.ended:
            return b""
        kind = self._out.read(1)
        if kind == b"K":
            reply = self._out.read(size)
            if len(reply) == size:
                return reply
        elif kind == b"E":
            (length,) = struct.unpack("=i", self._out.read(4))
            self._out.read(length)  # the reason; the target is lost
            return b""
        self._stop()
        return b""

    def _stop(self) -> None:
        self.ended = True
        self._end()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the process and close its pipes."""
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            try:
                pipe.close()
            except BrokenPipeError:  # unsent data is dropped
                continue


def _continued(before: Corners, last: Corners) -> Corners:
    """Return the corners (4, 2) one image later, if the last motion between images continues."""
    old, now, back, motion, ahead = (np.empty((3, 3)) for _ in range(5))
    corners = np.empty((4, 2))
    from_square(before, old)
    from_square(last, now)
    inverse(old, back)
    multiply(back, now, motion)
    multiply(now, motion, ahead)
    apply(ahead, _SQUARE, corners)
    return corners


def _outline(corners: Corners, margin_px: float) -> Corners:
    """Return the target's corners (4, 2) moved outwards along its sides [px], inwards if negative.

    The whole face of a small target is used.
    """
    sides = np.sqrt(((corners[[1, 3]] - corners[0]) ** 2).sum(axis=1))
    if sides.min() + 2 * margin_px < SMALLEST_TEMPLATE_PX:
        margin_px = max(margin_px, 0)
    unit, moved = np.empty((3, 3)), np.empty((4, 2))
    from_square(corners, unit)
    apply(unit, _SQUARE + np.sign(_SQUARE - 0.5) * margin_px / sides, moved)
    return moved


def _pixels(image: NDArray[np.uint8]) -> bytes:
    return np.ascontiguousarray(image, dtype=np.uint8).tobytes()
