"""Controllers in every language, evaluated as a worker does it."""

import subprocess
from collections.abc import Mapping
from pathlib import Path

from seamark.programs import preparation
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.sample import Sample
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome
from tests.services.languages import skip_without


def built(starter: Sample, folder: Path) -> tuple[bytes, str]:
    """Return a starter and its name as its author would upload it."""
    name, source = starter.upload_name, starter.upload()
    if not starter.build:
        return source, name
    (folder / name).write_bytes(source)
    target = folder / "controller.elf"
    command = starter.build.format(source=folder / name, program=target)
    subprocess.run(command.split(), check=True)
    return target.read_bytes(), target.name


def evaluated(
    content: bytes,
    name: str,
    config: Mapping[str, object],
    isolation: IsolationLevel,
    *,
    benchmark: str = "currents-v2",
    callbacks: Callbacks | None = None,
) -> RunOutcome:
    """Evaluate a controller; skips the test where its language does not run."""
    program = preparation.prepare(content, name, role="controller")
    skip_without(program.language, isolation)
    return evaluate_locally(
        *(benchmark, config),
        seed=3,
        controller=program,
        callbacks=callbacks,
        isolation=isolation,
    )
