"""One's own program run again with other gains, and swept over one of its parameters."""

import re

import pytest
from playwright.sync_api import FilePayload, Page, expect

from tests.journey.visitor import (
    PROGRAM,
    RUN_MS,
    Visitor,
    choose_file,
    customise,
    editor_of,
    shorten,
    write_program,
)

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

FORM = "/submit/currents-v1"
SWEPT = """
PARAMETERS = {"gain": {"default": 0.8, "range": [0, 2], "unit": "1/s"}}

class Controller:
    def __init__(self, config):
        self.gain = config["gain"]

    def step(self, observation):
        x, y, _ = observation.error
        return [self.gain * x, self.gain * y, 0.0, 0.0]
"""


def _run_number(page: Page) -> str:
    path = page.url.partition("#")[0]  # the player writes its time behind it
    return path.rsplit("/", 1)[1]


def test_two_runs_again_change_the_gain_alone_and_are_compared(reader: Visitor) -> None:
    page, numbers = reader.page, list[str]()
    reader.sign_up("iterator")
    reader.open(FORM)
    write_program(page, PROGRAM + "# of the iterator")
    shorten(page)
    page.get_by_label("Seed", exact=True).fill("7")
    page.get_by_role("button", name="Start run").click()
    for gain in ("0.3", "0.9"):
        reader.wait_for("succeeded")
        numbers.append(_run_number(page))
        page.get_by_role("link", name="Run again").click()
        expect(page.locator("[data-prefill]")).to_contain_text(
            f"The form has the program, configuration and seed of run {numbers[-1]}."
        )
        expect(editor_of(page)).to_contain_text("# of the iterator")
        customise(page, "Position controller")
        page.get_by_label("Proportional gain Kp").fill(gain)
        page.get_by_role("button", name="Start run").click()
        page.wait_for_url("**/runs/*")
        expect(page.get_by_text("started from")).to_contain_text(f"run {numbers[-1]}")
    reader.wait_for("succeeded")
    numbers.append(_run_number(page))

    reader.open("/runs/?sort=oldest")
    page.get_by_label("Select all").check()
    page.get_by_role("button", name="Compare").click()
    expect(page.get_by_role("heading", name="Compare 3 runs")).to_be_visible()
    differing = page.get_by_role("region", name="Table of settings that differ").locator("tr")

    expect(differing).to_have_count(2)  # program, seed, levels and the others are the same
    expect(differing.nth(0)).to_contain_text(" ".join(f"#{number}" for number in numbers))
    expect(differing.nth(1)).to_contain_text(re.compile(r"Kp \[1/s\]\s+\S*0\.30\.9\s*$"))
    assert len(set(page.locator(".compared-score strong").all_inner_texts())) == 3
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_parameter_of_an_upload_is_swept_and_its_best_value_used(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("sweeper")
    reader.open(FORM)
    file = FilePayload(name="swept.py", mimeType="text/x-python", buffer=SWEPT.encode())
    choose_file(page, file)
    gain = page.get_by_role("group", name="Parameters of the program").get_by_label("gain")
    expect(gain).to_have_value("0.8", timeout=RUN_MS)
    shorten(page)
    page.locator("#sweep > summary").click()
    page.get_by_label("Setting or parameter").select_option("gain")
    page.locator("#sweep").get_by_label("Values").first.fill("0, 0.4, 1.2")
    expect(page.get_by_text("This sweep has 3 runs.")).to_be_visible()
    page.get_by_role("button", name="Start 3 runs").click()

    page.wait_for_url("**/sweeps/*")
    expect(page.get_by_text("3 of 3 runs finished")).to_be_visible(timeout=RUN_MS)
    rows = page.get_by_role("region", name="Runs of the sweep").locator("tbody tr")
    values = rows.locator("td:nth-child(2)").all_inner_texts()
    scores = [float(text.split()[0]) for text in rows.locator("td:nth-child(4)").all_inner_texts()]
    best = values[scores.index(max(scores))]
    point = page.get_by_role("region", name="Best point")
    expect(point).to_contain_text(f"gain {best}")
    expect(page.locator(".sweep-curve circle")).to_have_count(3)
    point.get_by_role("link", name=re.compile("^Use the values")).click()

    expect(page.locator("[data-prefill]")).to_contain_text(
        "The form has the program, configuration"
    )
    expect(page.get_by_text("swept.py")).to_be_visible()
    expect(gain).to_have_value(best)
    assert values == ["0", "0.4", "1.2"]
    assert best != "0"  # without thrust the vehicle drifts away
    assert (reader.errors, reader.violations()) == ([], [])
