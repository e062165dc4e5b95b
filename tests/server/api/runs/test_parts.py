"""Programs in further roles in the API: sent with runs and sweeps, shown, downloaded."""

import io
import json
import zipfile
from typing import Any

import pytest
from werkzeug.test import TestResponse

from tests.cast import PROGRAM
from tests.part_programs import BENCHMARK, C_DETECTOR, DETECTOR, TRACKER
from tests.server.api.conftest import Site
from tests.server.api.test_api import RUNS, problem_of

RUN = {"benchmark": BENCHMARK, "controller": "chain"}
FILES = {"tracker_program": ("follow.py", TRACKER), "detector_program": ("find.c", C_DETECTOR)}


def form_of(run: dict[str, Any], files: dict[str, tuple[str, bytes]]) -> dict[str, Any]:
    """Return a form in bytes: werkzeug's test client leaves the file of a large one open."""
    parts = {"run": ("", json.dumps(run).encode())} | files
    body = b""
    for name, (file, content) in parts.items():
        named = f'; filename="{file}"' if file else ""
        head = f'--x\r\nContent-Disposition: form-data; name="{name}"{named}\r\n\r\n'
        body += head.encode() + content + b"\r\n"
    return {"data": body + b"--x--\r\n", "content_type": "multipart/form-data; boundary=x"}


def sent(
    site: Site,
    files: dict[str, tuple[str, bytes]] = FILES,
    *,
    role: str = "owner",
    path: str = RUNS,
    headers: dict[str, str] | None = None,
    **run: Any,
) -> TestResponse:
    return site.call(role, "POST", path, **form_of(RUN | run, files), headers=headers or {})


def number_of(answer: TestResponse) -> int:
    assert answer.status_code == 202, answer.get_data(as_text=True)
    return int(answer.get_json()["id"])


def fields_of(problem: dict[str, Any]) -> dict[str, str]:
    """Return field -> sentence."""
    return {one["field"]: one["detail"] for one in problem["errors"]}


def test_a_run_lists_its_parts_beside_a_built_in_controller(site: Site) -> None:
    run = sent(site).get_json()

    shown = [(part["role"], part["program_name"], part["language"]) for part in run["parts"]]
    assert shown == [("detector", "find.c", "c"), ("tracker", "follow.py", "python")]
    assert all(len(part["program_sha256"]) == 64 for part in run["parts"])
    assert (run["controller"], run["program_name"]) == ("chain", None)


def test_an_uploaded_controller_may_have_parts_too(site: Site) -> None:
    files = FILES | {"program": ("steer.py", PROGRAM)}

    run = sent(site, files, controller=None).get_json()

    assert (run["controller"], run["program_name"], len(run["parts"])) == ("upload", "steer.py", 2)


def test_all_runs_of_a_sweep_have_the_parts(site: Site) -> None:
    sweep = [{"name": "kp", "values": [0.4, 0.5]}]

    answer = sent(site, path="/api/v1/sweeps", sweep=sweep)

    assert answer.status_code == 202, answer.get_data(as_text=True)
    assert [len(cell["run"]["parts"]) for cell in answer.get_json()["cells"]] == [2, 2]


@pytest.mark.parametrize(
    ("files", "changes", "field", "sentence"),
    [
        (FILES, {"benchmark": "currents-v2", "controller": "pi"}, "tracker_program", "takes no"),
        ({"tracker_program": ("a.py", b"def f(")}, {}, "tracker_program", "line 1"),
        ({"tracker_program": ("a.py", PROGRAM)}, {}, "tracker_program", "Tracker"),
        ({"detector_program": ("a.txt", b"x")}, {}, "detector_program", "is not a type of program"),
        ({"detector_program": ("model.fmu", b"PK")}, {}, "detector_program", "model.fmu"),
        ({"detector_program": ("find.py", b"")}, {}, "detector_program", "is empty"),
    ],
)
def test_a_part_that_is_wrong_is_a_problem_of_its_field(
    site: Site,
    files: dict[str, tuple[str, bytes]],
    changes: dict[str, Any],
    field: str,
    sentence: str,
) -> None:
    answer = sent(site, files, **changes)

    assert answer.content_type == "application/problem+json"
    assert sentence in fields_of(answer.get_json())[field]


def test_each_part_has_the_limit_of_a_program(site: Site) -> None:
    large = b"#" * (site.settings.upload_max_bytes + 1)

    assert sent(site, {"tracker_program": ("a.py", large)}).status_code == 413


def test_guests_may_not_send_parts(site: Site) -> None:
    problem = problem_of(sent(site, role="guest"), 403, "account-needed")

    assert fields_of(problem).keys() == {"tracker_program"}


def test_a_check_is_of_one_program(site: Site) -> None:
    answer = sent(
        site, FILES | {"program": ("a.py", PROGRAM)}, path="/api/v1/checks", controller=None
    )

    assert "A check is of one program alone" in answer.get_data(as_text=True)


def test_a_repeated_submission_with_another_part_is_another_request(site: Site) -> None:
    key = {"Idempotency-Key": "k"}
    first = number_of(sent(site, headers=key))

    assert number_of(sent(site, headers=key)) == first
    other = FILES | {"tracker_program": ("follow.py", TRACKER + b"# other\n")}
    assert sent(site, other, headers=key).status_code == 422


def test_the_source_of_a_part_is_for_whom_may_see_the_program(site: Site) -> None:
    run_id = number_of(sent(site))
    address = f"{RUNS}/{run_id}/parts"

    file = site.call("owner", "GET", f"{address}/tracker")
    assert (file.status_code, file.data) == (200, TRACKER)
    assert "follow.py" in file.headers["Content-Disposition"]
    assert site.call("owner", "GET", f"{address}/detector").data == C_DETECTOR
    for role in ("other", "guest"):
        assert site.call(role, "GET", f"{address}/tracker").status_code == 404
    assert site.call("owner", "GET", f"{address}/controller").status_code == 422
    assert site.call("owner", "GET", f"{RUNS}/{run_id}/program").status_code == 404


@pytest.mark.parametrize(("program", "status"), [(True, 200), (False, 403)])
def test_publication_shows_parts_as_it_shows_the_program(
    site: Site, program: bool, status: int
) -> None:
    run_id = number_of(sent(site))
    claim = site.claim(languages=("python", "c"))
    assert claim is not None
    assert site.finish(claim)
    site.publish(run_id, method="Own eyes", program=program)

    assert site.call("guest", "GET", f"{RUNS}/{run_id}/parts/tracker").status_code == status
    assert site.call("owner", "GET", f"{RUNS}/{run_id}/parts/tracker").status_code == 200


def test_a_run_without_a_part_says_so(site: Site) -> None:
    run_id = number_of(sent(site, {"detector_program": ("find.py", DETECTOR)}))

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/parts/tracker")

    assert answer.status_code == 404
    assert "has no uploaded tracker" in answer.get_data(as_text=True)


def test_the_export_of_an_account_has_the_parts(site: Site) -> None:
    run_id = number_of(sent(site))

    data = site.call("owner", "GET", "/api/v1/me/data.zip").data

    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.read(f"runs/{run_id}/parts/tracker/follow.py") == TRACKER
