"""Whether a language runs on this machine: tried once in a process of tests."""

from functools import cache

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.probing.self_test import tried


def skip_without(language: str, isolation: IsolationLevel) -> None:
    """Skip a test where programs in a language cannot run."""
    if why := _why_not(language, isolation):
        pytest.skip(why)


@cache
def _why_not(language: str, isolation: IsolationLevel) -> str:
    return tried(language, isolation).why_not
