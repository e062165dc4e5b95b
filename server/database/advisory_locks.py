"""Advisory locks: one transaction at a time in each critical section. All their numbers."""

from enum import IntEnum, unique

from sqlalchemy import Connection, text
from sqlalchemy.orm import Session


@unique
class AdvisoryLock(IntEnum):
    """The critical sections of the service. PostgreSQL knows a lock by its number alone."""

    SUBMISSION = 0x5EA_0001  # quota check and insert of a run
    CHECKS = 0x5EA_0003  # the queue of checks
    BASELINES = 0x5EA_0004  # looking for baselines and submitting the missing ones
    LEADERBOARD = 0x5EA_0005  # changes of the `best` rows
    SCHEMA = 0x5EA_0006  # migrations
    GUEST_TURN = 0x5EA_0007  # starting a run of a guest before those of accounts
    BASELINE_TURN = 0x5EA_0008  # starting a baseline
    TOTALS = 0x5EA_0009  # counting the runs that have ended
    COMPETITIONS = 0x5EA_000A  # names of drafts, deciding rounds, adding batches to finals
    TEAMS = 0x5EA_000B  # who is in which team, and names of teams


_ACQUIRE = text("SELECT pg_advisory_xact_lock(:key)")
_TRY = text("SELECT pg_try_advisory_xact_lock(:key)")


def acquire(session: Session | Connection, lock: AdvisoryLock) -> None:
    """Wait for the lock and hold it until the transaction ends.

    SQLite has a single writer anyway (BEGIN IMMEDIATE); PostgreSQL takes an advisory lock.
    """
    connection = session.connection() if isinstance(session, Session) else session
    if connection.dialect.name == "postgresql":
        connection.execute(_ACQUIRE, {"key": int(lock)})


def try_acquire(session: Session, lock: AdvisoryLock) -> bool:
    """Hold the lock until the transaction ends; False, without waiting, if another one has it."""
    connection = session.connection()
    if connection.dialect.name != "postgresql":
        return True
    return bool(connection.scalar(_TRY, {"key": int(lock)}))
