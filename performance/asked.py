"""What a page asks a database: its statements and the connections that it takes for them."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Engine, event


@dataclass
class Asked:
    """The statements with their values, in order, and the number of connections."""

    statements: list[tuple[str, Any]] = field(default_factory=list)
    connections: int = 0  # taken from the pool; on PostgreSQL each begins with a ping

    @property
    def queries(self) -> int:
        """The number of statements that read."""
        return sum(statement.startswith("SELECT") for statement, _ in self.statements)


@contextmanager
def recorded(engine: Engine) -> Iterator[Asked]:
    """Record what a database is asked meanwhile."""
    asked = Asked()

    def keep(_c: object, _cursor: object, statement: str, values: Any, *_: object) -> None:
        asked.statements.append((statement, values))

    def count(*_: object) -> None:
        asked.connections += 1

    event.listen(engine, "before_cursor_execute", keep)
    event.listen(engine, "checkout", count)
    try:
        yield asked
    finally:
        event.remove(engine, "before_cursor_execute", keep)
        event.remove(engine, "checkout", count)
