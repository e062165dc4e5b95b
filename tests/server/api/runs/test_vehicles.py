"""Vehicles of users in the API: checked, sent with runs, sweeps and checks, downloaded."""

import hashlib
import io
import json
import zipfile
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from werkzeug.test import TestResponse

from seamark.server.database.tables import Check, Run
from seamark.server.pages.run.player_data import player_data
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.submission.validation import RANKED_VEHICLE
from seamark.sim.recording.telemetry import COMMON_THRUSTERS, INDEX, width_for
from tests.cast import PROGRAM, VEHICLE
from tests.server.api.conftest import Site
from tests.server.api.test_api import RUNS, problem_of
from tests.sim.vehicles.hostile_files import HOSTILE

pytestmark = pytest.mark.slow

NAME = f"mine@{hashlib.sha256(VEHICLE.encode()).hexdigest()[:16]}"
PRACTICE = {"benchmark": "currents-v2", "controller": "pi"}
IMPOSSIBLE = (
    VEHICLE
    + """
[sources]
scale = "kitchen scale"

[body]
inertia = { value = [1.0, 1.0, 9.0], unit = "kg m²", tag = "M", source = "scale" }
"""
)


def form_of(**parts: str | bytes) -> dict[str, Any]:
    """Return a form in bytes: werkzeug's test client leaves the file of a large one open."""
    body = b""
    for name, content in parts.items():
        file = "" if name == "run" else f'; filename="{"c.py" if name == "program" else "my.toml"}"'
        head = f'--x\r\nContent-Disposition: form-data; name="{name}"{file}\r\n\r\n'
        body += head.encode() + (content.encode() if isinstance(content, str) else content)
        body += b"\r\n"
    return {"data": body + b"--x--\r\n", "content_type": "multipart/form-data; boundary=x"}


def sent(
    site: Site, path: str = RUNS, *, role: str = "owner", vehicle: str | bytes = VEHICLE, **run: Any
) -> TestResponse:
    """Send a run with a vehicle."""
    return site.call(role, "POST", path, **form_of(run=json.dumps(PRACTICE | run), vehicle=vehicle))


def checked(site: Site, vehicle: str | bytes, *, role: str = "owner") -> TestResponse:
    return site.call(role, "POST", "/api/v1/vehicles/check", **form_of(vehicle=vehicle))


def row_of(site: Site, answer: TestResponse) -> Run:
    assert answer.status_code == 202, answer.get_data(as_text=True)
    with site.database.reading() as session:
        return session.get_one(Run, answer.get_json()["id"])


def test_a_check_says_what_is_wrong_and_what_a_vehicle_can_do(site: Site) -> None:
    good, wrong, unreadable = (checked(site, text) for text in (VEHICLE, IMPOSSIBLE, "format = 2"))

    report = good.get_json()
    assert (report["name"], report["title"], report["errors"]) == (NAME, "Mine", [])
    assert "where a flat plate has 1.17" in report["warnings"][0]
    assert any(line.startswith("full thrust") for line in report["figures"])
    assert report["defaults"] == {"kp": 0.7}
    assert "No distribution of mass has that" in wrong.get_json()["errors"][0]
    assert wrong.get_json()["figures"] == []
    assert "format must be 1" in unreadable.get_json()["errors"][0]
    assert unreadable.get_json()["name"] == ""


def test_a_check_stores_nothing(site: Site) -> None:
    checked(site, VEHICLE)

    assert list((site.settings.data / "programs").glob("*")) == []


def test_a_practice_run_names_the_vehicle_by_its_file_and_gives_it_back(site: Site) -> None:
    answer = sent(site)

    run = row_of(site, answer)
    assert run.config["vehicle"] == NAME
    assert run.vehicle_sha256 == hashlib.sha256(VEHICLE.encode()).hexdigest()
    file = site.call("owner", "GET", f"{RUNS}/{run.id}/vehicle.toml")
    assert (file.status_code, file.data) == (200, VEHICLE.encode())
    assert site.call("other", "GET", f"{RUNS}/{run.id}/vehicle.toml").status_code == 404
    assert site.call("owner", "GET", f"{RUNS}/{run.id}").get_json()["vehicle_sha256"]


def test_a_published_run_publishes_its_vehicle(site: Site) -> None:
    run_id = row_of(site, sent(site)).id
    assert site.finish(site.claim_next())
    assert site.call("guest", "GET", f"{RUNS}/{run_id}/vehicle.toml").status_code == 404

    site.publish(run_id)

    assert site.call("guest", "GET", f"{RUNS}/{run_id}/vehicle.toml").data == VEHICLE.encode()


def test_the_defaults_of_a_vehicle_come_with_it(site: Site) -> None:
    run = row_of(site, sent(site, benchmark="currents-v1"))

    assert run.config["kp"] == 0.7


@pytest.mark.parametrize("config", [{}, {"vehicle": NAME}])
def test_a_vehicle_of_somebody_else_cannot_be_chosen_by_its_name(
    site: Site, config: dict[str, object]
) -> None:
    row_of(site, sent(site, config=config))

    answer = site.call("other", "POST", RUNS, json=PRACTICE | {"config": {"vehicle": NAME}})

    (error,) = problem_of(answer, 422, "invalid-configuration")["errors"]
    assert error["field"] == "vehicle"
    assert "is chosen by its file" in error["detail"]


def test_a_file_and_another_choice_are_not_both_accepted(site: Site) -> None:
    answer = sent(site, config={"vehicle": "girona500"})

    (error,) = problem_of(answer, 422, "invalid-request")["errors"]
    assert (error["field"], "not both" in error["detail"]) == ("vehicle", True)


def test_a_ranked_run_refuses_a_vehicle_with_a_sentence(site: Site) -> None:
    document = problem_of(sent(site, kind="ranked"), 422, "invalid-request")

    assert document["errors"] == [{"field": "vehicle", "detail": RANKED_VEHICLE}]


def test_a_benchmark_without_a_vehicle_refuses_one(site: Site) -> None:
    answer = sent(site, benchmark="visibility-v2", controller="built-in")

    (error,) = problem_of(answer, 422, "invalid-configuration")["errors"]
    assert "vehicle is not a setting of this benchmark" in error["detail"]


def test_guests_send_no_vehicles(site: Site) -> None:
    problem_of(sent(site, role="guest"), 403, "account-needed")
    problem_of(checked(site, VEHICLE, role="guest"), 403, "account-needed")


def test_a_vehicle_that_cannot_exist_is_refused_with_the_error_of_its_check(site: Site) -> None:
    document = problem_of(sent(site, vehicle=IMPOSSIBLE), 422, "upload-rejected")

    assert "No distribution of mass has that" in document["errors"][0]["detail"]
    assert site.call("owner", "GET", RUNS).get_json()["runs"] == []


def test_a_vehicle_with_the_name_of_one_of_ours_is_refused(site: Site) -> None:
    ours = VEHICLE.replace('"mine"', '"girona500"')

    document = problem_of(sent(site, vehicle=ours), 422, "upload-rejected")

    assert "girona500 is a vehicle of Seamark" in document["detail"]


LARGE = ("too large", "a million entries", "a long header, many keys")


@pytest.mark.slow
@pytest.mark.parametrize("attack", [name for name in HOSTILE if name not in LARGE])
def test_a_hostile_file_is_refused_with_a_sentence(site: Site, attack: str) -> None:
    document = problem_of(sent(site, vehicle=HOSTILE[attack]()), 422, "upload-rejected")

    assert document["errors"][0]["field"] == "vehicle"
    assert len(document["detail"]) > 20


@pytest.mark.parametrize("attack", LARGE)
def test_a_large_file_is_refused_before_it_is_read(site: Site, attack: str) -> None:
    problem_of(sent(site, vehicle=HOSTILE[attack]()), 413, "payload-too-large")
    problem_of(checked(site, HOSTILE[attack]()), 413, "payload-too-large")


def test_all_runs_of_a_sweep_have_the_vehicle_unless_they_sweep_it(site: Site) -> None:
    gains = sent(site, "/api/v1/sweeps", sweep=[{"name": "kp", "values": [0.1, 0.2]}])
    vehicles = [NAME, "girona500"]
    swept = sent(site, "/api/v1/sweeps", sweep=[{"name": "vehicle", "values": vehicles}])

    with site.database.reading() as session:
        rows = [
            [session.get_one(Run, cell["run"]["id"]) for cell in answer.get_json()["cells"]]
            for answer in (gains, swept)
        ]
    sha256 = hashlib.sha256(VEHICLE.encode()).hexdigest()
    assert [row.vehicle_sha256 for row in rows[0]] == [sha256, sha256]
    assert [(row.config["vehicle"], row.vehicle_sha256) for row in rows[1]] == [
        (NAME, sha256),
        ("girona500", None),
    ]


def test_a_program_is_checked_with_the_vehicle(site: Site) -> None:
    run = json.dumps({"benchmark": "currents-v2"})
    form = form_of(run=run, vehicle=VEHICLE, program=PROGRAM)
    answer = site.call("owner", "POST", "/api/v1/checks", **form)

    assert answer.status_code == 202, answer.get_data(as_text=True)
    with site.database.reading() as session:
        check = session.get_one(Check, answer.get_json()["id"])
    assert check.config["vehicle"] == NAME
    assert check.vehicle_sha256 == hashlib.sha256(VEHICLE.encode()).hexdigest()


def test_a_run_is_submitted_again_with_its_vehicle(site: Site) -> None:
    run = row_of(site, sent(site))

    again = row_of(site, site.call("owner", "POST", f"{RUNS}/{run.id}/rerun"))

    assert (again.config, again.vehicle_sha256) == (run.config, run.vehicle_sha256)


def test_a_submission_with_another_vehicle_is_not_the_same_as_before(site: Site) -> None:
    forms = (
        form_of(run=json.dumps(PRACTICE), vehicle=text)
        for text in (VEHICLE, VEHICLE, VEHICLE.replace("Mine", "Yours"))
    )
    first, same, other = (
        site.call("owner", "POST", RUNS, headers={"Idempotency-Key": "one"}, **form)
        for form in forms
    )

    assert first.get_json()["id"] == same.get_json()["id"]
    assert "key" in problem_of(other, 422, "invalid-request")["detail"].lower()


def test_the_view_from_outside_draws_the_vehicle_of_the_run(site: Site) -> None:
    run_id = row_of(site, sent(site)).id
    site.record(run_id, rows=40)

    scene = site.call("owner", "GET", f"{RUNS}/{run_id}/scene.json?trial=0&level=0").get_json()

    assert (scene["vehicle"]["name"], scene["vehicle"]["title"]) == ("mine", "Mine")
    assert len(scene["vehicle"]["thrusters"]) == 8


FEW = VEHICLE.replace('extends = "bluerov2-heavy-v2"', 'extends = "girona500"')
MANY = VEHICLE.replace("[defaults]\nkp = 0.7\n", "") + "".join(
    f"""
[[thrusters]]
name = "t{at}"
direction = {["[1.0, 0.0, 0.0]", "[0.0, 1.0, 0.0]", "[0.0, 0.0, 1.0]"][at % 3]}
position = {{ value = [0.{at % 4}, 0.{at % 5}, 0.0], unit = "m", tag = "E", reason = "a guess" }}
"""
    for at in range(12)
)


@pytest.mark.slow
@pytest.mark.parametrize(("text", "count"), [(FEW, 5), (VEHICLE, 8), (MANY, 12)])
def test_charts_and_formats_have_as_many_thrusters_as_the_vehicle(
    site: Site, text: str, count: int
) -> None:
    run_id = row_of(site, sent(site, vehicle=text)).id
    width = width_for(count)
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, width)))
    assert site.finish(site.claim_next())

    with site.app.test_request_context():
        data = player_data(site.show(run_id), RunFiles(site.settings.data, run_id, 1))
    mcap = site.call("owner", "GET", f"{RUNS}/{run_id}/telemetry.mcap").data

    charted = [name for chart in data["charts"] for name in chart["columns"]]
    assert sum(name.startswith("thrust_") for name in charted) == min(count, COMMON_THRUSTERS)
    messages = make_reader(
        io.BytesIO(mcap), decoder_factories=[DecoderFactory()]
    ).iter_decoded_messages(topics=["/vehicle/thrust"])
    assert {len(message.data) for _, _, _, message in messages} == {count}


def manifest_in(archive: bytes) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(archive)) as file:
        (name,) = (each for each in file.namelist() if each.endswith("manifest.json"))
        document: dict[str, Any] = json.loads(file.read(name))
    return document


@pytest.mark.slow
def test_an_archive_is_what_a_rerun_needs(site: Site) -> None:
    run_id = row_of(site, sent(site)).id
    site.record(run_id, rows=40)
    entry = {"sha256": hashlib.sha256(VEHICLE.encode()).hexdigest(), "text": VEHICLE}
    assert site.finish(site.claim_next(), manifest={"vehicle_file": entry})

    archive = site.call("owner", "GET", f"{RUNS}/{run_id}/archive.zip").data
    manifest = site.call("owner", "GET", f"{RUNS}/{run_id}/manifest.json").get_json()

    assert manifest["vehicle_file"] == entry
    assert manifest_in(archive)["vehicle_file"] == entry


@pytest.mark.slow
def test_images_of_a_run_show_the_arm_of_its_vehicle_and_data_sets_have_its_file(
    site: Site,
) -> None:
    run_id = row_of(site, sent(site, config={"arm": "hook"})).id
    rows = np.zeros((40, width_for(8, arm=True)))
    rows[:, INDEX["t"]], rows[:, INDEX["z"]] = 0.05 * np.arange(40), 1.65
    RunFiles(site.settings.data, run_id, 1).append_rows(rows)
    entry = {"sha256": hashlib.sha256(VEHICLE.encode()).hexdigest(), "text": VEHICLE}

    camera = site.call("owner", "GET", f"{RUNS}/{run_id}/camera.jpg?trial=0&t=1")
    scene = site.call("owner", "GET", f"{RUNS}/{run_id}/scene.json").get_json()
    dataset = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip?trial=0&every=20").data

    assert (camera.status_code, camera.content_type) == (200, "image/jpeg")
    assert scene["vehicle"]["arm"] is not None
    assert manifest_in(dataset)["vehicle_file"] == entry
