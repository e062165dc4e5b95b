"""What the readers of archives share: a member, a refusal, counting while unpacking."""

import zlib
from dataclasses import dataclass

CHUNK = 64 * 1024  # [B] unpacked at a time
RATIO_MAX = 200  # unpacked : packed; text reaches 20, weights 2, a bomb 1000
RATIO_FROM = 256 * 1024  # [B] below it no ratio does harm


class ArchiveRefused(Exception):
    """The archive breaks a rule. The text is for its owner."""


@dataclass(frozen=True, slots=True)
class Member:
    """One entry: its name as it stands there, its content; None for a folder."""

    name: str
    content: bytes | None

    @property
    def shown(self) -> str:
        """The name for a sentence: short, without characters that hide others."""
        return shown(self.name)


def shown(name: str) -> str:
    """Return a name as it can be put into a sentence."""
    text = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in name)
    return text if len(text) <= 60 else f"{text[:40]}...{text[-15:]}"


class Room:
    """How much may still be unpacked, over all members."""

    def __init__(self, most: int, *, beside: int = 0) -> None:
        self._most = most
        self._beside = beside  # [B] that are no content: what tar puts around its files
        self._used = 0

    def take(self, count: int) -> None:
        """Count bytes that came out; raises ArchiveRefused."""
        self._used += count
        if self._used > self._most + self._beside:
            raise ArchiveRefused(f"Unpacked, the archive has more than {self._most / 2**20:g} MiB.")


def inflate(packed: bytes, wbits: int, room: Room, what: str) -> tuple[bytes, bytes]:
    """Return what `packed` holds, and the bytes behind its end, counting while it unpacks.

    Raises
    ------
    ArchiveRefused
        It is cut, damaged or too much.
    """
    machine = zlib.decompressobj(wbits)
    parts, rest, total = [], packed, 0
    try:
        while not machine.eof:
            part = machine.decompress(rest, CHUNK)
            rest = machine.unconsumed_tail
            total += len(part)
            if total > RATIO_FROM and total > RATIO_MAX * len(packed):
                raise ArchiveRefused(
                    f"{what} unpacks to more than {RATIO_MAX} times its size, as a bomb does."
                )
            room.take(len(part))
            if not part and not rest and not machine.eof:
                raise ArchiveRefused(f"{what} ends in the middle: the archive was cut.")
            parts.append(part)
    except zlib.error:
        raise ArchiveRefused(f"{what} cannot be unpacked: the archive is damaged.") from None
    return b"".join(parts), machine.unused_data
