"""Further programs in the form: sent as files, kept with errors, taken from a run."""

import io
import re

import pytest
from sqlalchemy import func, select
from werkzeug.test import TestResponse

from seamark.server.database.tables import Run
from tests.part_programs import BENCHMARK, C_DETECTOR, TRACKER
from tests.server.pages.conftest import Site

pytestmark = pytest.mark.slow

FORM = f"/submit/{BENCHMARK}"


def file(content: bytes, name: str) -> tuple[io.BytesIO, str]:
    return io.BytesIO(content), name


def sent(site: Site, who: str = "ann", **answers: object) -> TestResponse:
    return site.browser(who).post(FORM, {"controller": "chain"} | answers)


def run_of(answer: TestResponse) -> int:
    assert answer.status_code == 303, answer.text
    return int(answer.headers["Location"].rpartition("/")[2])


def parts_of(site: Site, answer: TestResponse) -> dict[str, str | None]:
    return {part.role: part.program_name for part in site.show(run_of(answer)).parts}


def kept_in(page: str, role: str) -> str:
    found = re.search(rf'name="kept_{role}_program" value="([^"]+)"', page)
    assert found is not None, page
    return found[1]


def error_in(page: str, role: str) -> str:
    found = re.search(rf'id="{role}_program-error">([^<]+)<', page)
    assert found is not None, page
    return found[1]


def test_only_the_form_of_a_benchmark_with_parts_asks_for_them(site: Site) -> None:
    browser = site.browser("ann")

    page, other = browser.get(FORM).text, browser.get("/submit/currents-v2").text

    for role in ("tracker", "detector"):
        assert f'<label for="{role}_program">Your own {role}</label>' in page
        assert f"{role}_program" not in other


def test_a_built_in_controller_runs_with_the_parts_of_the_form(site: Site) -> None:
    answer = sent(
        site,
        tracker_program=file(TRACKER, "follow.py"),
        detector_program=file(C_DETECTOR, "find.c"),
    )

    assert parts_of(site, answer) == {"detector": "find.c", "tracker": "follow.py"}


def test_a_run_without_files_has_no_parts(site: Site) -> None:
    assert parts_of(site, sent(site)) == {}


def test_a_part_that_is_wrong_is_explained_at_its_field_and_nothing_starts(site: Site) -> None:
    answer = sent(site, tracker_program=file(b"def f(", "follow.py"), kp="99")

    assert answer.status_code == 422
    assert "follow.py, line 1" in error_in(answer.text, "tracker")
    assert 'id="kp-error"' in answer.text
    with site.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(Run)) == 0


def test_a_part_is_kept_when_another_field_is_invalid_until_its_mark_is_removed(
    site: Site,
) -> None:
    page = sent(site, tracker_program=file(TRACKER, "follow.py"), kp="99").text

    assert "<strong>follow.py</strong>" in page
    kept = kept_in(page, "tracker")
    assert parts_of(site, sent(site, kept_tracker_program=kept)) == {"tracker": "follow.py"}
    assert parts_of(site, sent(site)) == {}


def test_a_kept_part_is_its_senders_and_of_its_role(site: Site) -> None:
    kept = kept_in(sent(site, tracker_program=file(TRACKER, "a.py"), kp="99").text, "tracker")

    for who, role, text in (
        ("ben", "tracker", kept),
        ("ann", "detector", kept),
        ("ann", "tracker", kept[:-2] + "xx"),
    ):
        answer = sent(site, who, **{f"kept_{role}_program": text})
        assert answer.status_code == 422
        assert f"Choose the file of your {role} again." in error_in(answer.text, role)


def test_guests_have_no_field_for_a_part_and_may_not_send_one(site: Site) -> None:
    page = site.browser().get(FORM).text
    assert 'type="file" id="tracker_program"' not in page
    assert "needs an account" in page

    answer = sent(site, "stranger", tracker_program=file(TRACKER, "a.py"))

    assert answer.status_code == 422
    assert "Uploading a tracker needs an account." in answer.text


def test_the_form_of_a_run_has_its_parts_again(site: Site) -> None:
    run_id = run_of(sent(site, tracker_program=file(TRACKER, "follow.py")))

    page = site.browser("ann").get(f"{FORM}?from={run_id}").text

    answer = sent(site, kept_tracker_program=kept_in(page, "tracker"))
    assert parts_of(site, answer) == {"tracker": "follow.py"}


def test_the_form_of_somebody_elses_run_says_that_its_parts_are_not_there(site: Site) -> None:
    tracker = {"tracker": site.store_program(TRACKER, "follow.py", "tracker")}
    run_id = site.succeeded("eva", benchmark=BENCHMARK, controller="chain", parts=tracker)
    site.publish(run_id, method="Own eyes", program=False)

    page = site.browser("ann").get(f"{FORM}?from={run_id}").text

    assert "It does not have its own tracker: only its owner may read it." in page


def test_the_page_of_a_run_names_the_programs_and_links_their_sources(site: Site) -> None:
    run_id = run_of(
        sent(
            site,
            tracker_program=file(TRACKER, "follow.py"),
            detector_program=file(C_DETECTOR, "find.c"),
        )
    )

    page = site.browser("ann").get(f"/runs/{run_id}").text

    assert "Built-in chain: search, recognise, recover, return + own detector + own tracker" in page
    assert f'href="/api/v1/runs/{run_id}/parts/tracker"><bdi>follow.py</bdi>' in page
    assert f'href="/api/v1/runs/{run_id}/parts/detector"><bdi>find.c</bdi>' in page
