"""The pages of docs/ on the site: all are there, nothing in them leads nowhere."""

import io
import re
from pathlib import Path
from urllib.parse import urljoin

import pytest
from PIL import Image

from performance.figures.compared import OPTIONS
from performance.figures.tutorial import SEED
from seamark import server
from seamark.server.pages.docs import guides
from seamark.server.pages.docs.navigation import MERGED
from seamark.sim.registry import BENCHMARKS, TRACKERS, benchmark
from seamark.sim.settings.tracker import TrackerSettings
from seamark.sim.trackers.options import CRITERIA, METHODS, WARPS
from tests.server.pages.conftest import Site

DOCS = Path(server.__file__).resolve().parents[1] / "docs"
NAMES = sorted(path.name for path in DOCS.glob("*.md"))
LINK = re.compile(r'(?:href|src)="([^"]+)"')


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_guide_is_listed_and_its_links_work(site: Site, name: str) -> None:
    browser = site.browser()
    address = f"/docs/guides/{name}" if name not in MERGED else f"/docs/{MERGED[name]}"
    assert f'href="{address}"' in browser.get("/docs/start").text

    shown = browser.get(address)

    assert shown.status_code == 200
    assert shown.text.count("<h1") == 1
    assert "style=" not in shown.text  # the site's policy takes none
    inside = shown.text.partition("<article")[2].partition("</article>")[0]
    all_links = LINK.findall(inside)
    assert all_links or "](" not in (DOCS / name).read_text(encoding="utf-8")
    links = [link for link in all_links if "://" not in link]
    assert [one for one in links if one[0] == "#" and f'id="{one[1:]}"' not in inside] == []
    targets = {link for link in links if link[0] != "#"}
    assert {
        one for one in targets if browser.get(urljoin(address, one)).status_code not in {200, 301}
    } == set()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nothing.md", "../README.md", "figures", "figures/nothing.png"])
def test_a_path_that_is_no_guide_is_not_found(site: Site, name: str) -> None:
    assert site.browser().get(f"/docs/guides/{name}").status_code == 404


def test_no_comment_of_a_page_is_shown() -> None:
    with_comments = [name for name in NAMES if "<!--" in (DOCS / name).read_text(encoding="utf-8")]

    assert [name for name in with_comments if "&lt;!--" in guides.html(name)] == []
    assert [n for n in BENCHMARKS if "&lt;!--" in guides.section("benchmarks.md", n)[0]] == []


def test_raw_html_in_a_guide_is_escaped() -> None:
    assert guides._markdown().render("<b>bold</b>") == "<p>&lt;b&gt;bold&lt;/b&gt;</p>\n"


@pytest.mark.parametrize("name", sorted(TrackerSettings.model_fields))
def test_the_page_of_trackers_names_every_setting_of_the_tracker(name: str) -> None:
    assert f"`{name}`" in (DOCS / "trackers.md").read_text(encoding="utf-8")
    assert name in benchmark("visibility-v1").schema()["properties"]


@pytest.mark.parametrize("choice", [*TRACKERS, *WARPS, *CRITERIA, *METHODS])
def test_the_page_of_trackers_names_every_choice(choice: str) -> None:
    assert f"`{choice}`" in (DOCS / "trackers.md").read_text(encoding="utf-8")


def test_figures_of_trackers_are_small() -> None:
    sizes = [path.stat().st_size for path in (DOCS / "figures").glob("trackers-*.png")]

    assert 0 < max(sizes) < 200_000


def test_the_page_of_a_comparison_shows_a_moving_picture_from_the_shipped_pages(site: Site) -> None:
    browser = site.browser()
    page = browser.get("/docs/guides/compare.md").text

    found = re.findall(r'(?:src|srcset)="(/docs/guides/figures/[^"]+\.webp)"', page)
    pictures = {address: browser.get(address) for address in found}

    assert {answer.content_type for answer in pictures.values()} == {"image/webp"}
    moving = Image.open(io.BytesIO(pictures["/docs/guides/figures/compare-observer.webp"].data))
    assert getattr(moving, "n_frames", 1) >= 20
    still = '<source media="(prefers-reduced-motion: reduce)" srcset="/docs/guides/figures/'
    assert f'{still}compare-observer-still.webp">' in page


def test_a_reader_makes_the_comparison_with_the_settings_of_its_pictures() -> None:
    page = (DOCS / "compare.md").read_text(encoding="utf-8")
    assert page.count(f"{OPTIONS} --seed {SEED}") == 3
