"""Results side by side without a server, by the same rules as on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from seamark.failures import UsageRefused
from seamark.plots.result import Result
from seamark.programs.parameters import KEY
from seamark.server.runs.showing.side_by_side import RUNS_MAX, RUNS_MIN, side_by_side
from seamark.sim import registry
from seamark.sim.settings.position_controllers import UPLOAD


@dataclass(frozen=True, slots=True)
class LocalPart:
    """A further program of a result, as its manifest names it."""

    role: str
    program_sha256: str
    language: str = ""  # manifests do not name it


@dataclass(frozen=True, slots=True)
class ComparedResult:
    """A result as a `seamark.server.runs.showing.score_differences.ComparedRun`."""

    id: int  # its position, from 1
    result: Result
    language: str | None = None  # manifests do not name it
    draw: int | None = None  # a local run verifies nothing
    submission: str | None = None  # nor has it fresh trials

    @property
    def benchmark(self) -> str:
        """The name of the benchmark."""
        return self.result.benchmark

    @property
    def config(self) -> Mapping[str, Any]:
        """The configuration, with the parameters of the program."""
        manifest = self.result.manifest
        own = {KEY: manifest[KEY]} if manifest.get(KEY) else {}
        return {**manifest["configuration"], **own}

    @property
    def controller(self) -> str:
        """The name of the built-in solution, or that of an upload."""
        return str(self.result.manifest.get("controller", UPLOAD))

    @property
    def program_sha256(self) -> str | None:
        """The digest of the program; None for a built-in solution."""
        return self.result.manifest.get("program_sha256")

    @property
    def program_name(self) -> str | None:
        """A name of the program: manifests have none."""
        return "program" if self.program_sha256 else None

    @property
    def parts(self) -> tuple[LocalPart, ...]:
        """The further programs."""
        digests: Mapping[str, str] = self.result.manifest.get("parts") or {}
        return tuple(LocalPart(*each) for each in digests.items())

    @property
    def seed(self) -> int | None:
        """The seed; None for a ranked run."""
        return self.result.manifest.get("seed")

    @property
    def trials(self) -> int:
        """The number of trials."""
        return int(self.result.manifest.get("trials", 1))

    @property
    def kind(self) -> str:
        """Ranked runs have no seed of their own, and neither have logs of missions."""
        if "log" in self.result.manifest:
            return "log"
        return "ranked" if self.seed is None else "practice"

    @property
    def state(self) -> str:
        """A run without metrics failed."""
        return "failed" if self.metrics is None else "succeeded"

    @property
    def metrics(self) -> Mapping[str, Any] | None:
        """The metrics."""
        return self.result.metrics

    @property
    def score(self) -> float | None:
        """The score; None if it failed."""
        return (self.metrics or {}).get("score")

    def seed_of_trial(self, trial: int) -> int:
        """Return the seed of a trial; one that no other result has where it is not known."""
        seeds = self.result.manifest.get("seeds")
        if seeds:
            return int(seeds[trial])
        return -self.id if self.seed is None else self.seed


def compare_results(results: Sequence[Result]) -> dict[str, Any]:
    """Return the comparison as the API has it, without series; each run has a `label`.

    Raises
    ------
    UsageRefused
        There are too few or too many, or one is of a benchmark that this version does not have.
    """
    if not RUNS_MIN <= len(results) <= RUNS_MAX:
        raise UsageRefused(f"Name {RUNS_MIN} to {RUNS_MAX} results.")
    for result in results:
        if result.benchmark not in registry.BENCHMARKS:
            raise UsageRefused(f"{result.name}: this version has no {result.benchmark}.")
    runs = [ComparedResult(at + 1, result) for at, result in enumerate(results)]
    seeds: Mapping[int, Callable[[int], int]] = {run.id: run.seed_of_trial for run in runs}
    compared = side_by_side(runs, lambda run: seeds[run.id])
    shown = [
        {"id": run.id, "label": run.result.name, "benchmark": run.benchmark, "score": run.score}
        for run in runs
    ]
    return {"runs": shown, **asdict(compared)}
