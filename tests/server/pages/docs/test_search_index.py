"""Finding a section of the documentation by its words, and code that can be copied."""

import re
from html import unescape

import pytest

from seamark.server.pages.docs.articles import article, code_block, sections_of
from seamark.server.pages.docs.search_index import RESULTS_MAX, SearchIndex
from tests.server.pages.conftest import Site

FOUND = re.compile(r'<ol class="docs-results">(.*?)</ol>', re.DOTALL)
LINK = re.compile(r'<a href="([^"]+)"')
TAGS = re.compile(r"<[^>]+>")
ANSWERS = {  # question of a newcomer -> section that answers it
    "how is the score computed": "/docs/metrics#how-the-score-is-computed",
    "quota": "/docs/runs#quotas",
    "how many runs can I start": "/docs/runs#quotas",
    "How do I install it?": "/docs/install",
    "what does step return": "/docs/controller#methods",
    "why did my run fail?": "/docs/runs#why-runs-fail",
    "which packages can I import": "/docs/box",
    "write a controller in C++": "/docs/languages#c-and-c",
    "can I use MATLAB": "/docs/languages#matlab",
    "who can see my run": "/docs/runs#privacy",
    "how do I cite a run": "/docs/guides/publishing.md#cite-a-run-and-archive-it",
    "what are the columns of the telemetry": "/docs/telemetry",
    "what is a ranked run": "/docs/start#practice-and-ranked-runs",
    "how do students join a class": "/docs/guides/classes.md#creating-a-class",
    "how much memory does my program get": "/docs/controller#limits",
    "keyboard shortcuts": "/docs/runs#keyboard-shortcuts",
    "reinforcement learning": "/docs/guides/training.md",
    "ROS": "/docs/guides/bridges.md#ros-programs-rosbridge",
    "how long does a run wait in the queue": "/docs/runs#the-queue",
    "delete my data": "/docs/runs#delete-the-data-of-a-run",
    "compare two runs": "/docs/runs#comparing-runs",
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("query", "address"),
    [
        ("workers alternate", "/docs/runs#the-queue"),
        ("embedded coder", "/docs/languages#embedded-coder"),
        ("confidence interval rank", "/docs/guides/ranking.md"),
        ("tele", "/docs/telemetry"),
    ],
)
def test_a_search_finds_the_section_of_its_words(site: Site, query: str, address: str) -> None:
    page = site.browser().get("/docs/search", query_string={"q": query})

    assert page.status_code == 200
    found = FOUND.search(page.text)
    assert found is not None
    assert f'href="{address}' in found.group(1)


def test_the_section_that_answers_a_question_of_a_newcomer_comes_first(site: Site) -> None:
    browser = site.browser()
    pages = {q: browser.get("/docs/search", query_string={"q": q}).text for q in ANSWERS}
    found = {question: FOUND.search(page) for question, page in pages.items()}

    first = {question: one and LINK.findall(one[1])[0] for question, one in found.items()}

    assert first == ANSWERS


@pytest.mark.parametrize("query", ["", " ", '"', "NEAR(", "a OR b*", "<b>", "x" * 5000])
def test_any_text_is_a_query(site: Site, query: str) -> None:
    page = site.browser().get("/docs/search", query_string={"q": query})

    assert page.status_code == 200
    assert "<b>" not in page.text


def test_sections_with_all_words_come_first_and_words_may_be_incomplete() -> None:
    html = article("<p>Alpha current</p><h2>The <em>end</em></h2><p>beta &lt;i&gt; currents</p>")
    index = SearchIndex([("/page", "Page", sections_of(html))])

    assert [one.address for one in index.find("alpha")] == ["/page"]
    assert [one.address for one in index.find("the curr beta")] == ["/page#the-end", "/page"]
    assert index.find("gamma") == []
    (found,) = index.find("beta")
    assert found.excerpt == "<mark>beta</mark> &lt;i&gt; currents"


def test_a_search_shows_no_more_than_its_limit() -> None:
    html = article("".join(f"<h2>Part {number}</h2><p>word</p>" for number in range(50)))

    assert len(SearchIndex([("/page", "Page", sections_of(html))]).find("word")) == RESULTS_MAX


def test_code_is_coloured_without_a_change_of_its_text() -> None:
    text = "def f(x):\n    return x < 1 and '<b>'  # &amp;\n"

    shown = code_block(text, "python")

    assert 'class="k"' in shown
    assert "style=" not in shown
    code = shown.partition("<code>")[2].partition("</code>")[0]
    assert unescape(TAGS.sub("", code)) == text.rstrip("\n")


@pytest.mark.parametrize(
    "name", ["native", "measures", "guides/languages.md", "guides/measures.md"]
)
def test_an_address_of_an_earlier_version_leads_to_the_page_of_its_subject(
    site: Site, name: str
) -> None:
    browser = site.browser()

    moved = browser.get(f"/docs/{name}")

    assert moved.status_code == 301
    assert browser.get(moved.location).status_code == 200
