"""The seed of each trial of a run: for simulating it, and for re-rendering its camera images.

Whoever inserts a ranked run has the seed key, and writes the seeds into its row; the worker that
claims the run takes them from there. So a worker needs no key, and one that was taken over cannot
tell the water of submissions that do not exist yet.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.database.tables import Run
from seamark.server.runs.record.states import LIVE, RunKind
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.engine.seeds import fresh_seed, hidden_seed

_FILLED = 1000  # rows that one transaction fills


class SeedsMissing(Exception):
    """The row of a claimed run has no seeds, and this process has no key that derives them."""


class SeededPart(Protocol):
    """What of a further program decides the seeds."""

    @property
    def role(self) -> str: ...  # noqa: D102 - the attribute of tables.RunPart
    @property
    def language(self) -> str: ...  # noqa: D102
    @property
    def program_sha256(self) -> str: ...  # noqa: D102


class Seeded(Protocol):
    """What decides the seeds of a run: its row and a view have it."""

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
    def parts(self) -> Sequence[SeededPart]: ...  # noqa: D102
    @property
    def seed(self) -> int | None: ...  # noqa: D102
    @property
    def trials(self) -> int: ...  # noqa: D102
    @property
    def submission(self) -> str | None: ...  # noqa: D102
    @property
    def draw(self) -> int | None: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSeeds:
    """Trial -> seed.

    A practice run uses its own seed in all trials. A ranked run has the public seed of the
    benchmark's protocol in the reference trials, then fresh ones: one for all fresh trials if the
    protocol says so. Without a protocol it has hidden ones, unless it verifies another run.
    """

    benchmark: str
    seed: int | None  # None: ranked
    submission: str  # digest of what was submitted
    draw: int | None = None  # of fresh trials for a verification; None: the submission's own
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
        if protocol is not None and protocol.shared_seed:
            trial = protocol.reference_trials
        return fresh_seed(self.secret, self.benchmark, of, trial)


def trial_seeds(run: Seeded, settings: Settings) -> TrialSeeds:
    """Return the seeds of a run's trials."""
    if run.seed is None and not settings.derives_seeds:
        raise RuntimeError("this process has no seed key")
    return TrialSeeds(
        benchmark=run.benchmark,
        seed=run.seed,
        submission=run.submission or submission_digest(run),
        draw=run.draw,
        secret=settings.seed_key.encode(),
    )


def derived(run: Seeded, settings: Settings) -> list[int] | None:
    """Return the seeds for the row of a run; None if all of its trials have one of its own."""
    if run.seed is not None:
        return None
    return list(map(trial_seeds(run, settings), range(run.trials)))


def fill(session: Session, settings: Settings) -> int:
    """Give live ranked runs that an earlier version inserted their seeds; return how many."""
    missing = (Run.kind == RunKind.RANKED, Run.seed.is_(None), Run.trial_seeds.is_(None))
    runs = session.scalars(select(Run).where(Run.state.in_(LIVE), *missing).limit(_FILLED)).all()
    for run in runs:
        run.trial_seeds = derived(run, settings)
    return len(runs)


def seeds_hidden(run: Seeded) -> bool:
    """Return whether the seeds must not be shown, because other runs have the same ones."""
    return run.seed is None and registry.benchmark(run.benchmark).protocol is None


def submission_digest(run: Seeded) -> str:
    """Return the SHA-256 over what is evaluated, without the files' names, title and notes.

    The same submission always has the same digest; any change to one of its programs or to its
    configuration gives another one.
    """
    text = json.dumps(submitted(run), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def submitted(run: Seeded) -> dict[str, Any]:
    """Return what the digest of a submission is over."""
    values: dict[str, Any] = {
        "benchmark": run.benchmark,
        "configuration": dict(run.config),
        "controller": run.controller,
        "language": run.language,
        "program": run.program_sha256,
    }
    if run.parts:
        values["parts"] = {part.role: [part.language, part.program_sha256] for part in run.parts}
    return values
