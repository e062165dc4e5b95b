"""The list of runs as a page: its address, and what is done to several runs at once."""

import re

import pytest

from seamark.server.runs.publication import publications
from seamark.server.runs.record.states import RunState
from tests.server.pages.conftest import Browser, Site


def _numbers(page: str) -> list[int]:
    return [int(number) for number in re.findall(r'name="runs" value="(\d+)"', page)]


def _change(browser: Browser, do: str, *run_ids: int) -> str:
    form = {"do": do, "runs": [str(run_id) for run_id in run_ids]}
    return browser.post("/runs/selected?q=x", form, follow_redirects=True).text


def test_the_address_of_a_list_has_its_search_its_filters_and_its_order(site: Site) -> None:
    low, high = site.succeeded("ann", title="gain"), site.succeeded("ann", title="gain")
    site.succeeded("ann", title="other")
    browser = site.browser("ann")

    found = browser.get("/runs/?q=gain&state=succeeded&sort=oldest&program=built-in").text
    nothing = browser.get("/runs/?q=gain&program=uploaded").text

    assert _numbers(found) == [low, high]
    assert 'value="gain"' in found
    assert '<option value="oldest" selected>' in found
    assert "No run matches this search." in nothing


@pytest.mark.parametrize("query", ["sort=x&skip=-1", "skip=99999999999", "kind=x&program=y"])
def test_a_senseless_address_still_shows_the_list(site: Site, query: str) -> None:
    site.queue("ann")

    assert site.browser("ann").get(f"/runs/?{query}").status_code == 200


def test_a_row_shows_the_interval_of_the_score_and_the_curve_of_the_error(site: Site) -> None:
    claim = site.running("ann", trials=3)
    assert site.finish(claim, score=50.0, error_curve=[0.1, 0.4, None, 0.2])

    page = site.browser("ann").get("/runs/").text

    assert "45.00 to 55.00" in page
    assert page.count("<polyline") == 2
    assert "at most 0.400 m" in page


def test_several_runs_are_deleted_at_once_and_the_others_are_left_as_they_are(site: Site) -> None:
    first, second, public = site.succeeded("ann"), site.succeeded("ann"), site.published("ann")

    page = _change(site.browser("ann"), "delete", first, second, public)

    assert "2 runs were deleted." in page
    assert "1 run was left as it is. Only private runs" in page
    assert _numbers(site.browser("ann").get("/runs/").text) == [public]


def test_several_runs_are_cancelled_published_and_made_private_at_once(site: Site) -> None:
    done, waiting = site.succeeded("ann"), site.queue("ann")
    browser = site.browser("ann")

    answers = [_change(browser, do, done, waiting) for do in ("cancel", "publish", "withdraw")]

    assert [answer.count("1 run was left as it is.") for answer in answers] == [1, 1, 1]
    assert site.show(waiting).state is RunState.CANCELLED
    assert not site.show(done).public


def test_of_the_selected_runs_those_whose_method_has_a_name_are_published(site: Site) -> None:
    built_in, unnamed, named = site.succeeded("ann"), *(_of_program(site) for _ in range(2))
    site.publish(named, method="Steady hand")
    with site.database.writing() as session:
        publications.withdraw(session, named)

    page = _change(site.browser("ann"), "publish", built_in, unnamed, named)

    assert "1 run was left as it is." in page
    assert "where you name the method" in page
    assert [site.show(each).public for each in (built_in, unnamed, named)] == [True, False, True]
    assert site.show(named).method == "Steady hand"


def _of_program(site: Site) -> int:
    """Return a run of ann's own program that has succeeded and has no title."""
    run_id = site.queue_program("ann")
    assert site.finish(site.claim_next())
    return run_id


def test_nobody_changes_the_selected_runs_of_others(site: Site) -> None:
    private, public = site.succeeded("ann"), site.published("ann")

    page = _change(site.browser("ben"), "delete", private, public)
    _change(site.browser("ben"), "withdraw", private, public)

    assert "2 runs were left as they are." in page
    assert site.show(public).public
    assert site.show(private).state is RunState.SUCCEEDED


def test_selected_runs_are_compared_side_by_side(site: Site) -> None:
    ids = [site.succeeded("ann"), site.succeeded("ann")]

    answer = site.browser("ann").post("/runs/selected", {"do": "compare", "runs": ids})

    assert answer.location == f"/compare?runs={ids[0]},{ids[1]}"


def test_title_and_notes_are_changed_by_page_and_api_alike_and_escaped(site: Site) -> None:
    run_id = site.succeeded("ann", title="before")
    browser = site.browser("ann")
    headers = {"X-CSRFToken": browser.csrf_token()}

    browser.post(f"/runs/{run_id}/edit", {"title": "  <b>new</b> ", "notes": "one\r\ntwo"})
    by_page = site.show(run_id)
    etag = browser.get(f"/api/v1/runs/{run_id}").headers["ETag"]
    answer = browser.client.patch(
        f"/api/v1/runs/{run_id}", json={"notes": "three"}, headers=headers
    )
    by_api = site.show(run_id)

    assert (by_page.title, by_page.notes) == ("<b>new</b>", "one\ntwo")
    assert (answer.status_code, by_api.title, by_api.notes) == (200, "<b>new</b>", "three")
    assert browser.get(f"/api/v1/runs/{run_id}").headers["ETag"] != etag
    assert "&lt;b&gt;new&lt;/b&gt;" in browser.get(f"/runs/{run_id}").text


@pytest.mark.slow
def test_a_run_is_deleted_by_page_and_api_alike(site: Site) -> None:
    by_page, by_api, public = site.succeeded("ann"), site.succeeded("ann"), site.published("ann")
    browser = site.browser("ann")
    headers = {"X-CSRFToken": browser.csrf_token()}

    page = browser.post(f"/runs/{by_page}/delete", follow_redirects=True)
    answers = [
        browser.client.delete(f"/api/v1/runs/{run_id}", headers=headers).status_code
        for run_id in (by_api, by_api, public)
    ]

    assert f"Run {by_page} has been deleted." in page.text
    assert answers == [204, 404, 409]
    assert browser.get(f"/runs/{by_page}").status_code == 404
    assert f'action="/runs/{public}/delete"' not in browser.get(f"/runs/{public}").text
