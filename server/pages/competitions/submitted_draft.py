"""The draft in a posted form: its fields or a TOML file, with picture, vehicle and other files."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, BinaryIO, NamedTuple, cast

from flask import g, request
from werkzeug.datastructures import FileStorage

from seamark.competitions.document import DocumentInvalid
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import drafts, entries
from seamark.server.judging.drafts import Draft
from seamark.server.pages.competitions import draft_form
from seamark.server.pages.submission import kept_files, submitted_vehicle
from seamark.server.programs import own_files, vehicles
from seamark.server.programs.own_files import FileRejected, StoredFile
from seamark.server.programs.vehicles import StoredVehicle, VehicleRejected
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import template_runs, uploads
from seamark.server.web.services import services
from seamark.server.web.template_runs import NoTemplate
from seamark.sim import registry
from seamark.sim.settings.own_files import LIBRARIES
from seamark.sim.settings.setting import schema_extras
from seamark.sim.vehicles.toml_reading import BYTES_MAX, TomlRefused, read_toml

DOCUMENT, PICTURE = "document", "picture"  # files of the form
_FILES = {  # entry with the path of a file beside a TOML file -> field of the form
    PICTURE: PICTURE,
    vehicles.FIELD: submitted_vehicle.FILE,
    **{name: name for name in LIBRARIES},
}
REFUSALS = (CompetitionRefused, SubmissionRejected, QuotaExceeded, StorageUnavailable)


@dataclass
class Brought:
    """What came with a form and is stored: the next form keeps it."""

    vehicle: StoredVehicle | None = None
    files: dict[str, StoredFile] = field(default_factory=dict)  # setting -> file

    def tokens(self, errors: Mapping[str, str]) -> dict[str, str]:
        """Return the hidden fields of what is kept: not of a file for which there is no setting."""
        fields = {
            kept_files.field(name): kept_files.token(name, file.sha256, file.name)
            for name, file in self.files.items()
            if name not in errors
        }
        if self.vehicle is not None:
            fields[submitted_vehicle.KEPT] = submitted_vehicle.token(self.vehicle)
            fields[submitted_vehicle.KEPT_NAME] = self.vehicle.name
        return fields


def store(posted: Mapping[str, str], brought: Brought) -> None:
    """Store the files of the form, and take those that it has kept.

    Raises
    ------
    DocumentInvalid, SubmissionRejected, QuotaExceeded, StorageUnavailable
        One cannot be used, or cannot be stored.
    """
    kept = posted.get(submitted_vehicle.KEPT_NAME, "")
    try:
        brought.vehicle = submitted_vehicle.save({vehicles.FIELD: kept}, posted)
        for setting in LIBRARIES:
            if (file := _file(setting, posted)) is not None:
                brought.files[setting] = file
    except VehicleRejected as rejected:
        raise DocumentInvalid({submitted_vehicle.FILE: rejected.shortened}) from None
    except FileRejected as rejected:
        raise DocumentInvalid({rejected.field: str(rejected)}) from None


def _file(setting: str, posted: Mapping[str, str]) -> StoredFile | None:
    sent = _sent(setting)
    if sent is not None:
        stream, name = cast(BinaryIO, sent.stream), sent.filename or ""
        return uploads.store_file(stream, name, setting=setting, viewer=g.viewer)
    kept = kept_files.kept(setting, posted.get(kept_files.field(setting), ""))
    if kept is None:
        return None
    sha256, value = kept
    (file,) = own_files.stored({setting: sha256}, {setting: value}, services().settings)
    return file


def read(posted: Mapping[str, str], brought: Brought, *, earlier: CompetitionView | None) -> Draft:
    """Return the draft of the form.

    Parameters
    ----------
    brought
        The files of the form.
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
    task = _task(posted, earlier)
    values |= {"benchmark": task.benchmark, "settings": task.settings}
    try:
        files = {one.setting: one for one in task.files} | brought.files
        return _draft(values, brought.vehicle or task.vehicle, files)
    except DocumentInvalid as invalid:
        errors = dict[str, str]()
        for place, text in invalid.errors.items():
            if place == "name" and "title" in invalid.errors and "name" not in values:
                continue  # it would come from the title
            field = draft_form.field_of(place, posted)
            errors[field] = f"{errors[field]} {text}" if field in errors else text
        raise DocumentInvalid(errors) from None


def _of_file(content: bytes, brought: Brought) -> Draft:
    try:
        values = read_toml(content)
        _require_files(values, brought)
        others = {name: values[name] for name in values.keys() - _FILES.keys()}
        return _draft(others, brought.vehicle, brought.files)
    except TomlRefused as refusal:
        raise DocumentInvalid({DOCUMENT: str(refusal)}) from None
    except DocumentInvalid as invalid:
        files = _FILES.values()
        errors = {name: invalid.errors[name] for name in files if name in invalid.errors}
        rest = [f"{at}: {text}" for at, text in invalid.errors.items() if at not in files]
        raise DocumentInvalid(errors | ({DOCUMENT: " ".join(rest)} if rest else {})) from None


def _require_files(values: Mapping[str, Any], brought: Brought) -> None:
    """Refuse a file that names others beside it which the form does not have."""
    there = {PICTURE: _sent(PICTURE), vehicles.FIELD: brought.vehicle} | dict(brought.files)
    missing = [name for name in _FILES if values.get(name) and there.get(name) is None]
    if missing:
        raise DocumentInvalid(
            {
                _FILES[name]: f"The TOML file names {values[name]}: choose it here."
                for name in missing
            }
        )


def _draft(
    values: Mapping[str, Any], own: StoredVehicle | None, files: Mapping[str, StoredFile]
) -> Draft:
    file = _sent(PICTURE)
    picture = None if file is None else file.stream.read(drafts.PICTURE_MAX_BYTES + 1)
    try:
        return drafts.read(
            *(values, services().settings),
            vehicle=own,
            picture=picture,
            files=tuple(files.values()),
        )
    except VehicleRejected as rejected:
        raise DocumentInvalid({submitted_vehicle.FILE: rejected.shortened}) from None
    except FileRejected as rejected:
        raise DocumentInvalid({rejected.field: str(rejected)}) from None


def _sent(field: str) -> FileStorage | None:
    """Return a file of the form; None if none was chosen."""
    file = request.files.get(field)
    return file if file is not None and file.filename else None


class _Task(NamedTuple):
    benchmark: str
    settings: dict[str, Any]
    vehicle: StoredVehicle | None = None
    files: tuple[StoredFile, ...] = ()


def _task(posted: Mapping[str, str], earlier: CompetitionView | None) -> _Task:
    """Return benchmark, settings and own files of the source that was chosen."""
    source, settings = posted.get("source", ""), services().settings
    if source == "kept" and earlier is not None:
        document = earlier.document
        files = entries.files_of(earlier, settings)
        vehicle = entries.vehicle_of(earlier, settings)
        return _Task(document.benchmark, document.settings, vehicle, files)
    if source != "run":
        return _Task(posted.get("benchmark", ""), {})
    try:
        run = template_runs.chosen(posted.get("run", ""))
        vehicle, files = vehicles.of_run(run, settings), own_files.of_run(run, settings)
    except NoTemplate as refusal:
        raise DocumentInvalid({"run": str(refusal)}) from None
    except FileNotFoundError:
        raise DocumentInvalid({"run": "The files of this run have been deleted."}) from None
    # All of them: what a run leaves at its default may have another one beside chosen presets.
    fields = registry.benchmark(run.benchmark).configuration.model_fields
    fixed = {
        name: value
        for name, value in run.config.items()
        if name in fields and schema_extras(fields[name])["x-role"] == "scenario"
    }
    return _Task(run.benchmark, fixed, vehicle, files)
