"""Competitions in the Python client: both clients organise one and take part in it."""

import asyncio
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from seamark.client import AsyncClient, Client, RequestInvalid
from seamark.server.accounts import accounts
from seamark.server.competitions import teams
from tests.cast import RECORD, VEHICLE, Backend
from tests.server.judging.cup import DAY_S, NAME, QUALIFICATION, Cup, values

Do = Callable[..., Any]


def waiting(address: str, token: str, name: str, /, *words: Any, **options: Any) -> Any:
    with Client(address, token) as client:
        return getattr(client, name)(*words, **options)


def asynchronous(address: str, token: str, name: str, /, *words: Any, **options: Any) -> Any:
    async def session() -> Any:
        async with AsyncClient(address, token) as client:
            return await getattr(client, name)(*words, **options)

    return asyncio.run(session())


@pytest.fixture(params=[waiting, asynchronous])
def do(request: pytest.FixtureRequest, backend: Backend, address: str) -> Do:
    """Call a method of the client of somebody of the cast."""
    tokens = {}
    with backend.database.writing() as session:
        for name in ("olga", "ann", "ben"):
            scopes = ("read", "submit", "admin")
            tokens[name] = accounts.new_token(session, backend.user_id(name), "t", scopes)

    def call(who: str, name: str, /, *words: Any, **options: Any) -> Any:
        return request.param(address, tokens[who], name, *words, **options)

    return call


def test_an_organiser_makes_changes_and_opens_a_draft(
    do: Do, backend: Backend, tmp_path: Path
) -> None:
    vehicle = tmp_path / "mine.toml"
    vehicle.write_text(VEHICLE)
    record = tmp_path / "ria.csv"
    record.write_text(RECORD)
    now = datetime.now(UTC).replace(microsecond=0)
    one = {"kind": "qualification", "opens": now, "closes": now + timedelta(days=1), "trials": 3}
    files = {"vehicle": vehicle, "current_record": record}
    made = do("olga", "create_competition", values(rounds=[one]), **files)
    changed = do("olga", "create_competition", values(rounds=[one], title="Reef"), replace=True)
    cup = Cup.named(backend)
    for at, run_id in enumerate(cup.live()):
        cup.finish(run_id, [20.0 + at, 21.0, 22.5])
    check = do("olga", "competition_check", NAME)
    opened = do("olga", "open_competition", NAME)
    until = time.time() + 2 * DAY_S
    moved = do("olga", "move_round", NAME, 1, until=until, reason="Rain.")

    assert made["vehicle_sha256"] is not None
    assert set(made["files"]) == {"current_record"}
    assert changed["title"] == "Reef"
    assert check["ended"]
    assert (opened["state"], moved["rounds"][0]["closes_at"]) == ("open", until)
    assert [each["name"] for each in do("ann", "competitions")["competitions"]] == [NAME]


def test_a_team_submits_and_looks_at_its_place(do: Do, backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann", name="Reef")
    with backend.database.reading() as session:
        team = teams.of_user(session, cup.id, backend.user_id("ann"))
    assert team is not None
    joined = do("ben", "join_team", NAME, team.code)
    sent = {"controller": "pi", "competition": NAME, "method": "PI"}
    run = do("ben", "submit", "currents-v1", **sent)
    cup.finish(run.id, [40.0, 41.0, 42.0])
    entries = do("ann", "competition_entries", NAME)
    board = do("ann", "competition_board", NAME, QUALIFICATION, per="method")

    assert [member["name"] for member in joined["members"]] == ["ann", "ben"]
    assert run.document["entry"]["team"] == "Reef"
    assert [entry["run"] for entry in entries["entries"]] == [run.id]
    assert board["rows"][0]["own"]
    assert do("ben", "competition", NAME)["own_team"] == "Reef"


def test_what_is_wrong_is_named(do: Do) -> None:
    with pytest.raises(RequestInvalid, match=r"settings\.levels"):
        do("olga", "create_competition", values(settings={"levels": [float("nan")]}))
