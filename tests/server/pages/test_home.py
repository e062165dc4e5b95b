"""The home page: a demo in one click, and reference entries before anything was computed."""

import re

from seamark.server import workers
from seamark.server.database.tables import Worker
from seamark.server.runs import baselines
from tests.server.pages.conftest import Site

FACT = re.compile(r"<dt>Queued or running</dt><dd>(\d+)</dd>")


def _start_worker(site: Site, slots: int = 1) -> None:
    with site.database.writing() as session:
        workers.register(
            session, Worker(name="w", slots=slots, level="full", languages=["python"], findings=[])
        )


def test_reference_results_are_there_before_anything_was_computed(site: Site) -> None:
    with site.database.writing() as session:
        submitted = baselines.ensure(session, site.settings)
    assert submitted

    page = site.browser().get("/").text

    assert ">reference</small>" in page
    waiting = FACT.search(page)
    assert waiting is not None
    assert waiting.group(1) == "0"


def test_the_demo_starts_a_run_of_a_visitor_without_an_account(site: Site) -> None:
    _start_worker(site)
    browser = site.browser()

    started = browser.post("/demo")

    assert started.status_code == 303
    assert "/runs/" in started.location
    shown = browser.get(started.location)
    assert shown.status_code == 200
    assert "Demo" in shown.text
    assert site.browser().get(started.location).status_code == 404  # it is the visitor's own


def test_the_demo_is_queued_if_there_is_nothing_to_replay(site: Site) -> None:
    started = site.browser().post("/demo")

    assert started.status_code == 303
    assert "/runs/" in started.location


def test_a_demo_beyond_the_quota_says_so(site: Site) -> None:
    _start_worker(site, slots=99)
    browser = site.browser()
    for _ in range(site.settings.quota_live):
        assert "/runs/" in browser.post("/demo").location

    refused = browser.post("/demo", follow_redirects=True)

    assert refused.request.path == "/"
    assert "notice warn" in refused.text
