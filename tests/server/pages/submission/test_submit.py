"""The form: generated from the schema, and with everything kept when something is wrong."""

import io
import re
from html import unescape

import pytest

from seamark.sandbox.languages import editor_starters, kinds
from tests.server.pages.conftest import Browser, Site

FORM = "/submit/currents-v1"
ARM_STARTERS = editor_starters("controller", moves_arm=True).values()
OTHER_STARTERS = editor_starters("controller").values()
PROGRAM = """
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        return [0, 0, 0, 0]
"""


def _new_run(browser: Browser, **answers: object) -> int:
    answer = browser.post(FORM, {"controller": "pi", **answers})
    assert answer.status_code == 303, answer.text
    return int(answer.headers["Location"].rsplit("/", 1)[-1])


def test_a_guest_starts_a_built_in_controller_and_sees_the_run(site: Site) -> None:
    browser = site.browser()

    run_id = _new_run(browser, kp="0.7", seed="5")

    run = site.show(run_id)
    assert (run.user_id, run.config["kp"], run.seed, run.kind) == (None, 0.7, 5, "practice")
    assert browser.get(f"/runs/{run_id}").status_code == 200
    assert site.browser().get(f"/runs/{run_id}").status_code == 404


def test_every_setting_of_the_schema_has_a_field_with_its_default(site: Site) -> None:
    from seamark.sim import registry

    page = site.browser().get(FORM).text

    names = set(registry.benchmark("currents-v1").schema()["properties"])
    assert names <= set(re.findall(r' name="(\w+)" [^>]*data-default=', page))


def test_a_wrong_gain_is_explained_at_its_field_and_all_values_are_kept(site: Site) -> None:
    answer = site.browser().post(
        FORM, {"controller": "p", "kp": "99", "ki": "0.03", "title": "mine"}
    )

    assert answer.status_code == 422
    error = re.search(r'id="kp-error">([^<]+)<', answer.text)
    assert error is not None
    assert "from 0 to 5" in error.group(1)
    assert re.search(r'name="kp" value="99"[^>]*aria-invalid="true"', answer.text)
    assert re.search(r'name="ki" value="0.03"', answer.text)
    assert re.search(r'name="title"[^>]*value="mine"', answer.text)
    assert re.search(r'name="controller" value="p" checked', answer.text)


@pytest.mark.parametrize("text", ["abc", "nan", "1e999", "", "0,5"])
def test_a_value_that_is_no_number_is_refused_with_a_message(site: Site, text: str) -> None:
    answer = site.browser().post(FORM, {"controller": "pi", "kp": text})

    assert answer.status_code == 422
    assert 'id="kp-error"' in answer.text


@pytest.mark.parametrize("seed", ["-1", "1.5", "seven", "99999999999"])
def test_a_wrong_seed_is_refused(site: Site, seed: str) -> None:
    answer = site.browser().post(FORM, {"controller": "pi", "seed": seed})

    assert answer.status_code == 422
    assert "seed" in answer.text


@pytest.mark.parametrize("trials", ["0", "-1", "11", "9" * 30])
def test_a_wrong_number_of_trials_is_refused(site: Site, trials: str) -> None:
    answer = site.browser().post(FORM, {"controller": "pi", "trials": trials})

    assert answer.status_code == 422
    assert "trials" in answer.text


@pytest.mark.slow
def test_a_form_without_a_controller_names_the_choices(site: Site) -> None:
    answer = site.browser().post(FORM, {"controller": ""})

    assert (
        "Choose a controller: pi, p, pid, pi-ff, smc, lqr, mpc, l1, or your own program."
        in answer.text
    )


def test_a_comma_in_a_number_is_explained(site: Site) -> None:
    answer = site.browser().post(FORM, {"controller": "pi", "kp": "0,5"})

    assert "Use a decimal point: 0.5." in answer.text


def test_choosing_a_vehicle_sets_its_defaults_without_javascript(site: Site) -> None:
    page = site.browser().get(f"{FORM}?vehicle=girona500-uwsim").text

    assert re.search(r'<option value="force" selected>', page)


def test_a_form_can_start_from_the_configuration_of_a_run(site: Site) -> None:
    run_id = site.succeeded("ann", config={"kp": 1.25})

    own = site.browser("ann").get(f"{FORM}?from={run_id}").text
    foreign = site.browser("ben").get(f"{FORM}?from={run_id}").text

    assert 'name="kp" value="1.25"' in own
    assert 'name="kp" value="1.25"' not in foreign


def test_a_preset_of_the_url_fills_in_its_settings_and_opens_them_without_scripts(
    site: Site,
) -> None:
    page = site.browser().get(f"{FORM}?preset=paper-p").text
    plain = site.browser().get(FORM).text

    assert re.search(r'name="controller" value="p" checked', page)
    assert re.search(r'<option value="girona500-uwsim" selected', page)
    assert re.search(r'<details class="customise" id="customise" open>', page)
    assert '<span class="count" data-changed-count>1 setting changed</span>' in page
    assert re.search(r'<details class="customise" id="customise">', plain)
    assert not re.search(r'<details class="group"[^>]* open', plain)


@pytest.mark.slow
def test_a_file_wins_over_the_untouched_editor_without_scripts(site: Site) -> None:
    file = (io.BytesIO(PROGRAM.encode()), "mine.py")
    fields = {"controller": "upload", "source": "editor", "program_text": "not Python"}

    run_id = _new_run(site.browser("ann"), program=file, **fields)

    assert site.show(run_id).program_name == "mine.py"


@pytest.mark.slow
def test_an_uploaded_file_is_queued(site: Site) -> None:
    file = (io.BytesIO(PROGRAM.encode()), "mine.py")

    run_id = _new_run(site.browser("ann"), controller="upload", source="file", program=file)

    run = site.show(run_id)
    assert (run.program_name, run.language, run.state) == ("mine.py", "python", "queued")


@pytest.mark.slow
def test_a_program_from_the_editor_is_queued(site: Site) -> None:
    fields = {"controller": "upload", "source": "editor", "program_text": PROGRAM}

    assert site.show(_new_run(site.browser("ann"), **fields)).program_name == "controller.py"


@pytest.mark.slow
@pytest.mark.parametrize(("language", "name"), [("c", "controller.c"), ("c++", "controller.cpp")])
def test_the_editor_takes_other_languages_and_the_page_has_their_templates(
    site: Site, language: str, name: str
) -> None:
    fields = {"controller": "upload", "source": "editor", "program_text": "int x;"}
    browser = site.browser("ann")

    run = site.show(_new_run(browser, language=language, **fields))

    assert (run.program_name, run.language) == (name, language)
    assert (
        f'<template data-program-template="{language}" data-file="{name}" '
        in browser.get(FORM).text
    )


@pytest.mark.parametrize("benchmark", ["recover-v1", "valve-v1", "connect-v1"])
def test_the_editor_starts_with_a_program_that_moves_the_arm_where_there_is_one(
    site: Site, benchmark: str
) -> None:
    page = unescape(site.browser("ann").get(f"/submit/{benchmark}").text)

    assert all(starter.text() in page for starter in ARM_STARTERS)
    assert not any(starter.text() in page for starter in OTHER_STARTERS)


def test_an_unknown_language_is_refused(site: Site) -> None:
    fields = {"controller": "upload", "source": "editor", "program_text": "x", "language": "ada"}

    answer = site.browser("ann").post(FORM, fields)

    assert answer.status_code == 422
    assert "Choose a language" in answer.text


@pytest.mark.slow
def test_a_syntax_error_names_the_line_and_the_text_is_kept(site: Site) -> None:
    text = "class Controller:\n    def step(self, observation)\n        return 1\n"

    answer = site.browser("ann").post(
        FORM, {"controller": "upload", "source": "editor", "program_text": text}
    )

    assert answer.status_code == 422
    assert re.search(r'id="program-error">controller.py, line 2: ', answer.text)
    assert "def step(self, observation)\n        return 1" in answer.text


def test_a_guest_cannot_upload_a_program(site: Site) -> None:
    file = (io.BytesIO(PROGRAM.encode()), "mine.py")

    answer = site.browser().post(FORM, {"controller": "upload", "program": file})

    assert answer.status_code == 422
    assert "needs an account" in answer.text


def test_an_upload_of_nine_megabytes_is_refused_with_the_limit(site: Site) -> None:
    head = b'--x\r\nContent-Disposition: form-data; name="program"; filename="big.py"\r\n\r\n'
    body = head + b"#" * 9_000_000 + b"\r\n--x--\r\n"

    answer = site.browser("ann").client.post(
        FORM, data=body, content_type="multipart/form-data; boundary=x"
    )

    assert answer.status_code == 413
    assert "The upload is too large" in answer.text
    assert "up to 8 MiB" in answer.text


def test_a_ranked_run_refuses_other_settings_at_their_fields(site: Site) -> None:
    answer = site.browser("ann").post(
        FORM, {"controller": "pi", "kind": "ranked", "level_duration_s": "60"}
    )

    assert answer.status_code == 422
    assert "Level duration) is fixed at 120 s in ranked runs" in answer.text
    assert 'id="level_duration_s-error"' in answer.text


def test_a_ranked_run_has_the_scenario_of_the_benchmark(site: Site) -> None:
    run_id = _new_run(site.browser("ann"), kind="ranked", kp="0.9", level_duration_s="120")

    run = site.show(run_id)
    assert (run.kind, run.seed, run.trials) == ("ranked", None, 10)
    assert (run.config["kp"], run.config["level_duration_s"]) == (0.9, 120.0)


def test_an_exceeded_quota_is_reported_on_the_form(site: Site) -> None:
    for _ in range(site.settings.quota_live):
        site.queue("ann")

    answer = site.browser("ann").post(FORM, {"controller": "pi"})

    assert answer.status_code == 429
    assert "which is the limit" in answer.text


def _kept(text: str) -> str:
    found = re.search(r'name="kept_program" value="([^"]+)"', text)
    assert found is not None
    return found.group(1)


def _refused(site: Site, name: str = "ann", **answers: object) -> str:
    file = (io.BytesIO(PROGRAM.encode()), "mine.py")
    answer = site.browser(name).post(
        FORM, {"controller": "upload", "source": "file", "program": file, "kp": "99", **answers}
    )
    assert answer.status_code == 422
    return answer.text


@pytest.mark.slow
def test_an_uploaded_file_is_kept_when_another_field_is_invalid(site: Site) -> None:
    page = _refused(site)

    again = {"controller": "upload", "source": "file", "kept_program": _kept(page)}
    run = site.show(_new_run(site.browser("ann"), **again))

    assert "mine.py" in page
    assert (run.program_name, run.language) == ("mine.py", "python")


@pytest.mark.slow
def test_a_kept_file_belongs_to_its_sender_and_cannot_be_forged(site: Site) -> None:
    kept = _kept(_refused(site))

    for name, text in (("ben", kept), ("ann", kept[:-2] + "xx"), ("ann", "e30.x.y")):
        answer = site.browser(name).post(
            FORM, {"controller": "upload", "source": "file", "kept_program": text}
        )
        assert (answer.status_code, "Choose a file" in answer.text) == (422, True)


@pytest.mark.slow
def test_an_invalid_file_and_an_invalid_field_are_reported_together(site: Site) -> None:
    page = _refused(site, program=(io.BytesIO(b"def f(:"), "mine.py"))

    assert "mine.py, line 1: invalid syntax" in page
    assert 'id="kp-error"' in page
    assert 'name="kept_program"' not in page


@pytest.mark.parametrize(
    ("languages", "words"),
    [
        ((), ""),
        (("python",), "Python"),
        (("c", "matlab", "fmu", "executable"), "C, MATLAB, an FMU or a Linux executable"),
    ],
)
def test_the_form_says_in_words_what_a_program_can_be(languages: list[str], words: str) -> None:
    assert kinds(languages) == words
