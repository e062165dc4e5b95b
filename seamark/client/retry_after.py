"""How long to wait before a server is asked again: what it says of that, within reason."""

from __future__ import annotations

import secrets
from datetime import datetime, timezone
from email.utils import parsedate_to_datetime

HEADER = "Retry-After"
FIRST_PAUSE_S, PAUSE_MAX_S = 0.5, 8.0  # doubled each time, unless the server asks for more
HINT_MAX_S = 86_400.0  # the longest quota of a service is for a day


def hint_s(text: str) -> float | None:
    """Return the time that a header Retry-After asks for [s]; None if it cannot be read.

    The header has seconds or a date (RFC 9110, 10.2.3), and comes from a stranger.
    """
    text = text.strip()
    if text.isascii() and text.isdecimal():
        return min(float(text), HINT_MAX_S)
    try:
        date = parsedate_to_datetime(text)
    except (ValueError, OverflowError):
        return None
    date = date if date.tzinfo else date.replace(tzinfo=timezone.utc)
    return min(max((date - datetime.now(timezone.utc)).total_seconds(), 0.0), HINT_MAX_S)


def pause_s(text: str, attempt: int) -> float:
    """Return how long to wait after a refusal [s], however soon the server wants the next attempt.

    Parameters
    ----------
    text
        Its header Retry-After; empty without one.
    attempt
        How many attempts there were before.
    """
    return max(hint_s(text) or 0.0, backoff_s(attempt))


def backoff_s(attempt: int) -> float:
    """Return a random pause: clients that were cut off together do not return together."""
    longest = min(FIRST_PAUSE_S * 2.0 ** min(attempt, 10), PAUSE_MAX_S)
    return longest * (0.5 + secrets.randbelow(1000) / 2000)
