"""The address with which a teacher invites a class: whoever has it signs up, in or just joins."""

import re
from dataclasses import replace

import pytest

from seamark.server.classes import classrooms
from seamark.server.classes.classrooms import ClassView
from tests.server.classes.class_cast import classroom
from tests.server.pages.conftest import Browser, Site

WORDS = "correct horse battery"
ADDRESS = re.compile(r"http://localhost(/classes/join/[\w-]+)")


def room(site: Site, class_id: int) -> ClassView:
    with site.database.reading() as session:
        found = classrooms.find(session, class_id)
    assert found is not None
    return found


def address_of(site: Site, class_id: int) -> str:
    found = ADDRESS.search(site.browser("tim").get(f"/classes/{class_id}").text)
    assert found is not None
    return found[1]


def sign_up(browser: Browser, name: str, address: str) -> str:
    """Follow the link to the form, send it, and return where the browser is sent."""
    link = re.search(r'href="(/sign-up\?[^"]+)"', browser.get(address).text)
    assert link is not None
    code = re.search(r'name="class" value="([^"]+)"', browser.get(link[1]).text)
    assert code is not None
    form = {"name": name, "password": WORDS, "class": code[1]}
    answer = browser.post("/sign-up", form)
    assert answer.status_code == 302, answer.text
    return answer.headers["Location"]


def with_settings(site: Site, **changes: object) -> Site:
    current = site.app.extensions["seamark"]
    settings = current.settings.model_copy(update=changes)
    site.app.extensions["seamark"] = replace(current, settings=settings)
    return site


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["open", "invitation"])
def test_who_has_no_account_signs_up_by_the_link_and_is_in_the_class(site: Site, mode: str) -> None:
    class_id = classroom(site)
    pupil = with_settings(site, sign_up=mode).browser()

    sent_to = sign_up(pupil, "cleo", address_of(site, class_id))

    assert sent_to == f"/classes/{class_id}"
    assert pupil.get(sent_to).status_code == 200
    assert room(site, class_id).pupils == 1


@pytest.mark.slow
def test_a_school_with_one_address_signs_up_by_the_link_beyond_the_limit_of_an_address(
    site: Site,
) -> None:
    class_id = classroom(site)
    address = address_of(site, class_id)
    crowded = with_settings(site, sign_ups_per_hour=1)

    for number in range(3):
        sign_up(crowded.browser(), f"pupil-{number}", address)

    assert room(site, class_id).pupils == 3


def test_who_is_signed_in_sees_the_class_and_joins_by_a_button(site: Site) -> None:
    class_id = classroom(site)
    address, ann = address_of(site, class_id), site.browser("ann")

    page = ann.get(address).text
    before = room(site, class_id).pupils
    joined = ann.post("/classes/join", {"code": address.rpartition("/")[2]})

    assert "5b" in page
    assert "Join class" in page
    assert (before, room(site, class_id).pupils) == (0, 1)
    assert ann.get(address).headers["Location"] == joined.headers["Location"]


def test_the_link_can_be_pasted_where_the_code_is_asked_for(site: Site) -> None:
    class_id = classroom(site)

    site.browser("ann").post("/classes/join", {"code": f"http://x{address_of(site, class_id)} "})

    assert room(site, class_id).pupils == 1


@pytest.mark.slow
@pytest.mark.parametrize("change", ["code", "archive"])
def test_a_link_that_the_teacher_has_replaced_joins_nobody_and_names_no_class(
    site: Site, change: str
) -> None:
    class_id = classroom(site)
    address = address_of(site, class_id)
    site.browser("tim").post(f"/classes/{class_id}/{change}")
    form = {"name": "cleo", "password": WORDS, "class": address.rpartition("/")[2]}

    page = site.browser().get(address)
    refused = with_settings(site, sign_up="invitation").browser().post("/sign-up", form)

    assert (page.status_code, refused.status_code) == (404, 422)
    assert "5b" not in re.sub(r"<[^>]*>", " ", page.text).split()  # addresses have such digits
    assert room(site, class_id).pupils == 0


def test_a_link_makes_no_account_where_sign_up_is_closed(site: Site) -> None:
    class_id = classroom(site)
    address = address_of(site, class_id)
    form = {"name": "cleo", "password": WORDS, "class": address.rpartition("/")[2]}
    stranger = with_settings(site, sign_up="closed").browser()

    assert "/sign-up" not in stranger.get(address).text.partition("<main")[2]
    assert stranger.post("/sign-up", form).status_code == 403


@pytest.mark.slow
def test_guessing_links_ends_after_a_few_hundred(site: Site) -> None:
    browser = site.browser()

    statuses = {browser.get(f"/classes/join/{number:010}").status_code for number in range(302)}

    assert statuses == {404, 429}


def test_signing_in_from_the_link_leads_back_to_it(site: Site) -> None:
    address = address_of(site, classroom(site))

    page = site.browser().get(address).text

    assert f'href="/sign-in?next={address}"' in page
