"""A job whose program a fake box does not read."""

from pathlib import Path

import pytest

from seamark.worker.evaluation.job import Job
from tests.worker.conftest import SHORT


@pytest.fixture
def job(tmp_path: Path) -> Job:
    """Two short trials of an uploaded controller."""
    program = tmp_path / "program"
    program.write_text("not read")
    return Job(
        benchmark="currents-v1",
        config=dict(SHORT),
        seeds=(5, 5),
        controller="upload",
        program=program,
    )
