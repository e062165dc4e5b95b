"""The document of a draft with its picture and its settings' files, as an organiser sends them."""

from __future__ import annotations

from typing import Any, BinaryIO, cast

from flask import request
from werkzeug.datastructures import FileStorage

from seamark.competitions.document import DocumentInvalid
from seamark.server.api.requests import request_body
from seamark.server.judging import drafts
from seamark.server.judging.drafts import Draft
from seamark.server.programs import vehicles
from seamark.server.web import access, uploads
from seamark.server.web.body_limits import JSON_MAX_BYTES
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim.settings.own_files import LIBRARIES
from seamark.sim.vehicles.toml_reading import TomlRefused, read_toml

DOCUMENT, PICTURE = "document", "picture"  # parts of the form
_FILES = (PICTURE, vehicles.FIELD, *LIBRARIES)
_TOML = (".toml", "application/toml")


def read() -> Draft:
    """Return the draft in the request; raises Problem.

    Raises
    ------
    DocumentInvalid, VehicleRejected, FileRejected, QuotaExceeded, StorageUnavailable
        As `drafts.read` and `uploads.store_vehicle`.
    """
    settings = services().settings
    if request.is_json:
        values = request_body.json_object(request.get_data(cache=False))
        return drafts.read(_without_paths(values), settings)
    if request.mimetype != "multipart/form-data":
        raise Problem(
            "unsupported-media-type",
            "Send the document as application/json, or as the part `document` of "
            f"multipart/form-data with the files {', '.join(_FILES)}.",
        )
    values, file = _document(), request.files.get(vehicles.FIELD)
    picture = request.files.get(PICTURE)
    vehicle = None
    if file is not None:
        vehicle = uploads.store_vehicle(*_opened(file), viewer=access.viewer())
    files = tuple(
        uploads.store_file(*_opened(request.files[name]), setting=name, viewer=access.viewer())
        for name in LIBRARIES
        if name in request.files
    )
    return drafts.read(
        *(_without_paths(values), settings),
        vehicle=vehicle,
        files=files,
        picture=None if picture is None else picture.stream.read(drafts.PICTURE_MAX_BYTES + 1),
    )


def _opened(file: FileStorage) -> tuple[BinaryIO, str]:
    return cast("BinaryIO", file.stream), file.filename or ""


def _document() -> dict[str, Any]:
    file = request.files.get(DOCUMENT)
    if file is not None:
        content = file.stream.read(JSON_MAX_BYTES + 1)
        return _toml(content) if _is_toml(file) else request_body.json_object(content)
    text = request.form.get(DOCUMENT)
    if text is None:
        raise Problem(
            "invalid-request",
            "The part document is missing.",
            errors={DOCUMENT: "This part is required: JSON, or a TOML file."},
        )
    return request_body.json_object(text.encode("utf-8", "surrogatepass"))


def _without_paths(values: dict[str, Any]) -> dict[str, Any]:
    """Return a document without the paths of files that are sent with it.

    Raises
    ------
    DocumentInvalid
        It names a file that is not.
    """
    named = {name: values[name] for name in _FILES if name in values}
    missing = {name: path for name, path in named.items() if name not in request.files}
    if missing:
        raise DocumentInvalid(
            {
                name: f"The document names {path!r}: send the file as the part {name} of a form."
                for name, path in missing.items()
            }
        )
    return {name: value for name, value in values.items() if name not in named}


def _is_toml(file: FileStorage) -> bool:
    suffix, media_type = _TOML
    return (file.filename or "").lower().endswith(suffix) or file.mimetype == media_type


def _toml(content: bytes) -> dict[str, Any]:
    if len(content) > JSON_MAX_BYTES:
        limit = JSON_MAX_BYTES >> 10
        raise Problem("payload-too-large", f"The document is limited to {limit} KiB.")
    try:
        return read_toml(content)
    except TomlRefused as refusal:
        raise DocumentInvalid({DOCUMENT: str(refusal)}) from None
