"""The audit log on both databases."""

import time

from sqlalchemy import update

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditAction, AuditFilter
from seamark.server.database.operation_tables import AuditEntry
from tests.cast import Backend

ROOT = Actor("root", "192.0.2.7")


def _write(both: Backend, count: int, target: str = "ann") -> None:
    with both.database.writing() as session:
        for _ in range(count):
            audit.record(session, ROOT, AuditAction.ROLE_CHANGED, target)


def test_pages_of_the_log_have_each_matching_entry_once(both: Backend) -> None:
    for target in ("ann", "ben", "ann"):
        _write(both, 3, target)
    wanted, seen, after = AuditFilter(action="role_changed", target="ann"), list[int](), None

    with both.database.reading() as session:
        while True:
            page = audit.page(session, wanted, after=after, limit=2)
            seen += [entry.id for entry in page.entries]
            after = page.next
            if after is None:
                break

    assert seen == [9, 8, 7, 3, 2, 1]


def test_an_entry_is_not_written_without_what_it_tells(backend: Backend) -> None:
    try:
        with backend.database.writing() as session:
            audit.record(session, ROOT, AuditAction.ROLE_CHANGED, "ann")
            raise RuntimeError
    except RuntimeError:
        pass

    with backend.database.reading() as session:
        assert audit.page(session, AuditFilter()).entries == []


def test_old_entries_are_deleted_and_their_numbers_never_used_again(both: Backend) -> None:
    _write(both, 2)
    with both.database.writing() as session:
        session.execute(update(AuditEntry).values(at=time.time() - 11 * 86_400.0))
        assert audit.forget_old(session, days=10) == 2
    _write(both, 1)

    with both.database.reading() as session:
        assert [entry.id for entry in audit.page(session, AuditFilter()).entries] == [3]


def test_blocked_sign_ins_of_an_hour_are_limited_whatever_strangers_try(both: Backend) -> None:
    with both.database.writing() as session:
        assert not audit.blocked_is_known(session, Actor("anonymous", "1"), "ann")
        for number in range(audit.BLOCKED_PER_HOUR):
            stranger = Actor("anonymous", str(number))
            audit.record(session, stranger, AuditAction.SIGN_IN_BLOCKED, "ann")

    with both.database.reading() as session:
        assert audit.blocked_is_known(session, Actor("anonymous", "another"), "ben")
