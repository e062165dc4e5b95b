"""How large the body of a request may be: what a form needs, whoever sends it.

Only programs and files of settings are large, and only accounts may upload them. Everything else
is parsed in the web process, so it is small: 8 MiB of URL-encoded fields took 2 s of CPU time and
600 MiB of memory.
"""

from flask import Flask, g, request
from werkzeug.exceptions import BadRequest, RequestEntityTooLarge

from seamark.programs import parts
from seamark.programs.preparation import TEXT_MAX_BYTES
from seamark.server.accounts.permissions import Action, can
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.settings.own_files import LIBRARIES
from seamark.sim.vehicles.toml_reading import BYTES_MAX as VEHICLE_MAX_BYTES

FORM_MAX_BYTES = 128 * 1024  # of a body without a program: URL-encoded, JSON or multipart
JSON_MAX_BYTES = 64 * 1024  # of a JSON document; the configuration of a large grid takes 10 KiB
FIELD_MAX = 16 * 1024  # [character] of a form's field, except for the text of a program
EDITOR_FIELD = "program_text"
_PROGRAMS_MAX = 1 + len(parts.ROLES)  # of one run
_MULTIPART = "multipart/form-data"
_FORMS = (_MULTIPART, "application/x-www-form-urlencoded")


def register(app: Flask, settings: Settings) -> None:
    """Limit each request before anything reads its body; after `g.viewer` is set."""

    @app.before_request
    def limit_body() -> None:
        uploads = request.mimetype == _MULTIPART and can(g.viewer, Action.UPLOAD)
        files = _files_max(settings, _programs_max()) if uploads else 0
        text = TEXT_MAX_BYTES if uploads else 0
        request.max_content_length = FORM_MAX_BYTES + files
        # Each field that is no file; the editor sends the text of a program as one.
        request.max_form_memory_size = FORM_MAX_BYTES + text

    @app.before_request
    def refuse_nul() -> None:
        """Refuse the character NUL, which PostgreSQL cannot store and nobody types."""
        texts = [request.path, *request.args.values()]
        if request.mimetype in _FORMS and request.method == "POST":
            texts += request.form.values()
        if any("\0" in text for text in texts):
            raise BadRequest("The character NUL is not allowed.")


def body_max(settings: Settings, content_type: str) -> int:
    """Return the largest body [byte] of this type that anybody may send; no more is received."""
    uploads = content_type.startswith(_MULTIPART)
    return FORM_MAX_BYTES + (_files_max(settings, _PROGRAMS_MAX) if uploads else 0)


def _files_max(settings: Settings, programs: int) -> int:
    """Return the size [byte] of so many of the largest programs, or other files, with a vehicle."""
    others = sum(library.bytes_max for library in LIBRARIES.values())
    return max(programs * settings.upload_max_bytes, others) + VEHICLE_MAX_BYTES


def _programs_max() -> int:
    """Return how many programs this request may send: the form of a benchmark has its parts."""
    if request.path.startswith("/api/"):
        return _PROGRAMS_MAX
    name = (request.view_args or {}).get("name")
    return 1 + len(registry.benchmark(name).parts) if name in registry.BENCHMARKS else 1


def form_fields() -> dict[str, str]:
    """Return the fields of the posted form; raises RequestEntityTooLarge if one is too long."""
    fields: dict[str, str] = request.form.to_dict()
    if any(len(text) > FIELD_MAX for name, text in fields.items() if name != EDITOR_FIELD):
        raise RequestEntityTooLarge
    return fields
