"""A class in a real browser: a teacher assigns, a student hands in, the teacher sees the result."""

import csv
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from playwright.sync_api import expect
from sqlalchemy import update

from seamark.server.database.engine import Database
from seamark.server.database.tables import User
from tests.journey.service import Service
from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def make_teacher(service: Service, name: str) -> None:
    database = Database(f"sqlite:///{service.data / 'seamark.db'}")
    with database.writing() as session:
        session.execute(update(User).where(User.name == name).values(role="teacher"))
    database.close()


def join_class(phone: Visitor, code: str) -> None:
    """Create the account of a pupil and join by the code, typed in lower case."""
    phone.sign_up("pupil")
    phone.open("/classes/")
    phone.page.get_by_label("Class code").fill(code.lower())
    phone.page.get_by_role("button", name="Join class").click()


def test_a_pupil_hands_in_a_run_and_the_teacher_sees_it(
    service: Service, reader: Visitor, phone: Visitor, finished: tuple[int, Any]
) -> None:
    page, pupil = reader.page, phone.page
    reader.sign_up("teacher")
    make_teacher(service, "teacher")
    reader.open("/classes/")
    page.get_by_label("Name").fill("Robotics 5b")
    page.get_by_role("button", name="Create class").click()
    code = page.locator("#class-code").inner_text()
    page.get_by_role("link", name="New assignment").click()
    reader.open(f"{page.url.removeprefix(reader.url)}?run={finished[0]}")
    page.get_by_label("Title").fill("Hold still")
    expect(page.get_by_label("Practice runs with my settings")).to_be_checked()
    expect(page.get_by_label("Take the settings from")).to_have_value(str(finished[0]))
    page.get_by_label("Seed").fill("5")
    next_week = datetime.now(UTC) + timedelta(days=7)
    page.get_by_label("Deadline").fill(next_week.strftime("%Y-%m-%dT%H:%M"))
    page.get_by_role("button", name="Create assignment").click()
    expect(page.get_by_role("heading", name="Task")).to_be_visible()
    assignment = page.url.removeprefix(reader.url)

    join_class(phone, code)
    pupil.get_by_role("link", name="Hold still").click()
    pupil.get_by_role("link", name="Start").click()
    expect(pupil.locator("#assignment")).to_contain_text("Robotics 5b")
    pupil.get_by_role("button", name="Start run").click()
    phone.wait_for("succeeded")
    phone.open(assignment)
    expect(pupil.get_by_role("region", name="Your runs")).to_contain_text("succeeded")

    reader.open(assignment)
    row = page.get_by_role("region", name="Students").get_by_role("row", name="pupil")
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    (line,) = csv.DictReader(download.value.path().read_text().splitlines())
    assert (line["pupil"], line["runs"], line["seed"]) == ("pupil", "1", "5")
    row.get_by_role("link").click()
    expect(page.get_by_role("link", name="Publish …")).to_have_count(0)
    assert (reader.errors, phone.errors) == ([], [])
    assert (reader.violations(), phone.violations()) == ([], [])
