"""Reading .zip strictly: archives that two programs could read differently are refused.

Every byte has exactly one purpose: the members follow each other from the first byte, then come the
central directory and its end record. The local header of each member must agree with the central
directory. Formats: PKWARE, .ZIP File Format Specification 6.3.10, section 4.3.
"""

import stat
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

from seamark.programs.archives.reading import ArchiveRefused, Member, SizeLimit, inflate, shown

LOCAL = struct.Struct("<4s5H3L2H")
CENTRAL = struct.Struct("<4s6H3L5H2L")
END = struct.Struct("<4s4H2LH")
DESCRIPTOR = struct.Struct("<3L")  # CRC and both sizes, after a member written as a stream
SIGNED = b"PK\x07\x08"  # optional signature before a descriptor
ENCRYPTED, STREAMED, UTF8, MASKED = 1 << 0, 1 << 3, 1 << 11, 1 << 13
STRONG = 1 << 6
STORED, DEFLATED = 0, 8
LARGE = 0xFFFFFFFF  # marks a number stored in a Zip64 record
UNIX = (3, 19)  # systems whose attributes contain the file mode: Unix, macOS
UNICODE_NAME = 0x7075  # the extra field with a Unicode name
COMMENT_MAX = 65535


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of the central directory."""

    name: str
    raw: bytes
    flags: int
    method: int
    crc: int
    compressed: int  # [B]
    size: int  # [B]
    offset: int  # [B] of the local header

    @property
    def shown(self) -> str:
        """The name for a message."""
        return shown(self.name)


def members_of_zip(data: bytes, *, size_max: int) -> Iterator[Member]:
    """Yield the members in order, at most `size_max` bytes [B]; raises ArchiveRefused."""
    start, count = _directory(data)
    entries = sorted(_entries(data, start, count), key=lambda entry: entry.offset)
    limit, at = SizeLimit(size_max), 0
    for entry in entries:
        if entry.offset != at:
            what = "overlaps the previous file" if entry.offset < at else "follows a gap"
            raise ArchiveRefused(f"{entry.shown} {what}; archives must not have gaps or overlaps.")
        content, at = _content(data, entry, start, limit)
        yield Member(entry.name, None if entry.name.endswith("/") else content)
    if at != start:
        raise ArchiveRefused("The archive contains data that belongs to no file.")


def _directory(data: bytes) -> tuple[int, int]:
    """Return offset and number of entries of the central directory."""
    if not data.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        raise ArchiveRefused("The file is not a .zip archive, although its name says so.")
    at = data.rfind(b"PK\x05\x06", max(0, len(data) - END.size - COMMENT_MAX))
    if at < 0 or at + END.size > len(data):
        raise ArchiveRefused("The archive is truncated: its end record is missing.")
    _, disk, first, here, count, size, start, comment = END.unpack_from(data, at)
    if disk or first or here != count:
        raise ArchiveRefused("The archive is split into several parts; send a single archive.")
    if count == 0xFFFF or LARGE in (size, start):
        raise ArchiveRefused("Archives in the Zip64 format are not supported.")
    if at + END.size + comment != len(data):
        raise ArchiveRefused("There is data after the end of the archive.")
    if start + size != at:
        raise ArchiveRefused("The central directory is not at the position stated in the archive.")
    return start, count


def _entries(data: bytes, start: int, count: int) -> Iterator[Entry]:
    """Yield the entries of the central directory, each validated on its own."""
    at = start
    for _ in range(count):
        if data[at : at + 4] != b"PK\x01\x02" or at + CENTRAL.size > len(data):
            raise ArchiveRefused("The central directory of the archive is damaged.")
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
        raise ArchiveRefused("The central directory of the archive is damaged.")


def _text(raw: bytes, flags: int) -> str:
    """Return a name; without the UTF-8 flag only ASCII is unambiguous."""
    try:
        return raw.decode("utf-8" if flags & UTF8 else "ascii")
    except UnicodeDecodeError:
        name = shown(raw.decode("ascii", "backslashreplace"))
        raise ArchiveRefused(f"The name {name} is not UTF-8; rename the file.") from None


def _check(entry: Entry, extra: bytes, made: int, attributes: int, disk: int) -> None:
    mode = attributes >> 16 if made >> 8 in UNIX else 0
    file_type = stat.S_IFMT(mode)
    rules = (
        (disk != 0, "is in another part of the archive"),
        (bool(entry.flags & (ENCRYPTED | STRONG | MASKED)), "is encrypted"),
        (
            entry.method not in (STORED, DEFLATED),
            f"is compressed by method {entry.method}, not deflate",
        ),
        (LARGE in (entry.compressed, entry.size, entry.offset), "uses the Zip64 format"),
        (stat.S_ISLNK(mode), "is a link; only files and folders are allowed"),
        (file_type not in (0, stat.S_IFREG, stat.S_IFDIR, stat.S_IFLNK), "is a device or a pipe"),
        (entry.method == STORED and entry.compressed != entry.size, "has two different sizes"),
        (entry.name.endswith("/") and entry.size > 0, "is a folder with content"),
        (
            not entry.name.endswith("/") and stat.S_ISDIR(mode),
            "is a folder without its slash",
        ),
        (_second_name(extra) not in (None, entry.raw), "has two different names"),
    )
    if wrong := next((sentence for broken, sentence in rules if broken), None):
        raise ArchiveRefused(f"{entry.shown} {wrong}.")


def _second_name(extra: bytes) -> bytes | None:
    """Return the name in the Unicode extra field, if there is one."""
    at = 0
    while at + 4 <= len(extra):
        field, size = struct.unpack_from("<2H", extra, at)
        if field == UNICODE_NAME:
            return extra[at + 9 : at + 4 + size]
        at += 4 + size
    return None


def _content(data: bytes, entry: Entry, end: int, limit: SizeLimit) -> tuple[bytes, int]:
    """Return the content of a member and the offset at which the next one must begin."""
    begin = _after_local_header(data, entry, end)
    compressed = data[begin : begin + entry.compressed]
    if begin + entry.compressed > end:
        raise ArchiveRefused(f"{entry.shown} overlaps the central directory.")
    if entry.method == STORED:
        limit.add(len(compressed))
        content, rest = compressed, b""
    else:
        content, rest = inflate(compressed, -zlib.MAX_WBITS, limit, entry.shown)
    if rest or len(content) != entry.size:
        raise ArchiveRefused(f"{entry.shown} does not have the size stated in the archive.")
    if zlib.crc32(content) != entry.crc:
        raise ArchiveRefused(f"{entry.shown} is damaged: its checksum is wrong.")
    at = begin + entry.compressed
    return content, at + (_descriptor(data, at, entry) if entry.flags & STREAMED else 0)


def _after_local_header(data: bytes, entry: Entry, end: int) -> int:
    """Return the offset of the content; the local header must agree with the central directory."""
    at = entry.offset
    if at + LOCAL.size > end or data[at : at + 4] != b"PK\x03\x04":
        raise ArchiveRefused(f"{entry.shown} is not at the position stated in the archive.")
    _, _, flags, method, _, _, crc, compressed, size, name, extra = LOCAL.unpack_from(data, at)
    begin: int = at + LOCAL.size
    same = (flags, method, data[begin : begin + name]) == (entry.flags, entry.method, entry.raw)
    local = (crc, compressed, size)
    central = (entry.crc, entry.compressed, entry.size)
    if not same or (local != central and not (entry.flags & STREAMED and local == (0, 0, 0))):
        raise ArchiveRefused(f"{entry.shown} has contradictory headers.")
    return begin + int(name) + int(extra)


def _descriptor(data: bytes, at: int, entry: Entry) -> int:
    """Return the length [B] of the data descriptor after a streamed member, which must agree."""
    signed = len(SIGNED) if data[at : at + 4] == SIGNED else 0
    fields = data[at + signed : at + signed + DESCRIPTOR.size]
    if fields != DESCRIPTOR.pack(entry.crc, entry.compressed, entry.size):
        raise ArchiveRefused(f"{entry.shown} has contradictory headers.")
    return signed + DESCRIPTOR.size
