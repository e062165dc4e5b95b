"""Uploaded programs: checked while they are read, kept under their SHA-256, never executed here."""

import fcntl
import hashlib
import os
import re
import secrets
import time
import unicodedata
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.limits import Limits
from seamark.server.programs import archives, python_lint
from seamark.server.programs.archives import ArchiveRefused
from seamark.server.programs.diagnostics import Flaw

_CHUNK = 64 * 1024
_SHA256 = re.compile(r"[0-9a-f]{64}")
_LIMITS = Limits()
TEXT_MAX_BYTES = 2 * 2**20  # of a program that a person writes; archives may have more


class UploadRejected(Exception):
    """The upload breaks a rule. Its text is written for the user and shown on the form."""


class UploadTooLarge(UploadRejected):
    """It is longer than a program of its kind may be."""


@dataclass(frozen=True, slots=True)
class StoredProgram:
    """A program in the store."""

    sha256: str
    name: str
    language: str
    size: int


@dataclass(frozen=True, slots=True)
class Prepared:
    """An upload in normal form, and what is wrong with it as far as reading shows."""

    name: str
    language: str
    content: bytes  # a text, or a plain zip archive (see server/archives)
    flaws: tuple[Flaw, ...] = ()


def store(
    stream: BinaryIO, filename: str, *, limit: int, data: Path, role: str = "controller"
) -> StoredProgram:
    """Check an upload, keep it and return its key; raises UploadRejected with a sentence.

    Parameters
    ----------
    limit : int [byte]
        A longer upload is refused without being read to its end, a text already at
        `TEXT_MAX_BYTES`.
    data : Path
        The data folder of the settings.
    role
        What the benchmark asks for: a key of `seamark.server.programs.interfaces.ROLES`.
    """
    prepared = receive(stream, filename, limit=limit, role=role)
    if prepared.flaws:
        raise UploadRejected(" ".join(_said(flaw) for flaw in prepared.flaws[:3]))
    return keep(prepared, data)


def receive(stream: BinaryIO, filename: str, *, limit: int, role: str) -> Prepared:
    """Return an upload as it would be kept; raises UploadRejected if it is none at all."""
    name = _clean(filename)
    language = _known(name)  # before anything is read
    if language is not None and LANGUAGES[language].is_text:
        limit = min(limit, TEXT_MAX_BYTES)
    return prepare(_read(stream, limit), name, role=role)


def prepare(source: bytes, filename: str, *, role: str = "controller") -> Prepared:
    """Return an upload as it would be kept. Runs nothing of it; raises UploadRejected."""
    name = _clean(filename)
    language = _known(name)
    if not source.strip():
        raise UploadRejected(f"{name} is empty.")
    if language is None or LANGUAGES[language].packed:
        return _prepared_archive(source, name, language, role)
    files = {name: source}
    flaws = python_lint.flaws_of(files, name, role) if language == "python" else []
    if language != "python":
        _check_kind(name, source, language)
    return Prepared(name, language, source, tuple(flaws))


def keep(prepared: Prepared, data: Path) -> StoredProgram:
    """Put a program into the store and return its key."""
    sha256 = hashlib.sha256(prepared.content).hexdigest()
    with _store_lock(data, fcntl.LOCK_SH):
        _write(prepared.content, path(data, sha256))
    return StoredProgram(sha256, prepared.name, prepared.language, len(prepared.content))


def path(data: Path, sha256: str) -> Path:
    """Return where the program with this key is kept."""
    if not _SHA256.fullmatch(sha256):
        raise ValueError(f"not a SHA-256: {sha256!r}")
    return data / "programs" / sha256


def read(data: Path, sha256: str) -> bytes:
    """Return the program's text; raises FileNotFoundError if it is not kept."""
    return path(data, sha256).read_bytes()


def touch(data: Path, sha256: str) -> bool:
    """Keep a program for another while; False if it is gone."""
    with _store_lock(data, fcntl.LOCK_SH):
        place = path(data, sha256)
        if not place.exists():
            return False
        os.utime(place)
    return True


def forget_unused(data: Path, *, older_than_s: float, used: Callable[[str], bool]) -> int:
    """Delete the programs that nothing refers to; return their number.

    A young one may belong to an order that is being written, therefore the age: it is counted from
    the last time that somebody sent it.
    """
    gone, limit = 0, time.time() - older_than_s
    for place in (data / "programs").glob("*"):
        if place.stat().st_mtime >= limit or used(place.name):
            continue
        with _store_lock(data, fcntl.LOCK_EX):  # it may just have been sent again
            if place.stat().st_mtime < limit:
                place.unlink()
                gone += 1
    return gone


def _known(name: str) -> str | None:
    """Return the language by the file's suffix; None for an archive, whose files will tell."""
    language = language_of(name)
    if language is None and not archives.is_archive(name):
        raise UploadRejected(f"{name}: no language is known for this kind of file.")
    return language


def _prepared_archive(source: bytes, name: str, language: str | None, role: str) -> Prepared:
    try:
        files = archives.files_of(source, name, limits=_LIMITS)
        content = archives.normal_form(files, limits=_LIMITS)
    except ArchiveRefused as reason:
        raise UploadRejected(f"{name}: {reason}") from None
    if language is not None:
        return Prepared(name, language, content)
    language, main = _main_of(files, name)
    flaws = python_lint.flaws_of(files, main, role) if language == "python" else []
    return Prepared(name, language, content, tuple(flaws))


def _main_of(files: dict[str, bytes], name: str) -> tuple[str, str]:
    """Return language and path of the file by which an archive is known."""
    for language in LANGUAGES.values():
        for main in language.mains:
            if main in files:
                return language.name, main
    known = ", ".join(f"{main} ({one.label})" for one in LANGUAGES.values() for main in one.mains)
    near = sorted(path for path in files if "/" not in path)[:5]
    raise UploadRejected(
        f"{name}: the archive needs one of {known} at its top; it has "
        f"{', '.join(near) or 'only folders'}."
    )


def _check_kind(name: str, source: bytes, language: str) -> None:
    """Raise UploadRejected if these bytes cannot be a program of this language."""
    refusal = LANGUAGES[language].refusal
    if refusal is None:
        _check_text(name, source)
    elif reason := refusal(source):
        raise UploadRejected(f"{name}: {reason}")


def _check_text(name: str, source: bytes) -> None:
    try:
        source.decode("utf-8")
    except UnicodeDecodeError as error:
        line = source[: error.start].count(b"\n") + 1
        raise UploadRejected(f"{name}, line {line}: the text is not UTF-8.") from None


def _said(flaw: Flaw) -> str:
    """Return a flaw as a sentence of a refusal."""
    where = f"{flaw.file}, line {flaw.line}" if flaw.line else str(flaw.file)
    return f"{where}: {flaw.sentence}"


def _clean(filename: str) -> str:
    """Return the last part of a client's file name, without control characters."""
    last = filename.replace("\\", "/").rsplit("/", 1)[-1]
    name = "".join(c for c in last if unicodedata.category(c)[0] != "C").strip()[-120:]
    if not name.strip("."):
        raise UploadRejected("The file has no name.")
    return name


def _read(stream: BinaryIO, limit: int) -> bytes:
    parts: list[bytes] = []
    size = 0
    while part := stream.read(_CHUNK):
        size += len(part)
        if size > limit:
            raise UploadTooLarge(f"The file is larger than {limit / 2**20:g} MiB.")
        parts.append(part)
    return b"".join(parts)


@contextmanager
def _store_lock(data: Path, kind: int) -> Iterator[None]:
    """Keep what is being written from being deleted as unused, and the other way round."""
    folder = data / "programs"
    folder.mkdir(parents=True, exist_ok=True)
    with (data / "programs.lock").open("a") as lock:
        fcntl.flock(lock, kind)
        yield


def _write(source: bytes, place: Path) -> None:
    """Write the file whole or not at all; who is second finds it there already, and young again."""
    if place.exists():
        os.utime(place)
        return
    draft = place.with_name(f"{place.name}.{secrets.token_hex(8)}")
    with draft.open("wb") as file:
        file.write(source)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(place)
