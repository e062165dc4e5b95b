"""The OpenAPI 3.1 document, its page, and a page for each type of problem."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from typing import Any

from flask import Blueprint, Flask, Response, abort, current_app, jsonify, render_template
from flask_openapi3.blueprint import APIBlueprint
from pydantic import BaseModel

from seamark.competitions.document import CompetitionDocument
from seamark.programs import parts
from seamark.server.api.account.mail import MailRequest
from seamark.server.api.classes.class_schemas import (
    AssignmentChange,
    AssignmentRequest,
    ClassChange,
    ClassRequest,
    JoinRequest,
)
from seamark.server.api.competitions.competition_schemas import (
    HandOverRequest,
    MoveRequest,
    TeamChange,
    TeamJoinRequest,
    TeamRequest,
)
from seamark.server.api.requests.schemas import (
    InvitationsRequest,
    ProfileBody,
    RunRequest,
    TokenRequest,
)
from seamark.server.api.runs.publication_schemas import PublicationRequest
from seamark.server.api.runs.sweeps import SweepRequest
from seamark.server.runs.record.run_notes import NOTES_MAX, TITLE_MAX
from seamark.server.web.problems import MEDIA_TYPE, PROBLEM_TYPES

page = Blueprint("openapi", __name__)
_KEY = "seamark-openapi"
_REF = "#/components/schemas/{model}"
_SECURITY: list[dict[str, list[str]]] = [{}, {"token": []}, {"cookie": []}]
_REFUSALS = (400, 401, 403, 404, 409, 410, 422, 500, 503)
_REFUSALS_OF_CHANGES = (413, 415, 429)
_PUBLISH = "runs/{run_id}/publish"
_COMPETITION = "competitions/{name}"
_JSON_BODIES: dict[tuple[str, str], type[BaseModel]] = {
    ("post", "tokens"): TokenRequest,
    ("post", "invitations"): InvitationsRequest,
    ("patch", "me/mail"): MailRequest,
    ("put", "me/profile"): ProfileBody,
    ("post", "classes"): ClassRequest,
    ("post", "classes/join"): JoinRequest,
    ("patch", "classes/{class_id}"): ClassChange,
    ("post", "classes/{class_id}/assignments"): AssignmentRequest,
    ("patch", "assignments/{assignment_id}"): AssignmentChange,
    ("post", f"{_COMPETITION}/rounds/{{number}}/move"): MoveRequest,
    ("post", f"{_COMPETITION}/hand-over"): HandOverRequest,
    ("post", f"{_COMPETITION}/teams"): TeamRequest,
    ("post", f"{_COMPETITION}/teams/join"): TeamJoinRequest,
    ("patch", f"{_COMPETITION}/team"): TeamChange,
    ("post", _PUBLISH): PublicationRequest,
}
_TABLES = (  # as JSON or as CSV
    *("leaderboards/{benchmark}", "assignments/{assignment_id}/pupils"),
    f"{_COMPETITION}/rounds/{{number}}/board",
)
_BINARY = ("image/", "application/octet-stream", "application/zip")
PROBLEM_SCHEMA: dict[str, Any] = {
    "type": "object",
    "description": "RFC 9457",
    "required": ["type", "title", "status", "detail"],
    "properties": {
        "type": {"type": "string", "description": "/problems/<slug>; stable, with its own page"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string", "description": "What is wrong with this request"},
        "errors": {
            "type": "array",
            "items": {
                "type": "object",
                "required": ["field", "detail"],
                "properties": {"field": {"type": "string"}, "detail": {"type": "string"}},
            },
        },
    },
}
_LOG_FORM: dict[str, Any] = {
    "multipart/form-data": {
        "schema": {
            "type": "object",
            "required": ["log"],
            "properties": {
                "log": {
                    "type": "string",
                    "format": "binary",
                    "description": "CSV, MCAP, ROS 1 bag or ROS 2 database, named by its suffix",
                },
                "mapping": {"type": "string", "description": "TOML or JSON; see docs/logs.md"},
                "benchmark": {"type": "string", "description": "Whose metrics"},
                "title": {"type": "string", "maxLength": TITLE_MAX},
                "notes": {"type": "string", "maxLength": NOTES_MAX},
            },
        }
    }
}
_VEHICLE: dict[str, Any] = {
    "type": "string",
    "format": "binary",
    "description": "TOML file of a vehicle of your own, for practice runs; see docs/vehicles.md",
}
_DRAFT_FORM: dict[str, Any] = {
    "multipart/form-data": {
        "schema": {
            "type": "object",
            "required": ["document"],
            "properties": {
                "document": {"$ref": _REF.format(model="CompetitionDocument")},
                "picture": {"type": "string", "format": "binary", "description": "PNG or JPEG"},
                "vehicle": {
                    "type": "string",
                    "format": "binary",
                    "description": "TOML file of a vehicle of your own; see docs/vehicles.md",
                },
            },
        },
        "encoding": {"document": {"contentType": "application/json"}},  # or a TOML file
    }
}
_VEHICLE_FORM: dict[str, Any] = {
    "multipart/form-data": {
        "schema": {
            "type": "object",
            "required": ["vehicle"],
            "properties": {"vehicle": _VEHICLE},
        }
    }
}
_DESCRIPTION = """Everything on the web pages can also be done through this API.

Authenticate with `Authorization: Bearer <token>` (account page, `POST /api/v1/tokens` or
`seamark token new`). Errors are `application/problem+json` with a stable `type`.
Times are seconds since 1970 (UTC). To get the next page of a list, pass its `next` as `after`.
"""


@cache
def build(blueprints: tuple[APIBlueprint, ...]) -> dict[str, Any]:
    """Return the document of all operations of the blueprints, built once; nobody may change it."""
    paths: dict[str, Any] = {}
    schemas: dict[str, Any] = {"Problem": PROBLEM_SCHEMA}
    tags: dict[str, dict[str, Any]] = {}
    for blueprint in blueprints:
        for path, item in blueprint.paths.items():
            paths.setdefault(path, {}).update(_plain(item))
        for name, schema in blueprint.components_schemas.items():
            schemas[name] = _plain(schema)
        for tag in blueprint.tags:
            tags.setdefault(tag.name, _plain(tag))
    _add_bodies(paths, schemas)
    for path in _TABLES:
        table = paths[f"/api/v1/{path}"]["get"]["responses"]["200"]["content"]
        table["text/csv"] = {"schema": {"type": "string"}}
    for operations in paths.values():
        for method, operation in operations.items():
            _complete(operation, changes=method != "get")
    return {
        "openapi": "3.1.0",
        "jsonSchemaDialect": "https://json-schema.org/draft/2020-12/schema",
        "info": {"title": "Seamark", "version": version("seamark"), "description": _DESCRIPTION},
        "servers": [{"url": "/"}],
        "tags": list(tags.values()),
        "paths": dict(sorted(paths.items())),
        "components": {
            "schemas": schemas,
            "securitySchemes": {
                "token": {"type": "http", "scheme": "bearer"},
                "cookie": {"type": "apiKey", "in": "cookie", "name": "seamark"},
            },
        },
    }


def _plain(model: Any) -> dict[str, Any]:
    dumped: dict[str, Any] = model.model_dump(
        mode="json", by_alias=True, exclude_unset=True, warnings=False
    )
    return dumped


def _add_bodies(paths: dict[str, Any], schemas: dict[str, Any]) -> None:
    """Describe the request bodies: flask-openapi3 supports a single media type only."""
    models: list[type[BaseModel]] = [RunRequest, SweepRequest, *_JSON_BODIES.values()]
    for model in models:
        schema = model.model_json_schema(ref_template=_REF)
        schemas |= schema.pop("$defs", {})
        schemas[model.__name__] = schema
    for (method, path), body in _JSON_BODIES.items():
        _add_body(paths, method, path, _as_json(body))
    _add_body(paths, "post", "runs", _as_json(RunRequest) | _with_files(RunRequest))
    _add_body(paths, "post", "sweeps", _as_json(SweepRequest) | _with_files(SweepRequest))
    _add_body(paths, "post", "checks", _with_files(RunRequest, parts_too=False))
    _add_body(paths, "post", "vehicles/check", _VEHICLE_FORM)
    schemas["CompetitionDocument"] = _document_schema(schemas)
    draft = _as_json(CompetitionDocument) | _DRAFT_FORM
    _add_body(paths, "post", "competitions", draft)
    _add_body(paths, "put", _COMPETITION, draft)
    _add_body(paths, "post", "logs", _LOG_FORM)


def _document_schema(schemas: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of the document of a competition; its parts are added to the schemas."""
    schema = CompetitionDocument.model_json_schema(ref_template=_REF)
    schemas |= schema.pop("$defs", {})
    return schema


def _add_body(paths: dict[str, Any], method: str, path: str, content: dict[str, Any]) -> None:
    paths[f"/api/v1/{path}"][method]["requestBody"] = {
        "required": path != _PUBLISH,
        "content": content,
    }


def _as_json(model: type[BaseModel]) -> dict[str, Any]:
    return {"application/json": {"schema": {"$ref": _REF.format(model=model.__name__)}}}


def _with_files(model: type[BaseModel], *, parts_too: bool = True) -> dict[str, Any]:
    """Return the multipart form of a run or sweep with its programs and vehicle."""
    further = {parts.field(role): _part(role) for role in parts.ROLES if parts_too}
    program = {"type": "string", "format": "binary", "description": "The program"}
    run = {"$ref": _REF.format(model=model.__name__)}
    form = {
        "type": "object",
        "required": ["run"],
        "properties": {"run": run, "program": program, "vehicle": _VEHICLE} | further,
    }
    encoding = {"run": {"contentType": "application/json"}}
    return {"multipart/form-data": {"schema": form, "encoding": encoding}}


def _part(role: str) -> dict[str, Any]:
    what = f"A {role} of your own beside the program, in benchmarks that have this part"
    return {"type": "string", "format": "binary", "description": what}


def _complete(operation: dict[str, Any], *, changes: bool) -> None:
    """Add how the operation may be refused, and by what its sender may authenticate."""
    content = {MEDIA_TYPE: {"schema": {"$ref": _REF.format(model="Problem")}}}
    for status in (*_REFUSALS, *_REFUSALS_OF_CHANGES) if changes else _REFUSALS:
        slugs = [slug for slug, kind in PROBLEM_TYPES.items() if kind.status == status]
        described = {"description": f"Problem: {', '.join(slugs)}", "content": content}
        operation["responses"].setdefault(str(status), described)
    for response in operation["responses"].values():
        for media_type, described in response.get("content", {}).items():
            if media_type.startswith(_BINARY):
                described["schema"] = {"type": "string", "format": "binary"}
    operation["security"] = _SECURITY


def store(app: Flask, blueprints: tuple[APIBlueprint, ...]) -> None:
    """Build the document once, at the start."""
    app.extensions[_KEY] = build(blueprints)


@page.get("/api/v1/openapi.json")
def openapi() -> Response:
    """Return the OpenAPI document."""
    return jsonify(current_app.extensions[_KEY])


@page.get("/api/docs")
def docs() -> str:
    """Show the API documentation."""
    return render_template("api/docs.html", api=current_app.extensions[_KEY])


@page.get("/problems/<slug>")
def problem(slug: str) -> str:
    """Explain one type of problem."""
    if slug not in PROBLEM_TYPES:
        abort(404)
    return render_template("api/problem.html", type=PROBLEM_TYPES[slug])


@page.get("/problems")
def problems() -> str:
    """List the types of problems."""
    return render_template("api/problems.html", types=PROBLEM_TYPES.values())
