"""The first controller: five lines that run, and the way through signing up and back."""

import html
import re

import pytest

from seamark.server.pages.submission import first_program
from seamark.server.runs.showing import recorded_demo
from seamark.sim import registry
from tests.server.pages.conftest import WORDS, Site

_HIDDEN = re.compile(r'<input type="hidden" name="([^"]+)" value="([^"]*)">')


def _form(page: str) -> dict[str, str]:
    form = page[page.index('id="run-form"') :]
    return {name: html.unescape(value) for name, value in _HIDDEN.findall(form)}


def test_the_home_page_leads_to_an_editor_with_five_lines_and_the_guide(site: Site) -> None:
    stranger = site.browser()
    assert 'href="/first-controller"' in stranger.get("/").text

    page = stranger.get("/first-controller").text

    assert len(first_program.TEXT.splitlines()) == 5
    assert html.escape(first_program.TEXT, quote=False) in page
    assert "How it works" in page
    assert 'href="/sign-up?next=/first-controller"' in page


@pytest.mark.slow
def test_the_five_lines_are_queued_with_the_settings_of_the_demo(site: Site) -> None:
    browser = site.browser("ann")
    sent = _form(browser.get("/first-controller").text) | {"program_text": first_program.TEXT}

    started = browser.post(f"/submit/{recorded_demo.BENCHMARK}", sent)

    assert started.status_code == 303, started.text
    run = site.show(int(started.location.rpartition("/")[2]))
    expected = registry.benchmark(run.benchmark).read(recorded_demo.SETTINGS).model_dump()
    assert {name: run.config[name] for name in recorded_demo.SETTINGS} == {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in expected.items()
        if name in recorded_demo.SETTINGS
    }
    assert (run.seed, run.controller, run.program_name) == (7, "upload", "controller.py")


def test_signing_up_leads_back_to_the_first_controller(site: Site) -> None:
    browser = site.browser()
    page = browser.get("/sign-up?next=/first-controller").text
    refused = browser.post("/sign-up", {"name": "", "password": "", "next": "/first-controller"})
    account = {"name": "new-here", "password": WORDS, "next": "/first-controller"}

    done = browser.post("/sign-up", account)

    assert 'name="next" value="/first-controller"' in page
    assert 'name="next" value="/first-controller"' in refused.text
    assert done.location == "/first-controller"
    assert "Run it</button>" in browser.get(done.location).text


@pytest.mark.parametrize(
    "address",
    [
        "https://evil.example/",
        "//evil.example",
        "/\\evil.example",
        "\\\\evil.example",
        "/\t/evil.example",
        "javascript:alert(1)",
    ],
)
def test_signing_up_leads_to_no_other_site(site: Site, address: str) -> None:
    account = {"name": "new-here", "password": WORDS, "next": address}

    done = site.browser().post("/sign-up", account)

    assert done.location == "/"
