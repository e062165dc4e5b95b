"""`seamark compare` and `leaderboard`: as the pages, as tables or as the document of the API."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from tests.cast import Backend


@pytest.fixture(autouse=True)
def _environment(address: str, token: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEAMARK_SERVER", address)
    monkeypatch.setenv("SEAMARK_TOKEN", token)


def _compare(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["compare", *arguments], prog_name="seamark")


def _in_a_process(*arguments: str) -> bytes:
    """Return what the command alone prints, without what the server logs in this process."""
    command = [sys.executable, "-m", "seamark.cli.main", "compare", *arguments]
    return subprocess.run(command, capture_output=True, check=True, timeout=60).stdout


@pytest.mark.slow
def test_compare_prints_what_differs_and_where_to_look(backend: Backend, address: str) -> None:
    first = backend.succeeded(seed=7, config={"kp": 0.4})
    second = backend.succeeded(seed=7, config={"kp": 0.6})

    tables = _compare(str(first), str(second))
    document = _in_a_process(str(first), str(second), "--json")

    assert tables.exit_code == 0, tables.output
    (row,) = [line for line in tables.output.splitlines() if line.endswith("0.4    0.6")]
    assert "gain" in row.lower()
    assert f"run {second} - run {first}: +0 " in tables.output
    assert f"{address}/compare?runs={first},{second}" in tables.output
    assert [run["id"] for run in json.loads(document)["runs"]] == [first, second]


@pytest.mark.parametrize(
    ("runs", "message"), [(("1",), "2 to 5 different runs"), (("1", "999"), "There is no run 999")]
)
def test_compare_says_what_is_wrong(backend: Backend, runs: tuple[str, ...], message: str) -> None:
    assert backend.succeeded() == 1

    answer = _compare(*runs)

    assert answer.exit_code == 2
    assert message in answer.output


@pytest.mark.slow
def test_a_server_that_does_not_answer_is_a_failure_of_the_platform(tmp_path: Path) -> None:
    answer = CliRunner().invoke(cli, ["compare", "1", "2", "--server", "http://127.0.0.1:9"])

    assert answer.exit_code == 3


@pytest.mark.slow
def test_leaderboard_prints_the_rows_of_the_page(backend: Backend) -> None:
    backend.published("eva", kind="ranked", title="Steady \x1b[31mhand")
    arguments = ("leaderboard", "currents-v1")

    shown = CliRunner().invoke(cli, [*arguments, "--program", "built-in"], prog_name="seamark")
    hidden = CliRunner().invoke(cli, [*arguments, "--baselines", "hide"], prog_name="seamark")
    none = CliRunner().invoke(cli, [*arguments, "--mine"], prog_name="seamark")
    wrong = CliRunner().invoke(cli, [*arguments, "--sort", "nothing"], prog_name="seamark")

    assert (shown.exit_code, none.exit_code) == (0, 0)
    assert "eva" in shown.output
    assert "45 to 55" in shown.output
    assert "PI, default settings" in shown.output  # a shipped reference entry
    assert "PI, default settings" not in hidden.output
    assert "\x1b" not in shown.output
    assert "eva" not in none.output
    assert wrong.exit_code != 0
    assert "rmse_m" in wrong.output


@pytest.mark.slow
def test_leaderboard_prints_each_method_if_asked_to(backend: Backend) -> None:
    for title in ("Observer", "Sliding mode"):
        backend.published("eva", kind="ranked", title=title)
    arguments = ["leaderboard", "currents-v1", "--baselines", "hide"]

    people, methods = (
        CliRunner().invoke(cli, [*arguments, *more], prog_name="seamark").output
        for more in ([], ["--per", "method"])
    )

    assert (people.count("eva"), methods.count("eva")) == (1, 2)
    assert "Sliding mode" not in people
    assert "Sliding mode" in methods


@pytest.mark.slow
def test_folders_are_compared_as_their_runs_would_be_on_a_server(results: Path) -> None:
    folders = [str(results / name) for name in ("p", "pi")]

    tables = CliRunner().invoke(cli, ["compare", *folders])
    document = json.loads(CliRunner().invoke(cli, ["compare", *folders, "--json"]).stdout)

    p, pi = (json.loads((results / name / "metrics.json").read_text()) for name in ("p", "pi"))
    (difference,) = document["scores"]
    assert "pi - p:" in tables.stdout
    assert "compared over 3 trials in the same conditions." in tables.stdout
    assert difference["difference"] == pytest.approx(pi["score"] - p["score"])
    assert difference["low"] < difference["difference"] < difference["high"]
    assert "solution" in [row["name"] for row in document["settings"]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "message"),
    [(("pi",), "Name 2 to 5 results"), (("pi", "none"), "none is neither a folder nor")],
)
def test_what_cannot_be_compared_is_refused(
    results: Path, names: tuple[str, ...], message: str
) -> None:
    answer = CliRunner().invoke(cli, ["compare", *(str(results / name) for name in names)])

    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())
