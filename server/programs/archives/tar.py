"""Reading .tar.gz: unpacked in bounded memory first, then only plain files and folders."""

import io
import tarfile
import zlib
from collections.abc import Iterator

from seamark.server.programs.archives.reading import ArchiveRefused, Member, Room, inflate, shown

WHAT = "The archive"
HEADROOM = 1 << 20  # [B] for the headers of the members
_KINDS = {
    tarfile.SYMTYPE: "a link",
    tarfile.LNKTYPE: "a link",
    tarfile.CHRTYPE: "a device",
    tarfile.BLKTYPE: "a device",
    tarfile.FIFOTYPE: "a pipe",
    tarfile.GNUTYPE_SPARSE: "a sparse file",
}


def members_of_tar_gz(data: bytes, *, most: int) -> Iterator[Member]:
    """Yield the members in order; raises ArchiveRefused. At most `most` bytes are unpacked."""
    if not data.startswith(b"\x1f\x8b"):
        raise ArchiveRefused("This is not a .tar.gz archive, whatever its name says.")
    room = Room(most)
    packed, behind = inflate(data, 16 + zlib.MAX_WBITS, Room(most, beside=HEADROOM), WHAT)
    if behind:
        raise ArchiveRefused("There are bytes behind the end of the archive.")
    try:
        with tarfile.open(fileobj=io.BytesIO(packed), mode="r:", errors="strict") as archive:
            for entry in archive:
                yield _member(archive, entry, room)
    except (tarfile.TarError, EOFError, UnicodeError, ValueError, RecursionError):
        raise ArchiveRefused("The archive cannot be read: it is damaged or cut.") from None


def _member(archive: tarfile.TarFile, entry: tarfile.TarInfo, room: Room) -> Member:
    if entry.isdir():
        return Member(entry.name, None)
    if not entry.isreg() or entry.issparse():
        kind = _KINDS.get(entry.type, "of an unknown kind")
        raise ArchiveRefused(f"{shown(entry.name)} is {kind}; only files and folders are taken.")
    room.take(entry.size)
    source = archive.extractfile(entry)
    content = b"" if source is None else source.read()
    if len(content) != entry.size:
        raise ArchiveRefused(f"{shown(entry.name)} ends in the middle: the archive was cut.")
    return Member(entry.name, content)
