"""Archives that no tool would write: each field of a zip can be set independently."""

import gzip
import io
import struct
import tarfile
import zipfile
import zlib
from dataclasses import dataclass, field, replace
from typing import Any

MAIN = b"""\
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
"""
LINK, DEVICE, PIPE = 0o120777, 0o020666, 0o010666
UNIX = 3 << 8
UTF8, STREAMED, ENCRYPTED = 1 << 11, 1 << 3, 1


@dataclass(frozen=True)
class Entry:
    """A member as both of its headers describe it; `local` and `central` make them differ."""

    name: bytes
    content: bytes = b""
    method: int = 0
    flags: int = UTF8
    mode: int = 0o100644
    extra: bytes = b""
    local: dict[str, Any] = field(default_factory=dict)
    central: dict[str, Any] = field(default_factory=dict)

    def packed(self) -> bytes:
        if self.method != zipfile.ZIP_DEFLATED:
            return self.content
        compressor = zlib.compressobj(9, zlib.DEFLATED, -15)
        return compressor.compress(self.content) + compressor.flush()

    def fields(self, changes: dict[str, Any]) -> dict[str, Any]:
        values = {
            "flags": self.flags,
            "method": self.method,
            "crc": zlib.crc32(self.content),
            "packed": len(self.packed()),
            "size": len(self.content),
            "name": self.name,
            "offset": None,
        }
        return values | changes


def zipped(*entries: Entry, tail: bytes = b"", end: dict[str, int] | None = None) -> bytes:
    """Return a zip archive of the entries, with the headers that they describe."""
    body, directory = bytearray(), bytearray()
    for entry in entries:
        offset = len(body)
        body += _local(entry) + entry.packed()
        directory += _central(entry, offset)
    values = {"count": len(entries), "size": len(directory), "start": len(body)} | (end or {})
    record = struct.pack(
        "<4s4H2LH", b"PK\x05\x06", 0, 0, values["count"], values["count"], values["size"],
        values["start"], 0,
    )  # fmt: skip
    return bytes(body + directory + record + tail)


def _local(entry: Entry) -> bytes:
    f = entry.fields(entry.local)
    sizes = (f["crc"], f["packed"], f["size"], len(f["name"]), 0)
    head = struct.pack("<4s5H3L2H", b"PK\x03\x04", 20, f["flags"], f["method"], 0, 33, *sizes)
    return head + bytes(f["name"])


def _central(entry: Entry, offset: int) -> bytes:
    f = entry.fields(entry.central)
    position = offset if f["offset"] is None else f["offset"]
    return (
        struct.pack(
            "<4s6H3L5H2L", b"PK\x01\x02", UNIX | 20, 20, f["flags"], f["method"], 0, 33, f["crc"],
            f["packed"], f["size"], len(f["name"]), len(entry.extra), 0, 0, 0, entry.mode << 16,
            position,
        )
        + bytes(f["name"])
        + entry.extra
    )  # fmt: skip


def beside_main(*entries: Entry) -> bytes:
    """Return an archive that would be fine without these entries."""
    return zipped(Entry(b"main.py", MAIN), *entries)


def named(name: str | bytes, **more: Any) -> bytes:
    """Return an archive with one more file of this name."""
    raw = name.encode() if isinstance(name, str) else name
    return beside_main(Entry(raw, b"x = 1\n", **more))


def damaged(name: bytes) -> Entry:
    """Return a member that says it is compressed and holds what no decompressor accepts."""
    deflated = {"method": zipfile.ZIP_DEFLATED}
    return Entry(name, b"\xff" * 40, local=deflated, central=deflated)


def overlapping() -> bytes:
    """Return an archive of two entries that share their content, as in the most effective bombs."""
    twin = Entry(b"twin.py", MAIN)
    return zipped(Entry(b"main.py", MAIN), replace(twin, central={"offset": 0}))


def nested_member() -> bytes:
    """Return an archive whose second member is inside the content of the first one."""
    inner = _local(Entry(b"inner.py", MAIN)) + MAIN
    outer = Entry(b"main.py", MAIN + inner)
    head = len(_local(outer)) + len(MAIN)
    body = _local(outer) + outer.content
    directory = _central(outer, 0) + _central(Entry(b"inner.py", MAIN), head)
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 2, 2, len(directory), len(body), 0)
    return body + directory + end


def tarred(*entries: tarfile.TarInfo, content: bytes = b"") -> bytes:
    """Return a .tar.gz of main.py and the entries, which all have the same content."""
    target = io.BytesIO()
    with tarfile.open(fileobj=target, mode="w:gz") as archive:
        main = tarfile.TarInfo("main.py")
        main.size = len(MAIN)
        archive.addfile(main, io.BytesIO(MAIN))
        for entry in entries:
            entry.size = len(content) if entry.isreg() else 0
            archive.addfile(entry, io.BytesIO(content))
    return target.getvalue()


def tar_entry(name: str, member_type: bytes = tarfile.REGTYPE, link: str = "") -> tarfile.TarInfo:
    """Return the header of a member."""
    entry = tarfile.TarInfo(name)
    entry.type, entry.linkname = member_type, link
    return entry


def bomb(size: int) -> bytes:
    """Return an archive that is small and unpacks to `size` bytes."""
    return beside_main(Entry(b"zeros.bin", bytes(size), zipfile.ZIP_DEFLATED))


def gzip_bomb(size: int) -> bytes:
    """Return a .tar.gz that unpacks to `size` bytes of zeros."""
    return gzip.compress(bytes(size), 9)
