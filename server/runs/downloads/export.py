"""All that the service stores of an account as one zip archive, made while it is sent."""

import json
import zipfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sqlalchemy.orm import Session

from seamark.server.accounts import accounts, identities, profiles
from seamark.server.accounts.permissions import Viewer
from seamark.server.classes import classrooms
from seamark.server.competitions import teams
from seamark.server.database.engine import Database
from seamark.server.database.mail_tables import MailAddress
from seamark.server.database.tables import User
from seamark.server.programs import store
from seamark.server.runs.data import stored_files
from seamark.server.runs.downloads import zip_stream
from seamark.server.runs.showing import run_lists, views
from seamark.server.runs.showing.run_lists import FIRST, ListCursor, RunFilter
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings

PAGE = 50  # runs that are read from the database at a time
CHUNK_BYTES = 256 * 1024
# Fields of a view that are not data of the run.
_NOT_OWN = {"guest", "teacher_id", "entry", "data_run", "hidden_names"}


def archive(
    database: Database, settings: Settings, viewer: Viewer, *, telemetry: bool
) -> Iterator[bytes]:
    """Yield a zip archive: the account, and each run with configuration, result, log and program.

    With `telemetry` also the recorded rows. Needs the memory of a page of runs, however many there
    are, and holds no transaction while a slow client reads.
    """

    def write(file: zipfile.ZipFile) -> Iterator[None]:
        file.writestr("account.json", as_json(_account(database, viewer)))
        for run_id in _run_ids(database, viewer):
            with database.reading() as session:
                run = views.show(session, run_id)
            if run is not None:  # it may have been deleted meanwhile
                yield from write_run(file, settings, run, telemetry=telemetry)

    return zip_stream.pieces(write)


def _account(database: Database, viewer: Viewer) -> dict[str, Any]:
    user_id = viewer.user_id or 0
    with database.reading() as session:
        user = session.get_one(User, user_id)
        return {
            "name": user.name,
            "role": user.role,
            "profile": asdict(profiles.of(user)),
            "created_at": user.created_at,
            "mail": _mail(session, user),
            "identities": [
                {"issuer": each.issuer, "subject": each.subject, "name": each.label}
                for each in identities.all_of(session, user_id)
            ],
            "tokens": [
                {"name": token.name, "created_at": token.created_at, "scopes": token.scopes}
                for token in accounts.tokens(session, user_id)
            ],
            "classes_joined": [each.name for each in classrooms.joined_by(session, user_id)],
            "teams": sorted(teams.memberships(session, user_id).values()),
            "classes_taught": [each.name for each in classrooms.taught_by(session, user_id)],
        }


def _mail(session: Session, user: User) -> dict[str, Any]:
    address = session.get(MailAddress, user.id) or MailAddress()
    return {
        "address": address.address,
        "not_confirmed": address.pending,
        "notify_minutes": user.notify_minutes,
    }


def _run_ids(database: Database, viewer: Viewer) -> Iterator[int]:
    start: ListCursor | None = FIRST
    while start is not None:
        with database.reading() as session:
            page = run_lists.page(session, viewer, RunFilter(), start=start, limit=PAGE)
        yield from (run.id for run in page.runs)
        start = page.next


def write_run(
    file: zipfile.ZipFile,
    settings: Settings,
    run: RunView,
    *,
    telemetry: bool,
    program: bool = True,
) -> Iterator[None]:
    """Write a run, chunk by chunk, with or without its program and its log."""
    folder = f"runs/{run.id}"
    file.writestr(f"{folder}/run.json", as_json(run.model_dump(mode="json", exclude=_NOT_OWN)))
    if run.data_deleted_at is not None:
        return
    files = stored_files.of_run(settings, run)
    if program and (log := files.log_text()):
        file.writestr(f"{folder}/log.txt", log)
    for name, sha256 in (*(_programs(run) if program else ()), *_files(run)):
        if store.size(settings, sha256):
            file.writestr(f"{folder}/{name}", store.read(settings, sha256))
    yield
    if telemetry and files.telemetry_path.is_file():
        file.writestr(f"{folder}/columns.json", as_json(files.columns))
        with (
            files.telemetry_path.open("rb") as rows,
            file.open(f"{folder}/telemetry.f64", "w", force_zip64=True) as entry,
        ):
            while chunk := rows.read(CHUNK_BYTES):
                entry.write(chunk)
                yield


def _programs(run: RunView) -> Iterator[tuple[str, str]]:
    """Yield name in the folder and SHA-256 of each program of a run."""
    if run.program_sha256 is not None:
        yield f"program/{Path(run.program_name or 'program').name}", run.program_sha256
    for part in run.parts:
        name = Path(part.program_name or "program").name
        yield f"parts/{part.role}/{name}", part.program_sha256


def as_json(value: object) -> str:
    """Return a value as the files of an archive have it."""
    return json.dumps(value, indent=2, ensure_ascii=False)


def _files(run: RunView) -> Iterator[tuple[str, str]]:
    """Yield name in the folder and SHA-256 of each file that a setting of a run names."""
    if run.vehicle_sha256 is not None:
        yield "vehicle.toml", run.vehicle_sha256
    for one in run.files:
        yield f"{one.setting}.csv", one.sha256
