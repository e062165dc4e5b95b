"""The page of a leaderboard: rows with details, filters, marks, plots."""

import re
from html import unescape

import pytest
from sqlalchemy import update

from seamark.server.database.tables import User
from seamark.server.pages.plots import Axis
from seamark.server.runs import leaderboard, results
from seamark.server.runs.failure_reasons import FailureReason
from seamark.server.runs.states import RunState
from tests.cast import Backend
from tests.server.pages.conftest import Site

PAGE = "/leaderboards/currents-v1"
API = f"/api/v1{PAGE}"


def _board(site: Site) -> None:
    """Two people and a baseline."""
    site.published("ann", kind="ranked", title="Observer", notes="Feeds the <current> forward.")
    claim = site.running("ben", kind="ranked", controller="upload", program=site.store_program())
    levels = [{"rmse_m": 0.5, "energy_n15_s": 100.0}]
    assert site.finish(claim, metrics={"score": 40.0, "levels": levels})
    site.publish(claim.run_id)
    with site.database.writing() as session:
        eva = User.id == site.user_id("eva")
        session.execute(update(User).where(eva).values(is_baseline=True))
    site.succeeded("eva", kind="ranked", title="Reference")


def _users(page: str) -> list[str]:
    return re.findall(r'aria-label="Compare run \d+ of (\w+)"', page)


def test_a_row_says_what_it_is_and_how_it_was_made(site: Site) -> None:
    _board(site)
    page = unescape(site.browser("ann").get(PAGE).text)

    assert "Observer" in page
    assert "Feeds the <current> forward." in page
    assert "ranked <strong>1st of 2</strong>" in page
    assert "How ranking works" in page
    assert 'href="/users/ben">ben</a>' in page
    assert "Python" in page
    assert page.count('<line class="mark"') == 2 * 1 + 1  # in each row: the baseline


def test_filters_of_page_and_api_agree(site: Site) -> None:
    _board(site)
    browser = site.browser("ann")
    expected = {
        "program=uploaded": ["ben"],
        "language=python": ["ben"],
        "baselines=only": ["eva"],
        "baselines=hide": ["ann", "ben"],
        "mine=1": ["ann"],
        "sort=energy_n15_s": ["ben"],
        "vehicle=bluerov2-heavy": [],
    }

    for query, users in expected.items():
        found = browser.get(f"{API}?{query}").get_json()
        assert sorted(_users(browser.get(f"{PAGE}?{query}").text)) == users, query
        assert sorted(row["user"] for row in found["ranks"]) == users, query
    assert browser.get(f"{API}?sort=nothing").status_code == 422
    assert site.browser().get(f"{API}?mine=1").status_code == 401


def test_the_csv_has_the_filtered_rows_with_all_metrics(site: Site) -> None:
    _board(site)
    heads, *rows = site.browser().get(f"{API}?format=csv&program=uploaded").text.splitlines()
    found = dict(zip(heads.split(","), rows[0].split(","), strict=True))

    assert len(rows) == 1
    assert (found["user"], found["language"], found["energy_n15_s"]) == ("ben", "python", "100.0")


@pytest.mark.parametrize("cause", FailureReason)
def test_a_run_that_failed_for_any_reason_never_ranks(
    backend: Backend, cause: FailureReason
) -> None:
    claim = backend.running("ann", kind="ranked")
    metrics = {"score": 99.0, "rankable": True}
    assert backend.finish(claim, state=RunState.FAILED, cause=cause, metrics=metrics)
    with backend.database.writing() as session:
        assert results.publish(session, claim.run_id)
        assert leaderboard.page(session, "currents-v1") == []
        assert leaderboard.rebuild(session) == 0


def test_ticks_are_round_numbers_on_the_axis() -> None:
    assert Axis(0.17, 0.62).ticks() == pytest.approx([0.2, 0.3, 0.4, 0.5, 0.6])
    assert Axis(1.0, 500.0, logarithmic=True).ticks() == [1.0, 10.0, 100.0]
    assert Axis.over([3.0]).ticks() == [2.0, 3.0, 4.0]
    assert Axis.over([0.0, 1.0], logarithmic=True).logarithmic is False
    assert [Axis(0.0, 1.0).at(value) for value in (-5.0, 0.5, 9.0)] == [2.0, 50.0, 98.0]
