"""Times that people write in the zone of a competition, also where clocks change."""

from datetime import UTC, datetime

import pytest

from seamark.competitions import document, zones
from seamark.competitions.document import DocumentInvalid
from tests.server.judging.cup import values

MADRID = "Europe/Madrid"


def test_a_time_without_an_offset_is_in_the_zone_in_summer_and_in_winter() -> None:
    summer, winter = datetime(2027, 7, 1, 12), datetime(2027, 12, 1, 12)

    assert zones.to_utc(summer, MADRID) == datetime(2027, 7, 1, 10, tzinfo=UTC)
    assert zones.to_utc(winter, MADRID) == datetime(2027, 12, 1, 11, tzinfo=UTC)


def test_a_time_with_an_offset_is_what_it_says() -> None:
    time = datetime.fromisoformat("2027-07-01T12:00-05:00")

    assert zones.to_utc(time, MADRID) == datetime(2027, 7, 1, 17, tzinfo=UTC)


def test_an_hour_that_clocks_skip_is_refused() -> None:
    with pytest.raises(ValueError, match="does not exist in Europe/Madrid"):
        zones.to_utc(datetime(2027, 3, 28, 2, 30), MADRID)


def test_an_hour_that_comes_twice_is_refused_with_the_two_ways_to_write_it() -> None:
    with pytest.raises(ValueError, match="comes twice") as caught:
        zones.to_utc(datetime(2027, 10, 31, 2, 30), MADRID)

    offsets = ("2027-10-31T02:30+02:00", "2027-10-31T02:30+01:00")
    assert all(text in str(caught.value) for text in offsets)
    times = [zones.to_utc(datetime.fromisoformat(text), MADRID) for text in offsets]
    assert [time.hour for time in times] == [0, 1]


def test_a_document_names_the_round_whose_time_clocks_skip() -> None:
    rounds = values()["rounds"]
    rounds[1]["closes"] = "2027-03-28T02:30"

    with pytest.raises(DocumentInvalid) as caught:
        document.read(values(rounds=rounds))
    assert "put forward" in caught.value.errors["rounds.1.closes"]
