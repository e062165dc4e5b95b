"""A program in a box as the simulator sees it."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.programs import trial_limits
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.inside.wire import MAX_VALUE
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome
from seamark.sandbox.pool import Pool
from seamark.sandbox.protocol.answers import Corners, Detection, Loss
from seamark.sim.control.observation import Images
from seamark.sim.engine.program import Command
from seamark.sim.trackers import Track, Window
from seamark.sim.trackers.template.warps import is_convex
from seamark.sim.vehicles.patterns import CLASSES
from seamark.worker.evaluation.worker_slot import WorkerSlot

LONGEST_TRIAL_S = 3600.0  # [s] simulated, for which the limits of warm boxes suffice
NAMED_LABELS, LABEL_SHOWN = 5, 20  # [label], [character] in the note about unknown labels


class BoxLike(Protocol):
    """The methods of a box that a trial calls; tests have one without a sandbox."""

    @property
    def outcome(self) -> Outcome | None: ...  # noqa: D102 - see seamark.sandbox.box.Box
    def load(  # noqa: D102
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None: ...
    def reset(self, level: Mapping[str, object]) -> None: ...  # noqa: D102
    def step(self, values: Any) -> Command: ...  # noqa: D102
    def show(self, images: Images) -> None: ...  # noqa: D102
    def start(self, image: Any, corners: Any) -> None: ...  # noqa: D102
    def update(self, image: Any) -> Corners | Loss: ...  # noqa: D102
    def detect(self, image: Any) -> list[Detection]: ...  # noqa: D102
    def finish(self) -> Outcome: ...  # noqa: D102
    def take_output(self) -> bytes: ...  # noqa: D102
    def close(self) -> None: ...  # noqa: D102


MakeBox = Callable[[str, Limits], BoxLike]
Compile = Callable[[str, bytes, str], bytes]  # language, source, file name -> what a box runs


class ControllerAdapter:
    """A `seamark.sim.engine.program.Program` over a box."""

    def __init__(self, box: BoxLike) -> None:
        self._box = box

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Announce a level to the program; raises ProgramEnded."""
        self._box.reset(level)

    def show(self, images: Images) -> None:
        """Give the program the newest images; it sees them at the next step."""
        self._box.show(images)

    def step(self, values: NDArray[np.float64]) -> Command:
        """Send the observation and return the checked answer; raises ProgramEnded."""
        return self._box.step(values)

    def note(self) -> str:
        """Return a note for the program's owner at the end of a trial; none here."""
        return ""


class TrackerAdapter:
    """A `seamark.sim.trackers.Tracker` over a box; it is shown whole images.

    Corners that are not finite, absurdly far away, or not a convex quadrilateral, clockwise as at
    the start, cannot be the target's: they count as lost, like None. A tracker that diverges in
    turbid water gives such an answer now and then, which is no reason to end its run. What are no
    corners at all (another shape or type) ends it: raises ProgramEnded.
    """

    def __init__(self, box: BoxLike) -> None:
        self._box = box
        self._last = np.zeros((4, 2))
        self._window: Window = (0, 0, 0, 0)
        self._answers = self._out_of_range = self._not_convex = 0

    def start(self, image: NDArray[np.uint8], corners: NDArray[np.float64]) -> None:
        """Show the target; raises ProgramEnded."""
        self._last = corners.copy()
        self._window = (0, 0, image.shape[1], image.shape[0])
        self._box.start(image, corners)

    def window(self) -> Window:
        """Return the whole image."""
        return self._window

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return where the program sees the target; raises ProgramEnded."""
        answer = self._box.update(image)
        self._answers += 1
        if isinstance(answer, Loss):
            self._out_of_range += answer is Loss.OUT_OF_RANGE
            return self._lost()
        corners = np.array(answer, dtype=np.float64)
        if not is_convex(corners):
            self._not_convex += 1
            return self._lost()
        self._last = corners
        return Track(corners, ok=True, residual=0.0, iterations=0)

    def _lost(self) -> Track:
        return Track(self._last, ok=False, residual=1.0, iterations=0)

    def note(self) -> str:
        """Return how many answers could not be the target's corners and why, if any."""
        kinds = (
            (self._out_of_range, f"were not finite or beyond {MAX_VALUE:g} px"),
            (
                self._not_convex,
                "were not a convex quadrilateral, clockwise like the corners of start()",
            ),
        )
        return "".join(
            f"[{count} of {self._answers} answers of update() {what}: they count as lost.]\n"
            for count, what in kinds
            if count
        )


class DetectorAdapter:
    """What finds things in images, over a box.

    A detection whose label is no class can be no hit: the metrics leave it out of the score, and
    the owner is told. What is no detection at all ends the run: raises ProgramEnded.
    """

    def __init__(self, box: BoxLike) -> None:
        self._box = box
        self._answers = self._with_unknown = 0
        self._unknown: list[str] = []  # the first ones, and one more if there are others

    def detect(self, image: NDArray[np.uint8]) -> list[Detection]:
        """Return what the program finds, as it says it; raises ProgramEnded."""
        found = self._box.detect(image)
        unknown = [one.label for one in found if one.label not in CLASSES]
        self._answers += 1
        self._with_unknown += bool(unknown)
        for label in unknown:
            if label not in self._unknown and len(self._unknown) <= NAMED_LABELS:
                self._unknown.append(label)
        return found

    def note(self) -> str:
        """Return how many answers had labels that are no class and which, if any."""
        if not self._unknown:
            return ""
        named = [_shortened(label) for label in self._unknown[:NAMED_LABELS]]
        named += ["others"] if len(self._unknown) > NAMED_LABELS else []
        return (
            f"[{self._with_unknown} of {self._answers} answers of detect() have labels that are no "
            f"class: {', '.join(named)}. They are left out of the score. The classes are "
            f"{', '.join(CLASSES)}.]\n"
        )


def _shortened(label: str) -> str:
    return (
        label if len(label) <= LABEL_SHOWN else f"{label[: LABEL_SHOWN - 1]}\N{HORIZONTAL ELLIPSIS}"
    )


# role of a program -> the adapter that makes its box a participant of a benchmark
ADAPTERS: Mapping[str, Callable[[BoxLike], Any]] = {
    "controller": ControllerAdapter,
    "tracker": TrackerAdapter,
    "detector": DetectorAdapter,
}


def box_pool(slot: WorkerSlot) -> Pool:
    """Return the pool of boxes of a slot; no box has been started yet."""
    warm = slot.languages if slot.isolation is not IsolationLevel.NONE else ()
    limits = trial_limits.for_trial(LONGEST_TRIAL_S)
    return Pool(
        dict.fromkeys(warm, slot.warm_boxes),
        limits=limits,
        isolation=slot.isolation,
        core=slot.core,
    )


def sandboxed_compiler(slot: WorkerSlot) -> Compile:
    """Return the function that compiles programs in a box of this slot."""

    def compile_program(language: str, source: bytes, filename: str) -> bytes:
        return compiled(language, source, filename, isolation=slot.isolation, core=slot.core)

    return compile_program


def without_compiling(language: str, source: bytes, filename: str) -> bytes:
    """Return the source as it is."""
    return source
