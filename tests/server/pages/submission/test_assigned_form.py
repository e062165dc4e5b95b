"""The form of a run for an assignment: what the teacher has fixed cannot be changed in it."""

import re

from seamark.server.runs.record.states import RunKind
from tests.server.classes.class_cast import assign, classroom
from tests.server.pages.conftest import Browser, Site

FORM = "/submit/currents-v1"
SHORT = {"levels": [0.1, 0.2], "current_gust": 0.3}


def form_of(site: Site, **changes: object) -> tuple[Browser, int, str]:
    assignment = assign(site, classroom(site, "ann"), config=SHORT, **changes)
    ann = site.browser("ann")
    return ann, assignment, ann.get(f"{FORM}?assignment={assignment}").text


def test_the_form_has_no_field_for_what_the_assignment_fixes(site: Site) -> None:
    _ann, _assignment, page = form_of(site, seed=5, trials=2)

    scenario = re.findall(r'<details class="group"( data-locked hidden)?[^>]*scenario', page)
    assert scenario
    assert all(scenario)
    assert re.findall(r'data-role="solution"', page)
    assert not re.search(r'id="(seed|trials)"', page)
    assert 'type="radio" name="kind"' not in page
    assert "seed 5" in page
    assert "0.1, 0.2" in page


def test_the_form_of_an_assignment_with_free_seeds_asks_for_one(site: Site) -> None:
    _ann, _assignment, page = form_of(site)

    assert 'id="seed"' in page
    assert 'id="trials"' not in page


def test_the_form_as_it_is_sent_starts_a_run_with_the_assigned_scenario(site: Site) -> None:
    ann, assignment, _page = form_of(site, seed=5, trials=2)
    posted = {"assignment": str(assignment), "kind": "practice", "controller": "pi", "kp": "0.7"}

    answer = ann.post(FORM, posted)

    run = site.show(int(answer.headers["Location"].rpartition("/")[2]))
    assert (run.config["levels"], run.config["kp"]) == ([0.1, 0.2], 0.7)
    assert (run.seed, run.trials, run.kind) == (5, 2, RunKind.PRACTICE)


def test_a_form_with_a_mistake_is_shown_again_with_the_scenario_still_fixed(site: Site) -> None:
    ann, assignment, _page = form_of(site, seed=5)
    posted = {"assignment": str(assignment), "kind": "practice", "controller": "pi", "kp": "x"}

    again = ann.post(FORM, posted)

    assert again.status_code == 422
    assert "data-locked hidden" in again.text
    assert re.search(r'name="levels" value="0.1, 0.2"', again.text)


def test_a_sweep_for_an_assignment_offers_and_takes_no_setting_that_it_fixes(site: Site) -> None:
    ann, assignment, page = form_of(site)
    posted = {"assignment": str(assignment), "kind": "practice", "controller": "pi"}
    sweep = {"sweep-0-name": "current_gust", "sweep-0-values": "0.1, 0.2"}

    refused = ann.post(FORM, posted | sweep)

    choices = page[page.index('id="sweep-0-name"') : page.index('id="sweep-0-values"')]
    assert 'value="kp"' in choices
    assert 'value="current_gust"' not in choices
    assert refused.status_code == 422
    assert "This assignment fixes current_gust." in refused.text
