"""Buttons with a question ask on a page of their own where no script has asked."""

import re
from html import unescape
from pathlib import Path

import pytest

from seamark import templates
from tests.server.pages.conftest import Browser, Site

DELETE = "Delete the selected runs?"


def _hidden(page: str) -> list[tuple[str, str]]:
    fields = re.findall(r'<input type="hidden" name="([^"]+)" value="([^"]*)">', page)
    return [(name, unescape(value)) for name, value in fields]


def _asked(browser: Browser, path: str, button: str) -> tuple[str, str]:
    """Press a button without a script; return the question and the page that asks."""
    page = browser.get(path).text
    pressed = re.search(rf'name="question" value="([^"]*)"[^>]*>(?:(?!</button>).)*{button}', page)
    assert pressed is not None
    return unescape(pressed[1]), page


@pytest.mark.slow
def test_nothing_changes_before_the_question_was_answered(site: Site) -> None:
    run_id, ann = site.queue("ann"), site.browser("ann")
    question, _ = _asked(ann, f"/runs/{run_id}", "Cancel")

    asked = ann.post(f"/runs/{run_id}/cancel", {"question": question})
    before = site.show(run_id).state.value
    ann.post(f"/runs/{run_id}/cancel", dict(_hidden(asked.text)))

    assert (asked.status_code, question in unescape(asked.text)) == (200, True)
    assert (before, site.show(run_id).state.value) == ("queued", "cancelled")


def test_the_answer_sends_all_that_the_form_had(site: Site) -> None:
    runs = [str(site.queue("ann")) for _ in range(3)]
    ann = site.browser("ann")

    asked = ann.post(
        "/runs/selected?do=cancel", {"question": DELETE, "runs": runs[:2], "x": '"><b>'}
    )
    sent = [field for field in _hidden(asked.text) if field[0] != "csrf_token"]
    ann.post(
        "/runs/selected?do=cancel", {"runs": [value for name, value in sent if name == "runs"]}
    )

    assert sent == [("runs", runs[0]), ("runs", runs[1]), ("x", '"><b>')]
    assert 'action="/runs/selected?do=cancel"' in asked.text
    states = [site.show(int(run_id)).state.value for run_id in runs]
    assert states == ["cancelled", "cancelled", "queued"]


@pytest.mark.parametrize(
    ("referrer", "back"),
    [
        ("http://localhost/runs?state=queued", "http://localhost/runs?state=queued"),
        ("https://elsewhere.example/", "/"),
        ("http://localhost.example/", "/"),
        ("javascript:alert(1)", "/"),
    ],
)
def test_the_way_back_stays_on_the_site(site: Site, referrer: str, back: str) -> None:
    asked = site.browser("ann").post(
        "/runs/selected", {"question": DELETE}, headers={"Referer": referrer}
    )

    assert f'<a class="button" href="{back}">Go back</a>' in asked.text


def test_a_question_needs_the_token_of_the_site_and_has_a_limit(site: Site) -> None:
    ann = site.browser("ann")

    forged = ann.client.post("/runs/selected", data={"question": DELETE})
    long = ann.post("/runs/selected", {"question": "x" * 501})

    assert DELETE not in forged.text
    assert (forged.status_code, long.status_code) == (403, 413)


def test_no_button_asks_by_a_script_alone() -> None:
    pages = list(Path(templates.__file__).parent.rglob("*.html"))

    assert len(pages) > 20
    assert [page.name for page in pages if "data-confirm" in page.read_text("utf-8")] == []
