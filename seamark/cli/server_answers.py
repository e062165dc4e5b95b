"""Refusals of a server as failures of a command."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from seamark.failures import PlatformFailed, UsageRefused


@contextmanager
def refusals_shown() -> Iterator[None]:
    """Turn what a server refuses within into the failure that the command ends with."""
    from seamark.client import ServerRefused, ServerUnavailable
    from seamark.sandbox.printable_text import printable_text

    try:
        yield
    except ServerUnavailable as error:
        raise PlatformFailed(str(error)) from None
    except ServerRefused as refusal:
        failure = PlatformFailed if refusal.status >= 500 else UsageRefused
        raise failure(printable_text(str(refusal))) from None
