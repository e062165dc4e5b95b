"""Request bodies: JSON, or multipart forms with a JSON part and a file part."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from flask import request
from pydantic import BaseModel, Field, ValidationError
from werkzeug.datastructures import FileStorage

from seamark.programs import parts
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import RunRequest
from seamark.server.programs import vehicles
from seamark.server.runs.submission.submission_keys import SubmissionKey
from seamark.server.runs.submission.validation import Submission
from seamark.server.web.body_limits import JSON_MAX_BYTES
from seamark.server.web.problems import Problem, from_validation_error
from seamark.server.web.services import services

KEY_MAX = 200  # [character] of an Idempotency-Key

Model = TypeVar("Model", bound=BaseModel)
Run = TypeVar("Run", bound=RunRequest)


class SubmissionHeaders(Query):
    """Headers of a submission."""

    key: str | None = Field(
        None,
        alias="Idempotency-Key",
        min_length=1,
        max_length=KEY_MAX,
        pattern=r"^[\x21-\x7e]*$",
        description="A text of the client's own, new for each submission. Sent again with the same "
        "one within a day, a submission of an account is answered as before and starts nothing.",
    )

    def submission_key(self, request: RunRequest, submission: Submission) -> SubmissionKey | None:
        """Return the key of a submission; None without one, and for a guest."""
        user_id = submission.viewer.user_id
        if self.key is None or user_id is None:
            return None
        program = None if submission.program is None else submission.program.sha256
        vehicle = None if submission.vehicle is None else submission.vehicle.sha256
        content = request.model_dump(mode="json") | {"kind of request": type(request).__name__}
        uploads = {"program": program} | ({} if vehicle is None else {"vehicle": vehicle})
        uploads |= {parts.field(role): part.sha256 for role, part in submission.parts.items()}
        return SubmissionKey.of(user_id, self.key, request=content | uploads)


def json_body(model: type[Model]) -> Model:
    """Return the validated JSON body; raises Problem."""
    if not request.is_json:
        raise Problem("unsupported-media-type", "Send the body as application/json.")
    return _parse(model, request.get_data(cache=False))


class Uploads(NamedTuple):
    """The files of a multipart form."""

    program: FileStorage | None = None
    vehicle: FileStorage | None = None
    parts: Mapping[str, FileStorage] = MappingProxyType({})  # role -> further program


def run_request(model: type[Run]) -> tuple[Run, Uploads]:
    """Return the validated run and, from a multipart form, its files; raises Problem."""
    if request.is_json:
        return json_body(model), Uploads()
    if request.mimetype != "multipart/form-data":
        raise Problem("unsupported-media-type")
    program_max_bytes = services().settings.upload_max_bytes
    text = request.form.get("run")
    if text is None:
        raise Problem(
            "invalid-request",
            "The part run is missing.",
            errors={"run": "This part is required and contains JSON."},
        )
    uploads = Uploads(
        request.files.get("program"), request.files.get(vehicles.FIELD), uploads_of_parts()
    )
    programs = (*([] if uploads.program is None else [uploads.program]), *uploads.parts.values())
    for program in programs:
        _check_size(program, program_max_bytes)
    return _parse(model, text.encode("utf-8", "surrogatepass")), uploads


def uploads_of_parts() -> dict[str, FileStorage]:
    """Return role -> file of each further program in the form of the request."""
    sent = {role: request.files.get(parts.field(role)) for role in parts.ROLES}
    return {role: file for role, file in sent.items() if file is not None and file.filename}


def _parse(model: type[Model], data: bytes) -> Model:
    """Return the validated model of a JSON text; raises Problem."""
    try:
        return model.model_validate(json_object(data))
    except ValidationError as error:
        raise from_validation_error(error) from None


def json_object(data: bytes) -> dict[str, Any]:
    """Return the object in a JSON text; raises Problem."""
    if len(data) > JSON_MAX_BYTES:
        raise Problem("payload-too-large", f"The JSON is limited to {JSON_MAX_BYTES >> 10} KiB.")
    try:
        # Not pydantic's parser: it rejects NaN as malformed JSON, without naming the field.
        value = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise Problem("bad-request", f"The body is not valid JSON: {error}.") from None
    if not isinstance(value, dict):
        raise Problem("invalid-request", "The body must be a JSON object.")
    return value


def _check_size(file: FileStorage, limit: int) -> None:
    size = file.stream.seek(0, 2)
    file.stream.seek(0)
    if size > limit:
        raise Problem(
            "payload-too-large",
            f"The program is {size / 2**20:.1f} MiB large; the limit is {limit / 2**20:g} MiB.",
        )
