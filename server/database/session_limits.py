"""What PostgreSQL bounds in each of our sessions, so that no machine stops the others by vanishing.

A machine that loses its power or its network, or whose virtual machine is paused, says nothing: by
default the server keeps its transaction, and the locks in it, for two hours or for ever. The kernel
of a process that is merely stopped answers keepalives, so the time between two statements counts.

The limits are set by the session itself rather than as options of the connection, which poolers
such as PgBouncer refuse. `seamark doctor` reads them back.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import Connection, bindparam, text

STATEMENT = """
SELECT set_config(name, value, false) FROM unnest(%s::text[], %s::text[]) AS chosen (name, value)
"""
# The server asks a client that is silent for 10 s, and gives it up 20 s later.
_OF_TCP = {
    "tcp_keepalives_idle": 10,  # [s]
    "tcp_keepalives_interval": 5,  # [s]
    "tcp_keepalives_count": 4,
    "tcp_user_timeout": 30_000,  # [ms]
}
_OF_TRANSACTIONS = ("lock_timeout", "idle_in_transaction_session_timeout")  # [ms]
_SETTINGS = text(
    "SELECT name, setting, reset_val FROM pg_settings WHERE name IN :names ORDER BY name"
).bindparams(bindparam("names", expanding=True))
_SERVER = text("SELECT pg_backend_pid(), inet_client_addr() IS NOT NULL")


@dataclass(frozen=True, slots=True)
class Findings:
    """What became of the limits of a session."""

    missing: list[str]  # names of those that are not in force
    pooled: bool  # a pooler may take the session for another one


def chosen(*, busy_s: float, idle_s: float) -> dict[str, int]:
    """Return the limits of a session: name -> value, in the unit that PostgreSQL takes it in.

    Parameters
    ----------
    busy_s
        How long a statement waits for a lock.
    idle_s
        How long a transaction may stand between two statements; 0: for ever.
    """
    times = (round(busy_s * 1000), round(idle_s * 1000))
    return dict(zip(_OF_TRANSACTIONS, times, strict=True)) | _OF_TCP


def parameters(limits: Mapping[str, int]) -> tuple[list[str], list[str]]:
    """Return the parameters of `STATEMENT`."""
    return list(limits), [str(value) for value in limits.values()]


def find(connection: Connection) -> Findings:
    """Return what PostgreSQL says of the limits of a session.

    Behind a pooler only those count that the role or the server has by itself.
    """
    driver = connection.connection.driver_connection
    backend, over_tcp = connection.execute(_SERVER).one()
    # A pooler gives its client another number than that of the server process.
    pooled = driver is not None and driver.info.backend_pid != backend
    names = [*_OF_TRANSACTIONS, *(_OF_TCP if over_tcp else ())]
    rows = connection.execute(_SETTINGS, {"names": names})
    off = [name for name, now, own in rows if int(own if pooled else now) == 0]
    return Findings(off, pooled)
