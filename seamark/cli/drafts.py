"""Files that appear when they are complete, or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from seamark.failures import UsageRefused


@contextmanager
def draft_of(out: Path) -> Iterator[BinaryIO]:
    """Provide a file that takes the place of `out` at the end; raises UsageRefused."""
    draft = out.with_name(f".{out.name}.{secrets.token_hex(4)}")
    try:
        with draft.open("w+b") as file:
            yield file
        os.replace(draft, out)
    except OSError as error:
        raise UsageRefused(f"{out} cannot be written: {error.strerror}.") from None
    finally:
        draft.unlink(missing_ok=True)
