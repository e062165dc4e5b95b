"""The programs, the vehicle and the record of currents of a request: read, checked and stored."""

from typing import BinaryIO

from seamark.programs import parts
from seamark.programs.preparation import UploadRejected
from seamark.server.accounts.permissions import Viewer
from seamark.server.programs import own_files, store, vehicles
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.submission import quota
from seamark.server.web.services import services


def store_program(
    stream: BinaryIO, filename: str, *, viewer: Viewer, role: str, personal: bool = True
) -> StoredProgram:
    """Store an upload whose run the viewer may submit.

    Parameters
    ----------
    personal
        Whether the quota of the viewer counts: a round of a competition has its own for teams.

    Raises
    ------
    UploadRejected
        It is no program for this role.
    QuotaExceeded
        Its run would be refused: what is stored for nothing takes space too.
    StorageUnavailable
        There is no room.
    """
    current = services()
    prepared = current.reader.read_upload(
        stream,
        filename,
        owner=viewer.owner or "",
        limit=current.settings.upload_max_bytes,
        role=role,
    )
    prepared.require_clean()
    if personal:
        with current.database.reading() as session:
            quota.enforce(session, viewer, current.settings, new_bytes=len(prepared.content))
    return store.save(prepared, current.settings)


def store_part(
    stream: BinaryIO, filename: str, *, viewer: Viewer, role: str, personal: bool = True
) -> StoredProgram:
    """Store a further program of a run, as `store_program`; what is raised names its field."""
    try:
        return store_program(stream, filename, viewer=viewer, role=role, personal=personal)
    except UploadRejected as rejected:
        rejected.field = parts.field(role)
        raise


def store_vehicle(stream: BinaryIO, filename: str, *, viewer: Viewer) -> StoredVehicle:
    """Store a vehicle with which the viewer may submit a run.

    Raises
    ------
    VehicleRejected
        It is no vehicle that can run.
    QuotaExceeded, StorageUnavailable
        As `store_program`.
    """
    current = services()
    report, content = current.reader.read_vehicle(stream, filename, owner=viewer.owner or "")
    report.require_usable()
    with current.database.reading() as session:
        quota.enforce(session, viewer, current.settings, new_bytes=len(content))
    return vehicles.save(report.name, content, current.settings)


def store_file(stream: BinaryIO, filename: str, *, setting: str, viewer: Viewer) -> StoredFile:
    """Store a file of a setting with which the viewer may organise a competition.

    Raises
    ------
    FileRejected
        It breaks a rule.
    QuotaExceeded, StorageUnavailable
        As `store_program`.
    """
    current = services()
    owner = viewer.owner or ""
    content = current.reader.read_file(stream, filename, setting=setting, owner=owner)
    with current.database.reading() as session:
        quota.enforce(session, viewer, current.settings, new_bytes=len(content))
    return own_files.save(setting, content, current.settings)
