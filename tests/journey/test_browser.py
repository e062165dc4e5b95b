"""From the first visit to a rank on the leaderboard, in a real browser with the real service."""

import re

import pytest
from playwright.sync_api import FilePayload, expect

from tests.journey.two_trials.two_trials import LEVEL_S, TRIALS
from tests.journey.visitor import (
    PROGRAM,
    RUN_MS,
    Visitor,
    choose_file,
    customise,
    shorten,
    write_program,
)

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def test_a_visitor_without_an_account_can_run_the_pi_controller(visitor: Visitor) -> None:
    page = visitor.page
    visitor.open("/")
    page.get_by_role("link", name="New run").click()
    shorten(page)

    page.get_by_role("button", name="Start run").click()
    visitor.wait_for("succeeded")

    expect(page.get_by_text("RMSE of the tool point").first).to_be_visible()
    expect(page.locator("[data-camera] img")).to_be_visible()
    expect(page.locator(".uplot canvas")).to_have_count(3)
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_an_uploaded_controller_goes_from_sign_up_to_the_leaderboard(reader: Visitor) -> None:
    page = reader.page
    reader.open("/sign-up")
    reader.fill_in_account("journey")
    reader.open("/submit/currents-v1")
    file = FilePayload(name="mine.py", mimeType="text/x-python", buffer=PROGRAM.encode())
    choose_file(page, file)
    page.get_by_text("Ranked", exact=True).click()
    expect(page.get_by_label("Level duration")).to_be_disabled()

    page.get_by_role("button", name="Start ranked run").click()
    expect(page.locator("[data-log]")).to_contain_text("level 1", timeout=RUN_MS)
    run = page.url.partition("#")[0]
    reader.rest()  # to draw the trials costs as much as to simulate them
    reader.wait_elsewhere(int(run.rpartition("/")[2]), timeout_ms=4 * RUN_MS)
    page.goto(run)
    reader.wait_for("succeeded")
    expect(page.locator("[data-log]")).to_contain_text("level 4")
    with page.expect_download() as download:
        page.get_by_role("link", name="telemetry.csv").click()
    reader.publish()
    expect(page.get_by_text("The run is now public")).to_be_visible()
    reader.open("/leaderboards/currents-v1")

    row = page.get_by_role("row", name=re.compile("journey"))
    expect(row).to_contain_text("Steady hand")
    lines = download.value.path().read_text().splitlines()
    rows = [line for line in lines if not line.startswith("#")]
    assert len(rows) == 1 + TRIALS * 5 * LEVEL_S * 20
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_program_that_divides_by_zero_fails_with_its_error_on_the_page(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("zero")
    reader.open("/submit/currents-v1")
    shorten(page)
    write_program(page, PROGRAM.replace("return [", "return [1 / 0, "))

    page.get_by_role("button", name="Start run").click()
    reader.wait_for("failed")

    expect(page.get_by_text("user_error")).to_be_visible()
    expect(page.get_by_text("ZeroDivisionError").first).to_be_visible()
    assert (reader.errors, reader.violations()) == ([], [])


def test_an_invalid_gain_is_marked_at_its_field_and_other_values_are_kept(reader: Visitor) -> None:
    page = reader.page
    reader.open("/submit/currents-v1")
    customise(page, "Position controller")
    page.get_by_label("Proportional gain Kp").fill("99")
    page.get_by_label("Integral gain Ki").fill("0.03")

    page.get_by_role("button", name="Start run").click()

    expect(page.locator("#kp-error")).to_contain_text("from 0 to 5")
    expect(page.get_by_label("Integral gain Ki")).to_have_value("0.03")
    assert reader.violations() == []


def test_choosing_a_vehicle_sets_its_defaults_and_keeps_other_values(reader: Visitor) -> None:
    page = reader.page
    reader.open("/submit/currents-v1")
    customise(page, "Position controller")
    page.get_by_label("Proportional gain Kp").fill("0.8")

    customise(page, "Experiment")
    page.get_by_label("Vehicle", exact=True).select_option("girona500-uwsim")

    expect(page.get_by_label("Current model")).to_have_value("force")
    expect(page.get_by_label("Proportional gain Kp")).to_have_value("0.8")


def test_steering_settings_are_shown_only_if_the_tracker_steers(reader: Visitor) -> None:
    page = reader.page
    reader.open("/submit/visibility-v1")
    customise(page, "Motion")
    groups = page.locator("details.group > summary")
    expect(groups.filter(has_text="Water and camera")).to_be_visible()
    expect(groups.filter(has_text="Sensors")).to_be_hidden()

    page.get_by_label("Vehicle motion").select_option("free")

    expect(groups.filter(has_text="Sensors")).to_be_visible()
    expect(groups.filter(has_text="Position controller")).to_be_visible()
    assert reader.violations() == []


def test_a_file_of_three_megabytes_is_refused_with_the_limit(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("heavy")
    reader.open("/submit/currents-v1")
    file = FilePayload(name="big.py", mimeType="text/x-python", buffer=b"#" * 3_000_000)
    choose_file(page, file)

    page.get_by_role("button", name="Start run").click()

    expect(page.locator("#program-error")).to_contain_text("larger than 2 MiB")
