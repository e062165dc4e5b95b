"""The program in a posted form: a file, the editor's text, or the file of the form before.

A browser does not send a file again when a form is shown once more. The stored program's key then
travels in a hidden field, signed and for this user alone.
"""

import io
from typing import Any, BinaryIO, cast

from flask import g, request
from itsdangerous import BadData, URLSafeTimedSerializer

from seamark.server.programs import starter_files, store
from seamark.server.programs.store import StoredProgram, UploadRejected
from seamark.server.runs import submission
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark

KEPT_S = 12 * 3600  # [s] half as long as programs are kept that nothing refers to
FIELD = "kept_program"


def take(benchmark: Benchmark, answers: dict[str, str]) -> StoredProgram:
    """Return the stored program of a form.

    Raises
    ------
    UploadRejected, SubmissionRejected
        There is none that can be taken, or none may be sent.
    """
    submission.require_permission(g.viewer, uploads=True)
    settings = services().settings
    keeping: Any = {
        "limit": settings.upload_max_bytes,
        "data": settings.data,
        "role": benchmark.role,
    }
    if answers.get("source") == "editor":
        return _of_editor(benchmark, answers, keeping)
    file = request.files.get("program")
    if file is not None and file.filename:
        return store.save_upload(cast(BinaryIO, file.stream), file.filename, **keeping)
    kept = _kept(benchmark, answers.get(FIELD, ""))
    if kept is None:
        raise UploadRejected("Choose a file, or write the program in the editor.")
    return kept


def token(benchmark: Benchmark, program: StoredProgram) -> str:
    """Return the hidden field that stands for a program in this user's next form."""
    facts = [program.sha256, program.name, program.language, program.size]
    return str(_signer().dumps([*facts, benchmark.role, g.viewer.user_id]))


def _of_editor(benchmark: Benchmark, answers: dict[str, str], keeping: Any) -> StoredProgram:
    name = starter_files.FILES[benchmark.role].get(answers.get("language", "python"))
    if name is None:
        raise UploadRejected("Choose one of the languages of the list.")
    # A browser sends line ends as CR LF; the program keeps those that its author typed.
    text = answers.get("program_text", "").replace("\r\n", "\n").encode()
    return store.save_upload(io.BytesIO(text), name, **keeping)


def _kept(benchmark: Benchmark, text: str) -> StoredProgram | None:
    """Return the program that a hidden field stands for, if it is this user's and still there."""
    try:
        sha256, name, language, size, role, user_id = _signer().loads(text, max_age=KEPT_S)
    except (BadData, ValueError):
        return None
    if (role, user_id) != (benchmark.role, g.viewer.user_id):
        return None
    if not store.touch(services().settings.data, sha256):
        return None
    return StoredProgram(sha256, name, language, size)


def _signer() -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(services().settings.secret_key, salt="kept program")
