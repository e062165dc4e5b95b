"""The time line of the player: what moves the playhead, and how far."""

from typing import Any

import pytest

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

_RUN = """async ([options, steps]) => {
  const { Playhead } = await import("/static/js/player/playhead.js");
  const playhead = new Playhead(options);
  for (const [name, ...values] of steps) playhead[name](...values);
  return { ...playhead.state(), newest: playhead.newest };
}"""


def _after(visitor: Visitor, options: dict[str, Any], *steps: list[Any]) -> dict[str, Any]:
    """Return the state of a new playhead after these calls."""
    if not visitor.page.url.startswith(visitor.url):
        visitor.open("/problems")
    state: dict[str, Any] = visitor.page.evaluate(_RUN, [options, list(steps)])
    return state


def test_a_playhead_follows_live_data_until_somebody_seeks(visitor: Visitor) -> None:
    live = {"duration": 100, "live": True}

    following = _after(visitor, live, ["available", 10], ["available", 20])
    sought = _after(visitor, live, ["available", 10], ["seek", 4], ["available", 20])
    back = _after(visitor, live, ["available", 10], ["seek", 4], ["follow"], ["available", 20])

    assert (following["t"], following["following"]) == (20, True)
    assert (sought["t"], sought["following"]) == (4, False)
    assert (back["t"], back["following"]) == (20, True)


def test_behind_live_data_it_waits_for_more_and_at_the_end_of_a_replay_it_stops(
    visitor: Visitor,
) -> None:
    steps: list[list[Any]] = [["available", 10], ["seek", 9], ["setSpeed", 5], ["play"]]

    waits = _after(visitor, {"duration": 100, "live": True}, *steps, ["advance", 1])
    goes_on = _after(
        visitor, {"duration": 100, "live": True}, *steps, ["advance", 1], ["available", 30],
        ["advance", 1],
    )  # fmt: skip
    stops = _after(visitor, {"duration": 100}, *steps, ["advance", 1])
    again = _after(visitor, {"duration": 100}, *steps, ["advance", 1], ["play"])
    loops = _after(visitor, {"duration": 100, "loop": True}, *steps, ["advance", 1])

    assert (waits["t"], waits["playing"]) == (10, True)
    assert (goes_on["t"], goes_on["playing"]) == (15, True)
    assert (stops["t"], stops["playing"]) == (10, False)
    assert (again["t"], again["playing"]) == (0, True)
    assert (loops["t"], loops["playing"]) == (0, True)


def test_it_cannot_be_moved_beyond_the_data(visitor: Visitor) -> None:
    options = {"duration": 100}

    assert _after(visitor, options, ["available", 10], ["seek", 50])["t"] == 10
    assert _after(visitor, options, ["available", 10], ["seek", -3])["t"] == 0


@pytest.mark.parametrize(
    "state",
    [{}, {"t": None, "speed": "fast", "trial": -1}, {"t": "x", "trial": 1.5, "speed": 3}],
)
def test_a_state_that_is_damaged_resumes_at_the_start(
    visitor: Visitor, state: dict[str, Any]
) -> None:
    found = _after(visitor, {"duration": 100}, ["restore", state])

    assert (found["t"], found["trial"], found["speed"]) == (0, 0, 1)


def test_a_resumed_time_is_kept_until_it_is_known_how_far_the_data_reach(visitor: Visitor) -> None:
    restored = ["restore", {"t": 40, "speed": 20, "trial": 2}]

    before = _after(visitor, {"duration": 100}, restored)
    less = _after(visitor, {"duration": 100}, restored, ["reaches", 30])
    more = _after(visitor, {"duration": 100}, restored, ["reaches", 90])

    assert (before["t"], before["trial"], before["speed"]) == (40, 2, 20)
    assert (less["t"], more["t"], more["newest"]) == (30, 40, 90)
