"""The time by the clock of the database, which all machines of a service have in common."""

from typing import Any

from sqlalchemy import Double, select
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.orm import Session
from sqlalchemy.sql.functions import FunctionElement


class Now(FunctionElement[float]):
    """The Unix time [s] at which a statement begins."""

    type = Double()
    inherit_cache = True


@compiles(Now, "sqlite")
def _on_sqlite(*_: Any, **__: Any) -> str:
    return "((julianday('now') - 2440587.5) * 86400.0)"


@compiles(Now, "postgresql")
def _on_postgresql(*_: Any, **__: Any) -> str:
    return "extract(epoch FROM statement_timestamp())::double precision"


def now(session: Session) -> float:
    """Return the Unix time [s]."""
    return session.scalars(select(Now())).one()
