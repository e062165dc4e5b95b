"""The form of an earlier run: one button that keeps program, configuration and seed."""

import io
import re
from html.parser import HTMLParser

import pytest
from sqlalchemy import update

from seamark.server.classes import assignments
from seamark.server.database.class_tables import Assignment
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing.views import RunView
from tests.server.classes.class_cast import assign, classroom, hand_in
from tests.server.pages.conftest import Site

FORM = "/submit/currents-v1"


class _Fields(HTMLParser):
    """What a browser would post without any change: inputs, selected options, text areas."""

    def __init__(self) -> None:
        super().__init__()
        self.values: dict[str, str] = {}
        self._select = self._area = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        name = given.get("name") or ""
        if tag == "select":
            self._select = name
        elif tag == "option" and "selected" in given:
            self.values[self._select] = given.get("value") or ""
        elif tag == "textarea":
            self._area = name
            self.values[name] = ""
        elif tag == "input" and name and given.get("type") != "file":
            checkable = given.get("type") in {"radio", "checkbox"}
            if not checkable or "checked" in given:
                self.values[name] = given.get("value") or "on"
            if not checkable:
                self.values[name] = given.get("value") or ""

    def handle_endtag(self, tag: str) -> None:
        if tag == "textarea":
            self._area = ""

    def handle_data(self, data: str) -> None:
        if self._area:
            self.values[self._area] += data


def _form(site: Site, run_id: int, who: str) -> dict[str, str]:
    page = site.browser(who).get(f"{FORM}?from={run_id}")
    assert page.status_code == 200
    start = page.text.index('id="run-form"')
    fields = _Fields()
    fields.feed(page.text[start : page.text.index("</form>", start)])
    del fields.values["csrf_token"]
    # Browsers ignore the first line break of a text area.
    fields.values["program_text"] = fields.values.get("program_text", "").removeprefix("\n")
    return fields.values


def _started(site: Site, run_id: int, who: str = "ann", **changes: str) -> RunView:
    """Open the form of a run, change fields and start it."""
    answer = site.browser(who).post(FORM, _form(site, run_id, who) | changes)
    assert answer.status_code == 303, re.findall(r'class="error[^>]*>[^<]*', answer.text)
    return site.show(int(answer.headers["Location"].rsplit("/", 1)[-1]))


def _same(old: RunView, new: RunView) -> bool:
    kept = ("kind", "config", "seed", "trials", "controller", "program_sha256", "language")
    return all(getattr(old, name) == getattr(new, name) for name in kept)


def test_a_built_in_controller_runs_again_with_its_settings_and_seed(site: Site) -> None:
    first = site.queue("ann", controller="p", config={"kp": 0.4}, seed=11, trials=3)

    again = _started(site, first)

    assert _same(site.show(first), again)
    assert again.rerun_of == first


def test_an_uploaded_program_runs_again_without_choosing_it_again(site: Site) -> None:
    first = site.queue_program("ann", config={"kp": 0.4}, seed=11)

    again = _started(site, first)

    assert _same(site.show(first), again)
    assert again.program_name == "mine.py"


@pytest.mark.slow
def test_one_setting_can_be_changed_and_the_rest_stays(site: Site) -> None:
    first = site.queue_program("ann", config={"kp": 0.4, "ki": 0.01}, seed=11)

    again = _started(site, first, kp="0.7")

    assert (again.config["kp"], again.config["ki"], again.seed) == (0.7, 0.01, 11)


@pytest.mark.slow
def test_a_program_that_was_written_in_the_editor_opens_there(site: Site) -> None:
    browser = site.browser("ann")
    source = "class Controller:\n    def __init__(self, config): ...\n    def step(self, o): ...\n"
    typed = {"controller": "upload", "source": "editor", "language": "python"}
    first = browser.post(FORM, typed | {"program_text": source}).headers["Location"]
    first_id = int(first.rsplit("/", 1)[-1])

    fields = _form(site, first_id, "ann")
    again = _started(site, first_id)

    assert (fields["source"], fields["program_text"]) == ("editor", source)
    assert _same(site.show(first_id), again)


def test_a_ranked_run_runs_again_as_a_ranked_one(site: Site) -> None:
    first = site.queue_program("ann", kind="ranked", benchmark="currents-v1")

    again = _started(site, first)

    assert again.kind is RunKind.RANKED
    assert _same(site.show(first), again)


def test_a_published_run_of_somebody_else_gives_its_program_to_an_account(site: Site) -> None:
    first = site.published("eva", controller="upload", program=site.store_program(), seed=5)

    again = _started(site, first, "ben")

    assert _same(site.show(first), again)


@pytest.mark.slow
def test_a_guest_gets_the_configuration_alone_and_is_told_so(site: Site) -> None:
    program = site.store_program()
    first = site.published("eva", controller="upload", program=program, config={"kp": 0.4}, seed=5)

    page = site.browser().get(f"{FORM}?from={first}").text
    again = _started(site, first, "stranger")

    assert "but not its program: uploading one needs an account" in page
    assert (again.config["kp"], again.seed, again.controller) == (0.4, 5, "pi")


def test_a_private_run_of_somebody_else_fills_in_nothing(site: Site) -> None:
    first = site.queue("ann", config={"kp": 0.4})

    again = _started(site, first, "ben")
    forged = site.browser("ben").post(FORM, {"controller": "pi", "from": str(first)})

    assert again.config["kp"] != 0.4
    assert site.show(int(forged.headers["Location"].rsplit("/", 1)[-1])).rerun_of is None


@pytest.mark.slow
def test_an_upload_replaces_the_program_of_the_earlier_run(site: Site) -> None:
    first = site.queue_program("ann")
    source = b"class Controller:\n    def __init__(self, c): ...\n    def step(self, o): ...\n"

    fields = _form(site, first, "ann")
    answer = site.browser("ann").post(
        FORM, fields | {"source": "file", "program": (io.BytesIO(source), "new.py")}
    )

    again = site.show(int(answer.headers["Location"].rsplit("/", 1)[-1]))
    assert (again.program_name, again.rerun_of) == ("new.py", first)


WITH_PARAMETERS = b"""
PARAMETERS = {"gain": {"default": 0.5, "range": [0, 2], "unit": "1/s"}, "kp": 1.0}
class Controller:
    def __init__(self, config): ...
    def step(self, observation): ...
"""


def test_parameters_of_the_program_are_in_the_form_and_part_of_the_configuration(
    site: Site,
) -> None:
    program = site.store_program(WITH_PARAMETERS)
    first = site.queue("ann", controller="upload", program=program, config={"gain": 1.5})

    fields = _form(site, first, "ann")
    again = _started(site, first, **{"parameters.gain": "0.25"})

    assert (fields["parameters.gain"], fields["parameters.kp"]) == ("1.5", "1")
    assert again.config["parameters"] == {"gain": 0.25, "kp": 1.0}
    assert again.config["kp"] == site.show(first).config["kp"] != 1.0  # the benchmark's own
    assert again.submission == site.show(first).submission


def test_a_parameter_out_of_range_is_marked_at_its_field(site: Site) -> None:
    first = site.queue("ann", controller="upload", program=site.store_program(WITH_PARAMETERS))

    fields = _form(site, first, "ann") | {"parameters.gain": "7"}
    answer = site.browser("ann").post(FORM, fields)

    assert answer.status_code == 422
    assert 'id="parameters.gain-error"' in answer.text
    assert 'value="7"' in answer.text


def test_a_built_in_controller_has_no_parameters_of_a_program(site: Site) -> None:
    first = site.queue("ann", controller="upload", program=site.store_program(WITH_PARAMETERS))

    again = _started(site, first, controller="pi")

    assert "parameters" not in again.config


def test_run_again_keeps_the_assignment_while_it_is_open(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann"), config={"levels": [0.1, 0.2]})
    first = hand_in(site, "ann", assignment, config={"kp": 0.7}, seed=5)

    again = _started(site, first)

    with site.database.writing() as session:
        handed_in = assignments.of_run(session, again.id)
        assert handed_in is not None
        session.execute(update(Assignment).values(deadline=1.0))
    assert handed_in.id == assignment
    assert _same(site.show(first), again)
    assert "assignment" not in _form(site, first, "ann")


def test_run_again_of_a_classmates_run_hands_nothing_in(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann", "ben"))
    run_id = hand_in(site, "ann", assignment)
    assert site.finish(site.claim_next())
    site.publish(run_id)

    assert "assignment" not in _form(site, run_id, "ben")


def test_a_run_names_its_assignment_to_its_owner_and_the_teacher_alone(site: Site) -> None:
    assignment = assign(site, classroom(site, "ann", "ben"), title="Hold <still>")
    run_id = hand_in(site, "ann", assignment)
    assert site.finish(site.claim_next())
    site.publish(run_id)
    link = f'for the assignment <a href="/assignments/{assignment}"><bdi>Hold &lt;still&gt;</bdi>'

    pages = {
        who: site.browser(who).get(f"/runs/{run_id}").text
        for who in ("ann", "tim", "ben", "stranger")
    }

    assert [who for who, page in pages.items() if link in page] == ["ann", "tim"]
    assert [who for who, page in pages.items() if "Hold &lt;still" in page] == ["ann", "tim"]
