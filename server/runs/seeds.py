"""The seed of each trial of a run: for simulating it, and for re-rendering its camera images."""

from dataclasses import dataclass, field
from typing import Protocol

from seamark.server.settings import Settings
from seamark.sim.engine.seeds import hidden_seed


class Seeded(Protocol):
    """What decides the seeds of a run: a claim and a view have it."""

    @property
    def benchmark(self) -> str: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def seed(self) -> int | None: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class TrialSeeds:
    """Trial -> seed: a practice run uses its own seed in all trials, a ranked run hidden ones."""

    benchmark: str
    seed: int | None  # None: ranked
    secret: bytes = field(repr=False)

    def __call__(self, trial: int) -> int:
        """Return the seed of a trial."""
        if self.seed is not None:
            return self.seed
        return hidden_seed(self.secret, self.benchmark, trial)


def trial_seeds(run: Seeded, settings: Settings) -> TrialSeeds:
    """Return the seeds of a run's trials."""
    return TrialSeeds(run.benchmark, run.seed, settings.secret_key.encode())
