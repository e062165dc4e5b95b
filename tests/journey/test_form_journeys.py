"""The form of a new run: by a newcomer, after mistakes, by keyboard, and on a phone."""

import pytest
from playwright.sync_api import FilePayload, Page, Route, expect

from tests.journey.visitor import (
    PROGRAM,
    RUN_MS,
    Visitor,
    choose_file,
    customise,
    editor_of,
    replace_program,
    shorten,
    write_program,
)

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

FORM = "/submit/currents-v1"
SCRIPT = "**/submit/main*.js"
BROKEN = PROGRAM.replace("def step(self, observation):", "def step(self, observation)")
START = "Start run"


def _in_sight(page: Page, name: str = START) -> bool:
    box = page.get_by_role("button", name=name).bounding_box()
    height = page.evaluate("innerHeight")
    return box is not None and 0 <= box["y"] <= height - box["height"]


def test_a_newcomer_checks_and_runs_the_example_as_it_is(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("newcomer")
    reader.open(FORM)
    page.locator("label", has_text="My own program").click()
    editor = editor_of(page)
    expect(editor).to_contain_text("class Controller")
    keyword = editor.get_by_text("class", exact=True).first
    assert keyword.evaluate("word => getComputedStyle(word).fontWeight") == "600"
    page.get_by_label("Language").select_option("c++")
    expect(editor).to_contain_text("#include")
    page.get_by_label("Language").select_option("python")

    page.get_by_role("button", name="Check program").click()
    expect(page.locator("#check-report")).to_contain_text("The program runs.", timeout=RUN_MS)
    shorten(page)
    expect(page.locator("[data-changed-count]")).to_have_text("3 settings changed")
    page.get_by_role("button", name=START).click()
    reader.wait_for("succeeded")

    assert (reader.errors, reader.violations()) == ([], [])


def test_an_error_in_a_program_is_shown_at_its_line_and_repaired_in_place(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.sign_up("repairer")
    reader.open(FORM)
    write_program(page, BROKEN)

    page.get_by_role("button", name=START).click()
    expect(page.locator("#program-error")).to_contain_text("controller.py, line 9")
    expect(page.locator(".cm-problem")).to_have_text("    def step(self, observation)")
    replace_program(page, PROGRAM)
    shorten(page)
    page.get_by_role("button", name=START).click()
    page.wait_for_url("**/runs/*")

    assert reader.violations() == []


def test_a_kept_file_is_named_beside_a_small_icon_and_need_not_be_chosen_again(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.sign_up("keeper-of-files")
    reader.open(FORM)
    file = FilePayload(name="mine.py", mimeType="text/x-python", buffer=PROGRAM.encode())
    choose_file(page, file)
    customise(page)
    page.locator("#seed").fill("seven")

    page.get_by_role("button", name=START).click()
    expect(page.get_by_text("mine.py")).to_be_visible()
    icon = page.locator("#own-program .drop svg").bounding_box()
    assert icon is not None
    assert icon["width"] < 24
    page.locator("#seed").fill("7")
    shorten(page)
    page.get_by_role("button", name=START).click()
    page.wait_for_url("**/runs/*")

    assert reader.violations() == []


def test_settings_that_are_unfolded_before_the_script_of_a_slow_machine_runs_stay_unfolded(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.sign_up("early-bird")
    scripts: list[Route] = []

    def hold(script: Route) -> None:
        scripts.append(script)

    page.route(SCRIPT, hold)
    with page.expect_request(SCRIPT):
        page.goto(reader.url + FORM, wait_until="commit")
    page.locator("#customise > summary").click()
    page.locator("details.group > summary", has_text="Experiment").click()
    page.get_by_label("Level duration").fill("10")

    scripts[0].continue_()
    expect(page.locator("[data-changed-count]")).to_have_text("1 setting changed")

    expect(page.get_by_label("Settle window")).to_be_visible()
    assert (reader.errors, reader.violations()) == ([], [])


def test_presets_fill_in_settings_and_a_ranked_run_says_which_it_does_not_use(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.sign_up("presetter")
    reader.open(FORM)
    weak = page.get_by_role("button", name="Weak thruster")
    weak.click()
    page.get_by_role("button", name="Beam current").click()
    page.locator("#customise > summary").click()
    expect(page.get_by_label("Faulty thruster")).to_have_value("0")
    expect(page.get_by_label("Thruster delay")).to_be_hidden()
    expect(page.locator("[data-changed-count]")).to_have_text("3 settings changed")

    page.get_by_text("Ranked", exact=True).click()
    expect(page.locator("[data-ranked-note]")).to_contain_text("Faulty thruster, Remaining thrust")
    expect(page.get_by_label("Faulty thruster")).to_be_hidden()
    page.get_by_text("Practice", exact=True).click()
    weak.click()
    expect(page.locator("[data-changed-count]")).to_have_text("1 setting changed")
    page.get_by_role("button", name="Reset all").click()

    expect(page.locator("[data-changed-count]")).to_be_hidden()
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_run_can_be_written_checked_and_started_by_keyboard_alone(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("typist")
    reader.open(FORM)
    keyboard = page.keyboard
    page.get_by_role("radio", name="PI", exact=True).focus()
    keyboard.press("ArrowUp")  # the last choice: one's own program
    editor = editor_of(page)
    expect(editor).to_be_visible()
    reader.tab_to(editor)
    keyboard.press("Control+a")
    keyboard.insert_text("def f():")
    keyboard.press("Enter")
    keyboard.press("Tab")
    keyboard.type("pass")
    expect(editor).to_contain_text("pass")
    assert page.locator("#program_text").input_value() == "def f():\n        pass"

    keyboard.press("Escape")
    keyboard.press("Tab")
    expect(page.get_by_role("button", name="Check program")).to_be_focused()
    page.locator("#customise > summary").focus()
    keyboard.press("Enter")
    expect(page.get_by_label("Run title")).to_be_visible()
    page.get_by_role("button", name=START).focus()
    keyboard.press("Enter")

    expect(page.locator("#problems")).to_be_focused()
    assert reader.violations() == []


def test_start_is_in_sight_on_a_phone_wherever_one_scrolls(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("walker")
    page.set_viewport_size({"width": 375, "height": 800})
    reader.open(FORM)
    assert _in_sight(page)
    page.locator("label", has_text="My own program").click()
    expect(editor_of(page)).to_be_visible()
    page.get_by_role("button", name="Weak thruster").click()
    customise(page, "Experiment")

    seen = []
    for part in (0.0, 0.3, 0.6, 0.9):
        page.evaluate(
            "part => scrollTo({top: part * document.body.scrollHeight, behavior: 'instant'})", part
        )
        seen.append(_in_sight(page))

    assert seen == [True] * 4
    assert page.evaluate("document.documentElement.scrollWidth") == 375
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_setting_that_was_changed_for_another_controller_does_not_keep_a_run_from_ranking(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.sign_up("undecided")
    reader.open("/submit/currents-v2")
    customise(page, "Position controller")
    page.locator("#kp").fill("0.9")
    page.locator("label", has_text="LQG").click()
    page.locator("label", has_text="Ranked").first.click()

    page.get_by_role("button", name="Start ranked run").click()
    page.wait_for_url("**/runs/*")
    reader.cancel_unseen()  # at once: 32 trials would keep a core busy for a minute

    assert (reader.errors, reader.violations()) == ([], [])
