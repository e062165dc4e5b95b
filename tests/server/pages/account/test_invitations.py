"""What teachers and organisers may do beyond other users, and what they may not."""

import re
from dataclasses import replace

import pytest

from seamark.server.accounts import invitations
from tests.server.pages.conftest import Site

WORDS = "correct horse battery"
ADDRESS = re.compile(r"http://localhost(/sign-up\?invitation=[\w-]+)")


@pytest.fixture
def invited_only(site: Site) -> Site:
    current = site.app.extensions["seamark"]
    settings = current.settings.model_copy(update={"sign_up": "invitation"})
    site.app.extensions["seamark"] = replace(current, settings=settings)
    return site


@pytest.mark.slow
def test_each_invitation_of_a_teacher_makes_one_account(invited_only: Site) -> None:
    made = invited_only.browser("tim").post("/invitations", {"count": "2", "days": "3"})
    addresses = ADDRESS.findall(made.text)

    for name, address in zip(("cleo", "dave"), addresses, strict=True):
        pupil = invited_only.browser()
        form = {"name": name, "password": WORDS, "invitation": address.partition("=")[2]}
        assert 'name="invitation"' in pupil.get(address).text
        assert pupil.post("/sign-up", form).status_code == 302
        assert invited_only.browser().post("/sign-up", form | {"name": "else"}).status_code == 422


def test_the_texts_of_invitations_are_shown_once(site: Site) -> None:
    teacher = site.browser("tim")
    (address,) = ADDRESS.findall(teacher.post("/invitations", {"count": "1"}).text)

    page = teacher.get("/invitations").text

    assert address not in page
    assert "You have 1 unused invitation." in page


def test_an_account_has_a_limited_number_of_unused_invitations(site: Site) -> None:
    with site.database.writing() as session:
        many = invitations.OPEN_MAX - 1
        invitations.create(session, days=1.0, count=many, user_id=site.user_id("tim"))

    statuses = [
        site.browser("tim").post("/invitations", {"count": count}).status_code
        for count in ("2", "1", "1")
    ]

    assert statuses == [422, 200, 422]


@pytest.mark.slow
@pytest.mark.parametrize("count", ["-1", "0", "1000000", "x", ""])
def test_a_form_makes_one_to_a_hundred_invitations(site: Site, count: str) -> None:
    made = site.browser("tim").post("/invitations", {"count": count, "days": "1e9"}).text

    assert 1 <= len(ADDRESS.findall(made)) <= invitations.BATCH_MAX


@pytest.mark.parametrize("who", ["tim", "olga"])
def test_neither_a_teacher_nor_an_organiser_publishes_for_others(site: Site, who: str) -> None:
    run_id = site.succeeded("ann", kind="ranked")

    answer = site.browser(who).post(f"/runs/{run_id}/publish")

    assert answer.status_code == 404
    assert not site.show(run_id).public


def test_an_organiser_takes_a_run_off_the_leaderboard_and_sees_it_no_more(site: Site) -> None:
    run_id, organiser = site.published("ann", kind="ranked"), site.browser("olga")
    assert "Withdraw" in organiser.get(f"/runs/{run_id}").text

    answer = organiser.post(f"/runs/{run_id}/withdraw")

    assert answer.headers["Location"] == "/leaderboards/currents-v1"
    assert not site.show(run_id).public
    assert organiser.get(f"/runs/{run_id}").status_code == 404


def test_a_page_for_teachers_names_the_role_to_others(site: Site) -> None:
    answer = site.browser("ann").get("/invitations")

    assert answer.status_code == 403
    assert "requires the role teacher" in answer.text
