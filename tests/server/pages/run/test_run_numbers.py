"""The numbers on the page of a run: what each is, and of which levels it is a mean."""

import re

import pytest

from seamark.server.pages.run import metric_tables
from seamark.sim import registry
from tests.server.pages.conftest import Site

LEVELS = 30


def _tracking(site: Site) -> str:
    """Return the page of a run of visibility-v2 whose losses are in its motion levels alone."""
    claim = site.running("ann", benchmark="visibility-v2", controller="built-in")
    levels = [
        {
            **{"level": level, "axis": "turbidity", "value": 7.0 - 0.5 * level, "name": f"{level}"},
            **{"p5_percent": 60.0, "p1_percent": 20.0, "held": False},
            "unreported_loss_percent": 0.0 if level < LEVELS // 2 else 46.0,
        }
        for level in range(LEVELS)
    ]
    overall = {"p5_percent": 60.0, "unreported_loss_percent": 0.0, "tau_midpoint": 3.5}
    metrics = {"score": 3.2, "level_held": None, "levels": levels, "trials": [], "overall": overall}
    assert site.finish(claim, metrics=metrics)
    return site.browser("ann").get(f"/runs/{claim.run_id}").text


def test_a_loss_over_the_turbidity_levels_is_not_shown_as_that_of_the_run(site: Site) -> None:
    page = _tracking(site)

    entry = re.search(r"<div><dt>(Unreported loss[^<]*)</dt><dd>(.*?)</dd>", page, re.DOTALL)
    assert entry is not None
    assert entry.group(1) == "Unreported loss, turbidity levels"
    assert "mean of the levels" in entry.group(2)
    assert '<td class="num">46</td>' in page


def test_terms_of_trackers_are_explained_by_buttons_and_in_words(site: Site) -> None:
    page = _tracking(site)

    buttons = dict(re.findall(r'popovertarget="([^"]+)">([^<]+)</button>', page))
    notes = dict(re.findall(r'id="([^"]+)" popover role="note">([^<]+)</span>', page))
    explained = {word: notes[target] for target, word in buttons.items() if target in notes}
    assert "within 5 px of the true ones" in explained["p@5"]
    assert "within 1 px of the true ones" in explained["p@1"]
    midpoint = page[page.index("<dt>τ midpoint</dt>") :]
    assert "falls to half of its plateau" in midpoint[: midpoint.index("</div>")]
    assert "the last one up to which all levels are held: p@5 of at least 95 %" in page


@pytest.mark.parametrize("name", sorted(registry.BENCHMARKS))
def test_every_benchmark_says_when_a_level_is_held(name: str) -> None:
    assert metric_tables.level_held_meaning(registry.benchmark(name))


def test_the_first_screen_has_two_actions_and_the_others_are_in_a_menu(site: Site) -> None:
    page = site.browser("ann").get(f"/runs/{site.succeeded('ann')}").text

    actions = page[page.index('data-part="actions"') : page.index('data-part="state"')]
    direct, menu = actions.split('<details class="menu">')
    assert direct.count('class="button') - direct.count("button-row") == 2
    assert ["Publish …" in direct, "Run again" in direct] == [True, True]
    assert [words in menu for words in ("Compare with …", "Copy link", "Delete")] == [True] * 3
