"""The user's own vehicle in a submitted form: a file, or one that the form has kept.

As a program (`submitted_program`), a kept file is named by a signed field, valid for this user.
"""

from collections.abc import Mapping
from typing import BinaryIO, cast

from flask import g, request
from itsdangerous import BadData, URLSafeTimedSerializer

from seamark.server.programs import store, vehicles
from seamark.server.programs.vehicles import StoredVehicle, VehicleRejected
from seamark.server.runs.submission import validation
from seamark.server.web import uploads
from seamark.server.web.services import services
from seamark.sim.vehicles import own

FILE = "vehicle_file"  # `vehicle` is the choice among those that are known
KEPT = "kept_vehicle"
KEPT_NAME = "kept_vehicle_name"  # of forms without a choice among vehicles
VALID_S = store.UNUSED_KEPT_S / 2


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
    kept = _kept(posted.get(KEPT, ""))
    if kept is None or kept.name != chosen:
        raise VehicleRejected("Choose the file of your vehicle again.")
    return kept


def without_lost(values: dict[str, object], vehicle: StoredVehicle | None) -> dict[str, object]:
    """Return the settings to show again: without a vehicle of which there is no file."""
    lost = vehicle is None and own.is_own(values.get(vehicles.FIELD))
    return {name: one for name, one in values.items() if not (lost and name == vehicles.FIELD)}


def token(vehicle: StoredVehicle) -> str:
    """Return the value of the hidden field for a stored vehicle."""
    return str(_signer().dumps([vehicle.name, vehicle.sha256, g.viewer.user_id]))


def _kept(text: str) -> StoredVehicle | None:
    """Return the vehicle of a hidden field if it belongs to this user and is still stored."""
    try:
        name, sha256, user_id = _signer().loads(text, max_age=int(VALID_S))
    except (BadData, ValueError):
        return None
    settings = services().settings
    if user_id != g.viewer.user_id or store.touch(settings, sha256) is None:
        return None
    return vehicles.stored(name, sha256, settings)


def _signer() -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(services().settings.secret_key, salt="kept vehicle")
