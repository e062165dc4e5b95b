"""`seamark competition`: from a starter file to a board, and what is refused in one sentence."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from seamark.cli import competition_files
from seamark.cli.main import cli
from seamark.competitions import document
from seamark.competitions.document import CompetitionDocument, Final, Round
from seamark.server.accounts import accounts
from seamark.server.competitions import teams
from tests.cast import RECORD, VEHICLE, Backend
from tests.server.judging.cup import DAY_S, NAME, QUALIFICATION, Cup, values

PNG = b"\x89PNG\r\n\x1a\nrest"


@pytest.fixture
def folder(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder from which commands reach a service with the cast."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEAMARK_SERVER", address)
    monkeypatch.delenv("SEAMARK_TOKEN", raising=False)
    return tmp_path


@pytest.fixture
def tokens(backend: Backend) -> dict[str, str]:
    """A token of each person, with all that the person may do."""
    made = {}
    with backend.database.writing() as session:
        for name in ("olga", "ann", "ben"):
            scopes = ("read", "submit", "admin")
            made[name] = accounts.new_token(session, backend.user_id(name), "t", scopes)
    return made


def run(*words: object, token: str = "") -> Result:
    of_token = ["--token", token] if token else []
    return CliRunner().invoke(cli, [*map(str, words), *of_token])


def answer(*words: object, token: str = "") -> Any:
    result = run(*words, "--json", token=token)
    assert result.exit_code in {0, 1}, result.output
    return json.loads(result.stdout)


def write(folder: Path, **changes: Any) -> Path:
    """Write a competition with a picture, a vehicle and a record of currents beside it."""
    (folder / "cup.png").write_bytes(PNG)
    (folder / "mine.toml").write_text(VEHICLE)
    (folder / "ria.csv").write_text(RECORD)
    file = folder / "cup.json"
    rounds = values()["rounds"][1:]
    own = {"rounds": rounds, "picture": "cup.png", "vehicle": "mine.toml"}
    own["current_record"] = "ria.csv"
    file.write_text(json.dumps(values(**(own | changes))))
    return file


def link(backend: Backend, address: str, team_id: int) -> str:
    with backend.database.reading() as session:
        team = teams.find(session, team_id)
    assert team is not None
    return f"{address}/competitions/{NAME}/join/{team.code}"


def test_the_starter_is_valid_as_it_stands_and_has_every_entry(folder: Path) -> None:
    assert run("competition", "init", "cup.toml").exit_code == 0
    checked = run("competition", "check", "cup.toml")
    text = (folder / "cup.toml").read_text()

    assert checked.exit_code == 0
    assert "cup.toml is valid." in checked.stdout
    parts = (CompetitionDocument, Round, Final)
    entries = {name for part in parts for name in part.model_fields} | {*competition_files.FILES}
    for name in entries - {"rounds", "settings"}:
        assert f"\n{name} = " in text or f"\n# {name} = " in text
    again = run("competition", "init", "cup.toml")
    assert (again.exit_code, "already exists" in again.stderr) == (2, True)
    assert answer("competition", "init", "other.toml") == {"file": "other.toml"}


def test_what_the_starter_comments_out_is_the_default(folder: Path) -> None:
    run("competition", "init", "cup.toml")
    plain = competition_files.read(Path("cup.toml")).values
    lines = (folder / "cup.toml").read_text().splitlines()
    shown = [line.removeprefix("# ") if " = " in line else line for line in lines]
    others = (*competition_files.FILES, "score")
    Path("all.toml").write_text("\n".join(line for line in shown if not line.startswith(others)))
    everything = competition_files.read(Path("all.toml")).values

    assert document.read(plain) == document.read(everything)
    assert plain != everything


@pytest.mark.slow
def test_a_competition_is_organised_from_the_command_line(
    folder: Path, backend: Backend, tokens: dict[str, str]
) -> None:
    olga = tokens["olga"]
    file = write(folder)
    made = run("competition", "create", file, token=olga)
    assert made.exit_code == 0, made.output
    assert f"seamark competition check {NAME} --wait" in made.stdout
    cup = Cup.named(backend)
    assert cup.view.has_picture
    assert cup.asked.settings["vehicle"].startswith("mine")
    assert cup.asked.settings["current_record"].startswith("record@")

    taken = run("competition", "create", file, token=olga)
    assert (taken.exit_code, f"There is a competition {NAME}." in taken.stderr) == (2, True)
    changed = answer(
        "competition",
        "create",
        write(folder, vehicle="mine.toml", title="Reef"),
        "--replace",
        token=olga,
    )
    assert (changed["title"], changed["state"]) == ("Reef", "draft")

    early = run("competition", "open", NAME, token=olga)
    waiting = run("competition", "check", NAME, token=olga)
    assert "Wait for the check to end" in early.stderr
    assert "reference entries wait for a worker. Try again, or add --wait." in waiting.stdout

    def play() -> None:
        for at, run_id in enumerate(cup.live()):
            cup.finish(run_id, [20.0 + 9 * at, 21.0 + 9 * at, 22.5 + 9 * at])

    with ThreadPoolExecutor(1) as worker:
        played = worker.submit(play)
        report = run("competition", "check", NAME, "--wait", token=olga)
        played.result()
    assert report.exit_code in {0, 1}
    assert {line.split()[0] for line in report.stdout.splitlines()} <= {
        *("good", "warning", "problem"),
    }
    assert answer("competition", "check", NAME, token=olga)["ended"]

    opened = run("competition", "open", NAME, token=olga)
    assert f"frozen as SHA-256 {cup.view.digest}." in opened.stdout
    until = time.strftime("%Y-%m-%dT%H:%M", time.localtime(time.time() + 3 * DAY_S))
    moved = run("competition", "move", NAME, 1, "--until", until, "--reason", "Rain.", token=olga)
    assert moved.exit_code == 0, moved.output
    assert cup.view.rounds[0].moves[0].reason == "Rain."


def test_moving_is_in_the_zone_of_the_competition(
    folder: Path, backend: Backend, tokens: dict[str, str]
) -> None:
    Cup.opened(backend)
    path = ("competition", "move", NAME, QUALIFICATION, "--reason", "Rain.", "--until")
    moved = answer(*path, "2027-07-01T12:00", token=tokens["olga"])
    words = run(*path, "tomorrow", token=tokens["olga"])
    gap = run(*path, "2027-03-28T02:30", token=tokens["olga"])

    assert moved["rounds"][1]["closes_at"] == 1814436000.0  # 10:00 UTC
    assert "write a time as 2027-05-01T12:00" in words.stderr
    assert "does not exist in Europe/Madrid" in gap.stderr


def test_a_team_is_joined_by_its_link(
    folder: Path, backend: Backend, address: str, tokens: dict[str, str]
) -> None:
    at = link(backend, address, Cup.opened(backend).team("ann", name="Reef"))
    rules = run("competition", "join", at, token=tokens["ben"])
    joined = run("competition", "join", at, "--agree", token=tokens["ben"])
    told = answer("competition", "join", at, "--agree", token=tokens["ben"])
    elsewhere = f"https://evil.example/competitions/{NAME}/join/ABCDE-12345"
    other = run("competition", "join", elsewhere, "--agree", token=tokens["ben"])
    none = run("competition", "join", "ABCDE-12345", "--agree", token=tokens["ben"])

    assert f"Read the rules on {address}/competitions/{NAME}, then add --agree." in rules.stderr
    assert joined.stdout == f"You are in the team Reef of {NAME}: ann, ben\n"
    assert told["name"] == "Reef"
    assert (other.exit_code, "is to evil.example, but your token" in other.stderr) == (2, True)
    assert "This is no link to a team." in none.stderr


def test_a_method_is_submitted_for_a_team(
    folder: Path, backend: Backend, tokens: dict[str, str]
) -> None:
    Cup.opened(backend).team("ann")
    words = ("submit", "currents-v1", "--controller", "pi", "--competition", NAME)
    sent = answer(*words, "--method", "PI", token=tokens["ann"])
    own = run(*words, token=tokens["ben"])
    fixed = [run(*words, *more, token=tokens["ann"]) for more in (("--ranked",), ("--seed", 0))]
    nobody = run(*words)

    assert sent["entry"] == {"competition": NAME, "round": 2, "team": "Team ann", "method": "PI"}
    assert "You are in no team of this competition." in own.stderr
    assert "A competition fixes what --ranked says: leave it out." in fixed[0].stderr
    assert "A competition fixes what --seed says: leave it out." in fixed[1].stderr
    assert "A competition needs an account" in nobody.stderr


def test_rounds_and_board_are_shown(folder: Path, backend: Backend) -> None:
    cup = Cup.opened(backend)
    cup.team("ann", name="Reef")
    cup.entered("ann", [40.0, 41.0, 42.0], "Steady hand")
    text = run("competition", "show", NAME).stdout
    shown = answer("competition", "show", NAME, "--round", 2, "--per", "method")

    assert "Harbour Cup (harbour-cup-v1), open" in text
    assert "Opens (Europe/Madrid)" in text
    assert "2 qualification" in text
    row = next(line.split() for line in text.splitlines() if "Steady hand" in line)
    assert row[:5] == ["1", "Reef", "Steady", "hand", "41"]
    assert "(reference entry)" in text
    assert shown["board"]["rows"][0]["method"] == "Steady hand"
    assert shown["competition"]["name"] == NAME


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("name = ", "is not valid TOML"),
        ('rules = """a\nb"""', "three quotes"),
        ("picture = 5", "picture is 5, but there is no such file beside it"),
        ('picture = "none.png"', "no such file beside it"),
    ],
)
def test_a_wrong_file_is_refused_in_a_sentence(folder: Path, content: str, sentence: str) -> None:
    (folder / "cup.toml").write_text(content)
    result = run("competition", "create", "cup.toml", token="smk_x")

    assert result.exit_code == 2
    assert sentence in result.stderr


def test_a_file_that_is_not_there_is_named(folder: Path) -> None:
    result = run("competition", "check", "cup.toml")

    assert result.stderr == "Error: cup.toml cannot be read: No such file or directory.\n"


def test_what_is_wrong_with_a_document_is_said_place_by_place(folder: Path) -> None:
    wrong = write(folder, benchmark="reef-v1", vehicle="mine.toml")
    settings = write(folder, settings={"kp": 1.0})
    wrong.with_name("wrong.json").write_text(json.dumps(values(title="")))
    title = run("competition", "check", "wrong.json")
    solution = run("competition", "check", settings.name)
    write(folder)
    (folder / "ria.csv").write_text("time,u,v")
    record = run("competition", "check", settings.name)

    assert (title.exit_code, solution.exit_code) == (1, 1)
    assert "problem title: " in title.stdout
    assert "ria.csv: A record begins with" in record.stderr
    assert "problem settings.kp: kp is chosen by those who take part." in solution.stdout
