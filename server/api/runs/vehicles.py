"""Vehicles of users: what a check says about one, and the file of a run's."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, BinaryIO, cast

from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import Field

from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import refusals
from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.request_body import Uploads
from seamark.server.api.requests.schemas import ResponseModel, RunPath
from seamark.server.programs import store, vehicles
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.submission import validation
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.storage import storage
from seamark.server.web import access, caching, rate_limits, uploads
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_vehicles",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Vehicles", description="Vehicles of your own, for practice runs.")],
)


class VehicleReportResponse(ResponseModel):
    """What is wrong with a vehicle, and what it can do; one without errors can run."""

    name: str = Field(description="By which runs name it; empty if the file cannot be read")
    title: str
    errors: list[str]
    warnings: list[str]
    figures: list[str] = Field(description="What follows from its numbers, line by line")
    defaults: dict[str, Any] = Field(description="Settings that come with it in currents-v1")


@api.post("/vehicles/check", responses={200: VehicleReportResponse})
@rate_limits.limiter.limit(rate_limits.CHECKS, key_func=rate_limits.client)
def check() -> dict[str, Any]:
    """Check the file of a vehicle, the part `vehicle` of a multipart form. Nothing is stored.

    It says the same as `seamark vehicle check`. A run takes the file as the part `vehicle` of
    `POST /runs`, `/sweeps` or `/checks`.
    """
    access.require_scope(Action.UPLOAD)
    with refusals.as_problems():
        validation.require_permission(access.viewer(), uploads="vehicle")
        file = request.files.get(vehicles.FIELD)
        if file is None:
            raise SubmissionRejected("Send the file of a vehicle.", field=vehicles.FIELD)
        reader, owner = services().reader, access.viewer().owner or ""
        stream, name = cast("BinaryIO", file.stream), file.filename or ""
        report, _content = reader.read_vehicle(stream, name, owner=owner)
    return asdict(report)


@api.get("/runs/<int:run_id>/vehicle.toml", responses=answers_with("application/toml"))
def vehicle_file(path: RunPath) -> Response:
    """Download the file of a run's own vehicle; who sees the run may have it."""
    view = access.run_for(path.run_id)
    if view.vehicle_sha256 is None:
        raise Problem("not-found", f"Run {view.id} has one of the vehicles of Seamark.")
    storage.require_readable(services().settings)
    try:
        content = store.read(services().settings, view.vehicle_sha256)
    except FileNotFoundError:
        raise Problem("not-found", "The vehicle has been deleted.") from None
    answer = Response(content, content_type="application/toml")
    answer.headers.set(
        "Content-Disposition", "attachment", filename=f"seamark-run-{view.id}-vehicle.toml"
    )
    answer.set_etag(view.vehicle_sha256)
    return caching.conditional(answer)


def vehicle_of(files: Uploads) -> StoredVehicle | None:
    """Return the stored vehicle of a request; raises as `uploads.store_vehicle`."""
    if files.vehicle is None:
        return None
    stream, name = cast("BinaryIO", files.vehicle.stream), files.vehicle.filename or ""
    return uploads.store_vehicle(stream, name, viewer=access.viewer())


def with_vehicle(config: dict[str, Any], vehicle: StoredVehicle | None) -> dict[str, Any]:
    """Return a configuration that names the vehicle that was sent with it.

    Raises
    ------
    SubmissionRejected
        It names another one.
    """
    if vehicle is None:
        return config
    if config.get(vehicles.FIELD, vehicle.name) != vehicle.name:
        raise SubmissionRejected(
            "Send a file, or choose a vehicle in the configuration, not both.",
            field=vehicles.FIELD,
        )
    return {**config, vehicles.FIELD: vehicle.name}
