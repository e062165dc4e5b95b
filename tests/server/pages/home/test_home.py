"""The home page: a recorded run in motion, and reference entries before anything was computed."""

import re

from seamark.server.runs.submission import baselines
from tests.server.pages.conftest import Site

FACT = re.compile(r"<dt>Queued or running</dt><dd>(\d+)</dd>")


def test_reference_results_are_there_before_anything_was_computed(site: Site) -> None:
    with site.database.writing() as session:
        submitted = baselines.ensure(session, site.settings)
    assert submitted

    page = site.browser().get("/").text

    assert ">reference</small>" in page
    waiting = FACT.search(page)
    assert waiting is not None
    assert waiting.group(1) == "0"


def test_something_moves_on_the_home_page_before_anything_was_computed(site: Site) -> None:
    stranger = site.browser()

    page = stranger.get("/").text

    moving = re.search(r'<img class="poster" src="([^"]+)"', page)
    assert moving is not None
    with stranger.get(moving.group(1)) as picture:
        assert picture.data.count(b"ANMF") > 10  # pictures of an animation
    assert "Recorded run" in page
    assert '"api": "/api/v1/demo"' in page
