"""The keys of submissions: one run for each, also of two requests at once, and not for ever."""

import threading
from collections.abc import Iterator

import pytest
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server.database.submission_tables import KeyOfSubmission
from seamark.server.runs.submission.submission_keys import KEPT_S, SubmissionKey, once
from tests.cast import Backend


@pytest.fixture
def numbers() -> Iterator[int]:
    return iter(range(1, 100))


def _key(backend: Backend, text: str = "a") -> SubmissionKey:
    return SubmissionKey.of(backend.user_id("ann"), text, request={"path": "/runs"})


def _once(backend: Backend, numbers: Iterator[int], text: str = "a", now: float = 0.0) -> int:
    with backend.database.writing() as session:
        return once(session, _key(backend, text), lambda: next(numbers), now=now)


def test_what_a_key_started_is_forgotten_after_a_day(both: Backend, numbers: Iterator[int]) -> None:
    first = _once(both, numbers)

    assert _once(both, numbers, now=KEPT_S - 1.0) == first
    assert _once(both, numbers, now=KEPT_S + 1.0) != first
    with both.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(KeyOfSubmission)) == 1


@pytest.mark.slow
def test_of_two_requests_at_once_one_starts_a_run(both: Backend, numbers: Iterator[int]) -> None:
    entered, answers = threading.Event(), list[int]()

    def slow() -> int:
        entered.set()
        second.join(timeout=0.5)  # it waits for the first one to commit
        return next(numbers)

    def repeat() -> None:
        entered.wait()
        answers.append(_once(both, numbers))

    second = threading.Thread(target=repeat)
    second.start()
    with both.database.writing() as session:
        answers.append(once(session, _key(both), slow, now=0.0))
    second.join()

    assert answers == [1, 1]


def test_a_submission_without_a_key_is_always_a_new_one(
    backend: Backend, numbers: Iterator[int]
) -> None:
    def start(session: Session) -> int:
        return once(session, None, lambda: next(numbers), now=0.0)

    with backend.database.writing() as session:
        assert (start(session), start(session)) == (1, 2)


def test_a_key_is_stored_as_a_hash(backend: Backend, numbers: Iterator[int]) -> None:
    _once(backend, numbers, text="secret")

    with backend.database.reading() as session:
        row = session.scalars(select(KeyOfSubmission)).one()
    assert "secret" not in f"{row.key}{row.request}"
