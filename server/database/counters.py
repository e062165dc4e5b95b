"""Numbers that would cost a scan of a table, by name."""

from collections.abc import Collection

from sqlalchemy import ScalarSelect, select
from sqlalchemy.orm import Session

from seamark.server.database.queue_tables import Counter
from seamark.server.database.upsert import upsert


def value(session: Session, name: str) -> float:
    """Return a number; 0 if it was never stored."""
    return session.scalar(select(stored(name))) or 0.0


def values(session: Session, names: Collection[str]) -> dict[str, float]:
    """Return the `value` of each of some numbers, by one statement."""
    query = select(Counter.name, Counter.value).where(Counter.name.in_(names))
    return dict.fromkeys(names, 0.0) | {name: number for name, number in session.execute(query)}


def stored(name: str) -> ScalarSelect[float]:
    """Return a number as an expression, for a query that asks for more; NULL if it is missing."""
    return select(Counter.value).where(Counter.name == name).scalar_subquery()


def add(session: Session, name: str, number: float) -> None:
    """Add to a number; one that was never stored is 0."""
    upsert(session, Counter, {"name": name, "value": number}, {"value": Counter.value + number})


def store(session: Session, name: str, number: float) -> None:
    """Store a number. The caller has a lock that all who store it take."""
    upsert(session, Counter, {"name": name, "value": number}, {"value": number})
