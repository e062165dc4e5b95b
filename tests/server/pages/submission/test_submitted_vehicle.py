"""A vehicle of one's own in the form: sent as a file, kept with errors, taken from a run."""

import io
import re

import pytest
from werkzeug.test import TestResponse

from seamark.server.runs.data import retention
from seamark.server.runs.submission.validation import RANKED_VEHICLE
from tests.cast import VEHICLE
from tests.server.classes.class_cast import assign, classroom
from tests.server.pages.conftest import Site
from tests.server.programs.test_vehicles import NAME, SHA256

pytestmark = pytest.mark.slow

FORM = "/submit/currents-v2"


def sent(site: Site, who: str = "ann", text: str = VEHICLE, **answers: object) -> TestResponse:
    file = (io.BytesIO(text.encode()), "mine.toml")
    form = {"controller": "pi", "vehicle": "girona500", "vehicle_file": file} | answers
    return site.browser(who).post(FORM, {name: one for name, one in form.items() if one})


def run_of(answer: TestResponse) -> int:
    assert answer.status_code == 303, answer.text
    return int(answer.headers["Location"].rpartition("/")[2])


def kept_in(page: str) -> str:
    found = re.search(r'name="kept_vehicle" value="([^"]+)"', page)
    assert found is not None
    return found[1]


def error_in(page: str) -> str:
    found = re.search(r'id="vehicle-error">([^<]+)<', page)
    assert found is not None, page
    return found[1]


def test_a_file_has_precedence_over_the_choice(site: Site) -> None:
    run = site.show(run_of(sent(site)))

    assert (run.config["vehicle"], run.vehicle_sha256) == (NAME, SHA256)


def test_a_file_that_is_wrong_is_explained_at_its_field(site: Site) -> None:
    answer = sent(site, text=VEHICLE.replace("format = 1", "format = 3"), kp="0.5")

    assert answer.status_code == 422
    assert "format must be 1" in error_in(answer.text)
    assert 'name="kp" value="0.5"' in answer.text


def test_many_errors_are_told_at_the_field_in_part(site: Site) -> None:
    page = sent(site, text='format = 1\nname = "mine"', vehicle=NAME).text

    assert " more: `seamark vehicle check` lists them." in error_in(page)
    assert len(error_in(page)) < 400
    assert NAME not in page  # which cannot be chosen without its file


def test_a_vehicle_is_kept_when_another_field_is_invalid(site: Site) -> None:
    page = sent(site, kp="99").text

    assert f'<option value="{NAME}" selected>' in page
    kept = kept_in(page)
    again = sent(site, vehicle=NAME, vehicle_file=None, kept_vehicle=kept)
    assert site.show(run_of(again)).vehicle_sha256 == SHA256


def test_another_choice_after_a_kept_file_counts(site: Site) -> None:
    kept = kept_in(sent(site, kp="99").text)

    run = site.show(run_of(sent(site, vehicle_file=None, kept_vehicle=kept)))

    assert (run.config["vehicle"], run.vehicle_sha256) == ("girona500", None)


def test_a_kept_vehicle_belongs_to_its_sender_and_cannot_be_forged(site: Site) -> None:
    kept = kept_in(sent(site, kp="99").text)

    for who, text in (("ben", kept), ("ann", kept[:-2] + "xx"), ("ann", None)):
        answer = sent(site, who, vehicle=NAME, vehicle_file=None, kept_vehicle=text)
        assert answer.status_code == 422
        assert "Choose the file of your vehicle again." in error_in(answer.text)


def test_a_ranked_run_refuses_a_vehicle(site: Site) -> None:
    answer = sent(site, kind="ranked", vehicle=None)

    assert answer.status_code == 422
    assert error_in(answer.text) == RANKED_VEHICLE


def test_an_assignment_refuses_a_vehicle_and_its_form_asks_for_none(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann"), config={}, benchmark="currents-v2")

    page = site.browser("ann").get(f"{FORM}?assignment={assignment}").text
    answer = sent(site, vehicle=None, assignment=str(assignment))

    assert "vehicle_file" not in page
    assert answer.status_code == 422
    assert "An assignment fixes the vehicle." in answer.text


def test_guests_have_no_field_for_a_file_and_may_not_send_one(site: Site) -> None:
    assert "vehicle_file" not in site.browser().get(FORM).text

    answer = sent(site, "stranger")

    assert answer.status_code == 422
    assert "Uploading a vehicle needs an account." in error_in(answer.text)


def test_the_form_of_a_run_has_its_vehicle_again(site: Site) -> None:
    run_id = run_of(sent(site))

    page = site.browser("ann").get(f"{FORM}?from={run_id}").text

    assert f'<option value="{NAME}" selected>' in page
    again = sent(site, vehicle=NAME, vehicle_file=None, kept_vehicle=kept_in(page))
    assert site.show(run_of(again)).config["vehicle"] == NAME


def test_somebody_else_may_use_the_vehicle_of_a_published_run(site: Site) -> None:
    run_id = run_of(sent(site))
    assert site.finish(site.claim_next())
    assert "kept_vehicle" not in site.browser("ben").get(f"{FORM}?from={run_id}").text
    site.publish(run_id)

    page = site.browser("ben").get(f"{FORM}?from={run_id}").text
    of_guest = site.browser().get(f"{FORM}?from={run_id}").text

    again = sent(site, "ben", vehicle=NAME, vehicle_file=None, kept_vehicle=kept_in(page))
    assert site.show(run_of(again)).vehicle_sha256 == SHA256
    assert "It does not have its vehicle: uploading one needs an account." in of_guest


def test_the_form_of_a_run_whose_vehicle_was_deleted_says_so(site: Site) -> None:
    run_id = run_of(sent(site))
    assert site.finish(site.claim_next())
    retention.delete(site.database, site.settings, [run_id])
    site.unused_deleted()

    page = site.browser("ann").get(f"{FORM}?from={run_id}").text

    assert "It does not have its vehicle: it has been deleted." in page
    assert NAME not in page
    assert site.browser("ann").get(f"/runs/{run_id}").status_code == 200


def test_the_page_of_a_run_offers_the_file_of_its_vehicle(site: Site) -> None:
    run_id = run_of(sent(site))

    page = site.browser("ann").get(f"/runs/{run_id}").text

    assert f"/api/v1/runs/{run_id}/vehicle.toml" in page
    assert NAME in page
