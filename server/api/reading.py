"""Reads the body of a request: JSON, or JSON in one part of a form with a file in another."""

from __future__ import annotations

import json
from typing import TypeVar

from flask import request
from pydantic import BaseModel, ValidationError
from werkzeug.datastructures import FileStorage

from seamark.server.programs.store import UploadRejected, UploadTooLarge
from seamark.server.web.problems import Problem, of_validation

JSON_MAX_BYTES = 256 * 1024
FORM_MARGIN_BYTES = 512 * 1024  # what a form may hold beside the program
Model = TypeVar("Model", bound=BaseModel)


def body(model: type[Model]) -> Model:
    """Return the JSON body, checked; raises Problem."""
    if not request.is_json:
        raise Problem("unsupported-media-type", "Send the body as application/json.")
    request.max_content_length = JSON_MAX_BYTES
    return parse(model, request.get_data(cache=False))


def body_or_form(
    model: type[Model], *, json_part: str, file_part: str, file_max_bytes: int
) -> tuple[Model, FileStorage | None]:
    """Return the checked JSON and the file, which only a multipart form can bring."""
    if request.is_json:
        return body(model), None
    if request.mimetype != "multipart/form-data":
        raise Problem("unsupported-media-type")
    request.max_content_length = file_max_bytes + FORM_MARGIN_BYTES
    text = request.form.get(json_part)
    if text is None:
        raise Problem(
            "invalid-request",
            f"The part {json_part} is missing.",
            errors={json_part: "A text in JSON is needed."},
        )
    file = request.files.get(file_part)
    if file is not None:
        _check_size(file, file_max_bytes)
    return parse(model, text.encode("utf-8", "surrogatepass")), file


def parse(model: type[Model], data: bytes) -> Model:
    """Return the checked model of a JSON text."""
    try:
        # Not pydantic's reader: it refuses NaN as bad JSON, without naming the field it stands in.
        value = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise Problem("bad-request", f"This is not JSON: {error}.") from None
    if not isinstance(value, dict):
        raise Problem("invalid-request", "The body must be a JSON object.")
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise of_validation(error) from None


def _check_size(file: FileStorage, limit: int) -> None:
    size = file.stream.seek(0, 2)
    file.stream.seek(0)
    if size > limit:
        raise Problem(
            "payload-too-large",
            f"The program has {size / 2**20:.1f} MiB; at most {limit / 2**20:g} MiB are taken.",
        )


def refused(reason: UploadRejected) -> Problem:
    """Return the problem of an upload that was not accepted."""
    large = isinstance(reason, UploadTooLarge)
    slug = "payload-too-large" if large else "upload-rejected"
    return Problem(slug, str(reason), errors={"program": str(reason)})
