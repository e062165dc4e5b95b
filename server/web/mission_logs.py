"""The log of a request: measured and stored, for pages and the API alike."""

from __future__ import annotations

from typing import BinaryIO, cast

from werkzeug.datastructures import FileStorage

from seamark.mission_logs.result import LogRefused
from seamark.server.runs.data import staging
from seamark.server.runs.data.files import StorageFailed
from seamark.server.runs.logs import mission_logs
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access
from seamark.server.web.services import services


def open_log(
    file: FileStorage | None,
    mapping: str,
    *,
    benchmark: str = "",
    title: str = "",
    notes: str = "",
) -> int:
    """Measure and store the log of a viewer who may upload, and return the number of its run.

    Raises
    ------
    LogRefused, SlotsBusy, QuotaExceeded, StorageUnavailable
        It cannot be read, measured or stored.
    """
    if file is None or not file.filename:
        raise LogRefused("Choose the file of the log.")
    viewer, held = access.viewer(), services()
    mission_logs.require_room(held.database, held.settings, viewer)
    texts = {"title": title, "notes": notes}
    try:
        with staging.temporary_folder(held.settings) as folder:
            result = held.logs.read(
                cast("BinaryIO", file.stream),
                file.filename,
                mapping,
                benchmark=benchmark,
                owner=viewer.owner or "",
                limit=held.settings.upload_max_bytes,
                folder=folder,
            )
            return mission_logs.store(held.database, held.settings, viewer, result, **texts)
    except StorageFailed as error:
        raise StorageUnavailable(str(error)) from error
