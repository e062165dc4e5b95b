"""The program in a submitted form: a file, the editor's text, or a file from a previous attempt."""

import io
from typing import BinaryIO, cast

from flask import g, request

from seamark.programs.parameters import Parameter
from seamark.programs.preparation import UploadRejected
from seamark.sandbox.languages import DEFAULT_LANGUAGE, editor_starters
from seamark.server.judging import entries
from seamark.server.pages.submission import kept_files
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.submission import validation
from seamark.server.web import uploads
from seamark.sim.benchmarks.benchmark import Benchmark

_WHAT = "program"
FIELD = kept_files.field(_WHAT)


def save(benchmark: Benchmark, posted: dict[str, str]) -> StoredProgram:
    """Store the program of a form and return it.

    Raises
    ------
    UploadRejected, SubmissionRejected
        The program is missing or invalid, or the user may not upload programs.
    QuotaExceeded, StorageUnavailable
        A quota is used up, or there is no room.
    """
    validation.require_permission(g.viewer, uploads="program")
    file = request.files.get("program")
    if file is not None and file.filename:  # without scripts, whichever source is selected
        return _save(benchmark, cast(BinaryIO, file.stream), file.filename)
    if posted.get("source") == "editor":
        return _save_text(benchmark, posted)
    program = kept(posted.get(FIELD, ""), benchmark.role)
    if program is None:
        raise UploadRejected("Choose a file, or write the program in the editor.")
    return program


def token(program: StoredProgram, role: str) -> str:
    """Return the value of the field by which the form keeps a stored program."""
    fields = program.sha256, program.name, program.language, program.size
    declared = [one.to_json() for one in program.parameters]
    return kept_files.token(_WHAT, *fields, declared, role)


def _save_text(benchmark: Benchmark, posted: dict[str, str]) -> StoredProgram:
    starter = editor_starters(benchmark.role).get(posted.get("language", DEFAULT_LANGUAGE))
    if starter is None:
        raise UploadRejected("Choose a language from the list.")
    # Browsers convert line endings to CR LF.
    text = posted.get("program_text", "").replace("\r\n", "\n").encode()
    return _save(benchmark, io.BytesIO(text), starter.upload_name)


def _save(benchmark: Benchmark, stream: BinaryIO, filename: str) -> StoredProgram:
    personal = not request.form.get(entries.FIELD)
    return uploads.store_program(
        stream, filename, viewer=g.viewer, role=benchmark.role, personal=personal
    )


def kept(text: str, role: str) -> StoredProgram | None:
    """Return the program that a form has kept if it is this user's and is still stored."""
    values = kept_files.kept(_WHAT, text)
    if values is None:
        return None
    sha256, name, language, size, declared, signed_role = values
    if signed_role != role:
        return None
    return StoredProgram(sha256, name, language, size, tuple(map(Parameter.from_json, declared)))
