"""The files that commands write, whole or not at all (`seamark.drafts`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from seamark import drafts
from seamark.failures import UsageRefused


@contextmanager
def draft_of(out: Path) -> Iterator[BinaryIO]:
    """Provide a file that takes the place of `out` at the end; raises UsageRefused."""
    try:
        with drafts.draft_of(out) as file:
            yield file
    except OSError as error:
        raise UsageRefused(f"{out} cannot be written: {error.strerror or error}.") from None
