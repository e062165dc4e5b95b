"""Shared by the archive readers: members, refusals, and decompression with a size limit."""

import zlib
from dataclasses import dataclass

CHUNK = 64 * 1024  # [B] decompressed at a time
RATIO_MAX = 200  # decompressed : compressed; text reaches 20, weights 2, a zip bomb 1000
RATIO_FROM = 256 * 1024  # [B] decompressed; below this any ratio is harmless


class ArchiveRefused(Exception):
    """The archive breaks a rule. The text is for the user."""


@dataclass(frozen=True, slots=True)
class Member:
    """One entry: its raw name and its content, None for a folder."""

    name: str
    content: bytes | None

    @property
    def shown(self) -> str:
        """The name for a message."""
        return shown(self.name)


def shown(name: str) -> str:
    """Return a name for a message: shortened, with unprintable characters escaped."""
    text = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in name)
    return text if len(text) <= 60 else f"{text[:40]}...{text[-15:]}"


class SizeLimit:
    """The limit of the decompressed size over all members."""

    def __init__(self, maximum: int, *, overhead: int = 0) -> None:
        self._maximum = maximum  # [B]
        self._overhead = overhead  # [B] in addition, for the headers of tar
        self._used = 0

    def add(self, count: int) -> None:
        """Count decompressed bytes; raises ArchiveRefused."""
        self._used += count
        if self._used > self._maximum + self._overhead:
            raise ArchiveRefused(
                f"The unpacked archive is larger than {self._maximum / 2**20:g} MiB."
            )


def inflate(compressed: bytes, wbits: int, limit: SizeLimit, name: str) -> tuple[bytes, bytes]:
    """Return the decompressed content and the bytes after its end.

    Raises
    ------
    ArchiveRefused
        The data is truncated, damaged or too large.
    """
    decompressor = zlib.decompressobj(wbits)
    parts, rest, total = [], compressed, 0
    try:
        while not decompressor.eof:
            part = decompressor.decompress(rest, CHUNK)
            rest = decompressor.unconsumed_tail
            total += len(part)
            if total > RATIO_FROM and total > RATIO_MAX * len(compressed):
                raise ArchiveRefused(
                    f"{name} unpacks to more than {RATIO_MAX} times its size, like a zip bomb."
                )
            limit.add(len(part))
            if not part and not rest and not decompressor.eof:
                raise ArchiveRefused(f"{name} is truncated.")
            parts.append(part)
    except zlib.error:
        raise ArchiveRefused(f"{name} cannot be unpacked: the archive is damaged.") from None
    return b"".join(parts), decompressor.unused_data
