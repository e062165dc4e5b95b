"""The user's own vehicle in a submitted form: a file, or one that the form has kept."""

from collections.abc import Mapping
from typing import BinaryIO, cast

from flask import g, request

from seamark.server.pages.submission import kept_files
from seamark.server.programs import vehicles
from seamark.server.programs.vehicles import StoredVehicle, VehicleRejected
from seamark.server.runs.submission import validation
from seamark.server.web import uploads
from seamark.server.web.services import services
from seamark.sim.vehicles import own

FILE = "vehicle_file"  # `vehicle` is the choice among those that are known
KEPT = kept_files.field(vehicles.FIELD)
KEPT_NAME = "kept_vehicle_name"  # of forms without a choice among vehicles


def save(values: Mapping[str, object], posted: Mapping[str, str]) -> StoredVehicle | None:
    """Store the vehicle of a form and return it; None if one of Seamark's is chosen.

    Raises
    ------
    VehicleRejected, SubmissionRejected
        It cannot run, is gone, or the user may not upload.
    QuotaExceeded, StorageUnavailable
        A quota is used up, or there is no room.
    """
    file, chosen = request.files.get(FILE), values.get(vehicles.FIELD)
    sent = file is not None and bool(file.filename)
    if not sent and not own.is_own(chosen):
        return None
    validation.require_permission(g.viewer, uploads="vehicle")
    if file is not None and file.filename:
        return uploads.store_vehicle(cast(BinaryIO, file.stream), file.filename, viewer=g.viewer)
    sha256, name = kept_files.kept(vehicles.FIELD, posted.get(KEPT, "")) or ("", "")
    if not name or name != chosen:
        raise VehicleRejected("Choose the file of your vehicle again.")
    return vehicles.stored(name, sha256, services().settings)


def without_lost(values: dict[str, object], vehicle: StoredVehicle | None) -> dict[str, object]:
    """Return the settings to show again: without a vehicle of which there is no file."""
    lost = vehicle is None and own.is_own(values.get(vehicles.FIELD))
    return {name: one for name, one in values.items() if not (lost and name == vehicles.FIELD)}


def token(vehicle: StoredVehicle) -> str:
    """Return the value of the hidden field for a stored vehicle."""
    return kept_files.token(vehicles.FIELD, vehicle.sha256, vehicle.name)
