"""Drafts of competitions: made from a document, checked by the reference entries, changed, deleted.

Whoever makes or changes one sends tickets for the reference entries after the commit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy.orm import Session

from seamark.competitions import document
from seamark.competitions.document import CompetitionDocument, DocumentInvalid
from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import check
from seamark.server.programs import own_files
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.data import run_size
from seamark.server.settings import Settings

PICTURE_MAX_BYTES = 512 * 1024
# Browsers decode the picture, the service never does.
_MEDIA_TYPES = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}


@dataclass(frozen=True, slots=True)
class Draft:
    """What an organiser has written: a document that is valid, its files and its picture."""

    document: CompetitionDocument
    vehicle: StoredVehicle | None = None
    picture: bytes | None = None
    files: tuple[StoredFile, ...] = ()  # that settings name, but for the vehicle's


def read(
    values: Mapping[str, Any],
    settings: Settings,
    *,
    vehicle: StoredVehicle | None = None,
    picture: bytes | None = None,
    files: tuple[StoredFile, ...] = (),
) -> Draft:
    """Return a draft of values as TOML or JSON gives them.

    Raises
    ------
    DocumentInvalid
        With a sentence for each place that is wrong.
    VehicleRejected
        No such vehicle exists.
    FileRejected
        Another file cannot be used.
    """
    asked = competitions.prepared(document.read(values), vehicle, files)
    if picture is not None and media_type(picture) is None:
        raise DocumentInvalid({"picture": "The picture must be a PNG or JPEG file."})
    if picture is not None and len(picture) > PICTURE_MAX_BYTES:
        limit = PICTURE_MAX_BYTES >> 10
        raise DocumentInvalid({"picture": f"The picture has at most {limit} KiB. Make it smaller."})
    most = max(one.trials for one in asked.rounds)
    with own_files.lent(vehicle, files):
        size = run_size.estimate(asked.scenario(), trials=most, program_bytes=None)
    if refusal := size.refusal(settings.run_max_bytes):
        raise DocumentInvalid({"settings": refusal})
    return Draft(asked, vehicle, picture, files)


def create(session: Session, organiser_id: int, draft: Draft, settings: Settings) -> str:
    """Make a draft, have it checked, and return its name.

    Raises
    ------
    CompetitionRefused, SubmissionRejected, StorageUnavailable
        The name is taken, or the reference entries cannot run.
    """
    made = competitions.create(
        *(session, organiser_id, draft.document),
        picture=draft.picture,
        vehicle=draft.vehicle,
        files=draft.files,
        secret=settings.seed_key.encode(),
    )
    check.request(session, competitions.get(session, made), settings)
    return draft.document.name


def change(
    session: Session, competition: CompetitionView, draft: Draft, settings: Settings
) -> Sequence[int]:
    """Replace a draft and have it checked again; the runs of the earlier check are forgotten.

    Without a picture it has the earlier one; without a vehicle or another file it has none of its
    own.
    Returns the runs whose files the caller removes after the commit (`deletion.remove_files`).
    Raises as `create`.
    """
    if not competition.is_draft:
        raise CompetitionRefused(competitions.FROZEN)
    forgotten = check.discard(session, competition)
    competitions.replace_draft(
        *(session, competition, draft.document),
        picture=draft.picture,
        vehicle=draft.vehicle,
        files=draft.files,
        secret=settings.seed_key.encode(),
    )
    check.request(session, competitions.get(session, competition.id), settings)
    return forgotten


def remove(session: Session, competition: CompetitionView) -> Sequence[int]:
    """Delete a draft; returns as `change`.

    Raises
    ------
    CompetitionRefused
        It is open.
    """
    if not competition.is_draft:
        raise CompetitionRefused("An open competition cannot be deleted: teams rely on it.")
    forgotten = check.discard(session, competition)
    competitions.remove_draft(session, competition)
    return forgotten


def media_type(picture: bytes) -> str | None:
    """Return the type of a picture by its first bytes; None if it is none that pages show."""
    return next((kind for mark, kind in _MEDIA_TYPES.items() if picture.startswith(mark)), None)
