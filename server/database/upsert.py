"""Statements that both databases have, but SQLAlchemy only in a form for each."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import inspect
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from seamark.server.database.tables import Base


def upsert(
    session: Session, table: type[Base], row: Mapping[str, Any], change: Mapping[str, Any]
) -> None:
    """Insert a row, or change the one with the same primary key; of two at once the second waits.

    Parameters
    ----------
    row
        Column -> value of a new row.
    change
        Column -> value or expression of the row that is there.
    """
    key = inspect(table).primary_key
    statement = _insert(session, table, row)
    session.execute(statement.on_conflict_do_update(index_elements=key, set_=dict(change)))


def insert_missing(session: Session, table: type[Base], row: Mapping[str, Any]) -> None:
    """Insert a row, unless there is one with the same primary key; of two at once the second waits.

    Parameters
    ----------
    row
        Column -> value.
    """
    session.execute(_insert(session, table, row).on_conflict_do_nothing())


def _insert(
    session: Session, table: type[Base], row: Mapping[str, Any]
) -> postgresql.Insert | sqlite.Insert:
    insert = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    return insert(table).values(**row)
