"""A short run whose controller is connected."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

from seamark.sim import registry
from seamark.sim.engine.program import Program
from seamark.sim.recording.telemetry import OnRows
from seamark.worker.evaluation.local import Callbacks, evaluate_connected, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome

BENCHMARK, SEED = "currents-v1", 7
PATIENCE_S = 240.0  # a simulator may have to be compiled first, on a busy machine
SHORT = {"levels": [0.1, 0.3], "level_duration_s": 2, "settle_s": 1, "tracker": "truth"}


def configuration(benchmark: str = BENCHMARK, **settings: Any) -> dict[str, Any]:
    """Return a short configuration as a document."""
    entry = registry.benchmark(benchmark)
    known = SHORT.keys() & entry.configuration.settings().keys()
    short = {name: SHORT[name] for name in known}
    return entry.read(short | settings).model_dump(mode="json")


def built_in(name: str, **settings: Any) -> RunOutcome:
    """Return the outcome of a built-in controller in the same run."""
    return evaluate_locally(BENCHMARK, configuration(**settings), seed=SEED, controller=name)


class Running:
    """A run in another thread."""

    def __init__(
        self,
        program: Program,
        *,
        rows: OnRows | None = None,
        benchmark: str = BENCHMARK,
        **settings: Any,
    ) -> None:
        self._pool = ThreadPoolExecutor(1)
        self._outcome = self._pool.submit(
            evaluate_connected,
            *(benchmark, configuration(benchmark, **settings), program),
            name="test",
            seed=SEED,
            callbacks=Callbacks(rows=rows) if rows else None,
        )

    def outcome(self) -> RunOutcome:
        """Wait for the end of the run."""
        outcome = self._outcome.result(timeout=PATIENCE_S)
        self._pool.shutdown()
        return outcome
