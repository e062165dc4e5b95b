"""Boxes for tests of the sandbox itself."""

import pytest

from sandbox.level import Level
from sandbox.probes import probe


@pytest.fixture(scope="session")
def level() -> Level:
    isolation = probe()
    if isolation.level < Level.MEDIUM:
        pytest.skip(isolation.sentence())
    return isolation.level
