import json

import pytest

from seamark.server.web.streams import events
from seamark.server.web.streams.events import Position


@pytest.mark.parametrize(
    "text", [None, "", "x", "1-2", "1-2-3-4", "-1-0-0", "1-2-٣", "9" * 30 + "-0-0", "1-0-"]
)
def test_what_is_no_position_counts_as_none(text: str | None) -> None:
    assert Position.parse(text) is None


def test_a_position_survives_its_text() -> None:
    assert Position.parse(str(Position(2, 3, 4))) == Position(2, 3, 4)


def test_an_event_is_encoded_as_the_standard_requires() -> None:
    frame = events.log(Position(1, 2, 3), "a\nb", gap=False)

    assert frame.data == b'id: 1-2-3\nevent: log\ndata: {"text": "a\\nb", "gap": false}\n\n'


def test_a_row_is_json_with_the_digits_that_a_screen_shows() -> None:
    values = [2.0, 5999.95, -0.0123456789, 1e-300, float("nan"), float("inf")]
    text = events.row_text(values, [True, True, False, False, False, False])

    assert json.loads(text) == [2, 5999.95, -0.012346, 1e-300, None, None]
