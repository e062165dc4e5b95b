"""The seed of each trial of a run: for simulating it, and for re-rendering its camera images."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.engine.seeds import fresh_seed, hidden_seed


class Seeded(Protocol):
    """What decides the seeds of a run: a claim and a view have it."""

    @property
    def benchmark(self) -> str: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def config(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def controller(self) -> str: ...  # noqa: D102
    @property
    def language(self) -> str | None: ...  # noqa: D102
    @property
    def program_sha256(self) -> str | None: ...  # noqa: D102
    @property
    def seed(self) -> int | None: ...  # noqa: D102
    @property
    def draw(self) -> int | None: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSeeds:
    """Trial -> seed.

    A practice run uses its own seed in all trials. A ranked run has the public seed of the
    benchmark's protocol in the reference trials, then fresh ones; without a protocol hidden ones,
    unless it verifies another run.
    """

    benchmark: str
    seed: int | None  # None: ranked
    submission: str  # digest of what was submitted
    draw: int | None = None  # of fresh water for a verification; None: the submission's own
    secret: bytes = field(repr=False)

    def __call__(self, trial: int) -> int:
        """Return the seed of a trial."""
        if self.seed is not None:
            return self.seed
        protocol = registry.benchmark(self.benchmark).protocol
        if protocol is not None and trial < protocol.reference_trials:
            return protocol.reference_seed
        if protocol is None and self.draw is None:
            return hidden_seed(self.secret, self.benchmark, trial)
        of = self.submission if self.draw is None else f"{self.submission} draw {self.draw}"
        return fresh_seed(self.secret, self.benchmark, of, trial)


def trial_seeds(run: Seeded, settings: Settings) -> TrialSeeds:
    """Return the seeds of a run's trials."""
    return TrialSeeds(
        benchmark=run.benchmark,
        seed=run.seed,
        submission=submission_digest(run),
        draw=run.draw,
        secret=settings.seed_key.encode(),
    )


def seeds_hidden(run: Seeded) -> bool:
    """Return whether the seeds must not be shown, because other runs have the same ones."""
    return run.seed is None and registry.benchmark(run.benchmark).protocol is None


def submission_digest(run: Seeded) -> str:
    """Return the SHA-256 over what is evaluated, without the file's name, title and notes.

    The same submission always has the same digest; any change to the program or to its
    configuration gives another one.
    """
    submitted = {
        "benchmark": run.benchmark,
        "configuration": dict(run.config),
        "controller": run.controller,
        "language": run.language,
        "program": run.program_sha256,
    }
    text = json.dumps(submitted, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
