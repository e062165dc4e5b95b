"""The resolution of the scene: as many pixels as the machine has time for."""

from typing import Any

import pytest

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

# Draws on a machine that takes `cost` [ms] for a picture with all pixels, on a screen of 60 Hz.
_DRAW = """async ([scale, cost, seconds]) => {
  const { Pace } = await import("/static/js/player/scene/pace.js");
  const pace = new Pace(scale);
  const changes = [];
  let now = 0;
  while (now < 1000 * seconds) {
    now += Math.max(1000 / 60, cost * pace.scale ** 2);
    if (pace.drawn(now, true)) changes.push([now / 1000, pace.scale]);
  }
  return { scale: pace.scale, changes, interval: Math.max(1000 / 60, cost * pace.scale ** 2) };
}"""


def _drawn(visitor: Visitor, *, scale: float, cost: float, seconds: float) -> dict[str, Any]:
    if not visitor.page.url.startswith(visitor.url):
        visitor.open("/problems")
    found: dict[str, Any] = visitor.page.evaluate(_DRAW, [scale, cost, seconds])
    return found


@pytest.mark.parametrize("cost", [1, 12, 20])
def test_a_scene_has_all_pixels_after_four_seconds_if_there_is_time(
    visitor: Visitor, cost: float
) -> None:
    assert _drawn(visitor, scale=0.5, cost=cost, seconds=4)["scale"] == 1


@pytest.mark.parametrize("cost", [30, 60, 120, 240])
@pytest.mark.parametrize("scale", [0.5, 1])
def test_the_resolution_settles_where_twenty_pictures_a_second_are_drawn(
    visitor: Visitor, cost: float, scale: float
) -> None:
    drawn = _drawn(visitor, scale=scale, cost=cost, seconds=60)

    assert drawn["interval"] < 50
    assert [at for at, _ in drawn["changes"] if at > 5] == []
