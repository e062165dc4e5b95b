"""What clients make of the header Retry-After, which any server may send."""

from datetime import UTC, datetime, timedelta
from email.utils import format_datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.client import retry_after
from seamark.client.retry_after import FIRST_PAUSE_S, HINT_MAX_S, PAUSE_MAX_S

ENDLESS = [
    "9" * 5000,
    "Mon, 99999999999999999999 Jan 2030 00:00:00 GMT",
    "Mon, 01 Jan 99999999999 00:00:00 GMT",
    "Fri, 31 Dec 9999 23:59:59 GMT",
]


@pytest.mark.parametrize(
    ("text", "expected"),
    [("0", 0.0), (" 7 ", 7.0), ("007", 7.0), ("Wed, 21 Oct 2015 07:28:00 GMT", 0.0)],
)
def test_seconds_and_dates_are_read(text: str, expected: float) -> None:
    assert retry_after.hint_s(text) == expected


def test_a_date_is_waited_for() -> None:
    date = format_datetime(datetime.now(UTC) + timedelta(seconds=900), usegmt=True)

    assert 600 < retry_after.pause_s(date, 0) <= 900


@pytest.mark.parametrize("text", ["", "-1", "+1", "1.5", "1e3", "inf", "nan", "soon", "٣", "0x10"])
def test_what_is_neither_is_no_hint(text: str) -> None:
    assert retry_after.hint_s(text) is None
    assert FIRST_PAUSE_S / 2 <= retry_after.pause_s(text, 0) <= FIRST_PAUSE_S


@pytest.mark.parametrize("text", ENDLESS)
def test_nobody_is_asked_to_wait_longer_than_a_day(text: str) -> None:
    assert retry_after.hint_s(text) in (None, HINT_MAX_S)


@given(
    st.one_of(st.text(), st.integers().map(str), st.from_regex(r"[0-9 ,:+A-Za-z-]*")),
    st.integers(0, 10_000),
)
def test_whatever_a_server_says_pauses_grow_and_end(text: str, attempt: int) -> None:
    grown = min(FIRST_PAUSE_S * 2.0 ** min(attempt, 20), PAUSE_MAX_S)

    assert grown / 2 <= retry_after.pause_s(text, attempt) <= HINT_MAX_S
