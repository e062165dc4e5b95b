"""Uploaded programs: checked while they are read, kept under their SHA-256, never executed here."""

import ast
import hashlib
import os
import re
import secrets
import unicodedata
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from sandbox.languages import language_of

_CHUNK = 64 * 1024
_SYNTAX_MAX = 256 * 1024  # [byte] a longer source is checked in its box only
_SHA256 = re.compile(r"[0-9a-f]{64}")


class UploadRejected(Exception):
    """The upload breaks a rule. Its text is written for the user and shown on the form."""


@dataclass(frozen=True, slots=True)
class StoredProgram:
    """A program in the store."""

    sha256: str
    name: str
    language: str
    size: int


def store(stream: BinaryIO, filename: str, *, limit: int, data: Path) -> StoredProgram:
    """Check an upload, keep it and return its key; raises UploadRejected with a sentence.

    Parameters
    ----------
    limit : int [byte]
        A longer upload is refused without being read to its end.
    data : Path
        The data folder of the settings.
    """
    name = _clean(filename)
    _language(name)  # before anything is read
    source = _read(stream, limit)
    language = check(source, name)
    sha256 = hashlib.sha256(source).hexdigest()
    _keep(source, path(data, sha256))
    return StoredProgram(sha256, name, language, len(source))


def path(data: Path, sha256: str) -> Path:
    """Return where the program with this key is kept."""
    if not _SHA256.fullmatch(sha256):
        raise ValueError(f"not a SHA-256: {sha256!r}")
    return data / "programs" / sha256


def read(data: Path, sha256: str) -> bytes:
    """Return the program's text; raises FileNotFoundError if it is not kept."""
    return path(data, sha256).read_bytes()


def check(source: bytes, name: str) -> str:
    """Return the language of a program; UploadRejected if it cannot be one. Runs nothing of it."""
    language = _language(name)
    if not source.strip():
        raise UploadRejected(f"{name} is empty.")
    try:
        text = source.decode("utf-8")
    except UnicodeDecodeError as error:
        line = source[: error.start].count(b"\n") + 1
        raise UploadRejected(f"{name}, line {line}: the text is not UTF-8.") from None
    if language == "python":
        _check_python(text, name)
    return language


def _language(name: str) -> str:
    """Return the language by the file's suffix."""
    language = language_of(name)
    if language is None:
        raise UploadRejected(f"{name}: no language is known for this kind of file.")
    return language


def _check_python(text: str, name: str) -> None:
    """Raise UploadRejected with the line if this cannot be a controller."""
    if len(text) > _SYNTAX_MAX:
        return
    try:
        tree = ast.parse(text, filename=name)
    except SyntaxError as error:
        raise UploadRejected(f"{name}, line {error.lineno}: {error.msg}.") from None
    except (ValueError, RecursionError, MemoryError):
        raise UploadRejected(f"{name}: this is not a Python text that can be read.") from None
    if not _defines_controller(tree):
        raise UploadRejected(
            f"{name} has no class named Controller. The documentation has a template to start from."
        )


def _defines_controller(tree: ast.Module) -> bool:
    """Return whether the name may exist: a class, an assignment or an import, at any depth."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name == "Controller":
            return True
        if isinstance(node, ast.Name) and node.id == "Controller":
            return True
        if isinstance(node, ast.alias) and (node.asname or node.name) in {"Controller", "*"}:
            return True
    return False


def _clean(filename: str) -> str:
    """Return the last part of a client's file name, without control characters."""
    last = filename.replace("\\", "/").rsplit("/", 1)[-1]
    name = "".join(c for c in last if unicodedata.category(c)[0] != "C").strip()[-120:]
    if not name:
        raise UploadRejected("The file has no name.")
    return name


def _read(stream: BinaryIO, limit: int) -> bytes:
    parts: list[bytes] = []
    size = 0
    while part := stream.read(_CHUNK):
        size += len(part)
        if size > limit:
            raise UploadRejected(f"The file is larger than {limit / 2**20:g} MiB.")
        parts.append(part)
    return b"".join(parts)


def _keep(source: bytes, place: Path) -> None:
    """Write the file whole or not at all; who is second finds it there already."""
    if place.exists():
        return
    place.parent.mkdir(parents=True, exist_ok=True)
    draft = place.with_name(f"{place.name}.{secrets.token_hex(8)}")
    with draft.open("wb") as file:
        file.write(source)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(place)
