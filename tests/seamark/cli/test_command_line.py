"""What the commands of `seamark` accept, refuse and print."""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from seamark.cli.commands.token import SCOPES as OFFERED
from seamark.cli.commands.user import ROLES
from seamark.cli.configuration import read_settings, typed
from seamark.cli.local_service import settings_of
from seamark.cli.main import COMMANDS, cli
from seamark.programs.arm_helpers import helper
from seamark.sandbox.languages import starters
from seamark.server.accounts import accounts, invitations
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.permissions import ACCOUNT_ROLES, SCOPES
from seamark.server.database.engine import Database
from seamark.sim import registry
from tests.services.prepared import SEAMARK, run

SHORT = ("--set", "levels=0", "--set", "level_duration_s=2", "--set", "settle_s=1", "--seed", "7")
CRASHING = """
class Controller:
    def __init__(self, config):
        pass
    def reset(self, level):
        print("started")
    def step(self, observation):
        return [1 / 0, 0, 0, 0]
"""


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def seamark(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, prog_name="seamark")


def process(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return run(SEAMARK, *arguments, on="warm")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_a_help_text(name: str) -> None:
    answer = seamark(name, "--help")

    assert answer.exit_code == 0
    assert "Usage: seamark" in answer.output


def test_help_imports_no_heavy_module() -> None:
    code = (
        "import sys; from seamark.cli.main import cli\n"
        "cli.main(['--help'], standalone_mode=False)\n"
        "assert not {'numpy', 'flask', 'sqlalchemy', 'celery'} & set(sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)

    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("run", "nothing"),
            "There is no benchmark nothing. Available: currents-v3,",
        ),
        (("run", "currents-v1", "--set", "kp"), "write it as key=value"),
        (("run", "currents-v1", "--set", "kp=-1"), "from 0 to"),
        (("run", "currents-v1", "--set", "kp=nan"), "from 0 to"),
        (("run", "currents-v1", "--set", "kpp=1"), "did you mean kp?"),
        (("run", "currents-v1", "--controller", "pii"), "Did you mean pi?"),
        (("run", "currents-v1", "--config", "none.toml"), "cannot be read"),
        (("run", "currents-v1", "--seed", "-1"), "--seed"),
        (("token", "new", "nobody"), "There is no account nobody."),
        (("user", "add", "a"), "A name consists of"),
        (("user", "add", "ann", "--password", "short"), "A password has"),
        (("user", "password", "nobody"), "There is no account nobody"),
        (("user", "role", "nobody", "teacher"), "There is no account nobody"),
        (("web",), "SEAMARK_BROKER_URL is not set"),
        (("worker",), "SEAMARK_BROKER_URL is not set"),
        (("up", "--port", "99999"), "--port"),
    ],
)
def test_wrong_usage_ends_with_a_message_and_exit_code_2(
    arguments: tuple[str, ...], message: str
) -> None:
    answer = seamark(*arguments)

    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())
    assert "Traceback" not in answer.output


def test_an_unknown_environment_variable_of_seamark_is_an_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SEAMARK_COLOUR", "blue")

    answer = seamark("db", "upgrade")

    assert (answer.exit_code, answer.output) == (
        2,
        "Error: SEAMARK_COLOUR is not a setting of Seamark.\n",
    )


@pytest.mark.slow
def test_a_server_that_does_not_answer_ends_with_exit_code_3() -> None:
    answer = seamark("submit", "currents-v1", "--server", "http://127.0.0.1:9")

    assert answer.exit_code == 3
    assert "http://127.0.0.1:9 does not answer" in answer.output


def test_an_account_gets_a_token_and_its_name_cannot_be_taken_twice(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path / "data"))

    made = seamark("user", "add", "ann", *data)
    twice = seamark("user", "add", "Ann", *data)
    token = seamark("token", "new", "ann", "--scope", "read", *data)

    assert made.exit_code == token.exit_code == 0
    assert (twice.exit_code, twice.output) == (2, "Error: The name Ann is taken.\n")
    assert token.output.splitlines()[-1].startswith("smk_")


def test_accounts_are_imported_from_a_file_and_each_refusal_has_its_reason(tmp_path: Path) -> None:
    data, names = ("--data", str(tmp_path / "data")), tmp_path / "names.txt"
    names.write_text("ann, class 7\nbob\n\nnot a name\nBob\n=1+1\n", encoding="utf-8")
    seamark("db", "upgrade", *data)

    lines = seamark("user", "import", str(names), *data).output.splitlines()
    rows = {row["name"]: row for row in csv.DictReader(lines)}

    made = {name: len(row["password"]) >= 10 for name, row in rows.items()}
    assert made == {"ann": True, "bob": True, "not a name": False, "Bob": False, "'=1+1": False}
    assert rows["Bob"]["refused"] == "The name Bob is taken."
    assert rows["not a name"]["refused"].startswith("A name consists of")


def test_accounts_are_never_imported_into_a_folder_without_a_service(tmp_path: Path) -> None:
    names = tmp_path / "names.txt"
    names.write_text("ann\n", encoding="utf-8")

    refused = seamark("user", "import", str(names), "--data", str(tmp_path / "elsewhere"))

    assert refused.exit_code == 2
    assert "docker compose exec" in refused.output
    assert not (tmp_path / "elsewhere" / "seamark.db").exists()


@pytest.mark.slow
def test_an_account_is_deleted_and_its_name_is_free_again(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path / "data"))
    seamark("user", "add", "ann", *data)

    link = seamark("user", "reset", "ann", *data)
    deleted = seamark("user", "delete", "ann", "--yes", *data)
    listed = seamark("user", "list", *data)

    assert link.output.startswith("/reset?link=")
    assert deleted.output == "Deleted the account ann.\n"
    assert (listed.exit_code, listed.output) == (0, "")
    assert seamark("user", "add", "ann", *data).exit_code == 0


def test_each_printed_invitation_makes_one_account(tmp_path: Path) -> None:
    printed = seamark("user", "invite", "--count", "2", "--data", str(tmp_path)).output

    database = Database(f"sqlite:///{tmp_path / 'seamark.db'}")
    with database.writing() as session:
        for text in printed.split():
            invitations.accept(session, text)
        with pytest.raises(AccountRejected, match="unknown, expired or used"):
            invitations.accept(session, printed.split()[0])
    database.close()
    assert len(printed.split()) == 2


@pytest.mark.slow
def test_a_token_beyond_the_limit_of_an_account_is_refused(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path))
    seamark("user", "add", "ann", "--password", "correct horse", *data)
    for _ in range(accounts.TOKENS_MAX):
        seamark("token", "new", "ann", *data)

    refused = seamark("token", "new", "ann", *data)

    assert refused.exit_code == 2
    assert "already have 50 tokens" in refused.output


@pytest.mark.slow
def test_roles_are_given_listed_and_changed(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path))
    for name, options in (("ann", ()), ("tim", ("--role", "teacher")), ("root", ("--admin",))):
        assert seamark("user", "add", name, *options, *data).exit_code == 0

    changed = seamark("user", "role", "ANN", "organiser", *data)
    lost = seamark("user", "role", "tim", "user", *data)
    listed = json.loads(seamark("user", "list", "--json", *data).output)["users"]

    assert (changed.output, lost.exit_code) == ("ann has the role organiser.\n", 0)
    assert {each["name"]: each["role"] for each in listed} == {
        "ann": "organiser",
        "tim": "user",
        "root": "admin",
    }
    assert seamark("user", "list", *data).output.split() == [
        *("ann", "organiser", "tim", "user", "root", "admin")
    ]


def test_the_audit_log_is_printed_newest_first(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path))
    seamark("user", "add", "ann", "--password", "correct horse", *data)
    seamark("user", "role", "ann", "teacher", *data)
    seamark("token", "new", "ann", *data)

    printed = seamark("audit", "--json", *data).output
    lines = [json.loads(line) for line in printed.splitlines()]
    last = seamark("audit", "--json", "--count", "1", "--target", "ann", *data).output
    text = seamark("audit", *data).output.splitlines()

    assert [(line["actor"], line["action"], line["target"]) for line in lines] == [
        ("command line", "token_made", "ann"),
        ("command line", "role_changed", "ann"),
    ]
    assert [json.loads(last)] == lines[:1]
    shown = [line.split("  ")[1:4] for line in text]
    assert shown == [[each[key] for key in ("actor", "action", "target")] for each in lines]


def test_the_roles_of_the_commands_are_those_of_the_server() -> None:
    assert tuple(role.label for role in ACCOUNT_ROLES) == ROLES


def test_the_scopes_of_tokens_are_those_of_the_server() -> None:
    assert set(OFFERED) == set(SCOPES)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("c.toml", "kp = 0.7\nlevels = [0, 0.1]\n"),
        ("c.json", '{"kp": 0.7, "levels": [0, 0.1]}'),
        ("o.json", '{"benchmark": "currents-v1", "config": {"kp": 0.7, "levels": [0, 0.1]}}'),
    ],
)
def test_settings_of_a_file_and_of_options_are_read_the_same(
    tmp_path: Path, name: str, text: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    schema: dict[str, Any] = registry.benchmark("currents-v1").schema()

    from_file = typed(read_settings(path, ()), schema)
    from_pairs = typed(read_settings(None, ("kp=0.7", "levels=0,0.1")), schema)

    assert from_file == from_pairs
    assert typed(read_settings(path, ("kp=0.9",)), schema)["kp"] == 0.9


def test_benchmarks_are_listed_as_text_and_as_json() -> None:
    listed = json.loads(seamark("benchmarks", "--json").output)
    schema = json.loads(seamark("benchmarks", "currents-v1", "--json").output)

    assert [entry["name"] for entry in listed] == list(registry.BENCHMARKS)
    assert "--set kp=" in seamark("benchmarks", "currents-v1").output
    assert schema["properties"]["kp"]["type"] == "number"


@pytest.mark.slow
def test_the_same_seed_gives_the_same_digest_in_two_processes(tmp_path: Path) -> None:
    out = tmp_path / "out"

    first = process("run", "currents-v1", *SHORT, "--out", str(out), "--json")
    second = seamark("run", "currents-v1", *SHORT, "--json")  # in this process

    results = [json.loads(done.stdout) for done in (first, second)]
    manifest = json.loads((out / "manifest.json").read_text())
    assert first.returncode == second.exit_code == 0
    assert results[0]["digest"] == results[1]["digest"] == manifest["digest"]
    assert sorted(path.name for path in out.iterdir()) == [
        "log.txt",
        "manifest.json",
        "metrics.json",
        "telemetry.csv",
    ]


def test_a_folder_with_other_files_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")

    answer = seamark("run", "currents-v1", *SHORT, "--out", str(tmp_path))

    assert answer.exit_code == 2
    assert "holds other files (thesis.tex)" in answer.output


@pytest.mark.slow
@pytest.mark.host
def test_a_program_that_crashes_ends_with_exit_code_1_and_its_own_traceback(tmp_path: Path) -> None:
    program = tmp_path / "crashing.py"
    program.write_text(CRASHING)
    out = tmp_path / "out"

    done = process("run", "currents-v1", *SHORT, "--controller", str(program), "--out", str(out))

    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr
    assert "sandbox" not in done.stderr
    assert (out / "log.txt").read_text() == "started\n"


HOSTILE = """
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        print("\\x1b]52;c;cm0gLXJm\\x07 \\x1b]0;title\\x07 \\u202eabc")
        raise ValueError("\\x1b[2J \\u202e")
"""


@pytest.mark.host
@pytest.mark.parametrize("command", [("check",), ("run", "currents-v1", *SHORT, "--controller")])
def test_nothing_that_a_program_prints_or_raises_acts_on_the_terminal(
    tmp_path: Path, command: tuple[str, ...]
) -> None:
    program = tmp_path / "mine.py"
    program.write_text(HOSTILE)

    answer = seamark(*command, str(program))

    assert answer.exit_code == 1
    assert r"\x1b[2J \u202e" in answer.output
    assert not {"\x1b", "\x07", "\u202e"} & set(answer.output)


def test_a_syntax_error_of_the_program_ends_with_exit_code_1(tmp_path: Path) -> None:
    program = tmp_path / "broken.py"
    program.write_text("class Controller(:\n")

    answer = seamark("run", "currents-v1", *SHORT, "--controller", str(program))

    assert answer.exit_code == 1
    assert "broken.py:1:" in answer.output


@pytest.mark.parametrize("language", starters())
def test_init_writes_a_controller_but_overwrites_none(language: str) -> None:
    starter = starters()[language].contents()

    first = seamark("init", "--language", language, "mine")
    written = {name: Path("mine", name).read_bytes() for name in starter}
    main = Path("mine", next(iter(starter)))
    main.write_text("my own")
    second = seamark("init", "--language", language, "mine")

    assert (first.exit_code, second.exit_code) == (0, 2)
    assert written == starter
    assert main.read_text() == "my own"


@pytest.mark.parametrize("benchmark", ["recover-v1", "valve-v1", "connect-v1"])
@pytest.mark.parametrize("language", starters(moves_arm=True))
def test_init_writes_a_program_that_moves_an_arm_and_its_kinematics(
    language: str, benchmark: str
) -> None:
    wanted = starters(moves_arm=True)[language].contents() | helper(language)

    answer = seamark("init", "--language", language, "--benchmark", benchmark, "mine")

    assert answer.exit_code == 0
    assert {name: Path("mine", name).read_bytes() for name in wanted} == wanted
    assert f"seamark run {benchmark} --controller" in answer.output


def test_every_language_with_a_controller_to_start_from_has_one_that_moves_an_arm() -> None:
    assert [*starters(moves_arm=True)] == [*starters()]


def test_a_folder_is_checked_as_the_archive_of_its_files(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "controller.py").write_text("import law\n\nclass Controler:\n    pass\n")
    (folder / "law.py").write_text("x = (\n")

    answer = seamark("check", str(folder))

    assert answer.exit_code == 1
    assert "controller.py:3: There is no class Controller" in answer.output
    assert "law.py:1:5: '(' was never closed." in answer.output


def test_a_folder_without_a_program_is_refused_with_the_names_that_one_may_have(
    tmp_path: Path,
) -> None:
    (tmp_path / "notes.txt").write_text("nothing")

    answer = seamark("run", "currents-v2", "--controller", str(tmp_path))

    assert answer.exit_code == 1
    assert "needs one of main.py (Python), controller.py (Python)" in answer.output


@pytest.mark.slow
def test_the_operator_can_replace_a_forgotten_password(tmp_path: Path) -> None:
    data = ("--data", str(tmp_path / "d"))
    seamark("user", "add", "ann", *data)

    drawn = json.loads(seamark("user", "password", "ANN", "--json", *data).output)["password"]

    database = Database(settings_of(tmp_path / "d").database_url)
    with database.reading() as session:
        assert accounts.authenticate(session, "ann", drawn) is not None
    database.close()


@pytest.mark.parametrize(
    ("source", "code", "says"),
    [
        ("class Controler:\n    pass\n", 1, "mine.py:1: There is no class Controller. Did you"),
        ("x = (\n", 1, "mine.py:1:5: '(' was never closed."),
    ],
)
def test_check_reports_the_errors_of_the_source_with_their_lines(
    tmp_path: Path, source: str, code: int, says: str
) -> None:
    program = tmp_path / "mine.py"
    program.write_text(source)

    answer = seamark("check", str(program))

    assert (answer.exit_code, says in answer.output) == (code, True), answer.output
