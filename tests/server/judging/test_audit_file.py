"""The audit file of a competition proves by itself how it was decided."""

import copy
import json
from typing import Any

import pytest

from seamark.competitions import audit
from seamark.competitions.findings import Level
from seamark.server.judging import audit_file
from tests.cast import RECORD, VEHICLE, Backend
from tests.server.judging.cup import FINAL, QUALIFICATION, Cup, values
from tests.server.judging.test_finals import APART, MIXED, SAME


def document_of(cup: Cup) -> dict[str, Any]:
    cup.freeze_again()
    view = cup.view
    with cup.backend.database.reading() as session:
        made = audit_file.audit_of(session, view, cup.backend.settings)
    restored: dict[str, Any] = json.loads(json.dumps(made))
    return restored


def problems(document: dict[str, Any]) -> list[str]:
    return [one.sentence for one in audit.verify(document) if one.level is Level.PROBLEM]


def played(backend: Backend) -> Cup:
    cup = Cup.opened(backend, programs="public")
    cup.team("ann")
    cup.team("eva")
    cup.team("ben")
    cup.entered("ann", SAME, "PI")
    cup.entered("eva", SAME, "MPC", config={"kp": 0.7})
    cup.fail(cup.submit("ben", "Broken"))
    cup.begin_final()
    for _ in range(2):
        cup.play_batch({"PI": APART, "MPC": MIXED})
        cup.advance()
    return cup


def test_the_audit_of_a_decided_competition_holds(both: Backend) -> None:
    document = document_of(played(both))

    assert problems(document) == []
    assert document["standings"]["batches"] == 2
    assert {entry["team"] for entry in document["entries"]} >= {"Team ann", None}


def test_the_audit_has_the_files_of_the_organiser_once_a_round_is_decided(
    backend: Backend,
) -> None:
    """Before, they are as hidden as its entries."""
    files = {"vehicle": backend.store_vehicle(), "files": (backend.store_record(),)}
    cup = Cup.opened(backend, rounds=values()["rounds"][1:2], **files)
    before = document_of(cup)
    cup.shift(1, closes_in_s=0.0)
    cup.advance()
    after = document_of(cup)

    assert before["files"] == {}
    assert after["files"] == {"vehicle": VEHICLE, "current_record": RECORD}
    assert problems(after) == []
    named = [each.sentence for each in audit.verify(after) if "of the setting" in each.sentence]
    settings = cup.asked.settings
    assert named == [
        f"The file of the setting {name} is {settings[name]}."
        for name in ("current_record", "vehicle")
    ]


@pytest.mark.parametrize("ties", ["earlier", "shared"])
def test_the_audit_of_a_competition_without_a_final_proves_its_places(
    both: Backend, ties: str
) -> None:
    cup = Cup.opened(both, rounds=values()["rounds"][1:2], ties=ties)
    for who in ("ann", "eva", "ben"):
        cup.team(who)
    cup.entered("ann", [10.0, 11.0, 12.0], "PI")
    cup.entered("ann", [40.0, 41.0, 42.0], "pi")
    cup.entered("eva", [20.0, 21.0, 22.0], "MPC")
    cup.entered("ben", [40.0, 41.0, 42.0], "LQR")
    cup.fail(cup.submit("ben", "Broken"))
    cup.shift(1, closes_in_s=0.0)
    cup.advance()
    document = document_of(cup)

    assert problems(document) == []
    assert [one["place"] for one in document["board"]] == [1, 1 if ties == "shared" else 2, 3]
    sentence = "Round 1 (qualification): the standings of 3 entries follow from the scores."
    assert sentence in [each.sentence for each in audit.verify(document)]


def test_another_score_in_the_audit_is_found(backend: Backend) -> None:
    document = document_of(played(backend))
    changed = copy.deepcopy(document)
    final = [one for one in changed["entries"] if one["round"] == FINAL and one["team"]]
    final[0]["scores"][0] += 50.0

    assert problems(changed)


def test_a_round_that_is_not_decided_shows_no_entry_and_no_key(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    document = document_of(cup)

    assert document["entries"] == []
    assert [one["key"] for one in document["rounds"][1:]] == [None, None]
    assert problems(document) == []


def test_programs_that_the_rules_hide_are_there_by_their_digest_alone(backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann")
    cup.entered("ann", SAME, "PI")
    cup.close_qualification()
    for _ in range(2):
        cup.advance()

    (entry,) = [one for one in document_of(cup)["entries"] if one["round"] == QUALIFICATION]
    assert entry["submitted"] is None
    assert len(entry["submission"]) == 64
