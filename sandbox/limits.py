"""Every limit of a box. Units are in the names."""

import math
from dataclasses import asdict, dataclass
from typing import NamedTuple

MAX_STEP_WALL_S = (
    600.0  # [s] longer, an answer would occupy a core for too long, whoever is to blame
)
TIMES = ("cpu_s", "wall_s", "start_cpu_s", "start_wall_s", "step_cpu_s", "step_wall_s")


class AnswerLimit(NamedTuple):
    """How long one answer may take."""

    cpu_s: float
    wall_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What all processes of one box may use together.

    CPU time is the fair limit: it does not grow when the machine is busy. The wall times are
    backstops for programs that sleep or hang; time in which the host runs others does not count.
    """

    cpu_s: float = 60.0  # [s] all processes of the box, from the program's arrival to its end
    wall_s: float = 180.0  # [s] waiting for the program, all answers together
    start_cpu_s: float = 10.0  # [s] import and __init__; then each reset
    start_wall_s: float = 30.0  # [s] interpreter start; then import and __init__; then each reset
    step_cpu_s: float = 1.0  # [s] one answer
    step_wall_s: float = 10.0  # [s] one answer
    memory_mib: int = 512  # [MiB] all processes, shared memory and files under /tmp
    processes: int = 32  # processes and threads
    output_kib: int = 64  # [KiB] printed text that is kept: half from the head, half from the tail
    output_max_mib: int = 4  # [MiB] printed text after which the run is ended
    tmp_mib: int = 16  # [MiB] files under /tmp
    shared_mib: int = 16  # [MiB] files under /dev/shm
    file_mib: int = 16  # [MiB] one file
    open_files: int = 64  # descriptors of one process
    source_kib: int = 8192  # [KiB] text of the program, or all files of its archive unpacked
    archive_files: int = 256  # files and folders of an archive
    binary_mib: int = 8  # [MiB] the compiled program

    @property
    def start_limit(self) -> AnswerLimit:
        """For import and __init__, and for each reset."""
        return AnswerLimit(self.start_cpu_s, self.start_wall_s)

    @property
    def step_limit(self) -> AnswerLimit:
        """For one answer."""
        return AnswerLimit(self.step_cpu_s, self.step_wall_s)

    def fit(self, started: "Limits") -> bool:
        """Return whether a box that was started with other limits can still take these.

        Times are enforced from outside, except for RLIMIT_CPU.
        """
        fixed = {name: value for name, value in asdict(self).items() if name not in TIMES}
        same = fixed.items() <= asdict(started).items()
        return same and self.cpu_s <= started.cpu_s

    def __post_init__(self) -> None:
        """Refuse values that make no sense."""
        for name, value in asdict(self).items():
            if not math.isfinite(value) or value <= 0:
                raise ValueError(f"{name} must be positive and finite, not {value}")
        if self.wall_s < self.cpu_s:
            raise ValueError(f"wall_s ({self.wall_s}) is shorter than cpu_s ({self.cpu_s})")
        if self.step_wall_s > MAX_STEP_WALL_S:
            raise ValueError(f"step_wall_s ({self.step_wall_s}) is over {MAX_STEP_WALL_S}")
        if self.output_max_mib * 1024 < self.output_kib:
            raise ValueError("output_max_mib is less than the output_kib that are kept")


MEANING = {  # limit -> what happens when a program reaches it; shown on the form and in the docs
    "cpu_s": "the run ends: time limit",
    "wall_s": "the run ends: time limit",
    "start_cpu_s": "the run ends: time limit",
    "start_wall_s": "the run ends: time limit",
    "step_cpu_s": "the run ends: time limit",
    "step_wall_s": "the run ends: time limit",
    "memory_mib": "the kernel ends the program, or Python raises MemoryError: memory limit",
    "processes": "starting another one fails; if the program fails because of it: process limit",
    "output_kib": "the middle of the log is dropped, and the dropped bytes are counted",
    "output_max_mib": "the run ends: output limit",
    "tmp_mib": "writing fails with OSError: no space left on device",
    "shared_mib": "writing fails with OSError: no space left on device",
    "file_mib": "writing fails with OSError: file too large",
    "open_files": "opening fails with OSError: too many open files",
    "source_kib": "the upload is refused; an archive counts unpacked",
    "archive_files": "the archive is refused when it is uploaded",
    "binary_mib": "the compiled program (C, C++) is refused before it starts",
}

COMPILING = Limits(  # of a compiler's box
    cpu_s=15.0,
    wall_s=60.0,
    start_cpu_s=15.0,
    start_wall_s=45.0,
    memory_mib=768,
    processes=16,
    output_kib=64 << 10,  # the compiled program leaves the box this way, and all of it is kept
    output_max_mib=64,
    tmp_mib=192,
    file_mib=64,
)
