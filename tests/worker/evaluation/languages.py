"""Controllers in every language, evaluated as a worker does it."""

from collections.abc import Mapping

import pytest

from seamark.programs import preparation
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.probing.self_test import tried
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome


def evaluated(
    content: bytes, name: str, config: Mapping[str, object], isolation: IsolationLevel
) -> RunOutcome:
    """Evaluate a controller of currents-v2; skips the test where its language does not run."""
    program = preparation.prepare(content, name, role="controller")
    if why := tried(program.language, isolation).why_not:
        pytest.skip(why)
    return evaluate_locally("currents-v2", config, seed=3, controller=program, isolation=isolation)
