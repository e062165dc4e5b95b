"""A vehicle of one's own, from its file to the view of the run."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from playwright.sync_api import Locator, Page, expect

from seamark.cli.main import cli
from tests.cast import VEHICLE
from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]
UNFOLD = "for (const part of document.querySelectorAll('.submit-form details')) part.open = true"


def number_of(page: Page) -> int:
    """Return the number of the run whose page is open."""
    found = re.search(r"/runs/(\d+)", page.url)
    assert found is not None
    return int(found[1])


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    file = tmp_path / "mine.toml"
    file.write_text(VEHICLE, encoding="utf-8")
    return file


@pytest.fixture
def wrong(tmp_path: Path) -> Path:
    file = tmp_path / "wrong.toml"
    file.write_text(VEHICLE.replace("format = 1", "format = 3"), encoding="utf-8")
    return file


def form_of(visitor: Visitor, name: str) -> tuple[Locator, Locator, Locator]:
    """Open the form of a run; return the field of the file, its report and the choice."""
    visitor.sign_up(name)
    visitor.open("/submit/currents-v1")
    page = visitor.page
    page.evaluate(UNFOLD)
    choice = page.get_by_label("Vehicle", exact=True)
    return page.get_by_label("Or your own"), page.locator("[data-vehicle-report]"), choice


def test_a_vehicle_is_checked_and_chosen_as_soon_as_its_file_is(
    reader: Visitor, mine: Path, wrong: Path
) -> None:
    file, report, choice = form_of(reader, "checking")

    file.set_input_files(wrong)
    expect(report).to_contain_text("This vehicle cannot run:")
    expect(report).to_contain_text("format must be 1")
    expect(choice).to_have_value("girona500")

    file.set_input_files(mine)
    expect(report).to_contain_text("Mine can run.")
    expect(report).to_contain_text("where a flat plate has 1.17")
    expect(choice).to_have_value(re.compile("^mine@"))
    expect(reader.page.locator("#kp")).to_have_value("0.7")  # comes with it
    report.get_by_text("What it can do").click()
    expect(report.locator("pre")).to_contain_text("full thrust")

    file.set_input_files(wrong)
    expect(report).to_contain_text("This vehicle cannot run:")
    expect(choice).to_have_value("girona500")
    expect(file).to_have_value(re.compile("wrong.toml"))

    file.set_input_files(mine)
    expect(report).to_contain_text("Mine can run.")
    choice.select_option("bluerov2-heavy")
    expect(report).to_be_empty()
    expect(file).to_have_value("")  # another choice counts
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_vehicle_is_run_drawn_and_run_again(visitor: Visitor, mine: Path, tmp_path: Path) -> None:
    file, report, choice = form_of(visitor, "builder")
    page = visitor.page
    file.set_input_files(mine)
    expect(report).to_contain_text("Mine can run.")
    name = choice.input_value()

    page.locator("#level_duration_s").fill("4")
    page.locator("#levels").fill("0, 0.2")
    page.locator("#settle_s").fill("1")
    page.get_by_role("button", name="Start run").click()
    visitor.wait_for("succeeded")
    expect(page.get_by_text(name).first).to_be_attached()
    with page.expect_download() as download:
        page.get_by_role("link", name="vehicle.toml").click()
    assert Path(download.value.path()).read_text("utf-8") == VEHICLE
    run = number_of(page)
    scene = page.request.get(f"{visitor.url}/api/v1/runs/{run}/scene.json").json()
    assert (scene["vehicle"]["title"], len(scene["vehicle"]["thrusters"])) == ("Mine", 8)

    archive = tmp_path / "run.zip"
    archive.write_bytes(page.request.get(f"{visitor.url}/api/v1/runs/{run}/archive.zip").body())
    here = CliRunner().invoke(cli, ["rerun", str(archive)])
    assert here.exit_code == 0, here.output

    visitor.open(f"/submit/currents-v1?from={run}")
    expect(page.get_by_label("Vehicle", exact=True)).to_have_value(name)
    page.get_by_role("button", name="Start run").click()
    visitor.wait_for("succeeded")
    again = number_of(page)
    digests = [
        page.request.get(f"{visitor.url}/api/v1/runs/{one}").json()["result"]["digest"]
        for one in (run, again)
    ]
    assert digests[0] == digests[1]
    assert (visitor.errors, visitor.violations()) == ([], [])
