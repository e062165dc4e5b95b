"""Reading .tar.gz: decompressed in bounded memory; only plain files and folders are accepted."""

import io
import tarfile
import zlib
from collections.abc import Iterator

from seamark.programs.archives.reading import ArchiveRefused, Member, SizeLimit, inflate, shown

HEADERS_MAX = 1 << 20  # [B] for the headers of the members
_TYPES = {
    tarfile.SYMTYPE: "a link",
    tarfile.LNKTYPE: "a link",
    tarfile.CHRTYPE: "a device",
    tarfile.BLKTYPE: "a device",
    tarfile.FIFOTYPE: "a pipe",
    tarfile.GNUTYPE_SPARSE: "a sparse file",
}


def members_of_tar_gz(data: bytes, *, size_max: int) -> Iterator[Member]:
    """Yield the members in order, at most `size_max` bytes [B]; raises ArchiveRefused."""
    if not data.startswith(b"\x1f\x8b"):
        raise ArchiveRefused("The file is not a .tar.gz archive, although its name says so.")
    limit = SizeLimit(size_max)
    whole = SizeLimit(size_max, overhead=HEADERS_MAX)
    content, rest = inflate(data, 16 + zlib.MAX_WBITS, whole, "The archive")
    if rest:
        raise ArchiveRefused("There is data after the end of the archive.")
    try:
        with tarfile.open(fileobj=io.BytesIO(content), mode="r:", errors="strict") as archive:
            for entry in archive:
                yield _member(archive, entry, limit)
    except (tarfile.TarError, EOFError, UnicodeError, ValueError, RecursionError):
        raise ArchiveRefused("The archive cannot be read: it is damaged or truncated.") from None


def _member(archive: tarfile.TarFile, entry: tarfile.TarInfo, limit: SizeLimit) -> Member:
    if entry.isdir():
        return Member(entry.name, None)
    if not entry.isreg() or entry.issparse():
        kind = _TYPES.get(entry.type, "of an unknown type")
        raise ArchiveRefused(f"{shown(entry.name)} is {kind}; only files and folders are allowed.")
    limit.add(entry.size)
    source = archive.extractfile(entry)
    content = b"" if source is None else source.read()
    if len(content) != entry.size:
        raise ArchiveRefused(f"{shown(entry.name)} is truncated.")
    return Member(entry.name, content)
