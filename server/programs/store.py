"""Uploaded programs: checked while they are read, stored under their SHA-256, never run here."""

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
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.limits import Limits
from seamark.server.programs import archives, python_lint
from seamark.server.programs.archives import ArchiveRefused
from seamark.server.programs.diagnostics import Diagnostic

LINTERS = {PYTHON.name: python_lint.lint}  # what can be checked without running a program
_CHUNK = 64 * 1024
_SHA256 = re.compile(r"[0-9a-f]{64}")
_LIMITS = Limits()
UNUSED_KEPT_S = 86_400.0  # until `delete_unused` may delete a program
TEXT_MAX_BYTES = 2 * 2**20  # of a source file; archives may be larger


class UploadRejected(Exception):
    """The upload breaks a rule. The text is for the user and shown on the form."""


class UploadTooLarge(UploadRejected):
    """The upload is larger than a program of its type may be."""


@dataclass(frozen=True, slots=True)
class StoredProgram:
    """A program in the store."""

    sha256: str
    name: str
    language: str
    size: int  # [B]


@dataclass(frozen=True, slots=True)
class PreparedProgram:
    """An upload in normal form, with the problems found in its source."""

    name: str
    language: str
    content: bytes  # source text, or a plain zip archive (see seamark.server.programs.archives)
    diagnostics: tuple[Diagnostic, ...] = ()


def save_upload(
    stream: BinaryIO, filename: str, *, limit: int, data: Path, role: str = "controller"
) -> StoredProgram:
    """Check an upload and store it; raises UploadRejected if anything is wrong with it.

    Parameters
    ----------
    limit : int [B]
        A larger upload is rejected without reading the rest; source files already at
        `TEXT_MAX_BYTES`.
    data : Path
        The data folder of the settings.
    role
        What the benchmark evaluates: a key of `seamark.server.programs.interfaces.INTERFACES`.
    """
    prepared = read_upload(stream, filename, limit=limit, role=role)
    if prepared.diagnostics:
        raise UploadRejected(" ".join(_as_sentence(one) for one in prepared.diagnostics[:3]))
    return save(prepared, data)


def read_upload(stream: BinaryIO, filename: str, *, limit: int, role: str) -> PreparedProgram:
    """Read an upload into normal form; raises UploadRejected if it cannot be a program."""
    name = _clean(filename)
    language = _language_by_suffix(name)  # before anything is read
    if language is not None and LANGUAGES[language].is_text:
        limit = min(limit, TEXT_MAX_BYTES)
    return prepare(_read(stream, limit), name, role=role)


def prepare(source: bytes, filename: str, *, role: str = "controller") -> PreparedProgram:
    """Return a program in normal form. Runs nothing of it; raises UploadRejected."""
    name = _clean(filename)
    language = _language_by_suffix(name)
    if not source.strip():
        raise UploadRejected(f"{name} is empty.")
    if language is None or LANGUAGES[language].is_archive:
        return _prepare_archive(source, name, language, role)
    if language not in LINTERS:
        _check_format(name, source, language)
    return PreparedProgram(name, language, source, _lint(language, {name: source}, name, role))


def save(prepared: PreparedProgram, data: Path) -> StoredProgram:
    """Put a program into the store, or renew one that is already there."""
    sha256 = hashlib.sha256(prepared.content).hexdigest()
    with _store_lock(data, fcntl.LOCK_SH):
        _write(prepared.content, path(data, sha256))
    return StoredProgram(sha256, prepared.name, prepared.language, len(prepared.content))


def path(data: Path, sha256: str) -> Path:
    """Return where the program with this key is stored."""
    if not _SHA256.fullmatch(sha256):
        raise ValueError(f"not a SHA-256: {sha256!r}")
    return data / "programs" / sha256


def read(data: Path, sha256: str) -> bytes:
    """Return the content of a program; raises FileNotFoundError if it is not in the store."""
    return path(data, sha256).read_bytes()


def touch(data: Path, sha256: str) -> bool:
    """Reset the age of a program, so that it is not deleted soon; False if it is gone."""
    with _store_lock(data, fcntl.LOCK_SH):
        return _renew(path(data, sha256))


def delete_unused(
    data: Path, *, used: Callable[[str], bool], older_than_s: float = UNUSED_KEPT_S
) -> int:
    """Delete old programs that nothing refers to; return how many.

    The age counts from the last upload or `touch`: the submission that will refer to a recent
    program may still be in progress. Uploads and other workers' deletions may run at the same
    time, so any file may vanish between listing the folder and taking the lock.
    """
    deleted, limit = 0, time.time() - older_than_s
    for file in (data / "programs").glob("*"):
        if not _is_older(file, limit) or used(file.name):
            continue
        with _store_lock(data, fcntl.LOCK_EX):
            if _is_older(file, limit):  # it may have been uploaded again in the meantime
                file.unlink()
                deleted += 1
    return deleted


def _is_older(file: Path, limit: float) -> bool:
    """Return whether the file exists and was last written or touched before `limit`."""
    try:
        return file.stat().st_mtime < limit
    except FileNotFoundError:
        return False


def _renew(file: Path) -> bool:
    """Set the file's time to now; False if there is no such file."""
    try:
        os.utime(file)
    except FileNotFoundError:
        return False
    return True


def _language_by_suffix(name: str) -> str | None:
    """Return the language; None for an archive, where the main file decides."""
    language = language_of(name)
    if language is None and not archives.is_archive(name):
        raise UploadRejected(f"{name}: this file type is not supported.")
    return language


def _prepare_archive(source: bytes, name: str, language: str | None, role: str) -> PreparedProgram:
    try:
        files = archives.files_of(source, name, limits=_LIMITS)
        content = archives.normal_form(files, limits=_LIMITS)
    except ArchiveRefused as reason:
        raise UploadRejected(f"{name}: {reason}") from None
    if language is not None:
        return PreparedProgram(name, language, content)
    language, main = _main_file(files, name)
    return PreparedProgram(name, language, content, _lint(language, files, main, role))


def _lint(language: str, files: dict[str, bytes], main: str, role: str) -> tuple[Diagnostic, ...]:
    """Return what the language's linter finds, nothing if it has none."""
    return tuple(LINTERS[language](files, main, role)) if language in LINTERS else ()


def _main_file(files: dict[str, bytes], name: str) -> tuple[str, str]:
    """Return language and path of the archive's main file."""
    for language in LANGUAGES.values():
        for main in language.archive_mains:
            if main in files:
                return language.name, main
    languages = LANGUAGES.values()
    known = ", ".join(f"{main} ({one.label})" for one in languages for main in one.archive_mains)
    top = sorted(path for path in files if "/" not in path)[:5]
    raise UploadRejected(
        f"{name}: the archive needs one of {known} at its top level; it has "
        f"{', '.join(top) or 'only folders'}."
    )


def _check_format(name: str, source: bytes, language: str) -> None:
    """Raise UploadRejected if these bytes cannot be a program of this language."""
    refusal = LANGUAGES[language].binary_refusal
    if refusal is None:
        _check_utf8(name, source)
    elif reason := refusal(source):
        raise UploadRejected(f"{name}: {reason}")


def _check_utf8(name: str, source: bytes) -> None:
    try:
        source.decode("utf-8")
    except UnicodeDecodeError as error:
        line = source[: error.start].count(b"\n") + 1
        raise UploadRejected(f"{name}, line {line}: the source is not UTF-8.") from None


def _as_sentence(diagnostic: Diagnostic) -> str:
    file = str(diagnostic.file)
    location = f"{file}, line {diagnostic.line}" if diagnostic.line else file
    return f"{location}: {diagnostic.sentence}"


def _clean(filename: str) -> str:
    """Return the last part of a client's file name, without control characters."""
    last = filename.replace("\\", "/").rsplit("/", 1)[-1]
    name = "".join(c for c in last if unicodedata.category(c)[0] != "C").strip()[-120:]
    if not name.strip("."):
        raise UploadRejected("The file has no name.")
    return name


def _read(stream: BinaryIO, limit: int) -> bytes:
    chunks: list[bytes] = []
    size = 0
    while chunk := stream.read(_CHUNK):
        size += len(chunk)
        if size > limit:
            raise UploadTooLarge(f"The file is larger than {limit / 2**20:g} MiB.")
        chunks.append(chunk)
    return b"".join(chunks)


@contextmanager
def _store_lock(data: Path, mode: int) -> Iterator[None]:
    """Lock the store: shared (LOCK_SH) to add programs, exclusive (LOCK_EX) to delete them."""
    folder = data / "programs"
    folder.mkdir(parents=True, exist_ok=True)
    with (data / "programs.lock").open("a") as lock:
        fcntl.flock(lock, mode)
        yield


def _write(content: bytes, target: Path) -> None:
    """Write the file atomically, or renew it if it exists."""
    if _renew(target):
        return
    draft = target.with_name(f"{target.name}.{secrets.token_hex(8)}")
    with draft.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(target)
