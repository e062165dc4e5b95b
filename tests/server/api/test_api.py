"""Orders, refusals, problem documents, ETags, events and data of the HTTP interface."""

import io
import json
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.server.runs.data.downsampling import downsample
from seamark.sim import registry
from seamark.sim.recording.telemetry import COLUMNS, NAMES
from tests.cast import PROGRAM
from tests.server.api.conftest import Site
from tests.telemetry_csv import read

RUNS = "/api/v1/runs"


def problem_of(answer: Any, status: int, slug: str) -> dict[str, Any]:
    assert answer.status_code == status
    assert answer.content_type == "application/problem+json"
    document: dict[str, Any] = json.loads(answer.data)
    assert document["type"] == f"/problems/{slug}"
    assert document["status"] == status
    return document


def form_of(source: bytes) -> dict[str, Any]:
    """Return a form in bytes: werkzeug's test client leaves the file of a large one open."""
    part = 'Content-Disposition: form-data; name="{}"{}\r\n\r\n'
    run = part.format("run", "") + '{"benchmark": "currents-v1"}'
    program = part.format("program", '; filename="c.py"').encode() + source
    body = b"--x\r\n" + run.encode() + b"\r\n--x\r\n" + program + b"\r\n--x--\r\n"
    return {"data": body, "content_type": "multipart/form-data; boundary=x"}


def events_of(text: str) -> list[tuple[str, str]]:
    found = []
    for block in text.split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if ": " in line)
        if "event" in fields:
            found.append((fields.get("id", ""), fields["event"]))
    return found


@pytest.mark.parametrize(("text", "field"), [("NaN", "kp"), ("-1", "kp"), ("1e999", "ki")])
def test_an_invalid_gain_is_refused_under_its_name(site: Site, text: str, field: str) -> None:
    body = f'{{"benchmark": "currents-v1", "controller": "pi", "config": {{"{field}": {text}}}}}'

    answer = site.call("owner", "POST", RUNS, data=body, content_type="application/json")

    document = problem_of(answer, 422, "invalid-configuration")
    assert [error["field"] for error in document["errors"]] == [field]
    assert "from 0 to" in document["errors"][0]["detail"]


def test_a_file_of_a_vehicle_is_refused_with_where_it_can_be_used(
    site: Site, tmp_path: Path
) -> None:
    mine = tmp_path / "mine.toml"
    text = registry.VEHICLES["bluerov2-heavy"].read_text("utf-8")
    mine.write_text(text.replace('"bluerov2-heavy"', '"mine"'), encoding="utf-8")
    order = {"benchmark": "currents-v2", "controller": "pi", "config": {"vehicle": str(mine)}}

    answer = site.call("owner", "POST", RUNS, json=order)

    document = problem_of(answer, 422, "invalid-configuration")
    (error,) = document["errors"]
    assert error["field"] == "vehicle"
    assert "A vehicle of your own is chosen by its file" in error["detail"]


@pytest.mark.slow
def test_an_upload_is_queued_under_its_hash(site: Site) -> None:
    source = PROGRAM
    form = {"run": '{"benchmark": "currents-v1"}', "program": (io.BytesIO(source), "c.py")}

    answer = site.call("owner", "POST", RUNS, data=form)

    assert answer.status_code == 202
    assert answer.get_json()["program_name"] == "c.py"
    assert site.call("owner", "GET", answer.headers["Location"] + "/program").data == source


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "status", "slug"),
    [
        (b"class Controller(:\n", 422, "upload-rejected"),
        (b"x = 1\n", 422, "upload-rejected"),
        (b"#" * (3 * 2**20), 413, "payload-too-large"),
    ],
)
def test_an_invalid_program_is_refused_and_not_queued(
    site: Site, source: bytes, status: int, slug: str
) -> None:
    answer = site.call("owner", "POST", RUNS, **form_of(source))

    problem_of(answer, status, slug)
    assert site.call("owner", "GET", RUNS).get_json()["runs"] == []


def test_an_exceeded_quota_is_a_429_with_retry_after(site: Site) -> None:
    for _ in range(site.settings.quota_live):
        site.queue()

    answer = site.call("owner", "POST", RUNS, json={"benchmark": "currents-v1", "controller": "p"})

    problem_of(answer, 429, "quota-exceeded")
    assert int(answer.headers["Retry-After"]) > 0


def test_the_list_of_tokens_says_which_of_them_are_used(site: Site) -> None:
    before = time.time()
    site.call("owner", "GET", RUNS)

    tokens = site.call("owner", "GET", "/api/v1/tokens").get_json()["tokens"]

    used = {token["name"]: token["last_used_at"] for token in tokens}
    assert before <= used.pop("owner") <= time.time()
    assert set(used.values()) <= {None}


def test_a_cookie_without_the_csrf_token_changes_nothing(site: Site) -> None:
    browser = site.client()
    order = {"benchmark": "currents-v1", "controller": "p"}
    address = browser.post(RUNS, json=order).headers["Location"]

    problem_of(browser.post(f"{address}/cancel"), 403, "csrf")
    secret = browser.get("/api/v1/me").get_json()["csrf_token"]
    cancelled = browser.post(f"{address}/cancel", headers={"X-CSRFToken": secret})

    assert cancelled.get_json()["state"] == "cancelled"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "path", "options", "status", "slug"),
    [
        ("GET", "/api/v1/nothing", {}, 404, "not-found"),
        ("GET", f"{RUNS}/abc", {}, 404, "not-found"),
        ("GET", "/api/v1/benchmarks/none", {}, 404, "not-found"),
        ("DELETE", RUNS, {}, 405, "method-not-allowed"),
        ("POST", RUNS, {"data": "x", "content_type": "text/plain"}, 415, "unsupported-media-type"),
        ("POST", RUNS, {"data": "{", "content_type": "application/json"}, 400, "bad-request"),
        ("POST", RUNS, {"json": {}}, 422, "invalid-request"),
        ("POST", RUNS, {"json": {"benchmark": "x", "controller": "p"}}, 422, "invalid-request"),
        ("GET", f"{RUNS}?limit=0", {}, 422, "invalid-request"),
        ("GET", "/api/v1/leaderboards/currents-v1?after=x", {}, 422, "invalid-request"),
    ],
)
def test_every_refusal_is_a_problem_document_with_a_page(
    site: Site, method: str, path: str, options: dict[str, Any], status: int, slug: str
) -> None:
    answer = site.call("owner", method, path, **options)

    document = problem_of(answer, status, slug)
    assert site.client().get(document["type"]).status_code == 200
    assert (answer.status_code == 405) == ("Allow" in answer.headers)


def test_an_unchanged_run_is_not_sent_twice(site: Site) -> None:
    path = f"{RUNS}/{site.queue()}"
    first = site.call("owner", "GET", path)

    same = site.call("owner", "GET", path, headers={"If-None-Match": first.headers["ETag"]})
    site.call("owner", "POST", f"{path}/cancel")
    changed = site.call("owner", "GET", path, headers={"If-None-Match": first.headers["ETag"]})

    assert (same.status_code, same.data) == (304, b"")
    assert "Retry-After" in first.headers
    assert changed.get_json()["state"] == "cancelled"
    assert "Retry-After" not in changed.headers


def test_the_pages_of_a_list_hold_each_run_once_in_order(site: Site) -> None:
    made = [site.queue() for _ in range(5)]

    first = site.call("owner", "GET", f"{RUNS}?limit=3").get_json()
    second = site.call("owner", "GET", f"{RUNS}?limit=3&after={first['next']}").get_json()

    listed = [run["id"] for run in first["runs"] + second["runs"]]
    assert listed == made[::-1]
    assert second["next"] is None


def test_the_hidden_seeds_of_a_ranked_run_are_never_shown(site: Site) -> None:
    run_id = site.succeeded(kind="ranked")

    shown = [
        site.call("owner", "GET", f"{RUNS}/{run_id}{part}").text
        for part in ("", "/manifest.json", "/telemetry.csv", "/config.json")
    ]

    assert json.loads(shown[0])["seed"] is None
    assert json.loads(shown[1]) == {"seed": None, "trials": [{"seed": None}]}
    assert "seed hidden" in shown[2]


def test_the_seeds_of_a_ranked_run_on_fresh_water_are_disclosed(site: Site) -> None:
    run_id = site.succeeded(kind="ranked", benchmark="currents-v2")

    manifest, csv = (
        site.call("owner", "GET", f"{RUNS}/{run_id}/{name}")
        for name in ("manifest.json", "telemetry.csv")
    )

    assert manifest.get_json() == {"seed": 7, "trials": [{"seed": 9}]}
    assert "seed of each trial in manifest.json" in csv.text


def test_a_run_that_does_not_rank_says_why(site: Site) -> None:
    claim = site.running(kind="ranked")
    metrics = {"score": 1.0, "rankable": False, "not_ranked": "Trial 1: It drove away."}
    site.finish(claim, metrics=metrics)

    run = site.call("owner", "GET", f"{RUNS}/{claim.run_id}").get_json()

    assert run["not_ranked"] == "Trial 1: It drove away."


def test_a_benchmark_with_fresh_trials_says_how_many_there_are(site: Site) -> None:
    first, second = (
        site.call("owner", "GET", f"/api/v1/benchmarks/currents-{version}").get_json()
        for version in ("v1", "v2")
    )

    assert (first["protocol"], first["ranked_trials"]) == (None, 10)
    protocol = second["protocol"]
    assert second["ranked_trials"] == protocol["reference_trials"] + protocol["fresh_trials"]


def test_events_resume_after_the_last_event_id_or_after_the_parameter(site: Site) -> None:
    run_id = site.recorded()
    path = f"{RUNS}/{run_id}/events"
    (telemetry_id, _), *later = events_of(site.call("owner", "GET", path).text)

    by_header = site.call("owner", "GET", path, headers={"Last-Event-ID": telemetry_id})
    by_parameter = site.call("owner", "GET", f"{path}?after={telemetry_id}")
    header_counts = site.call(
        "owner", "GET", f"{path}?after=1-0-0", headers={"Last-Event-ID": telemetry_id}
    )

    assert [event_type for _, event_type in later] == ["log", "state", "end"]
    assert events_of(by_header.text) == later
    assert events_of(by_parameter.text) == later
    assert events_of(header_counts.text) == later


def test_the_stream_of_a_live_run_begins_with_its_state(site: Site) -> None:
    run_id = site.queue()

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/events")

    assert answer.text.startswith("retry: 2000\n\nevent: state\ndata: ")
    assert '"viewers": 1' in answer.text


def test_the_events_of_an_ended_run_are_replayed_from_its_files(site: Site) -> None:
    run_id = site.recorded()

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/events")

    types = [event_type for _, event_type in events_of(answer.text)]
    assert answer.content_type.startswith("text/event-stream")
    assert types == ["telemetry", "log", "state", "end"]


def test_a_stream_beyond_the_limit_is_refused(site: Site) -> None:
    path = f"{RUNS}/{site.queue()}/events"
    site.services.streams.open_streams = site.settings.streams_max

    refused = site.call("owner", "GET", path)
    site.services.streams.open_streams -= 1

    problem_of(refused, 503, "streams-full")
    assert refused.headers["Retry-After"]
    assert site.call("owner", "GET", path).status_code == 200


def test_telemetry_is_the_same_in_every_format_while_the_run_is_running(site: Site) -> None:
    run_id = site.queue_program()
    site.record(run_id, rows=700)
    path = f"{RUNS}/{run_id}"

    names, table = read(site.call("owner", "GET", f"{path}/telemetry.csv").text)
    plain = site.call("owner", "GET", f"{path}/telemetry.f64")
    binary = np.frombuffer(plain.data, "<f8")
    later = site.call("owner", "GET", f"{path}/telemetry.csv?start=690")

    assert (tuple(names), len(table)) == (NAMES, 700)
    assert np.array_equal(table.ravel(), binary)
    assert plain.headers["X-Columns"].split(",") == [one.name for one in COLUMNS]
    assert plain.headers["X-Units"].split(",") == [one.unit for one in COLUMNS]
    assert np.array_equal(read(later.text)[1], table[690:])
    assert later.headers["X-Next-Row"] == "700"


@pytest.mark.slow
def test_the_log_is_read_from_an_offset(site: Site) -> None:
    path = f"{RUNS}/{site.recorded()}/log"

    first = site.call("owner", "GET", path)
    rest = site.call("owner", "GET", f"{path}?after={first.headers['X-Next-Offset']}")

    assert first.text == "hello from the program\n"
    assert rest.text == ""


@given(
    values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=400),
    max_points=st.integers(2, 60),
)
def test_thinning_keeps_the_extremes_and_at_most_the_requested_points(
    values: list[float], max_points: int
) -> None:
    column = np.array(values)[:, np.newaxis]
    t = np.arange(len(values), dtype=float)

    times, thinned = downsample(t, column, max_points)

    assert len(times) == len(thinned) <= max(max_points, 2)
    assert (np.diff(times) >= 0).all()
    assert (thinned.min(), thinned.max()) == (column.min(), column.max())


def test_a_published_ranked_run_is_on_the_leaderboard_as_json_and_csv(site: Site) -> None:
    run_id = site.succeeded(kind="ranked", title="=1+1")
    assert site.call("owner", "POST", f"{RUNS}/{run_id}/publish").status_code == 200
    path = "/api/v1/leaderboards/currents-v1"

    as_json = site.call("guest", "GET", path).get_json()
    as_csv = site.call("guest", "GET", path, headers={"Accept": "text/csv"}).text

    assert [(row["user"], row["run"]) for row in as_json["ranks"]] == [("ann", run_id)]
    assert as_csv.splitlines()[0].startswith("rank,rank_low,rank_high,user")
    assert "'=1+1" in as_csv  # no spreadsheet may calculate a title


def test_the_service_is_alive_but_not_ready_without_a_worker(site: Site) -> None:
    ready = site.client().get("/readyz")

    assert site.client().get("/healthz").status_code == 200
    assert ready.status_code == 503
    assert ready.get_json()["checks"] == {
        "database": "ok",
        "broker": "ok",
        "storage": "ok",
        "worker": "no worker is alive",
        "queue": "ok",
    }
    assert 'seamark_runs{state="queued"} 0.0' in site.client().get("/metrics").text


def test_a_failed_run_shows_its_cause(site: Site) -> None:
    detail = {"title": "It stopped", "sentence": "Because.", "remedy": "Mend it."}
    run_id = site.failed(detail)

    shown = site.call("owner", "GET", f"{RUNS}/{run_id}").get_json()

    assert shown["failure"] == {"cause": "user_error", **detail}
    assert shown["state"] == "failed"


def test_a_data_set_holds_an_image_for_every_selected_row(site: Site) -> None:
    run_id = site.recorded()

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip?every=10&begin=0.5")

    with zipfile.ZipFile(io.BytesIO(answer.data)) as file:
        names = [name for name in file.namelist() if "/images/" in name]
        assert file.testzip() is None
    assert len(names) == 3  # rows at 0.5, 1.0 and 1.5 s of 2 s


@pytest.mark.parametrize(
    ("query", "status", "slug"),
    [
        ("every=0", 422, "invalid-request"),
        ("begin=9", 404, "not-found"),
        ("trial=3", 404, "not-found"),
    ],
)
def test_a_data_set_without_images_is_refused(
    site: Site, query: str, status: int, slug: str
) -> None:
    answer = site.call("owner", "GET", f"{RUNS}/{site.recorded()}/dataset.zip?{query}")

    problem_of(answer, status, slug)


def test_a_data_set_has_no_more_images_than_the_web_server_renders(site: Site) -> None:
    run_id = site.recorded()
    site.record(run_id, rows=2000)

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip?every=1")

    assert "2040 images" in problem_of(answer, 422, "invalid-request")["detail"]
