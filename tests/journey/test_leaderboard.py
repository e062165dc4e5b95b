"""The first screen of a leaderboard, and its plot as the browser draws it."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, ViewportSize
from sqlalchemy import update

from seamark.server.database.tables import Best
from seamark.sim import registry
from tests.cast import Backend
from tests.services.pages import served

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

NAME = registry.DEFAULT_BENCHMARK
SCREENS = ((1280, 900, 330), (375, 800, 400))  # [px]: size, and how far down the table has begun
OVERLAPS = """() => {
  const of = (css) => [...document.querySelectorAll(css)].map((one) => one.getBoundingClientRect());
  const labels = of(".plot-area text"), dots = of(".plot-area circle");
  const meet = (a, b) =>
    a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  const after = (at) => [...labels.slice(at + 1), ...dots];
  const pairs = labels.flatMap((one, at) => after(at).filter((other) => meet(one, other)));
  return [labels.length, pairs.length];
}"""


@pytest.fixture
def address(backend: Backend) -> Iterator[str]:
    """The address of a service with the cast and without a worker."""
    with served(backend, threaded=True) as found:
        yield found


def _entries(backend: Backend, count: int) -> None:
    """Publish entries that nobody beats in both error and power, close to each other."""
    for number in range(count):
        who = f"laboratory-{number}"
        backend.sign_up(who)
        run_id = backend.published(who, kind="ranked", benchmark=NAME)
        shown = {"tool_rmse_m": 0.2 - 0.02 * number, "power_share": 0.05 + 0.004 * number}
        with backend.database.writing() as session:
            session.execute(update(Best).where(Best.run_id == run_id).values(metrics=shown))


def test_the_table_begins_on_the_first_screen_and_labels_of_the_plot_do_not_overlap(
    backend: Backend, address: str, chromium: Browser
) -> None:
    _entries(backend, 6)

    for width, height, limit in SCREENS:
        size: ViewportSize = {"width": width, "height": height}
        page = chromium.new_page(viewport=size, reduced_motion="reduce")
        page.goto(f"{address}/leaderboards/{NAME}", wait_until="load")
        table = page.locator("table.board").bounding_box()
        labels, overlaps = page.evaluate(OVERLAPS)
        wide = page.evaluate("document.documentElement.scrollWidth")
        page.close()
        assert table is not None
        assert table["y"] < limit
        assert (labels, overlaps, wide) == (6, 0, width)
