"""Further programs of a run, from the form to the page of the run."""

import re
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import Visitor
from tests.part_programs import BENCHMARK, DETECTOR

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def test_a_detector_is_chosen_by_its_label_corrected_and_named_on_the_page_of_the_run(
    reader: Visitor, tmp_path: Path
) -> None:
    good, wrong = tmp_path / "find.py", tmp_path / "wrong.py"
    good.write_bytes(DETECTOR)
    wrong.write_bytes(b"def f(")
    reader.sign_up("searching")
    reader.open(f"/submit/{BENCHMARK}")
    page = reader.page
    field = page.get_by_label("Your own detector")

    field.set_input_files(wrong)
    page.get_by_role("button", name="Start run").click()
    expect(page.locator("#detector_program-error")).to_contain_text("wrong.py, line 1")
    expect(field).to_have_attribute("aria-invalid", "true")
    assert reader.violations() == []

    field.set_input_files(good)
    page.get_by_role("button", name="Start run").click()
    expect(page).to_have_url(re.compile(r"/runs/\d+$"))
    expect(page.get_by_text("+ own detector")).to_be_visible()
    expect(page.get_by_role("link", name="find.py").first).to_be_visible()
