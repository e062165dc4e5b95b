"""Numbers that would cost a scan of a table, by name."""

from collections.abc import Collection

from sqlalchemy import ScalarSelect, delete, func, select
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


def total(session: Session, prefix: str) -> float:
    """Return the sum of the numbers whose names begin in a way."""
    return session.scalar(select(stored_total(prefix))) or 0.0


def stored_total(prefix: str) -> ScalarSelect[float]:
    """Return `total` as an expression, for a query that asks for more; NULL for 0."""
    named = Counter.name.startswith(prefix, autoescape=True)
    return select(func.sum(Counter.value)).where(named).scalar_subquery()


def forget(session: Session, prefix: str) -> None:
    """Delete the numbers whose names begin in a way; not those that another process deletes."""
    named = select(Counter.name).where(Counter.name.startswith(prefix, autoescape=True))
    free = named.with_for_update(skip_locked=True)
    session.execute(
        delete(Counter).where(Counter.name.in_(free)),
        execution_options={"synchronize_session": False},
    )


def add(session: Session, name: str, number: float) -> None:
    """Add to a number; one that was never stored is 0."""
    upsert(session, Counter, {"name": name, "value": number}, {"value": Counter.value + number})


def store(session: Session, name: str, number: float) -> None:
    """Store a number. The caller has a lock that all who store it take."""
    upsert(session, Counter, {"name": name, "value": number}, {"value": number})
