"""The page of a leaderboard: rows with details, filters, marks, plots."""

import re
from html import unescape
from urllib.parse import quote

import pytest
from sqlalchemy import update

from seamark.programs.failure_reasons import FailureReason
from seamark.server.accounts.accounts import RESERVED_PREFIX
from seamark.server.database.tables import User
from seamark.server.pages.charts.plots import Axis
from seamark.server.runs.leaderboard import best_runs, leaderboard
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import baselines
from seamark.sim.benchmarks import reference_results
from seamark.sim.registry import benchmark
from tests.cast import Backend
from tests.server.pages.conftest import Site

PAGE = "/leaderboards/currents-v1"
SHIPPED = "Results without a link come with Seamark: this service has no run of them."
PENDING = "It is computing its own."
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


def test_shipped_reference_entries_are_shown_until_the_service_has_its_own(site: Site) -> None:
    browser = site.browser()
    pages = ("/leaderboards/currents-v2", "/benchmarks/currents-v2")
    shipped = reference_results.of_benchmark(benchmark("currents-v2"))

    before = [browser.get(page).text for page in pages]
    listed = browser.get(f"/api/v1{pages[0]}").get_json()
    with site.database.writing() as session:
        name = f"{RESERVED_PREFIX}-p"
        change = update(User).where(User.id == site.user_id("eva"))
        session.execute(change.values(is_baseline=True, name=name, name_key=name))
    own = site.succeeded("eva", kind="ranked", benchmark="currents-v2", title="P of this service")
    after = [browser.get(page).text for page in pages]
    found = browser.get(f"/api/v1{pages[0]}?program=uploaded").get_json()

    assert [page.count('<li class="mark"><span>') for page in before] == [len(shipped)] * 2
    assert listed["ranks"] == []
    assert [entry["run"] for entry in listed["reference_entries"]] == [None] * len(shipped)
    assert sorted(entry["score"] for entry in listed["reference_entries"]) == sorted(
        result.score for result in shipped.values()
    )
    for page in after:
        assert page.count('<li class="mark"><span>') == len(shipped) - 1
        assert f'<a href="/runs/{own}"><bdi>P of this service</bdi>' in page
    assert [one["run"] for one in found["reference_entries"] if one["run"]] == [own]
    assert len(found["reference_entries"]) == len(shipped)


@pytest.mark.slow
def test_reference_entries_are_being_computed_only_as_long_as_their_runs_are_live(
    site: Site,
) -> None:
    addresses = ("/leaderboards/currents-v2", "/benchmarks/currents-v2")
    browser = site.browser()

    def shown() -> list[tuple[bool, bool]]:
        found = [browser.get(address).text for address in addresses]
        return [(SHIPPED in page, PENDING in page) for page in found]

    before = shown()
    with site.database.writing() as session:
        submitted = baselines.ensure(session, site.settings)
    waiting = shown()
    for run_id in submitted:
        assert site.cancel(run_id)
    after = shown()

    assert before == after == [(True, False)] * 2
    assert waiting == [(True, True)] * 2


@pytest.mark.slow
def test_a_learned_reference_entry_says_how_it_was_trained_before_and_after_its_run(
    site: Site,
) -> None:
    browser, entry = site.browser(), benchmark("recover-v1").baselines["imitation"]
    addresses = ["/leaderboards/recover-v1", "/benchmarks/recover-v1"]

    def shown() -> list[bool]:
        return [entry.notes in unescape(browser.get(address).text) for address in addresses]

    before = shown()
    with site.database.writing() as session:
        baselines.ensure(session, site.settings)
    claim = site.claim_alone("recover-v1", entry.built_in)
    assert site.finish(claim)
    addresses.append(f"/runs/{claim.run_id}")

    assert entry.notes
    assert (before, shown()) == ([True] * 2, [True] * 3)


def test_shipped_reference_entries_are_marks_of_the_plot_of_error_against_energy(
    site: Site,
) -> None:
    page = site.browser().get("/leaderboards/currents-v2").text

    plotted = re.findall(r'<circle class="mark[^>]*><title>([^<]*)</title>', page)
    shipped = reference_results.of_benchmark(benchmark("currents-v2"))
    titles = [benchmark("currents-v2").baselines[name].title for name in shipped]
    assert sorted(map(unescape, plotted)) == sorted(titles)


@pytest.mark.slow
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


@pytest.mark.slow
def test_filters_appear_only_when_there_is_something_to_filter(site: Site) -> None:
    def offered(query: str = "") -> list[str]:
        form = site.browser().get(PAGE + query).text.partition('<form class="board-filters"')[2]
        return re.findall(r'<select name="(\w+)"', form.partition("</form>")[0])

    site.published("root", kind="ranked")
    alone = offered()
    _board(site)

    assert alone == []
    assert offered() == ["program", "baselines", "sort"]
    assert offered("?language=c") == ["program", "language", "baselines", "sort"]


def _two_methods(site: Site) -> None:
    for who, title in (("ann", "Observer"), ("ann", "Sliding mode"), ("ben", "Observer")):
        site.published(who, kind="ranked", title=title)


def test_a_page_with_one_row_per_method_names_each_of_them_and_ranks_it_among_methods(
    site: Site,
) -> None:
    _two_methods(site)
    browser = site.browser("ann")

    people, methods = (browser.get(f"{PAGE}{query}").text for query in ("", "?per=method"))

    assert (_users(people), _users(methods)) == (["ann", "ben"], ["ann", "ann", "ben"])
    assert re.findall(r"<bdi>(Observer|Sliding mode)</bdi></a>", methods) == [
        *("Observer", "Sliding mode", "Observer")
    ]
    assert "ranked <strong>1st of 2</strong>" in re.sub(r"\s+", " ", people)
    assert "ranked <strong>1st of 3 methods</strong>" in re.sub(r"\s+", " ", methods)
    assert '<option value="method" selected>' in methods
    assert "Each user appears once" in people
    assert "Each method of a user appears once" in methods
    assert f'{API}?format=csv&amp;per=method"' in methods


def test_rows_per_method_are_offered_once_somebody_has_two(site: Site) -> None:
    site.published("ann", kind="ranked", title="Observer")
    offered = [site.browser().get(f"{PAGE}{query}").text for query in ("", "?per=person")]
    site.published("ann", kind="ranked", title="Sliding mode")

    offered.append(site.browser().get(PAGE).text)

    assert ['name="per"' in page for page in offered] == [False, True, True]


def test_the_api_and_its_csv_have_a_row_per_method(site: Site) -> None:
    _two_methods(site)
    browser = site.browser("ann")

    first = browser.get(f"{API}?per=method&limit=2").get_json()
    rest = browser.get(f"{API}?per=method&limit=2&after={quote(first['next'])}").get_json()
    mine = browser.get(f"{API}?per=method&mine=1").get_json()
    csv = browser.get(f"{API}?per=method&format=csv").text
    people = browser.get(f"{API}?per=person").get_json()

    rows = [(row["rank"], row["user"], row["method"]) for row in first["ranks"] + rest["ranks"]]
    assert rows == [(1, "ann", "Observer"), (2, "ann", "Sliding mode"), (3, "ben", "Observer")]
    assert rest["next"] is None
    assert [row["rank"] for row in mine["ranks"]] == [1, 2]
    assert len(csv.splitlines()) == 1 + 3
    assert people == browser.get(API).get_json()
    assert len(people["ranks"]) == 2
    assert browser.get(f"{API}?per=team").status_code == 422


def test_trackers_vehicles_and_built_in_solutions_are_called_by_their_names(site: Site) -> None:
    site.published("ann", kind="ranked", config={"tracker": "esm"})

    page = site.browser().get(PAGE).text

    cells = re.findall(r'data-label="(Tracker|Vehicle)">([^<]*)<', page)
    assert cells == [("Vehicle", "Girona 500"), ("Tracker", "Template tracker")]
    assert "vehicle: Girona 500, tracker: Template tracker." in page
    assert "<bdi>PI</bdi>" in page


def test_the_table_comes_before_everything_that_explains_it(site: Site) -> None:
    _board(site)

    page = site.browser().get(PAGE).text

    parts = ("<table", 'id="scale-title"', "How ranking works")
    assert sorted(parts, key=page.index) == list(parts)


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
        assert publications.publish(session, claim.run_id, Terms(method="Steady hand"))
        assert leaderboard.page(session, "currents-v1") == []
        assert best_runs.rebuild(session) == 0


def test_ticks_are_round_numbers_on_the_axis() -> None:
    assert Axis(0.17, 0.62).ticks() == pytest.approx([0.2, 0.3, 0.4, 0.5, 0.6])
    assert Axis(1.0, 500.0, logarithmic=True).ticks() == [1.0, 10.0, 100.0]
    assert Axis.over([3.0]).ticks() == [2.0, 3.0, 4.0]
    assert Axis.over([0.0, 1.0], logarithmic=True).logarithmic is False
    assert [Axis(0.0, 1.0).at(value) for value in (-5.0, 0.5, 9.0)] == [2.0, 50.0, 98.0]
