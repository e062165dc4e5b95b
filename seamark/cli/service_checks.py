"""What `seamark doctor` asks about a service, of all its parts at once and for a limited time.

A part that is away keeps runs from working: it is `bad`. Only what has grown too open is a warning.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future, wait
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from seamark.cli.findings import Check

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings
    from seamark.server.storage.objects import Objects

ANSWER_S = 8.0  # [s] in which every part has to answer
_NO_BUCKET = "404 Not Found"  # to the question what is in it
_NO_RIGHT = ("401 Unauthorized", "403 Forbidden")
WHY_MAX = 200  # [character] of what a library says


def of_service(settings: Settings) -> Iterator[Check]:
    """Yield the results for all parts of a service, in a fixed order."""
    until = time.monotonic() + ANSWER_S
    asked = {name: _started(ask, settings) for name, ask in PARTS.items()}
    for name, answer in asked.items():
        if wait([answer], max(until - time.monotonic(), 0.0)).done:
            yield from answer.result()
        else:
            says = f"gave no answer within {ANSWER_S:g} s"
            yield Check(name, "bad", says, "Is it running, and is the network in order?")


def _started(ask: Callable[[Settings], Iterable[Check]], settings: Settings) -> Future[list[Check]]:
    """Ask in a thread of its own, which does not keep this process from ending."""
    answer = Future[list[Check]]()

    def act() -> None:
        try:
            answer.set_result(list(ask(settings)))
        except Exception as error:  # raised where the answer is read
            answer.set_exception(error)

    threading.Thread(target=act, daemon=True).start()
    return answer


def _database(settings: Settings) -> Iterable[Check]:
    from sqlalchemy import make_url
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
    from seamark.server.database import schema
    from seamark.server.database.engine import Database

    shown = make_url(settings.database_url).render_as_string(hide_password=True)
    if not _has_database(settings):
        yield Check("database", "ok", f"{shown} (created at the first start)")
        return
    database = Database(settings.database_url)
    try:
        schema.check(database.engine)
        yield Check("database", "ok", shown)
        if database.engine.dialect.name == "postgresql":
            yield _limits(database)
    except schema.SchemaTooOld as old:
        yield Check("database", "bad", str(old), "`seamark up` does it by itself.")
    except PlatformFailed as failed:
        yield Check("database", "bad", str(failed))
    except SQLAlchemyError as error:
        remedy = "Check SEAMARK_DATABASE_URL and that the server is running."
        yield Check("database", "bad", f"{shown}: {type(error).__name__}", remedy)
    finally:
        database.close()


def _has_database(settings: Settings) -> bool:
    """Return whether there may be a database: to open a file that is not there would make it."""
    sqlite = "sqlite:///"
    url = settings.database_url
    return not url.startswith(sqlite) or Path(url.removeprefix(sqlite)).exists()


def _limits(database: Database) -> Check:
    """Say whether PostgreSQL ends the transactions of machines that vanish."""
    from seamark.server.database import session_limits

    name = "limits of sessions"
    with database.engine.connect() as connection:
        limits = session_limits.find(connection)
    if not limits.missing:
        return Check(name, "ok", "a machine that vanishes does not hold up the others")
    says = f"not in force: {', '.join(limits.missing)}"
    if limits.pooled:
        says = (
            f"a pooler stands before PostgreSQL, and its sessions lack {', '.join(limits.missing)}"
        )
    remedy = (
        "A machine that vanishes may stop the queue for hours. Set them for the role of the "
        'service, see "A pooler before PostgreSQL" in docs/hosting.md.'
    )
    return Check(name, "warning", says, remedy)


@contextmanager
def _connected(settings: Settings) -> Iterator[Connection | None]:
    """Yield a connection to a database with tables of this version; None if there is none."""
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.failures import PlatformFailed
    from seamark.server.database import schema
    from seamark.server.database.engine import Database

    if not _has_database(settings):
        yield None
        return
    database = Database(settings.database_url)
    try:
        try:
            schema.check(database.engine)
        except (schema.SchemaTooOld, PlatformFailed, SQLAlchemyError):  # `_database` says so
            yield None
            return
        with database.engine.connect() as connection:
            yield connection
    finally:
        database.close()


def _keys(settings: Settings) -> Iterable[Check]:
    """Compare with the database what decides results."""
    from seamark.server.database import data_folder

    with _connected(settings) as connection:
        if connection is None:
            return
        seeds = data_folder.other_seeds(connection, settings)
        code = data_folder.other_code(connection)
        alone = connection.dialect.name == "sqlite"
    if settings.derives_seeds:
        yield Check("seed key", "bad" if seeds else "ok", seeds or "that of the database")
    else:
        remedy = "Set SEAMARK_SEED_KEY where a web server runs; a machine of workers needs none."
        yield Check("seed key", "bad" if alone else "warning", "none on this machine", remedy)
    yield Check("result code", "bad" if code else "ok", code or "that of the database")


def _broker(settings: Settings) -> Iterable[Check]:
    from redis.exceptions import RedisError

    from seamark.embedded.broker import find_server
    from seamark.failures import PlatformFailed
    from seamark.server.messaging import broker

    if not settings.broker_url:
        try:
            yield Check("broker", "ok", f"`seamark up` starts {find_server().name}")
        except PlatformFailed as missing:
            yield Check("broker", "bad", "none", str(missing))
        return
    client = broker.connect(settings)
    try:
        client.ping()
        yield Check("broker", "ok", "answers")
    except RedisError as error:
        remedy = "Check SEAMARK_BROKER_URL and that the server is running."
        yield Check("broker", "bad", f"does not answer: {error}", remedy)
    finally:
        client.close()


def _data_folder(settings: Settings) -> Iterable[Check]:
    data, name = settings.data, "data folder"
    if not data.exists():
        yield Check(name, "ok", f"{data} (created at the first start)")
    elif not os.access(data, os.R_OK | os.W_OK | os.X_OK):
        yield Check(name, "bad", f"this user may not write to {data}", "Run as its owner.")
    elif not settings.storage_url and (why := _of_another_service(settings)):
        yield Check(name, "bad", why)
    else:
        yield Check(name, "ok", str(data))
        yield from _open_files(settings)


def _open_files(settings: Settings) -> Iterable[Check]:
    from seamark.server.storage import private_files

    if readable := private_files.open_to_others(settings):
        says = f"other users may read {', '.join(path.name for path in readable)}"
        remedy = (
            f"Start the service, which closes them, or: chmod go= {' '.join(map(str, readable))}"
        )
        yield Check("files of the service", "warning", says, remedy)


def _objects(settings: Settings) -> Iterable[Check]:
    from seamark.server.storage import objects
    from seamark.server.storage.objects import ObjectsAway

    name, stored = "object storage", objects.of(settings)
    if stored is None:
        return
    try:
        is_new = _is_new(stored)
        why = _of_another_service(settings)
    except ObjectsAway as error:
        yield Check(name, "bad", *_explained(settings, str(error)))
        return
    says = f"{settings.storage_url} answers" + (" (empty)" if is_new else "")
    yield Check(name, "bad" if why else "ok", why or says)


def _is_new(stored: Objects) -> bool:
    """Return whether there is nothing yet; raises ObjectsAway also if there is no bucket."""
    from seamark.server.storage.objects import MARK

    return not stored.folders("") and stored.get(MARK) is None


def _of_another_service(settings: Settings) -> str:
    """Return why the storage is not the one of the database; empty if it is, or may become it."""
    from seamark.server.database import data_folder
    from seamark.server.database.data_folder import WrongDataFolder

    with _connected(settings) as connection:
        try:
            if connection is not None:
                data_folder.check(connection, settings)
        except WrongDataFolder as wrong:
            return f"{wrong}."
    return ""


def _explained(settings: Settings, why: str) -> tuple[str, str]:
    """Return what is wrong with an object storage, and what to do."""
    bucket = settings.storage_url.removeprefix("s3://").partition("/")[0]
    if _NO_BUCKET in why:
        return f"there is no bucket {bucket}", "Create it, or check SEAMARK_STORAGE_URL."
    if any(word in why for word in _NO_RIGHT):
        keys = "Check SEAMARK_STORAGE_ACCESS_KEY, ..._SECRET_KEY, and what they may do there."
        return f"refuses the keys for the bucket {bucket}", keys
    remedy = "Check SEAMARK_STORAGE_ENDPOINT and that the server is running."
    return f"does not answer: {why[:WHY_MAX]}", remedy


def _room(settings: Settings) -> Iterable[Check]:
    from seamark.server.storage import storage

    data = settings.data
    folder = next(folder for folder in (data, *data.parents) if folder.exists())
    free, least = storage.free_bytes(folder), settings.free_min_bytes
    says = f"{free / 2**30:.1f} GiB free in {folder}; runs need {least / 2**30:.1f} GiB"
    state = "bad" if free < least else "warning" if free < 2 * least else "ok"
    remedy = "Free or add space, choose another folder with --data, or set SEAMARK_FREE_MIN_BYTES."
    yield Check("disk", state, says, remedy)


PARTS: Mapping[str, Callable[[Settings], Iterable[Check]]] = {
    "database": _database,
    "keys": _keys,
    "broker": _broker,
    "data folder": _data_folder,
    "object storage": _objects,
    "disk": _room,
}
