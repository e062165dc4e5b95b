"""The documentation of a program's limits."""

import re
from dataclasses import fields
from html import unescape

import pytest

from seamark.programs.arm_helpers import helper
from seamark.sandbox.languages import LANGUAGES, editor_starters
from seamark.sandbox.limits import MEANING, Limits
from seamark.sim.recording.telemetry import ANSWER_COLUMNS, OBJECT_COLUMNS, WORK_COLUMNS
from seamark.sim.vehicles.patterns import CLASSES
from tests.server.pages.conftest import Site

NAMES = [field.name for field in fields(Limits)]
ROW = re.compile(r'<tr><th scope="row">([^<]+)</th><td class="num">[^<]+</td><td>([^<]+)</td></tr>')


def test_every_limit_has_a_meaning() -> None:
    assert set(MEANING) == set(NAMES)


@pytest.mark.parametrize("page", ["controller", "tracker", "detector"])
def test_a_page_lists_every_limit_once_with_its_meaning(site: Site, page: str) -> None:
    rows = ROW.findall(site.browser().get(f"/docs/{page}").text)

    assert [unescape(meaning) for _, meaning in rows] == [MEANING[name] for name in NAMES]
    assert len({label for label, _ in rows}) == len(NAMES)


def test_the_page_about_detectors_has_every_label_and_the_starter(site: Site) -> None:
    page = site.browser().get("/docs/detector").text

    labels = re.findall(r'<th scope="row"><code>([a-z]+)</code></th>', page)
    assert labels == [*CLASSES]
    assert "DICT_APRILTAG_36h11" in page


def test_the_page_of_the_telemetry_has_every_column_of_arms_and_detectors(site: Site) -> None:
    page = site.browser().get("/docs/telemetry").text

    ranges = re.findall(r"<code>(\w+)(?: to (\w+))?</code>", page)
    names = [
        *(column.name for column in WORK_COLUMNS),
        *(f"object_N_{column.name}" for column in OBJECT_COLUMNS),
        *(f"answer_N_{column.name}" for column in ANSWER_COLUMNS),
    ]
    shown = [
        name
        for first, last in ranges
        if first in names
        for name in names[names.index(first) : names.index(last or first) + 1]
    ]
    assert shown == names


@pytest.mark.slow
def test_the_page_of_languages_shows_each_starter_that_moves_an_arm_and_its_kinematics(
    site: Site,
) -> None:
    page = site.browser().get("/docs/languages").text
    text = unescape(re.sub(r"<[^>]+>", "", page))
    starters = [known.text() for known in editor_starters("controller", moves_arm=True).values()]
    files = [content.decode() for name in LANGUAGES for content in helper(name).values()]

    assert len(starters) == 4
    assert len(set(files)) == 3
    assert all(one.strip() in text for one in starters + files)
