"""What a database is asked: statements, connections, and the plans of slow queries."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import Engine, event

SLOW_MS = 10.0  # of a query whose plan is printed


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


@contextmanager
def slow_queries(engine: Engine, slow: dict[str, object]) -> Iterator[None]:
    """Keep the statements that take longer than `SLOW_MS` meanwhile, with their values."""
    starts: list[float] = []

    def begin(*_: object) -> None:
        starts.append(time.perf_counter())

    def end(_c: object, _cursor: object, statement: str, values: object, *_: object) -> None:
        if 1e3 * (time.perf_counter() - starts.pop()) > SLOW_MS and "SELECT" in statement[:6]:
            slow[statement] = values

    event.listen(engine, "before_cursor_execute", begin)
    event.listen(engine, "after_cursor_execute", end)
    try:
        yield
    finally:
        event.remove(engine, "before_cursor_execute", begin)
        event.remove(engine, "after_cursor_execute", end)


def plans(engine: Engine, slow: dict[str, object]) -> Iterator[str]:
    """Yield the slow queries and their plans."""
    explain = "EXPLAIN (ANALYZE) " if engine.dialect.name == "postgresql" else "EXPLAIN QUERY PLAN "
    with engine.connect() as connection:
        for statement, values in slow.items():
            yield f"\n{' '.join(statement.split())[:400]}"
            for row in connection.exec_driver_sql(explain + statement, values):  # type: ignore[arg-type]
                yield f"    {row[-1]}"
