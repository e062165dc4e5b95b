"""A slot of a worker: where one evaluation at a time runs."""

import json
from dataclasses import asdict, dataclass
from typing import Self

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.evaluation.cores import NO_LOCKS, Cores

NO_MOTHER = -1  # zygotes are new interpreters


@dataclass(frozen=True, slots=True)
class WorkerSlot:
    """The isolation, the cores and the warm boxes of one evaluation at a time."""

    isolation: IsolationLevel
    core: int | None  # of the simulator and the box of a single trial; None: not pinned
    shared_cores: tuple[int, ...] = ()  # on which the trials of one run may run in parallel
    core_locks: int = NO_LOCKS  # descriptor of the locks on them
    languages: tuple[str, ...] = ()  # of uploads; their boxes are started between runs
    warm_boxes: int = 0  # of each language
    mother: int = NO_MOTHER  # descriptor on which the worker's processes ask for a zygote

    def cores(self) -> Cores:
        """Return the cores of one run."""
        return Cores(self.core, self.shared_cores, locks=self.core_locks)

    def cores_for(self, trials: int) -> Cores | None:
        """Return the cores of trials in parallel; None if they run one after the other."""
        cores = self.cores()
        return cores if min(trials, cores.count) > 1 else None

    def inherited_descriptors(self) -> tuple[int, ...]:
        """Return the descriptors that a zygote of this slot has to inherit."""
        return () if self.core_locks == NO_LOCKS else (self.core_locks,)

    def to_json(self) -> str:
        """Return the slot for a command line; an inherited descriptor keeps its number."""
        return json.dumps(asdict(self) | {"isolation": self.isolation.name})

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return the slot that `to_json` was given."""
        values = json.loads(text)
        return cls(
            isolation=IsolationLevel[values.pop("isolation")],
            shared_cores=tuple(values.pop("shared_cores")),
            languages=tuple(values.pop("languages")),
            **values,
        )
