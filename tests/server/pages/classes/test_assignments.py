"""The pages of assignments: their form, their instructions, and what pupils have handed in."""

import csv
import re

import pytest

from seamark.sandbox.languages import editor_starters
from tests.server.classes.class_cast import assign, classroom
from tests.server.pages.conftest import Site

LINKED = (
    "Read https://example.org/a?b=1&c=2 first.\n<b>javascript:alert(1)</b> http://x.org/\"onx='1"
)


def test_addresses_in_instructions_are_links_and_everything_else_is_text(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann"), instructions=LINKED)

    page = site.browser("ann").get(f"/assignments/{assignment}").text

    shown = page[page.index('aria-label="Instructions"') :].partition("</section>")[0]
    links = re.findall(r'<a href="([^"]+)" rel="([^"]+)"', shown)
    assert links[0][0] == "https://example.org/a?b=1&amp;c=2"
    assert {"nofollow", "noopener", "noreferrer"} <= set(links[0][1].split())
    assert "&lt;b&gt;javascript:alert(1)&lt;/b&gt;" in shown
    assert [address.partition(":")[0] for address, _rel in links] == ["https", "http"]


def test_the_form_of_an_assignment_offers_the_practice_runs_of_the_teacher(site: Site) -> None:
    room = classroom(site)
    own, other = site.succeeded("tim"), site.succeeded("ann")
    ranked = site.succeeded("tim", kind="ranked")

    page = site.browser("tim").get(f"/classes/{room}/assignments/new").text

    choices = page[page.index('id="run"') :].partition("</select>")[0]
    assert re.findall(r'value="(\d+)"', choices) == [str(own)]
    assert f"#{own} · currents-v1" in choices
    assert "score" in choices
    assert {str(other), str(ranked)}.isdisjoint(re.findall(r'value="(\d+)"', choices))


def test_a_run_that_the_address_names_is_chosen_already(site: Site) -> None:
    room = classroom(site)
    public, private = site.published("ann"), site.succeeded("ann")
    form = f"/classes/{room}/assignments/new?run="

    shown, hidden = (site.browser("tim").get(f"{form}{run}").text for run in (public, private))

    assert f'value="{public}" selected' in shown
    assert f'value="{private}"' not in hidden


def test_the_chosen_run_gives_benchmark_and_settings(site: Site) -> None:
    room = classroom(site)
    run = site.succeeded("tim", config={"levels": [0.1, 0.3]})
    form = {"title": "Hold", "kind": "run", "run": str(run)}

    made = site.browser("tim").post(f"/classes/{room}/assignments", form)

    assert "0.1, 0.3" in site.browser("tim").get(made.headers["Location"]).text


def test_a_form_without_a_run_asks_to_choose_one(site: Site) -> None:
    room = classroom(site)
    form = {"title": "Hold", "kind": "run", "run": ""}

    refused = site.browser("tim").post(f"/classes/{room}/assignments", form)

    assert refused.status_code == 422
    assert "Choose one of your runs." in refused.text


@pytest.mark.slow
def test_teacher_and_pupil_see_that_a_starter_program_was_handed_in_unchanged(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann", "ben"))
    starter = editor_starters("controller")["python"].text()
    programs = {"ann": starter.replace("\n", "\r\n"), "ben": f"# mine\n{starter}"}
    posted = {"assignment": str(assignment), "controller": "upload", "source": "editor"}
    for name, text in programs.items():
        form = posted | {"language": "python", "program_text": text}
        assert site.browser(name).post("/submit/currents-v1", form).status_code == 303
        assert site.finish(site.claim_next(), score=40.0)

    pages = {
        name: site.browser(name).get(f"/assignments/{assignment}").text.count(">starter program<")
        for name in ("tim", "ann", "ben")
    }
    table = site.browser("tim").get(f"/assignments/{assignment}/pupils.csv").text

    assert pages == {"tim": 1, "ann": 1, "ben": 0}
    rows = {row["pupil"]: row["is_starter"] for row in csv.DictReader(table.splitlines())}
    assert (rows["ann"], rows["ben"]) == ("True", "False")
