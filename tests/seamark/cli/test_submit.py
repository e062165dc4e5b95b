"""`seamark submit` with a file, and on which terms it publishes a run."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.client import Client
from tests.cast import VEHICLE, Backend

STILL = """class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, observation):
        return 0.0, 0.0, 0.0, 0.0
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A program that does nothing."""
    file = tmp_path / "still.py"
    file.write_text(STILL)
    return file


def submit(address: str, token: str, *options: object) -> Result:
    common = ["submit", "currents-v1", "--server", address, "--token", token]
    return CliRunner().invoke(cli, [*common, *map(str, options)])


@pytest.mark.slow
def test_a_file_is_submitted_as_a_program_of_ones_own(
    address: str, token: str, program: Path
) -> None:
    answer = submit(address, token, "--controller", program)

    assert answer.exit_code == 0, answer.output
    assert f"{address}/runs/1" in answer.output


@pytest.mark.slow
def test_who_submits_without_a_token_is_told_that_no_browser_can_open_the_page(
    address: str, token: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SEAMARK_TOKEN", raising=False)
    as_guest = CliRunner().invoke(cli, ["submit", "currents-v1", "--server", address])
    in_account = submit(address, token)

    assert "no browser can open its page" in as_guest.stderr
    assert in_account.stderr == ""


@pytest.mark.slow
@pytest.mark.usefixtures("worker")
def test_a_run_is_published_on_the_terms_that_the_options_name(
    address: str, token: str, program: Path
) -> None:
    own = ("--controller", program, "--publish", "--method", "Steady hand", "--json")

    plain = submit(address, token, *own)
    chosen = submit(address, token, *own, "--licence", "EUPL-1.2", "--anonymous")
    private = submit(address, token, *own, "--results-only")

    runs = [json.loads(one.stdout) for one in (plain, chosen, private)]
    assert [run["public"] for run in runs] == [True, True, True]
    assert [run["licence"] for run in runs] == [None, "EUPL-1.2", None]
    assert [run["program_public"] for run in runs] == [True, True, False]
    assert [run["user"] for run in runs] == ["ann", "Anonymous author", "ann"]
    assert {run["method"] for run in runs} == {"Steady hand"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--licence", "MIT"), "need --publish"),
        (("--anonymous",), "need --publish"),
        (("--method", "Steady hand"), "need --publish"),
        (("--publish", "--licence", "WTFPL"), "'MIT', 'BSD-3-Clause'"),
        (("--publish", "--licence", "MIT"), "A licence is for the program"),
        (("--publish", "--sweep", "kp=0.1,0.2"), "--publish is for one run"),
        (("--publish", "--token", ""), "Publishing needs an account"),
    ],
)
def test_impossible_terms_are_refused_before_anything_is_submitted(
    backend: Backend, address: str, token: str, options: tuple[str, ...], says: str
) -> None:
    refused = submit(address, token, "--controller", "pi", *options)

    assert refused.exit_code == 2
    assert says in " ".join(refused.output.split())
    assert backend.claim() is None


@pytest.mark.slow
def test_a_program_is_not_published_without_the_name_of_its_method(
    backend: Backend, address: str, token: str, program: Path
) -> None:
    refused = submit(address, token, "--controller", program, "--publish")

    assert refused.exit_code == 2
    assert "Name the method that you publish, with --method." in refused.output
    assert backend.claim() is None


@pytest.mark.slow
@pytest.mark.usefixtures("worker")
def test_the_result_is_printed_although_the_server_does_not_publish_it(
    backend: Backend, address: str, token: str, program: Path
) -> None:
    done = submit(address, token, "--controller", "pi", "--ranked", "--wait", "--json")
    backend.publish(int(json.loads(done.stdout)["id"]))

    refused = submit(
        *(
            address,
            token,
            "--controller",
            program,
            "--ranked",
            "--publish",
            "--method",
            "X",
            "--anonymous",
        )
    )

    assert refused.exit_code == 2
    assert "Score 50" in refused.stdout
    assert "is published under your name" in refused.stderr


@pytest.mark.slow
def test_a_vehicle_is_uploaded_with_the_run_and_the_answer_says_so(
    address: str, token: str, tmp_path: Path
) -> None:
    mine = tmp_path / "my_rov.toml"
    mine.write_text(VEHICLE, encoding="utf-8")
    choice = ("--controller", "pi", "--set", f"vehicle={mine}", "--set", "kp=0.5")

    told = submit(address, token, *choice)
    document = json.loads(submit(address, token, *choice, "--json").stdout)

    assert f"The vehicle of {mine} is uploaded." in told.output
    assert document["config"]["vehicle"].startswith("mine@")
    assert document["config"]["kp"] == 0.5
    with Client(address, token) as client:
        assert client.run(document["id"]).vehicle() == VEHICLE.encode()


@pytest.mark.slow
def test_a_vehicle_that_cannot_be_read_or_run_is_refused_with_its_error(
    address: str, token: str, tmp_path: Path
) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(VEHICLE.replace("format = 1", "format = 3"), encoding="utf-8")
    absent = tmp_path / "absent.toml"

    answers = [
        submit(address, token, "--controller", "pi", "--set", f"vehicle={file}")
        for file in (wrong, absent)
    ]

    assert [answer.exit_code for answer in answers] == [2, 2]
    assert "format must be 1" in answers[0].output
    assert f"{absent} cannot be read: No such file or directory." in answers[1].output
