"""Times that people write in the time zone of a competition."""

from datetime import UTC, datetime
from functools import cache
from zoneinfo import ZoneInfo, available_timezones


@cache
def zone_names() -> frozenset[str]:
    """Return the names of all time zones (IANA), such as Europe/Madrid."""
    return frozenset(available_timezones())


def to_utc(time: datetime, zone: str) -> datetime:
    """Return a time in UTC; one without an offset is in the zone.

    Raises
    ------
    ValueError
        When clocks change: there is no such time, or there are two. The text is for the user.
    """
    if time.tzinfo is not None:
        return time.astimezone(UTC)
    first, second = (time.replace(tzinfo=ZoneInfo(zone), fold=fold) for fold in (0, 1))
    if first.utcoffset() == second.utcoffset():
        return first.astimezone(UTC)
    shown = f"{time:%H:%M on %d %B %Y}"
    if first.astimezone(UTC).astimezone(first.tzinfo).replace(tzinfo=None) != time:
        raise ValueError(
            f"{shown} does not exist in {zone}, where clocks are put forward then. Choose another "
            "time."
        )
    either = " or ".join(one.isoformat(timespec="minutes") for one in (first, second))
    raise ValueError(
        f"{shown} comes twice in {zone}, where clocks are put back then. Write {either}."
    )


def in_zone(at: float, zone: str) -> datetime:
    """Return a time [s since 1970] as clocks in a zone show it."""
    return datetime.fromtimestamp(at, ZoneInfo(zone))
