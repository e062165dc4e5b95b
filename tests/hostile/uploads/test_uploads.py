"""Hostile uploads: POST /runs refuses each of them with its own reason."""

import io
import json
import tarfile
import tracemalloc
import zipfile
from collections.abc import Callable

import pytest
from sqlalchemy import func, select

from seamark.server.database.tables import Run
from tests.hostile.uploads import archives as make
from tests.hostile.uploads.archives import MAIN, Entry, beside_main, named, tar_entry, zipped
from tests.server.api.conftest import Site

DEFLATED = zipfile.ZIP_DEFLATED
NESTED = zipped(Entry(b"main.py", MAIN))
UNICODE_NAME = b"\x75\x70\x0d\x00\x01\0\0\0\0other.py"
GOOD = zipped(Entry(b"main.py", MAIN))
Build = Callable[[], bytes]

ZIPS: dict[str, tuple[Build, str]] = {
    "points outside": (lambda: named("../out.py"), "points outside the archive"),
    "points outside in the middle": (lambda: named("a/../../out.py"), "points outside the archive"),
    "absolute": (lambda: named("/etc/passwd"), "is absolute"),
    "a drive": (lambda: named("C:evil.py"), "is absolute"),
    "a backslash": (lambda: named("..\\out.py"), "contains a backslash"),
    "a zero byte": (lambda: named("a\0.py"), "invisible characters"),
    "a line break": (lambda: named("a\n.py"), "invisible characters"),
    "a name from right to left": (lambda: named("a\u202egpj.py"), "invisible characters"),
    "a hidden space": (lambda: named("ma\u200bin.py"), "invisible characters"),
    "a lookalike of a dot": (lambda: named("\uff0e\uff0e/out.py"), "look like others"),
    "a lookalike of a slash": (lambda: named("a\uff0fb.py"), "look like others"),
    "reserved": (lambda: named("aux.py"), "reserved on Windows"),
    "a dot at the end": (lambda: named("main.py."), "trailing space or dot"),
    "an empty part": (lambda: named("a//b.py"), "has an empty part"),
    "a stream of NTFS": (lambda: named("main.py:evil"), "one of the characters"),
    "too long": (lambda: named("a" * 300), "longer than 180"),
    "too deep": (lambda: named("a/" * 12 + "b.py"), "folders deep"),
    "twice": (lambda: named("main.py"), "main.py is in the archive twice"),
    "differs in case": (lambda: named("Main.py"), "differ only in upper and lower case"),
    "differs in its accents": (
        lambda: beside_main(Entry("\u00e9.py".encode()), Entry("e\u0301.py".encode())),
        "differ only",
    ),
    "a file and a folder": (
        lambda: beside_main(Entry(b"a", b"x"), Entry(b"a/b.py", b"x")),
        "a is both a file and a folder",
    ),
    "not UTF-8": (lambda: named(b"\xff.py"), "is not UTF-8"),
    "in an old code page": (lambda: named(b"\x82.py", flags=0), "is not UTF-8"),
    "two names": (lambda: named("a.py", extra=UNICODE_NAME), "two different names"),
    "a link": (lambda: named("a.py", mode=make.LINK), "is a link"),
    "a device": (lambda: named("a.py", mode=make.DEVICE), "is a device"),
    "a pipe": (lambda: named("a.py", mode=make.PIPE), "is a device or a pipe"),
    "encrypted": (lambda: named("a.py", flags=make.ENCRYPTED), "is encrypted"),
    "an archive in it": (lambda: beside_main(Entry(b"a.bin", NESTED)), "is a nested archive"),
    "a tar in it": (
        lambda: beside_main(Entry(b"a.dat", bytes(257) + b"ustar\x0000" + bytes(248))),
        "is a nested archive (tar)",
    ),
    "a bomb": (lambda: make.bomb(4 << 20), "like a zip bomb"),
    "a bomb that lies about its size": (
        lambda: beside_main(
            Entry(b"a", bytes(4 << 20), DEFLATED, local={"size": 9}, central={"size": 9})
        ),
        "like a zip bomb",
    ),
    "many small bombs": (
        lambda: beside_main(*(Entry(b"%d" % n, bytes(250_000), DEFLATED) for n in range(40))),
        "larger than 8 MiB",
    ),
    "too many": (
        lambda: beside_main(*(Entry(b"%d.py" % n) for n in range(300))),
        "more than 256 entries",
    ),
    "truncated in the middle": (lambda: GOOD[: len(GOOD) // 2], "is truncated"),
    "truncated at the end": (lambda: GOOD[:-3], "is truncated"),
    "a truncated file": (
        lambda: beside_main(Entry(b"a", b"\x4b", 8, local={"packed": 1}, central={"packed": 1})),
        "a is truncated",
    ),
    "overlapping": (make.overlapping, "overlaps the previous file"),
    "one inside the other": (make.nested_member, "overlaps the previous file"),
    "another name inside": (
        lambda: beside_main(Entry(b"a.py", b"x", local={"name": b"b.py"})),
        "contradictory headers",
    ),
    "another size inside": (
        lambda: beside_main(Entry(b"a.py", b"x", local={"size": 7})),
        "contradictory headers",
    ),
    "a wrong checksum": (
        lambda: beside_main(Entry(b"a.py", b"x", local={"crc": 1}, central={"crc": 1})),
        "its checksum is wrong",
    ),
    "another method": (lambda: named("a.py", method=14), "compressed by method 14"),
    "leading data": (lambda: b"#!/bin/sh\n" + GOOD, "not a .zip archive"),
    "trailing data": (lambda: GOOD + b"evil", "data after the end"),
    "central directory elsewhere": (
        lambda: zipped(Entry(b"main.py", MAIN), end={"start": 3}),
        "not at the position stated",
    ),
    "more files than it lists": (
        lambda: zipped(Entry(b"main.py", MAIN), Entry(b"a.py"), end={"count": 1}),
        "damaged",
    ),
    "one of several": (
        lambda: GOOD[:-18] + b"\1\0" + GOOD[-16:],
        "split into several parts",
    ),
    "of more than 4 GiB": (
        lambda: zipped(Entry(b"main.py", MAIN), end={"count": 0xFFFF}),
        "Zip64",
    ),
    "no main.py": (lambda: zipped(Entry(b"a.py", MAIN)), "needs one of main.py (Python)"),
    "nothing": (zipped, "contains no files"),
    "only metadata of macOS": (
        lambda: zipped(Entry(b"__MACOSX/main.py", MAIN)),
        "contains no files",
    ),
    "not a zip": (lambda: MAIN, "not a .zip archive"),
    "a syntax error": (
        lambda: beside_main(Entry(b"pid.py", b"def f(:\n")),
        "pid.py, line 1: invalid syntax",
    ),
}
TARS: dict[str, tuple[Build, str]] = {
    "points outside": (lambda: make.tarred(tar_entry("../out.py")), "points outside the archive"),
    "absolute": (lambda: make.tarred(tar_entry("/etc/x")), "is absolute"),
    "a link out": (
        lambda: make.tarred(tar_entry("a.py", tarfile.SYMTYPE, "/etc/shadow")),
        "is a link",
    ),
    "a hard link": (
        lambda: make.tarred(tar_entry("a.py", tarfile.LNKTYPE, "main.py")),
        "is a link",
    ),
    "a device": (lambda: make.tarred(tar_entry("a", tarfile.CHRTYPE)), "is a device"),
    "a pipe": (lambda: make.tarred(tar_entry("a", tarfile.FIFOTYPE)), "is a pipe"),
    "a file in a file": (
        lambda: make.tarred(tar_entry("main.py/a.py")),
        "both a file and a folder",
    ),
    "a bomb": (lambda: make.gzip_bomb(100 << 20), "larger than 8 MiB"),
    "truncated": (lambda: make.tarred()[:-20], "is truncated"),
    "trailing data": (lambda: make.tarred() + b"evil", "data after the end"),
    "not a tar": (lambda: make.gzip_bomb(3000), "contains no files"),
    "not a gzip": (lambda: b"hello", "not a .tar.gz archive"),
}
CASES = [("mine.zip", name, *case) for name, case in ZIPS.items()]
CASES += [("mine.tar.gz", name, *case) for name, case in TARS.items()]


def upload(site: Site, content: bytes, name: str) -> tuple[int, str]:
    """Return the status and the detail of the answer to an upload."""
    run = {"run": json.dumps({"benchmark": "currents-v1"})}
    form = run | {"program": (io.BytesIO(content), name)}
    answer = site.call("owner", "POST", "/api/v1/runs", data=form)
    return answer.status_code, answer.get_json().get("detail", "")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "build", "reason"),
    [(file, build, reason) for file, _, build, reason in CASES],
    ids=[f"{file.split('.')[1]}: {name}" for file, name, *_ in CASES],
)
def test_a_hostile_upload_is_refused_with_its_reason_and_leaves_no_file(
    site: Site, file: str, build: Build, reason: str
) -> None:
    status, sentence = upload(site, build(), file)

    assert (status, reason in sentence) == (422, True), sentence
    assert sentence.startswith(f"{file}: ") or "line" in sentence
    assert not list(site.settings.data.glob("programs/*"))
    with site.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(Run)) == 0


@pytest.mark.slow
def test_a_bomb_never_uses_more_memory_than_the_limit(site: Site) -> None:
    bomb = make.gzip_bomb(200 << 20)
    upload(site, bomb, "warm.tar.gz")

    tracemalloc.start()
    status, _ = upload(site, bomb, "bomb.tar.gz")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert status == 422
    assert peak < 40 << 20


def usual(suffix: str) -> bytes:
    """Return an archive as common tools write it."""
    target = io.BytesIO()
    files = {"main.py": MAIN, "lib/gains.py": b"KP = 0.5\n", "__pycache__/a.pyc": b"x"}
    if suffix == "tar.gz":
        with tarfile.open(fileobj=target, mode="w:gz") as archive:
            archive.addfile(make.tar_entry(".", tarfile.DIRTYPE))
            for name, content in files.items():
                entry = tarfile.TarInfo(f"./robot/{name}")
                entry.size = len(content)
                archive.addfile(entry, io.BytesIO(content))
        return target.getvalue()
    with zipfile.ZipFile(target, "w", DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(f"robot/{name}", content)
        packed.writestr("__MACOSX/._main.py", b"junk")
    return target.getvalue()


def streamed() -> bytes:
    """Return a zip archive written without seeking, as browsers and macOS write them."""

    class Pipe(io.RawIOBase):
        def __init__(self) -> None:
            self.all = bytearray()

        def writable(self) -> bool:
            return True

        def write(self, data: bytes) -> int:  # type: ignore[override]
            self.all += bytes(data)
            return len(data)

    pipe = Pipe()
    with zipfile.ZipFile(pipe, "w", DEFLATED) as packed:
        packed.writestr("main.py", MAIN)
        packed.writestr("lib/gains.py", b"KP = 0.5\n")
    return bytes(pipe.all)


@pytest.mark.slow
def test_the_same_files_have_one_hash_however_they_are_packed(site: Site) -> None:
    for content, name in (
        (usual("zip"), "a.zip"),
        (usual("tar.gz"), "b.tar.gz"),
        (usual("tar.gz"), "c.tgz"),
        (streamed(), "d.zip"),
    ):
        status, detail = upload(site, content, name)
        assert status == 202, detail

    kept = {path.name for path in (site.settings.data / "programs").iterdir()}
    assert len(kept) == 1
    with site.database.reading() as session:
        assert set(session.scalars(select(Run.program_sha256))) == kept
        assert set(session.scalars(select(Run.language))) == {"python"}
