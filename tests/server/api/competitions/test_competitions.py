"""Competitions at the API: an organiser makes a draft, opens it, moves rounds and hands it over."""

import hashlib
import io
import json
import time
from typing import Any

import pytest

from seamark.server.accounts import audit
from seamark.server.accounts.audit import AuditFilter
from seamark.sim.files import target_pictures
from seamark.sim.physics.water_motion import records
from tests.cast import MARKER, RECORD, VEHICLE
from tests.server.api.conftest import Site
from tests.server.judging.cup import DAY_S, NAME, QUALIFICATION, Cup, values

API = "/api/v1/competitions"
PNG = b"\x89PNG\r\n\x1a\nrest"
TOML = """
name = "harbour-cup-v1"
title = "Harbour Cup"
rules = ["Be fair.", "Have fun."]
benchmark = "currents-v1"

[settings]
levels = [0.0, 0.2]

[[rounds]]
kind = "qualification"
opens = 2031-05-01T12:00:00Z
closes = 2031-06-01T12:00:00Z
trials = 3
"""


def form(document: object = None, **files: tuple[bytes, str]) -> dict[str, Any]:
    sent: dict[str, Any] = {"document": json.dumps(values() if document is None else document)}
    return {"data": sent | {name: (io.BytesIO(of), at) for name, (of, at) in files.items()}}


def actions(site: Site) -> list[tuple[str, str, str]]:
    with site.database.reading() as session:
        entries = audit.page(session, AuditFilter(target=NAME)).entries
        return [(entry.actor, entry.action, entry.target) for entry in entries]


def test_a_draft_is_seen_by_its_organiser_alone(hall: Site) -> None:
    made = hall.call("olga", "POST", API, json=values())
    lists = {who: hall.call(who, "GET", API).get_json() for who in ("olga", "otto", "ann")}

    assert made.status_code == 201
    assert made.headers["Location"] == f"{API}/{NAME}"
    assert made.get_json()["state"] == "draft"
    assert [one["name"] for one in lists["olga"]["drafts"]] == [NAME]
    assert lists["otto"] == lists["ann"] == {"competitions": [], "drafts": []}
    for path in ("", "/check", "/picture", "/rounds/1/board", "/team"):
        assert hall.call("otto", "GET", f"{API}/{NAME}{path}").status_code in {403, 404}
    assert hall.call("ann", "POST", API, json=values()).status_code == 403


def test_a_draft_comes_with_a_picture_and_a_vehicle(hall: Site) -> None:
    files = {"picture": (PNG, "cup.png"), "vehicle": (VEHICLE.encode(), "mine.toml")}
    made = hall.call("olga", "POST", API, **form(**files)).get_json()
    picture = hall.call("olga", "GET", f"{API}/{NAME}/picture")

    assert made["document"]["settings"]["vehicle"].startswith("mine")
    assert made["vehicle_sha256"]
    assert (picture.data, picture.content_type) == (PNG, "image/png")


def test_a_draft_comes_with_a_record_of_currents(hall: Site) -> None:
    files = {"current_record": (RECORD.encode(), "ria.csv")}
    made = hall.call("olga", "POST", API, **form(**files)).get_json()
    name, sha256 = made["document"]["settings"]["current_record"], made["files"]["current_record"]
    without = hall.call("olga", "PUT", f"{API}/{NAME}", json=values()).get_json()
    alone = hall.call(
        "olga", "PUT", f"{API}/{NAME}", json=values(settings={"current_record": name})
    )

    assert sha256 == hashlib.sha256(RECORD.encode()).hexdigest()
    assert name == f"record@{sha256[:16]}"
    assert without["files"] == {}
    assert alone.status_code == 422  # the web process has forgotten it
    assert not records.LIBRARY.is_known(name)


def test_a_draft_comes_with_a_picture_on_its_target(hall: Site) -> None:
    files = {"target_texture": (MARKER, "marker.pgm")}
    vision = values(benchmark="visibility-v2", settings={})
    made = hall.call("olga", "POST", API, **form(vision, **files))
    other = hall.call("olga", "PUT", f"{API}/{NAME}", **form(**files))

    kept = target_pictures.LIBRARY.converted(MARKER)
    document = made.get_json()
    assert document["files"] == {"target_texture": hashlib.sha256(kept).hexdigest()}
    name = target_pictures.LIBRARY.name_of(kept)
    assert document["document"]["settings"]["target_texture"] == name
    assert not target_pictures.LIBRARY.is_known(name)
    (error,) = other.get_json()["errors"]
    assert error["detail"] == "currents-v1 has no target texture to choose."


def test_a_document_may_be_a_toml_file(hall: Site) -> None:
    data = {"document": (io.BytesIO(TOML.encode()), "cup.toml")}
    made = hall.call("olga", "POST", API, data=data).get_json()

    assert made["document"]["rules"] == "Be fair.\n\nHave fun."
    assert made["rounds"][0]["trials"] == 3


def test_a_document_may_name_the_files_that_are_sent_with_it(hall: Site) -> None:
    named = f'picture = "cup.png"\n{TOML}'.encode()
    alone = {"document": (io.BytesIO(named), "cup.toml")}
    both = alone | {"document": (io.BytesIO(named), "cup.toml")}
    both["picture"] = (io.BytesIO(PNG), "cup.png")
    refused = hall.call("olga", "POST", API, data=alone)
    made = hall.call("olga", "POST", API, data=both)
    names = {"vehicle": "mine.toml", "current_record": "ria.csv", "target_texture": "a.png"}
    body = hall.call("olga", "PUT", f"{API}/{NAME}", json=values(**names))

    assert [each["field"] for each in refused.get_json()["errors"]] == ["picture"]
    assert "picture" in made.get_json()["links"]
    assert [each["field"] for each in body.get_json()["errors"]] == [*names]


def test_what_is_wrong_with_a_document_is_told_place_by_place(hall: Site) -> None:
    wrong = values(title="", benchmark="currents-v1", settings={"levels": [9.0]})
    wrong["rounds"][1]["quota"] = 0
    answer = hall.call("olga", "POST", API, json=wrong)
    settings = hall.call("olga", "POST", API, json=values(settings={"kp": 1.0}))

    assert (answer.status_code, settings.status_code) == (422, 422)
    assert {each["field"] for each in answer.get_json()["errors"]} == {"title", "rounds.1.quota"}
    assert [each["field"] for each in settings.get_json()["errors"]] == ["settings.kp"]


def test_a_changed_draft_is_checked_again_and_keeps_its_picture(hall: Site) -> None:
    hall.call("olga", "POST", API, **form(picture=(PNG, "cup.png")))
    changed = hall.call("olga", "PUT", f"{API}/{NAME}", json=values(title="Reef Cup"))
    check = hall.call("olga", "GET", f"{API}/{NAME}/check").get_json()

    assert changed.get_json()["title"] == "Reef Cup"
    assert "picture" in changed.get_json()["links"]
    assert check["waiting"] == check["asked"] > 0
    assert check["findings"] == []


def test_a_draft_opens_after_its_check_and_never_changes_then(hall: Site) -> None:
    cup = Cup.draft(hall, rounds=values()["rounds"][1:])
    early = hall.call("olga", "POST", f"{API}/{NAME}/open")
    cup.check()
    report = hall.call("olga", "GET", f"{API}/{NAME}/check").get_json()
    opened = hall.call("olga", "POST", f"{API}/{NAME}/open")
    changed = hall.call("olga", "PUT", f"{API}/{NAME}", json=values())
    deleted = hall.call("olga", "DELETE", f"{API}/{NAME}")

    assert early.status_code == 409
    assert "Wait for the check" in early.get_json()["detail"]
    assert report["ended"]
    assert report["findings"]
    assert {each["score"] is None for each in report["references"]} == {False}
    assert (opened.status_code, opened.get_json()["state"]) == (200, "open")
    assert (changed.status_code, deleted.status_code) == (409, 409)
    listed = hall.call("nobody", "GET", API).get_json()["competitions"]
    assert [one["name"] for one in listed] == [NAME]
    assert listed[0]["current"] == 1


def test_a_deleted_draft_leaves_its_name(hall: Site) -> None:
    hall.call("olga", "POST", API, json=values())
    deleted = hall.call("olga", "DELETE", f"{API}/{NAME}")

    assert deleted.status_code == 204
    assert hall.call("otto", "POST", API, json=values()).status_code == 201


def test_everybody_sees_that_a_round_was_moved_and_why(hall: Site) -> None:
    Cup.opened(hall)
    body = {"until": time.time() + 3 * DAY_S, "reason": "The \x1bserver was away."}
    refused = hall.call("olga", "POST", f"{API}/{NAME}/rounds/2/move", json=body)
    body["reason"] = "The server was away."
    moved = hall.call("olga", "POST", f"{API}/{NAME}/rounds/2/move", json=body)
    seen = hall.call("nobody", "GET", f"{API}/{NAME}").get_json()["rounds"]
    body["until"] = 1.0
    earlier = hall.call("olga", "POST", f"{API}/{NAME}/rounds/2/move", json=body)

    assert (refused.status_code, moved.status_code) == (422, 200)
    assert seen[1]["moves"][0]["reason"] == "The server was away."
    assert seen[2]["opens_at"] == seen[1]["closes_at"]
    assert earlier.status_code == 422
    assert [each["field"] for each in earlier.get_json()["errors"]] == ["until"]


def test_a_competition_is_handed_over_to_an_organiser_who_takes_no_part(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", "root")
    path = f"{API}/{NAME}/hand-over"
    details = [
        hall.call("olga", "POST", path, json={"user": name}).get_json()["detail"]
        for name in ("tim", "root", "no one")
    ]
    done = hall.call("olga", "POST", path, json={"user": "otto"})

    assert details[0] == "tim is no organiser. An admin can make the account one."
    assert "is in a team" in details[1]
    assert details[2] == "There is no account no one."
    assert done.status_code == 204
    assert hall.call("olga", "GET", f"{API}/{NAME}/check").status_code == 403
    assert hall.call("otto", "GET", f"{API}/{NAME}/check").status_code == 200


def test_the_audit_log_tells_what_an_organiser_does(hall: Site) -> None:
    hall.call("olga", "POST", API, json=values(rounds=values()["rounds"][1:]))
    cup = Cup.named(hall)
    for at, run_id in enumerate(cup.live()):
        cup.finish(run_id, [20.0 + at, 21.0, 22.5])
    assert hall.call("olga", "POST", f"{API}/{NAME}/open").status_code == 200
    body = {"until": time.time() + 1.5 * DAY_S, "reason": "Rain."}
    assert hall.call("olga", "POST", f"{API}/{NAME}/rounds/1/move", json=body).status_code == 200
    hall.call("olga", "POST", f"{API}/{NAME}/hand-over", json={"user": "otto"})

    assert actions(hall) == [
        ("olga", "competition_handed_over", NAME),
        ("olga", "round_moved", NAME),
        ("olga", "competition_opened", NAME),
        ("olga", "competition_created", NAME),
    ]


@pytest.mark.parametrize("role", ["otto", "ann", "nobody"])
def test_only_its_organiser_moves_a_competition(hall: Site, role: str) -> None:
    Cup.opened(hall)
    body = {"until": time.time() + 3 * DAY_S, "reason": "Rain."}
    paths = {f"/rounds/{QUALIFICATION}/move": body, "/hand-over": {"user": role}, "/open": {}}
    answers = {hall.call(role, "POST", f"{API}/{NAME}{at}", json=of) for at, of in paths.items()}

    assert {answer.status_code for answer in answers} <= {401, 403}
