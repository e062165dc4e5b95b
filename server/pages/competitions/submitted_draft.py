"""The draft in a posted form: its fields or a TOML file, with the picture and the vehicle."""

from collections.abc import Mapping
from typing import Any

from flask import request

from seamark.competitions.document import DocumentInvalid
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import drafts, entries
from seamark.server.judging.drafts import Draft
from seamark.server.pages.competitions import draft_form
from seamark.server.pages.submission import submitted_vehicle
from seamark.server.programs import vehicles
from seamark.server.programs.vehicles import StoredVehicle, VehicleRejected
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import template_runs
from seamark.server.web.services import services
from seamark.server.web.template_runs import NoTemplate
from seamark.sim import registry
from seamark.sim.settings.setting import schema_extras
from seamark.sim.vehicles.toml_reading import BYTES_MAX, TomlRefused, read_toml

_PATHS = {"picture", vehicles.FIELD}  # in a file for the command line: of files beside it
DOCUMENT, PICTURE = "document", "picture"  # files of the form
REFUSALS = (CompetitionRefused, SubmissionRejected, QuotaExceeded, StorageUnavailable)


def vehicle(posted: Mapping[str, str]) -> StoredVehicle | None:
    """Store the vehicle of the form; None if there is no file and none was kept.

    Raises
    ------
    DocumentInvalid, SubmissionRejected, QuotaExceeded, StorageUnavailable
        It cannot run, or cannot be stored.
    """
    kept = posted.get(submitted_vehicle.KEPT_NAME, "")
    try:
        return submitted_vehicle.save({vehicles.FIELD: kept}, posted)
    except VehicleRejected as rejected:
        raise DocumentInvalid({submitted_vehicle.FILE: rejected.shortened}) from None


def read(
    posted: Mapping[str, str], brought: StoredVehicle | None, *, earlier: CompetitionView | None
) -> Draft:
    """Return the draft of the form.

    Parameters
    ----------
    brought
        The vehicle of the form.
    earlier
        The draft that it changes, whose settings it may keep.

    Raises
    ------
    DocumentInvalid
        With a sentence for each field that is wrong, by the names of the fields.
    """
    document = request.files.get(DOCUMENT)
    if document is not None and document.filename:
        return _of_file(document.stream.read(BYTES_MAX + 1), brought)
    values = draft_form.values_of(posted)
    benchmark, settings, kept = _task(posted, earlier)
    values |= {"benchmark": benchmark, "settings": settings}
    try:
        return _draft(values, brought or kept)
    except DocumentInvalid as invalid:
        errors = dict[str, str]()
        for place, text in invalid.errors.items():
            if place == "name" and "title" in invalid.errors and "name" not in values:
                continue  # it would come from the title
            field = draft_form.field_of(place, posted)
            errors[field] = f"{errors[field]} {text}" if field in errors else text
        raise DocumentInvalid(errors) from None


def _of_file(content: bytes, brought: StoredVehicle | None) -> Draft:
    try:
        values = read_toml(content)
        _require_files(values, brought)
        return _draft({name: values[name] for name in values.keys() - _PATHS}, brought)
    except TomlRefused as refusal:
        raise DocumentInvalid({DOCUMENT: str(refusal)}) from None
    except DocumentInvalid as invalid:
        files = (PICTURE, submitted_vehicle.FILE)
        errors = {name: invalid.errors[name] for name in files if name in invalid.errors}
        others = [f"{at}: {text}" for at, text in invalid.errors.items() if at not in files]
        raise DocumentInvalid(errors | ({DOCUMENT: " ".join(others)} if others else {})) from None


def _require_files(values: Mapping[str, Any], brought: StoredVehicle | None) -> None:
    """Refuse a file that names a picture or a vehicle beside it which the form does not have."""
    picture = request.files.get(PICTURE)
    there = {PICTURE: picture is not None and bool(picture.filename), vehicles.FIELD: bool(brought)}
    fields = {PICTURE: PICTURE, vehicles.FIELD: submitted_vehicle.FILE}
    missing = [name for name in there if values.get(name) and not there[name]]
    if missing:
        raise DocumentInvalid(
            {
                fields[name]: f"The TOML file names {values[name]}: choose it here."
                for name in missing
            }
        )


def _draft(values: Mapping[str, Any], own: StoredVehicle | None) -> Draft:
    file = request.files.get(PICTURE)
    picture = None
    if file is not None and file.filename:
        picture = file.stream.read(drafts.PICTURE_MAX_BYTES + 1)
    try:
        return drafts.read(values, services().settings, vehicle=own, picture=picture)
    except VehicleRejected as rejected:
        raise DocumentInvalid({submitted_vehicle.FILE: rejected.shortened}) from None


def _task(
    posted: Mapping[str, str], earlier: CompetitionView | None
) -> tuple[str, dict[str, Any], StoredVehicle | None]:
    """Return benchmark, settings and own vehicle of the source that was chosen."""
    source, settings = posted.get("source", ""), services().settings
    if source == "kept" and earlier is not None:
        document = earlier.document
        return document.benchmark, document.settings, entries.vehicle_of(earlier, settings)
    if source != "run":
        return posted.get("benchmark", ""), {}, None
    try:
        run = template_runs.chosen(posted.get("run", ""))
        its_own = vehicles.of_run(run, settings)
    except NoTemplate as refusal:
        raise DocumentInvalid({"run": str(refusal)}) from None
    except FileNotFoundError:
        raise DocumentInvalid({"run": "The vehicle of this run has been deleted."}) from None
    # All of them: what a run leaves at its default may have another one beside chosen presets.
    fields = registry.benchmark(run.benchmark).configuration.model_fields
    fixed = {
        name: value
        for name, value in run.config.items()
        if name in fields and schema_extras(fields[name])["x-role"] == "scenario"
    }
    return run.benchmark, fixed, its_own
