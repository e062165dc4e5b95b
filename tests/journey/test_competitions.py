"""A competition in real browsers: an organiser opens it, a team submits, a spectator looks on."""

from datetime import datetime, timedelta

import pytest
from playwright.sync_api import expect
from sqlalchemy import update

from seamark.server.database.engine import Database
from seamark.server.database.tables import User
from tests.journey import accessibility
from tests.journey.conftest import SHORT
from tests.journey.service import Service
from tests.journey.visitor import RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

COMPETITION = "/competitions/harbour-cup-v1"


def make_organiser(service: Service, name: str) -> None:
    database = Database(f"sqlite:///{service.data / 'seamark.db'}")
    with database.writing() as session:
        session.execute(update(User).where(User.name == name).values(role="organiser"))
    database.close()


def open_competition(organiser: Visitor) -> None:
    """Make a draft of the settings of a run by the form, wait for its report, and open it."""
    page = organiser.page
    run_id = organiser.submit({"benchmark": "currents-v1", "controller": "pi", "config": SHORT})
    organiser.open(f"/competitions/new?run={run_id}")
    page.get_by_label("Title").fill("Harbour Cup")
    page.get_by_label("Rules").fill("Be fair.")
    begin = page.locator("[id='practice1.opens']")
    earlier = datetime.fromisoformat(begin.input_value()) - timedelta(hours=2)
    begin.fill(earlier.strftime("%Y-%m-%dT%H:%M"))
    for trials in ("practice1.trials", "qualification.trials"):
        page.locator(f"[id='{trials}']").fill("2")
    page.get_by_role("button", name="Save and check").click()
    heading = page.locator("#check-title")
    expect(heading).to_have_text("Check", timeout=RUN_MS)  # without loading the page again
    expect(page.get_by_role("region", name="Reference entries")).to_contain_text("PI")
    assert list(accessibility.defects(page)) == []
    organiser.press_and_confirm("Open")
    expect(page.get_by_role("heading", name="Board")).to_be_visible()


def submit_entry(member: Visitor, method: str, controller: str) -> None:
    """Submit a built-in controller under a name by the form that is open, and wait for it."""
    page = member.page
    page.get_by_label("Name of your method").fill(method)
    page.locator(f"label.pill:has(input[value='{controller}'])").click()
    page.get_by_role("button", name="Submit entry").click()
    expect(page.get_by_text(f"method {method}")).to_be_visible()
    member.wait_for("succeeded")


def test_an_organiser_opens_a_competition_and_a_team_sees_its_place_on_the_board(
    service: Service, reader: Visitor, phone: Visitor
) -> None:
    reader.sign_up("organiser")
    make_organiser(service, "organiser")
    open_competition(reader)

    captain = phone.page
    phone.sign_up("captain")
    phone.open(COMPETITION)
    captain.get_by_role("link", name="Take part").click()
    captain.get_by_label("Name of the team").fill("Kelp")
    captain.get_by_label("I have read the rules").check()
    captain.get_by_role("button", name="Found team").click()
    link = captain.locator("#team-link").inner_text()

    page = reader.page
    page.context.clear_cookies()
    reader.sign_up("second")
    reader.open(link.removeprefix(reader.url))
    page.get_by_label("I have read the rules").check()
    page.get_by_role("button", name="Join team").click()
    page.get_by_role("link", name="Submit an entry").click()
    submit_entry(reader, "Steady", "pi")
    page.get_by_role("link", name="Run again").click()
    submit_entry(reader, "Wild", "p")

    phone.open(f"{COMPETITION}/team")
    entries = captain.get_by_role("region", name="Entries")
    expect(entries.get_by_role("row")).to_have_count(3)
    expect(captain.get_by_text("3 of 5 submissions left")).to_be_visible()
    reader.open(f"{COMPETITION}?per=method")
    expect(page.locator(".notice")).to_contain_text("has place 1 of 2")
    assert list(accessibility.defects(page)) == []

    page.context.clear_cookies()
    reader.open(COMPETITION)
    board = page.get_by_role("region", name="Board of round 1")
    expect(board.get_by_role("row", name="Kelp")).to_have_count(1)
    expect(board.get_by_text("your team")).to_have_count(0)
    expect(page.get_by_text("commitment").first).to_be_attached()
    assert (reader.errors, phone.errors) == ([], [])
    assert (reader.violations(), phone.violations()) == ([], [])
