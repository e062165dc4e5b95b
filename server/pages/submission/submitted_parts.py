"""The further programs in a submitted form: files, or those that the form has kept."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import BinaryIO, cast

from flask import g, request

from seamark.programs import archives, parts
from seamark.programs.preparation import UploadRejected
from seamark.sandbox.languages import LANGUAGES, kinds
from seamark.server.judging import entries
from seamark.server.pages.submission import submitted_program
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.submission import validation
from seamark.server.web import uploads
from seamark.sim.benchmarks.benchmark import Benchmark


@dataclass(frozen=True, slots=True, kw_only=True)
class PartField:
    """What the form shows of a role that a program of the user's may have beside the main one."""

    role: str
    name: str
    suffixes: tuple[str, ...]  # of its files
    kinds: str  # of programs, in words; empty: none can run now
    error: str
    kept: StoredProgram | None
    token: str  # by which the form has kept it


def save(
    benchmark: Benchmark, posted: Mapping[str, str]
) -> tuple[dict[str, StoredProgram], dict[str, str]]:
    """Store the further programs of a form; return them by role, and errors by field.

    Raises
    ------
    SubmissionRejected
        The user may not upload programs.
    QuotaExceeded, StorageUnavailable
        A quota is used up, or there is no room.
    """
    stored: dict[str, StoredProgram] = {}
    errors: dict[str, str] = {}
    for role in benchmark.parts:
        try:
            program = _save(role, posted)
        except UploadRejected as refusal:
            errors[parts.field(role)] = str(refusal)
        else:
            stored |= {} if program is None else {role: program}
    return stored, errors


def fields(
    benchmark: Benchmark,
    languages: Collection[str],
    kept: Mapping[str, StoredProgram],
    errors: Mapping[str, str],
) -> list[PartField]:
    """Return what the form shows of each part of a benchmark.

    Parameters
    ----------
    languages
        In which programs can run now.
    kept
        Role -> program that was sent before, or that of a run.
    """
    return [_field(role, languages, kept.get(role), errors) for role in benchmark.parts]


def _field(
    role: str,
    languages: Collection[str],
    kept: StoredProgram | None,
    errors: Mapping[str, str],
) -> PartField:
    suitable = [name for name in languages if role in LANGUAGES[name].roles]
    suffixes = [suffix for name in suitable for suffix in LANGUAGES[name].suffixes]
    return PartField(
        role=role,
        name=parts.field(role),
        suffixes=(*suffixes, *archives.SUFFIXES),
        kinds=kinds(suitable) if suitable else "",
        error=errors.get(parts.field(role), ""),
        kept=kept,
        token="" if kept is None else submitted_program.token(kept, role),
    )


def _save(role: str, posted: Mapping[str, str]) -> StoredProgram | None:
    """Return the program of a role; None if the built-in solution is to have it."""
    name = parts.field(role)
    file, kept = request.files.get(name), posted.get(f"kept_{name}", "")
    sent = file is not None and bool(file.filename)
    if not sent and not kept:
        return None
    validation.require_permission(g.viewer, uploads=role)
    if file is not None and file.filename:
        stream = cast(BinaryIO, file.stream)
        personal = not request.form.get(entries.FIELD)
        return uploads.store_part(
            stream, file.filename, viewer=g.viewer, role=role, personal=personal
        )
    program = submitted_program.kept(kept, role)
    if program is None:
        raise UploadRejected(f"Choose the file of your {role} again.")
    return program
