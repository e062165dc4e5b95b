"""Entries at the API: submitted, counted once, listed, withdrawn, chosen; and the boards."""

import io
import json
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from sqlalchemy import update

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import Round
from seamark.server.judging.entries import NOT_NOW
from tests.cast import PROGRAM
from tests.server.api.conftest import Site
from tests.server.judging.cup import DAY_S, FINAL, NAME, QUALIFICATION, Cup, round_of, values

CUP = f"/api/v1/competitions/{NAME}"
RUN: dict[str, Any] = {"benchmark": "currents-v1", "controller": "pi", "competition": NAME}
RUN |= {"method": "PI"}


def submit(site: Site, who: str = "ann", key: str = "", **changes: Any) -> Any:
    headers = {"Idempotency-Key": key} if key else {}
    return site.call(who, "POST", "/api/v1/runs", json=RUN | changes, headers=headers)


def entries(site: Site, who: str = "ann") -> Any:
    return site.call(who, "GET", f"{CUP}/entries").get_json()


def board(site: Site, who: str, number: int = QUALIFICATION, **query: str) -> Any:
    path = f"{CUP}/rounds/{number}/board"
    return site.call(who, "GET", path, query_string=query).get_json()


def with_board(board: str) -> list[dict[str, Any]]:
    """Return rounds of which the qualification has a board that is visible or hidden."""
    return [
        round_of("qualification", -DAY_S, DAY_S, trials=3, quota=3, board=board),
        round_of("final", 2 * DAY_S, None, trials=6, batches=1),
    ]


def test_an_entry_says_where_it_counts_and_not_who_is_in_the_team(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", "ben", name="Reef")
    answer = submit(hall)
    run = answer.get_json()

    assert answer.status_code == 202
    assert run["entry"] == {"competition": NAME, "round": 2, "team": "Reef", "method": "PI"}
    assert (run["kind"], run["user"], run["trials"]) == ("entry", "Reef", 3)
    assert not {"members", "code", "captain"} & set(run["entry"])
    assert '"ann"' not in answer.text
    path = f"/api/v1/runs/{run['id']}"
    seen = {who: hall.call(who, "GET", path).status_code for who in ("ben", "olga", "eva", "otto")}
    assert seen == {"ben": 200, "olga": 200, "eva": 404, "otto": 404}
    assert hall.call("root", "GET", "/api/v1/runs?which=all&kind=entry").get_json()["runs"]
    assert [each["run"] for each in entries(hall, "ben")["entries"]] == [run["id"]]


def test_a_run_that_is_no_entry_says_so(hall: Site) -> None:
    run = hall.call(
        "ann", "POST", "/api/v1/runs", json={"benchmark": "currents-v1"} | {"controller": "pi"}
    )

    assert run.get_json()["entry"] is None


@pytest.mark.parametrize(
    ("who", "changes", "field"),
    [
        ("eva", {}, "competition"),
        ("olga", {}, "competition"),
        ("ann", {"competition": "reef-cup-v1"}, "competition"),
        ("ann", {"assignment": 1}, "competition"),
        ("ann", {"competition": None}, "method"),
        ("ann", {"benchmark": "track-v1", "controller": "csrt"}, "benchmark"),
        ("ann", {"config": {"levels": [0.9]}}, "levels"),
        ("ann", {"method": "x" * 61}, "method"),
    ],
)
def test_what_a_round_does_not_ask_for_is_refused(
    hall: Site, who: str, changes: dict[str, Any], field: str
) -> None:
    Cup.opened(hall).team("ann")
    answer = submit(hall, who, **changes)

    assert answer.status_code == 422
    assert [error["field"] for error in answer.get_json()["errors"]] == [field]
    assert entries(hall)["entries"] == []


def test_an_uploaded_program_needs_the_name_of_its_method(hall: Site) -> None:
    Cup.opened(hall).team("ann")
    body = json.dumps(RUN | {"controller": None, "method": ""})
    data = {"run": body, "program": (io.BytesIO(PROGRAM), "mine.py")}
    answer = hall.call("ann", "POST", "/api/v1/runs", data=data)

    assert [error["field"] for error in answer.get_json()["errors"]] == ["method"]


def test_a_sweep_is_no_entry(hall: Site) -> None:
    Cup.opened(hall).team("ann")
    body = RUN | {"sweep": [{"name": "kp", "values": [0.1, 0.2]}]}
    answer = hall.call("ann", "POST", "/api/v1/sweeps", json=body)

    assert answer.status_code == 422
    assert entries(hall)["entries"] == []


def test_a_repeated_submission_counts_once_also_after_the_round(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", "ben")
    first, second = submit(hall, key="k"), submit(hall, key="k")
    other = submit(hall, key="k", method="PID")
    of_ben = submit(hall, "ben", key="k")
    last = submit(hall, key="m")
    cup.shift(QUALIFICATION, closes_in_s=-1.0)
    late, new = submit(hall, key="k"), submit(hall, key="n")

    assert first.get_json()["id"] == second.get_json()["id"] == late.get_json()["id"]
    assert (other.status_code, of_ben.status_code, last.status_code) == (422, 202, 202)
    assert (late.status_code, new.status_code) == (202, 422)
    assert len(entries(hall)["entries"]) == 3


def test_of_two_submissions_at_once_the_quota_lets_one_through(hall: Site) -> None:
    Cup.opened(hall).team("ann", "ben")
    for method in ("PI", "PI"):
        assert submit(hall, method=method).status_code == 202
    with ThreadPoolExecutor(2) as threads:
        answers = list(threads.map(lambda who: submit(hall, who), ("ann", "ben")))

    assert sorted(answer.status_code for answer in answers) == [202, 422]
    assert entries(hall)["left"] == 0
    refused = next(answer for answer in answers if answer.status_code == 422)
    assert "used its submissions of round 2" in refused.get_json()["detail"]


def test_the_quota_of_a_person_does_not_keep_a_program_from_a_competition(hall: Site) -> None:
    Cup.opened(hall).team("ann")
    for _ in range(hall.settings.quota_live):
        hall.queue("ann")
    body = json.dumps(RUN | {"controller": None, "method": "Steady hand"})

    def upload(run: str, who: str = "ann") -> Any:
        data = {"run": run, "program": (io.BytesIO(PROGRAM), "mine.py")}
        return hall.call(who, "POST", "/api/v1/runs", data=data)

    assert upload('{"benchmark": "currents-v1"}').status_code == 429
    # No room for languages without a worker: the refusal is of the program, not of the quota.
    assert upload(body).status_code in {202, 422}
    assert upload(body, "eva").get_json()["errors"][0]["field"] == "competition"


def test_an_entry_is_withdrawn_by_the_captain_and_still_counts(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", "ben")
    cup.team("eva")
    run_id = cup.entered("ben", [40.0, 41.0, 42.0])
    path = f"{CUP}/entries/{run_id}/withdraw"

    assert hall.call("ben", "POST", path).status_code == 403
    assert hall.call("eva", "POST", path).status_code == 409
    withdrawn = hall.call("ann", "POST", path).get_json()
    assert withdrawn["left"] == 2
    assert withdrawn["entries"][0]["withdrawn_at"] is not None
    assert board(hall, "nobody")["rows"] == []


def test_a_captain_chooses_what_goes_into_the_final(hall: Site) -> None:
    rounds = with_board("visible")
    rounds[-1] |= {"carry": "chosen"}
    cup = Cup.opened(hall, rounds=rounds)
    cup.team("ann", "ben")
    first, second = (cup.entered("ben", [at, at + 1.0, at + 2.0]) for at in (40.0, 50.0))

    def choose(who: str, method: str, run_id: int) -> Any:
        return hall.call(who, method, f"{CUP}/entries/{run_id}/choice")

    assert choose("ben", "PUT", first).status_code == 403
    assert choose("ann", "PUT", second).status_code == 200
    chosen = choose("ann", "PUT", first).get_json()["entries"]
    assert [each["run"] for each in chosen if each["chosen"]] == [first]
    none = choose("ann", "DELETE", first).get_json()["entries"]
    assert [each["run"] for each in none if each["chosen"]] == []


def test_a_board_has_a_row_for_each_team_or_each_method(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", name="=Reef")
    cup.team("eva", name="Wreck")
    cup.entered("ann", [40.0, 41.0, 42.0], "PI")
    cup.entered("ann", [50.0, 51.0, 52.0], "Sliding mode")
    cup.entered("eva", [45.0, 46.0, 47.0], "MPC")
    teams, methods = board(hall, "nobody"), board(hall, "eva", per="method")
    table = hall.call("nobody", "GET", f"{CUP}/rounds/2/board", headers={"Accept": "text/csv"})

    assert [(row["place"], row["method"]) for row in teams["rows"]] == [
        *((1, "Sliding mode"), (2, "MPC")),
    ]
    assert teams["reference_entries"]
    assert [row["method"] for row in methods["rows"]] == ["Sliding mode", "MPC", "PI"]
    assert [row["own"] for row in methods["rows"]] == [False, True, False]
    assert table.content_type.startswith("text/csv")
    lines = table.text.splitlines()
    assert lines[0].startswith("place,place_low,place_high,team,method,run,score,")
    assert lines[1].startswith("1,1,1,'=Reef,Sliding mode,")
    assert len(lines) == 3 + len(teams["reference_entries"])


def test_a_hidden_board_shows_a_team_its_own_rows_without_places(hall: Site) -> None:
    cup = Cup.opened(hall, rounds=with_board("hidden"))
    cup.team("ann", "ben")
    cup.team("eva")
    cup.entered("ann", [40.0, 41.0, 42.0])
    cup.entered("eva", [45.0, 46.0, 47.0])
    seen = {who: board(hall, who, 1) for who in ("ben", "tim", "otto", "olga", "root", "nobody")}
    csv = hall.call("ben", "GET", f"{CUP}/rounds/1/board?format=csv").text

    assert [(row["place"], row["score"]) for row in seen["ben"]["rows"]] == [(None, 41.0)]
    assert [seen[who]["rows"] for who in ("tim", "otto", "nobody")] == [[], [], []]
    assert [len(seen[who]["rows"]) for who in ("olga", "root")] == [2, 2]
    assert [seen[who]["hidden"] for who in ("ben", "olga")] == [True, False]
    assert "46.0" not in csv


def test_nobody_sees_a_final_before_it_is_decided(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", [40.0, 41.0, 42.0], "PI")
    cup.entered("eva", [50.0, 51.0, 52.0], "MPC")
    cup.begin_final()
    cup.play_batch({"PI": [30, 31, 32, 33, 34, 35.0], "MPC": [40, 41, 42, 43, 44, 45.1]})
    sealed = {who: board(hall, who, FINAL) for who in ("ann", "olga", "root", "nobody")}
    cup.advance()
    decided = board(hall, "nobody", FINAL)

    assert [each["rows"] for each in sealed.values()] == [[]] * 4
    assert [(row["place"], row["method"]) for row in decided["rows"]] == [(1, "MPC"), (2, "PI")]
    assert decided["decided"]
    assert hall.call("nobody", "GET", CUP).get_json()["state"] == "ended"
    assert hall.call("nobody", "GET", f"{CUP}/rounds/4/board").status_code == 404


def test_a_submission_after_the_round_is_refused(hall: Site) -> None:
    cup = Cup.opened(hall, rounds=values()["rounds"])
    cup.team("ann")
    cup.shift(QUALIFICATION, closes_in_s=-0.1)
    answer = submit(hall)

    assert answer.status_code == 422
    assert "No round of this competition accepts" in answer.get_json()["detail"]


def test_a_round_that_closes_while_a_submission_is_on_its_way_refuses_it(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann")
    with ThreadPoolExecutor(1) as threads:
        with hall.database.writing() as session:
            acquire(session, AdvisoryLock.SUBMISSION)
            answer = threads.submit(submit, hall)
            time.sleep(0.5)  # the round was open when the request began
            of_cup = (Round.competition_id == cup.id, Round.number == QUALIFICATION)
            session.execute(update(Round).where(*of_cup).values(closes_at=time.time()))
        refused = answer.result()

    assert refused.status_code == 422
    # On SQLite the request waits before it reads: its token is marked as used.
    assert refused.get_json()["detail"] in {"This round has closed.", NOT_NOW}
    assert entries(hall)["entries"] == []
