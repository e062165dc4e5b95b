"""Entries by the form of a benchmark, whose scenario the competition fixes."""

import re
from typing import Any

import pytest
from sqlalchemy import func, select

from seamark.server.database.tables import Run
from seamark.server.runs.record.states import RunKind
from tests.server.judging.cup import NAME, Cup
from tests.server.pages.conftest import Site

FORM = f"/submit/currents-v1?competition={NAME}"
ENTRY = {"competition": NAME, "controller": "pi", "entry_method": "Steady hand"}


@pytest.fixture
def cup(site: Site) -> Cup:
    """An open competition with a team of ann's."""
    opened = Cup.opened(site)
    opened.team("ann", "ben")
    return opened


def post(site: Site, who: str = "ann", **changes: Any) -> Any:
    return site.browser(who).post("/submit/currents-v1", ENTRY | changes)


def runs(site: Site) -> int:
    with site.database.reading() as session:
        return session.scalar(select(func.count()).select_from(Run)) or 0


def test_the_form_offers_neither_kind_nor_seed_nor_trials_nor_scenario_nor_sweep(
    site: Site, cup: Cup
) -> None:
    page = site.browser("ann").get(FORM).text

    assert "<h1>New entry</h1>" in page
    assert "3 of 3 submissions of your team left" in page
    assert "current levels 0, 0.2 m/s" in page
    for name in ("seed", "trials", "title", "sweep-0-name", "vehicle_file"):
        assert f'name="{name}"' not in page
    assert re.findall(r'name="kind" value="(\w+)"', page) == ["practice"]
    assert "default" in page


def test_an_entry_by_the_form_counts_for_the_team_in_the_round_that_is_open(
    site: Site, cup: Cup
) -> None:
    answer = post(site)

    run = site.show(int(answer.headers["Location"].rpartition("/")[2]))
    assert run.kind is RunKind.ENTRY
    assert run.entry is not None
    assert (run.entry.method, run.entry.round, run.trials) == ("Steady hand", 2, 3)
    assert run.config["levels"] == [0.0, 0.2]
    assert cup.live() == [run.id]


def test_a_forged_kind_seed_and_number_of_trials_have_no_effect(site: Site, cup: Cup) -> None:
    answer = post(site, kind="ranked", seed="7", trials="1", title="T")

    run = site.show(int(answer.headers["Location"].rpartition("/")[2]))
    assert (run.kind, run.trials, run.title) == (RunKind.ENTRY, 3, "Steady hand")
    assert run.seed != 7


@pytest.mark.parametrize(
    ("who", "changes", "sentence"),
    [
        ("ann", {"entry_method": "x" * 61}, "Shorten the name of the method"),
        ("ann", {"levels": "0, 0.1"}, "This competition fixes Current levels to 0, 0.2."),
        ("ann", {"sweep-0-name": "kp", "sweep-0-values": "0.1, 0.2"}, "no sweep"),
        ("ann", {"competition": "no-cup-v1"}, "There is no competition no-cup-v1."),
        ("eva", {}, "You are in no team of this competition."),
    ],
)
def test_what_a_competition_does_not_take_is_refused_with_a_sentence_and_nothing_starts(
    site: Site, cup: Cup, who: str, changes: dict[str, str], sentence: str
) -> None:
    before = runs(site)

    answer = post(site, who, **changes)

    assert answer.status_code == 422
    assert sentence in answer.text
    assert runs(site) == before


def test_a_method_that_is_refused_is_marked_at_its_field_and_kept(site: Site, cup: Cup) -> None:
    long = "y" * 61

    page = post(site, entry_method=long).text

    assert f'name="entry_method" value="{long}"' in page
    assert '<p class="error" id="entry_method-error">Shorten the name' in page
    assert "3 of 3 submissions" in page  # it is still the form of an entry


def test_a_used_quota_is_refused_and_the_form_and_the_pages_offer_no_more(
    site: Site, cup: Cup
) -> None:
    for number in range(3):
        cup.entered("ann", [40.0, 41.0, 42.0 + number])

    refused = post(site)
    pages = [site.browser("ann").get(f"/competitions/{NAME}{at}").text for at in ("", "/team")]

    assert refused.status_code == 422
    assert "Your team has used its submissions of round 2." in refused.text
    assert not any("Submit an entry" in page for page in pages)
    assert "It has 0 of 3 submissions left" in pages[0]


@pytest.mark.parametrize("who", ["stranger", "eva"])
def test_who_is_in_no_team_gets_the_ordinary_form_with_a_note(
    site: Site, cup: Cup, who: str
) -> None:
    page = site.browser(who).get(FORM).text

    assert f"You cannot submit to {NAME} now" in page
    assert "New run" in page
    assert "New entry" not in page


def test_the_methods_of_a_team_are_offered(site: Site, cup: Cup) -> None:
    cup.entered("ann", [40.0, 41.0, 42.0], method="Steady <b>")

    page = site.browser("ben").get(FORM).text

    assert '<option value="Steady &lt;b&gt;">' in page


def test_the_page_of_an_entry_says_what_it_is_and_offers_only_what_members_may(
    site: Site, cup: Cup
) -> None:
    run_id = cup.entered("ben", [40.0, 41.0, 42.0], method="Steady")

    own = site.browser("ann").get(f"/runs/{run_id}")
    others = {who: site.browser(who).get(f"/runs/{run_id}").status_code for who in ("eva", "olga")}

    assert "entry of" in own.text
    assert f'href="/competitions/{NAME}?round=2"' in own.text
    assert f'href="/competitions/{NAME}/team"' in own.text
    assert "method <bdi>Steady</bdi>" in own.text
    for forbidden in ("Publish", "Withdraw", "Delete"):
        assert f">{forbidden}" not in own.text
    assert others == {"eva": 404, "olga": 200}


def test_an_entry_run_again_is_an_entry_with_the_same_program(site: Site, cup: Cup) -> None:
    program = site.store_program(name="steady.py")
    run_id = cup.submit("ben", "Steady", controller="upload", program=program)
    cup.finish(run_id, [40.0, 41.0, 42.0])

    page = site.browser("ann").get(f"/submit/currents-v1?from={run_id}").text

    assert "New entry" in page
    assert f"The form has the program and configuration of run {run_id}." in page
    assert 'name="entry_method" value="Steady"' in page
    assert re.search(r'value="upload" checked', page)


def test_an_entry_run_again_when_no_round_is_open_is_a_practice_run(site: Site, cup: Cup) -> None:
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])
    cup.close_qualification()

    page = site.browser("ann").get(f"/submit/currents-v1?from={run_id}").text

    assert "New run" in page
    assert 'name="competition"' not in page


def test_all_teams_have_the_files_that_the_organiser_brought(site: Site) -> None:
    vehicle, record = site.store_vehicle(), site.store_record()
    Cup.opened(site, vehicle=vehicle, files=(record,)).team("ann")

    shown = site.browser("ann").get(f"/competitions/{NAME}").text
    form = site.browser("ann").get(FORM).text
    answer = post(site)

    run = site.show(int(answer.headers["Location"].rpartition("/")[2]))
    assert (run.config["vehicle"], run.vehicle_sha256) == (vehicle.name, vehicle.sha256)
    assert run.config["current_record"] == record.name
    assert [one.sha256 for one in run.files] == [record.sha256]
    assert f"<dd>{vehicle.name}</dd>" in shown
    assert f"vehicle {vehicle.name}" in form


def test_an_entry_run_again_has_the_record_only_while_a_round_is_open(site: Site) -> None:
    cup = Cup.opened(site, files=(site.store_record(),))
    cup.team("ann")
    address = f"/submit/currents-v1?from={cup.submit('ann')}"
    lacks = "It does not have its record of currents"

    entry = site.browser("ann").get(address).text
    cup.close_qualification()
    practice = site.browser("ann").get(address).text

    assert "record@" in entry
    assert lacks not in entry
    assert "record@" not in practice
    assert lacks in practice
