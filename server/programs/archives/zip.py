"""Reading .zip strictly: an archive that two programs could read in two ways is refused.

Every byte must belong to exactly one thing: the members one behind the other from the first byte,
the central directory behind them, its end record at the end. Each member's local header must say
what the central one says. Figures: PKWARE, .ZIP File Format Specification 6.3.10, chapter 4.3.
"""

import stat
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

from seamark.server.programs.archives.reading import ArchiveRefused, Member, Room, inflate, shown

LOCAL = struct.Struct("<4s5H3L2H")
CENTRAL = struct.Struct("<4s6H3L5H2L")
END = struct.Struct("<4s4H2LH")
DESCRIPTOR = struct.Struct("<3L")  # CRC and both sizes behind a member that was written as a stream
SIGNED = b"PK\x07\x08"  # stands before a descriptor, or not
ENCRYPTED, STREAMED, UTF8, MASKED = 1 << 0, 1 << 3, 1 << 11, 1 << 13
STRONG = 1 << 6
STORED, DEFLATED = 0, 8
LARGE = 0xFFFFFFFF  # where Zip64 keeps the number elsewhere
UNIX = (3, 19)  # systems whose attributes hold the mode of a file: Unix, macOS
UNICODE_NAME = 0x7075  # the extra field with a second name
COMMENT_MAX = 65535


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of the central directory."""

    name: str
    raw: bytes
    flags: int
    method: int
    crc: int
    packed: int  # [B]
    size: int  # [B]
    offset: int  # [B] of the local header

    @property
    def shown(self) -> str:
        """The name for a sentence."""
        return shown(self.name)


def members_of_zip(data: bytes, *, most: int) -> Iterator[Member]:
    """Yield the members in order; raises ArchiveRefused. At most `most` bytes are unpacked."""
    start, count = _directory(data)
    entries = sorted(_entries(data, start, count), key=lambda entry: entry.offset)
    room, at = Room(most), 0
    for entry in entries:
        if entry.offset != at:
            what = "overlaps the one before it" if entry.offset < at else "begins behind a gap"
            raise ArchiveRefused(f"{entry.shown} {what}; archives are packed without gaps.")
        content, at = _content(data, entry, start, room)
        yield Member(entry.name, None if entry.name.endswith("/") else content)
    if at != start:
        raise ArchiveRefused("There are bytes in the archive that belong to no file.")


def _directory(data: bytes) -> tuple[int, int]:
    """Return offset and number of entries of the central directory."""
    if not data.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        raise ArchiveRefused("This is not a .zip archive, whatever its name says.")
    at = data.rfind(b"PK\x05\x06", max(0, len(data) - END.size - COMMENT_MAX))
    if at < 0 or at + END.size > len(data):
        raise ArchiveRefused("The end of the archive is missing: it was cut.")
    _, disk, first, here, count, size, start, comment = END.unpack_from(data, at)
    if disk or first or here != count:
        raise ArchiveRefused("The archive is one part of several; send it as one.")
    if count == 0xFFFF or LARGE in (size, start):
        raise ArchiveRefused("The archive has the form for more than 4 GiB (Zip64).")
    if at + END.size + comment != len(data):
        raise ArchiveRefused("There are bytes behind the end of the archive.")
    if start + size != at:
        raise ArchiveRefused("The archive's list of files is not where the archive says.")
    return start, count


def _entries(data: bytes, start: int, count: int) -> Iterator[Entry]:
    """Yield the central directory's entries, each checked by itself."""
    at = start
    for _ in range(count):
        if data[at : at + 4] != b"PK\x01\x02" or at + CENTRAL.size > len(data):
            raise ArchiveRefused("The archive's list of files is damaged.")
        fields = CENTRAL.unpack_from(data, at)
        (_, made, _, flags, method, _, _, crc, packed, size, name, extra, comment) = fields[:13]
        disk, _, attributes, offset = fields[13:]
        begin = at + CENTRAL.size
        raw, more = data[begin : begin + name], data[begin + name : begin + name + extra]
        at = begin + name + extra + comment
        entry = Entry(_text(raw, flags), raw, flags, method, crc, packed, size, offset)
        _check(entry, more, made, attributes, disk)
        yield entry
    if data[at : at + 4] != b"PK\x05\x06":
        raise ArchiveRefused("The archive's list of files is damaged.")


def _text(raw: bytes, flags: int) -> str:
    """Return a name; without the mark for UTF-8 only ASCII means the same everywhere."""
    try:
        return raw.decode("utf-8" if flags & UTF8 else "ascii")
    except UnicodeDecodeError:
        said = shown(raw.decode("ascii", "backslashreplace"))
        raise ArchiveRefused(f"The name {said} is not in UTF-8; rename the file.") from None


def _check(entry: Entry, extra: bytes, made: int, attributes: int, disk: int) -> None:
    mode = attributes >> 16 if made >> 8 in UNIX else 0
    kind = stat.S_IFMT(mode)
    rules = (
        (disk != 0, "lies on another part of the archive"),
        (bool(entry.flags & (ENCRYPTED | STRONG | MASKED)), "is encrypted"),
        (
            entry.method not in (STORED, DEFLATED),
            f"is packed by method {entry.method}, not deflate",
        ),
        (LARGE in (entry.packed, entry.size, entry.offset), "has the form for more than 4 GiB"),
        (stat.S_ISLNK(mode), "is a link; only files and folders are taken"),
        (kind not in (0, stat.S_IFREG, stat.S_IFDIR, stat.S_IFLNK), "is a device or a pipe"),
        (entry.method == STORED and entry.packed != entry.size, "has two sizes"),
        (entry.name.endswith("/") and entry.size > 0, "is a folder with content"),
        (not entry.name.endswith("/") and stat.S_ISDIR(mode), "is a folder without its slash"),
        (_second_name(extra) not in (None, entry.raw), "has two names"),
    )
    if wrong := next((sentence for broken, sentence in rules if broken), None):
        raise ArchiveRefused(f"{entry.shown} {wrong}.")


def _second_name(extra: bytes) -> bytes | None:
    """Return the name in the extra field for Unicode, if there is one."""
    at = 0
    while at + 4 <= len(extra):
        kind, size = struct.unpack_from("<2H", extra, at)
        if kind == UNICODE_NAME:
            return extra[at + 9 : at + 4 + size]
        at += 4 + size
    return None


def _content(data: bytes, entry: Entry, end: int, room: Room) -> tuple[bytes, int]:
    """Return the content of a member and where the next one must begin."""
    begin = _behind_local_header(data, entry, end)
    packed = data[begin : begin + entry.packed]
    if begin + entry.packed > end:
        raise ArchiveRefused(f"{entry.shown} overlaps the list of files.")
    if entry.method == STORED:
        room.take(len(packed))
        content, behind = packed, b""
    else:
        content, behind = inflate(packed, -zlib.MAX_WBITS, room, entry.shown)
    if behind or len(content) != entry.size:
        raise ArchiveRefused(f"{entry.shown} has another size than the archive says.")
    if zlib.crc32(content) != entry.crc:
        raise ArchiveRefused(f"{entry.shown} is damaged: its checksum is wrong.")
    at = begin + entry.packed
    return content, at + (_descriptor(data, at, entry) if entry.flags & STREAMED else 0)


def _behind_local_header(data: bytes, entry: Entry, end: int) -> int:
    """Return where the packed bytes begin; the local header must say what the central one says."""
    at = entry.offset
    if at + LOCAL.size > end or data[at : at + 4] != b"PK\x03\x04":
        raise ArchiveRefused(f"{entry.shown} is not where the archive says.")
    _, _, flags, method, _, _, crc, packed, size, name, extra = LOCAL.unpack_from(data, at)
    begin: int = at + LOCAL.size
    same = (flags, method, data[begin : begin + name]) == (entry.flags, entry.method, entry.raw)
    told = (crc, packed, size)
    known = (entry.crc, entry.packed, entry.size)
    if not same or (told != known and not (entry.flags & STREAMED and told == (0, 0, 0))):
        raise ArchiveRefused(f"{entry.shown} is described in two ways in the archive.")
    return begin + int(name) + int(extra)


def _descriptor(data: bytes, at: int, entry: Entry) -> int:
    """Return the length [B] of the record behind a streamed member, which must say the same."""
    signed = len(SIGNED) if data[at : at + 4] == SIGNED else 0
    fields = data[at + signed : at + signed + DESCRIPTOR.size]
    if fields != DESCRIPTOR.pack(entry.crc, entry.packed, entry.size):
        raise ArchiveRefused(f"{entry.shown} is described in two ways in the archive.")
    return signed + DESCRIPTOR.size
