import pytest
from sqlalchemy import text

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.engine import Database


def test_no_two_critical_sections_share_a_lock() -> None:
    numbers = [int(lock) for lock in AdvisoryLock.__members__.values()]

    assert len(numbers) == len(set(numbers))


@pytest.mark.parametrize("lock", AdvisoryLock)
def test_a_critical_section_does_not_wait_for_the_others(
    postgres_url: str, lock: AdvisoryLock
) -> None:
    database = Database(postgres_url)
    others = [other for other in AdvisoryLock if other is not lock]

    with database.writing() as first, database.writing() as second:
        for other in others:
            acquire(first, other)
        second.execute(text("SET LOCAL lock_timeout = '2s'"))
        acquire(second, lock)  # raises OperationalError if it has to wait

    database.close()
