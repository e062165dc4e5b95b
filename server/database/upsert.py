"""One statement that both databases have, but SQLAlchemy only in a form for each."""

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
    insert = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    statement = insert(table).values(**row)
    key = inspect(table).primary_key
    session.execute(statement.on_conflict_do_update(index_elements=key, set_=dict(change)))
