"""Says why a database cannot be opened, in a sentence for whoever runs the service."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import URL, Connection, Engine
from sqlalchemy.exc import DBAPIError

from seamark.failures import PlatformFailed
from seamark.server.database.engine import DATABASE_AWAY

_CHECK = "Check SEAMARK_DATABASE_URL"
_REASONS = (  # what PostgreSQL or its library says -> what it means
    (
        re.compile(r"password authentication failed|no password supplied|role .* does not exist"),
        "{server} refuses the user {user} or the password. " + _CHECK,
    ),
    (
        re.compile(r'database ".*" does not exist'),
        "{server} has no database {name}. Create it, or check SEAMARK_DATABASE_URL",
    ),
    (
        re.compile(r"translate host name|resolve host|name or service not known", re.IGNORECASE),
        "The host of the database, {host}, is not known. " + _CHECK,
    ),
)
_SILENT = "{server} does not answer: {why}. Is it running? " + _CHECK


class DatabaseAway(PlatformFailed):
    """The database cannot be opened. The text says why and what to do."""


@contextmanager
def connected(engine: Engine) -> Iterator[Connection]:
    """Yield a connection.

    Raises
    ------
    DatabaseAway
        There is none to be had.
    """
    try:
        connection = engine.connect()
    except DATABASE_AWAY as error:
        raise DatabaseAway(f"{_sentence(engine.url, error)}.") from None
    with connection:
        yield connection


def _sentence(url: URL, error: DBAPIError) -> str:
    why = str(error.orig).strip().partition("\n")[0].rstrip(".")
    if url.get_backend_name() == "sqlite":
        return f"The database file {url.database} cannot be opened: {why}"
    host = url.host or str(url.query.get("host", "this machine"))
    at = host if url.port is None else f"{host}:{url.port}"
    known = {
        "server": f"PostgreSQL at {at}",
        "host": host,
        "user": url.username or "without a name",
    }
    meant = (text for pattern, text in _REASONS if pattern.search(why))
    return next(meant, _SILENT).format(**known, name=url.database, why=why)
