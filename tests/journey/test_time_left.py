"""The estimate of the time that a run still takes, as its page computes it."""

from itertools import pairwise

import pytest

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def test_the_time_left_counts_down_and_is_written_without_sixty_seconds(visitor: Visitor) -> None:
    visitor.open("/")

    found = visitor.page.evaluate("""async () => {
      const { about, duration, Estimate } = await import("/static/js/run/estimate.js");
      const estimate = new Estimate(100);
      const left = [];
      // Twice as slow as expected at first, then in one leap to where it should be.
      for (let t = 0; t <= 60; t += 1) left.push(estimate.update(t < 30 ? t / 200 : t / 100, t));
      return { texts: [599.7, 59.7, 3599.9].map(duration), about: about(61), left };
    }""")

    left = found["left"]
    steps = [after - before for before, after in pairwise(left)]
    assert found["texts"] == ["10 min", "1 min", "1 h"]
    assert found["about"] == "1 min"
    assert max(abs(step) for step in steps) < 6
    assert visitor.errors == []
