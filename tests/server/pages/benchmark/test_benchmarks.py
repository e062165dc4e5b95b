"""The page of a benchmark: the text that explains it as a paper would, then its parameters."""

import re
from html import unescape
from urllib.parse import urljoin

import pytest

from seamark.server.pages.docs import guides
from seamark.sim import registry
from tests.server.pages.conftest import Site

LINK = re.compile(r'(?:href|src)="([^"]+)"')
SECTIONS = [
    "Question",
    "Protocol",
    "Score",
    "Statistics",
    "Reference entries",
    "Checklist",
    "Known limits",
    "History",
]


def text_of(site: Site, name: str) -> str:
    return unescape(site.browser().get(f"/benchmarks/{name}").text)


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_a_benchmark_is_explained_by_all_sections_of_a_paper(site: Site, name: str) -> None:
    inside = text_of(site, name).partition('<article class="prose folded">')[2]
    headings = re.findall(r"<h2[^>]*>([^<]+)</h2>", inside.partition("</article>")[0])

    assert headings == SECTIONS


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_no_two_regions_of_the_page_have_the_same_name(site: Site, name: str) -> None:
    names = re.findall(r'role="region" aria-label="([^"]+)"', text_of(site, name))

    assert names
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_every_link_and_figure_of_the_explanation_is_there(site: Site, name: str) -> None:
    address = f"/benchmarks/{name}"
    page = site.browser().get(address).text
    inside = page.partition('<article class="prose folded">')[2].partition("</article>")[0]
    assert inside

    links = {urljoin(address, unescape(one)) for one in LINK.findall(inside) if "://" not in one}

    missing = [one for one in links if site.browser().get(one).status_code not in (200, 301, 302)]
    assert missing == []


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_no_two_headings_of_a_page_share_an_anchor(site: Site, name: str) -> None:
    for page in (f"/benchmarks/{name}", "/docs/guides/benchmarks.md"):
        anchors = re.findall(r' id="([^"]+)"', site.browser().get(page).text)

        assert len(anchors) == len(set(anchors)), page


@pytest.mark.slow
@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_the_contents_lead_to_the_headings(site: Site, name: str) -> None:
    page = text_of(site, name)
    contents = page.partition('aria-label="Contents"')[2].partition("</nav>")[0]

    targets = re.findall(r'href="#([^"]+)"', contents)

    assert len(targets) > len(SECTIONS)
    assert [one for one in targets if f'id="{one}"' not in page] == []


@pytest.mark.parametrize("place", ["/leaderboards/{}", "/submit/{}"])
def test_leaderboard_and_form_lead_to_the_explanation(site: Site, place: str) -> None:
    page = site.browser("ann").get(place.format("currents-v1")).text

    assert 'href="/benchmarks/currents-v1"' in page


def test_repeated_headings_get_numbered_anchors() -> None:
    html = guides._markdown().render("## Score\n\n## Score\n")

    assert re.findall(r'id="([^"]+)"', html) == ["score", "score-1"]


def test_a_benchmark_without_a_text_has_an_empty_explanation() -> None:
    assert guides.section("benchmarks.md", "not-there") == ("", {})


def test_all_benchmarks_are_listed_with_picture_question_and_leader(site: Site) -> None:
    site.published("ann", kind="ranked")
    page = unescape(site.browser().get("/benchmarks/").text)

    for name in registry.BENCHMARKS:
        assert f'href="/benchmarks/{name}"' in page
        assert registry.benchmark(name).question in page
        with site.browser().get(f"/static/benchmarks/{name}.jpg") as picture:
            assert picture.status_code == 200
    assert page.count("Leader: <strong>ann</strong>") == 1


def test_the_page_of_a_benchmark_names_its_leader_and_marks_beside(site: Site) -> None:
    assert "Nobody has published a ranked run yet." in text_of(site, "currents-v1")

    site.published("ben", kind="ranked", title="Steady hand")
    page = text_of(site, "currents-v1")

    assert "Steady hand" in page
    assert "is ranked 1st of 1" in page


@pytest.mark.parametrize("where", ["leaderboards", "submit"])
def test_the_menu_lists_each_benchmark_once_and_earlier_versions_under_their_heading(
    site: Site, where: str
) -> None:
    page = site.browser().get(f"/{where}/visibility-v1").text
    menu = page.partition('<details class="menu benchmark-menu">')[2].partition("</details>")[0]
    newest, heading, earlier = menu.partition(">Earlier versions</p>")
    link = re.compile(rf'href="/{where}/([a-z0-9-]+)"')

    assert heading
    assert sorted(link.findall(menu)) == sorted(registry.BENCHMARKS)
    versions = map(registry.newest_version, registry.BENCHMARKS)
    assert set(link.findall(newest)) == set(versions)
    assert {"currents-v1", "visibility-v1"} <= set(link.findall(earlier))


@pytest.mark.parametrize("where", ["benchmarks", "leaderboards", "submit"])
def test_an_earlier_version_names_the_current_one_and_the_current_one_does_not(
    site: Site, where: str
) -> None:
    newest = registry.newest_version("currents-v1")
    said = f'This is an earlier version: <a href="/{where}/{newest}">{newest}</a>'

    assert said in site.browser().get(f"/{where}/currents-v1").text
    assert "This is an earlier version" not in site.browser().get(f"/{where}/{newest}").text
