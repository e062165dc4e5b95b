"""The rows of all tables as JSON lines: the same for SQLite and PostgreSQL, of every version.

Not pg_dump and the backup function of SQLite: their files fit one database only, pg_dump must be
as new as the server, and neither an image nor a laptop has it. A dump in one transaction that reads
is as consistent, and what one database has written the other one can read.
"""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from sqlalchemy import JSON, Connection, column, func, insert, inspect, select, table, text
from sqlalchemy.sql.expression import TableClause

from seamark.server.database.tables import Base

LEFT_OUT = frozenset(("workers",))  # they register again
CHUNK_BYTES = 4 * 2**20
BATCH = 1000  # rows


def dump(connection: Connection) -> Iterator[tuple[str, int, bytes]]:
    """Yield the table, number of rows and JSON lines of one chunk after the other.

    The first line of a chunk has the names of the columns, each other one the values of a row. The
    caller's transaction has one snapshot for all of them.
    """
    for name in _in_order(connection):
        yield from _chunks(connection, name)


def load(connection: Connection, name: str, chunk: bytes) -> int:
    """Insert the rows of a chunk into its table; return how many."""
    first, *lines = chunk.splitlines()
    names = json.loads(first)
    into = insert(_described(connection, name))
    for at in range(0, len(lines), BATCH):
        batch = lines[at : at + BATCH]
        rows = [dict(zip(names, json.loads(line), strict=True)) for line in batch]
        connection.execute(into, rows)
    return len(lines)


def count_on(connection: Connection) -> None:
    """Let the numbers of new rows follow those of the loaded ones; SQLite does that by itself."""
    if connection.dialect.name != "postgresql":
        return
    sequence = text("SELECT pg_get_serial_sequence(:name, 'id')")
    for name in _in_order(connection):
        if "id" not in _described(connection, name).c:
            continue
        if value := connection.scalar(sequence, {"name": name}):
            last = select(func.max(column("id"))).select_from(table(name)).scalar_subquery()
            connection.execute(select(func.setval(value, func.coalesce(last, 0) + 1, False)))


def _chunks(connection: Connection, name: str) -> Iterator[tuple[str, int, bytes]]:
    of = _described(connection, name)
    head = json.dumps(list(of.c.keys())).encode()
    lines, size = [head], len(head)
    for row in connection.execute(select(of), execution_options={"yield_per": BATCH}):
        lines.append(json.dumps(list(row), allow_nan=False).encode())
        size += len(lines[-1]) + 1
        if size > CHUNK_BYTES:
            yield name, len(lines) - 1, b"\n".join(lines)
            lines, size = [head], len(head)
    if len(lines) > 1:
        yield name, len(lines) - 1, b"\n".join(lines)


def _in_order(connection: Connection) -> list[str]:
    """Return the tables of Seamark, each after those to which its foreign keys lead."""
    known = Base.metadata.tables.keys() - LEFT_OUT
    tables = inspect(connection).get_sorted_table_and_fkc_names()
    return [name for name, _ in tables if name in known]


def _described(connection: Connection, name: str) -> TableClause:
    """Return a table with the columns and types that it has in the database."""
    columns: list[Mapping[str, Any]] = [*inspect(connection).get_columns(name)]
    return table(name, *(column(each["name"], _type(each["type"])) for each in columns))


def _type(column_type: Any) -> Any:
    """Return a type for which None is NULL, also where the database has JSON."""
    return JSON(none_as_null=True) if isinstance(column_type, JSON) else column_type
