"""`seamark tune` with real runs."""

import json
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from tests.services.prepared import run

SHORT = ("--set", "levels=0.2", "--set", "level_duration_s=4", "--set", "settle_s=1")
GAINS = ("--controller", "pi", "--param", "kp=0.1:2", "--param", "ki=0:0.5:log")
SMALL = (*SHORT, "--trials", "2", "--batch", "3", "--method", "random")
INTERRUPTED = """
import signal

from seamark.cli.main import main
from seamark.tuning.history import History

save, saved = History.save, []


def save_and_interrupt(history):
    save(history)
    saved.append(history)
    if len(saved) == 5:
        signal.raise_signal(signal.SIGINT)  # as Ctrl-C does, in the middle of a batch


History.save = save_and_interrupt
main()
"""
BRITTLE = """
PARAMETERS = {"gain": {"default": 0.5, "range": [0.0, 2.0]}}


class Controller:
    def __init__(self, config):
        self.gain = config["gain"]

    def reset(self, level):
        pass

    def step(self, observation):
        if self.gain > 1.0:
            raise ValueError("too much")
        return [self.gain, 0.0, 0.0, 0.0]
"""


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def tune(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["tune", "currents-v1", *arguments], prog_name="seamark")


@pytest.mark.slow
def test_the_result_does_not_depend_on_the_number_of_jobs() -> None:
    one = tune(*GAINS, *SMALL, "--candidates", "3", "--validate", "2", "--jobs", "1", "--json")
    Path("tuned.csv").rename("first.csv")
    two = tune(*GAINS, *SMALL, "--candidates", "3", "--validate", "2", "--jobs", "2", "--json")

    assert one.exit_code == two.exit_code == 0
    assert one.stdout == two.stdout
    assert Path("tuned.csv").read_bytes() == Path("first.csv").read_bytes()
    found = json.loads(one.stdout)
    assert [each["candidate"] for each in found["candidates"]] == [0, 1, 2, 3]
    assert found["best"]["score"] == max(each["score"] for each in found["candidates"])


@pytest.mark.slow
def test_the_best_configuration_gives_its_score_again_in_a_run() -> None:
    answer = tune(*GAINS, *SMALL, "--candidates", "4", "--validate", "0", "--json")

    command = ("run", "currents-v1", "--controller", "pi", "--config", "tuned.toml", "--json")
    run = CliRunner().invoke(cli, [*command, "--seed", "1", "--trials", "2"])

    assert json.loads(run.stdout)["score"] == json.loads(answer.stdout)["best"]["score"]


@pytest.mark.slow
def test_a_program_is_tuned_by_what_it_declares_and_its_crashes_are_listed() -> None:
    Path("brittle.py").write_text(BRITTLE)

    search = (*SMALL, "--method", "grid", "--candidates", "3", "--validate", "2")
    answer = tune("--controller", "brittle.py", *search)

    assert answer.exit_code == 0
    assert "1 candidate failed:" in answer.stdout
    assert "too much" in answer.stdout
    assert tomllib.loads(Path("tuned.toml").read_text())["parameters"]["gain"] <= 1.0
    rows = Path("tuned.csv").read_text().splitlines()
    assert [row.split(",")[-1] for row in rows[1:]] == ["gain", "0.5", "0.0", "1.0", "2.0"]


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_there_and_resume_goes_on() -> None:
    whole = tune(*GAINS, *SMALL, "--candidates", "12", "--validate", "0", "--out", "whole.toml")
    options = (*GAINS, *SMALL, "--candidates", "12", "--validate", "0", "--jobs", "1")
    stopped = run(INTERRUPTED, "tune", "currents-v1", *options, on="warm")
    kept = Path("tuned.csv").read_text().splitlines()

    refused = tune(*options)
    resumed = tune(*options, "--resume")

    assert whole.exit_code == resumed.exit_code == 0
    assert (stopped.returncode, refused.exit_code) == (130, 2)
    assert "--resume" in refused.output
    assert len(kept) < len(Path("tuned.csv").read_text().splitlines())
    assert Path("tuned.csv").read_text() == Path("whole.csv").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "Give 1 to 20 parameters with --param"),
        (("--param", "levels=0:1"), "it cannot be tuned here. These can:"),
        (("--param", "level_duration_s=10:20"), "it cannot be tuned here"),
        (("--param", "kp=0:1", "--method", "cma-es"), "two or more ranges"),
        (("--param", "kp=0:1", "--resume"), "There is no history tuned.csv"),
        (("--param", "kp=0:1", "--out", "none/best.toml"), "cannot be written"),
    ],
)
def test_a_search_that_makes_no_sense_is_refused(arguments: tuple[str, ...], message: str) -> None:
    answer = tune("--controller", "pi", *SHORT, *arguments)

    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())
